//! The declaration of a frame: resources, and passes with what each does to them.

use std::fmt;
use std::sync::Arc;

use ash::vk;

use super::access::Access;
use super::resource::{
    BufferHandle, BufferInfo, Handle, History, ImageHandle, ImageInfo, Lifetime, Part, Resource, ResourceInfo,
};

/// What names begin with of what the frame before has left.
pub const PREVIOUS: &str = "previous_";

/// Names a pass of one graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PassId(usize);

impl PassId {
    /// Position in the graph's pass list.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// One resource as one pass uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use {
    /// The resource.
    pub resource: Handle,
    /// The only level of it that the pass uses, or `None` for all of it.
    pub level: Option<u32>,
    /// What the pass does with it.
    pub access: Access,
    /// Descriptor binding it is attached at; `None` for attachments, indirect arguments and copies.
    pub binding: Option<BindingName>,
}

/// How a pass names a descriptor binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingName {
    /// As the pass's shaders call it.
    Name(&'static str),
    /// By its number, in graphs without shaders.
    Number(u32),
}

impl fmt::Display for BindingName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

impl From<&'static str> for BindingName {
    fn from(name: &'static str) -> Self {
        Self::Name(name)
    }
}

impl From<i32> for BindingName {
    fn from(number: i32) -> Self {
        Self::Number(number.unsigned_abs())
    }
}

/// One step of the frame: a name, what it uses, and how to record it.
#[derive(Clone, Debug)]
pub struct Pass<P> {
    /// Name, also its debug label, timing key and crash marker; unique in the graph.
    pub name: String,
    /// Everything the pass reads and writes.
    pub uses: Vec<Use>,
    /// Whether the pass is recorded several times in a row, each time after the writes of the time before.
    pub repeats: bool,
    /// Whether a later frame may use its results again instead of running it: [`Graph::keep_from`].
    pub is_kept: bool,
    /// How to record the pass; opaque to the plan.
    pub payload: P,
}

impl<P> Pass<P> {
    /// A pass that uses nothing yet.
    pub fn new(name: impl Into<String>, payload: P) -> Self {
        Self { name: name.into(), uses: Vec::new(), repeats: false, is_kept: false, payload }
    }

    /// The same pass recorded several times in a row; the plan says what must stand in between.
    #[must_use]
    pub fn repeated(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// Attaches a resource, or one level of an image, at a descriptor binding.
    #[must_use]
    pub fn bind(mut self, binding: impl Into<BindingName>, part: impl Into<Part>, access: Access) -> Self {
        self.add_use(part.into(), access, Some(binding.into()));
        self
    }

    /// The pass with what `declare` adds to it.
    #[must_use]
    pub fn with(self, declare: impl FnOnce(Self) -> Self) -> Self {
        declare(self)
    }

    /// Uses one more resource without a descriptor.
    pub fn declare(&mut self, part: impl Into<Part>, access: Access) {
        self.add_use(part.into(), access, None);
    }

    /// Uses a resource, or one level of an image, without a descriptor: attachments, indirect arguments, copies.
    ///
    /// A resource used more than once in a pass counts as used in all those ways at once: if the pass writes it
    /// at one stage and reads it at another, the pass must record the barriers in between itself. Each level of an
    /// image counts for itself: a pass may read one and write the next.
    #[must_use]
    pub fn uses(mut self, part: impl Into<Part>, access: Access) -> Self {
        self.declare(part, access);
        self
    }

    fn add_use(&mut self, Part { resource, level }: Part, access: Access, binding: Option<BindingName>) {
        self.uses.push(Use { resource, level, access, binding });
    }
}

/// A whole frame: resources, and passes in the order they run.
///
/// Passes stay in the order they were added: the code that adds them is the frame's table of contents, and the
/// plan checks that order rather than changing it.
#[derive(Clone, Debug)]
pub struct Graph<P> {
    resources: Vec<Resource>,
    passes: Vec<Pass<P>>,
}

impl<P> Default for Graph<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<P> Graph<P> {
    /// An empty frame.
    #[must_use]
    pub fn new() -> Self {
        Self { resources: Vec::new(), passes: Vec::new() }
    }

    /// A buffer that is written before it is read in every frame.
    pub fn transient_buffer(&mut self, name: &str, size_bytes: u64) -> BufferHandle {
        self.buffer(name, size_bytes, Lifetime::Transient)
    }

    /// A buffer that keeps its contents from frame to frame.
    pub fn persistent_buffer(&mut self, name: &str, size_bytes: u64) -> BufferHandle {
        self.buffer(name, size_bytes, Lifetime::Persistent)
    }

    /// A buffer that has these contents before the first frame and keeps them as long as no pass writes it.
    pub fn filled_buffer(&mut self, name: &str, contents: Arc<[u8]>) -> BufferHandle {
        let buffer = self.persistent_buffer(name, contents.len() as u64);
        self.resources[buffer.0].contents = Some(contents);
        buffer
    }

    /// An image of one level and one layer that has these contents before the first frame and keeps them as long as no pass
    /// writes it.
    pub fn filled_image(&mut self, name: &str, info: ImageInfo, contents: Arc<[u8]>) -> ImageHandle {
        let image = self.persistent_image(name, info);
        self.resources[image.0].contents = Some(contents);
        image
    }

    /// A buffer owned outside the graph, whose owner knows its size; other graphs on the queue may use it as well.
    pub fn imported_buffer(&mut self, name: &str) -> BufferHandle {
        self.buffer(name, 0, Lifetime::Imported)
    }

    /// An image owned outside the graph, whose owner knows its size; other graphs on the queue may use it as well.
    pub fn imported_image(&mut self, name: &str, format: vk::Format) -> ImageHandle {
        let info = ResourceInfo::Image(ImageInfo::new(format, 0, 0));
        ImageHandle(self.resource_slot(name, info, Lifetime::Imported))
    }

    /// The buffer of this name.
    #[must_use]
    pub fn buffer_named(&self, name: &str) -> Option<BufferHandle> {
        let named = |resource: &Resource| matches!(resource.info, ResourceInfo::Buffer(_)) && resource.name == name;
        self.resources.iter().position(named).map(BufferHandle)
    }

    /// An image that is written before it is read in every frame.
    pub fn transient_image(&mut self, name: &str, info: ImageInfo) -> ImageHandle {
        ImageHandle(self.resource_slot(name, ResourceInfo::Image(info), Lifetime::Transient))
    }

    /// An image that keeps its contents and layout from frame to frame.
    pub fn persistent_image(&mut self, name: &str, info: ImageInfo) -> ImageHandle {
        ImageHandle(self.resource_slot(name, ResourceInfo::Image(info), Lifetime::Persistent))
    }

    /// An image that is handed over anew for every frame, such as one of a swapchain; the frame writes all of it.
    pub fn acquired_image(&mut self, name: &str, info: ImageInfo) -> ImageHandle {
        ImageHandle(self.resource_slot(name, ResourceInfo::Image(info), Lifetime::Acquired))
    }

    /// The image that another graph has acquired and drawn to in the same frame.
    pub fn continued_image(&mut self, name: &str, info: ImageInfo) -> ImageHandle {
        ImageHandle(self.resource_slot(name, ResourceInfo::Image(info), Lifetime::Continued))
    }

    /// A buffer that the frame writes and the host reads afterwards; one of its passes must declare
    /// [`Access::HostRead`].
    pub fn readback_buffer(&mut self, name: &str, size_bytes: u64) -> BufferHandle {
        self.buffer(name, size_bytes, Lifetime::Readback)
    }

    /// A buffer that this frame writes, and the one that the frame before wrote, `previous_NAME`.
    pub fn history_buffer(&mut self, name: &str, size_bytes: u64) -> History<BufferHandle> {
        let [previous, current] = self.history(name, ResourceInfo::Buffer(BufferInfo { size_bytes }));
        History { previous: BufferHandle(previous), current: BufferHandle(current) }
    }

    /// An image that this frame writes, and the one that the frame before wrote, `previous_NAME`.
    pub fn history_image(&mut self, name: &str, info: ImageInfo) -> History<ImageHandle> {
        let [previous, current] = self.history(name, ResourceInfo::Image(info));
        History { previous: ImageHandle(previous), current: ImageHandle(current) }
    }

    fn history(&mut self, name: &str, info: ResourceInfo) -> [usize; 2] {
        let previous = self.resources.len();
        let current = Lifetime::Previous { current: Handle(previous + 1) };
        self.resource_slot(&format!("{PREVIOUS}{name}"), info, current);
        [previous, self.resource_slot(name, info, Lifetime::Current { previous: Handle(previous) })]
    }

    /// Appends a pass to the frame.
    pub fn add_pass(&mut self, pass: Pass<P>) -> PassId {
        self.passes.push(pass);
        PassId(self.passes.len() - 1)
    }

    /// A pass that was added before, to declare more of it.
    pub fn pass_mut(&mut self, pass: PassId) -> &mut Pass<P> {
        &mut self.passes[pass.0]
    }

    /// Lays two chains of passes side by side, `first..second` and `second..` in the pass list: the first of each, then
    /// the second of each, and so on. Passes that do not depend on each other then share their barriers. Ids of these
    /// passes no longer hold.
    ///
    /// # Panics
    /// When one chain uses what the other writes.
    pub fn lay_side_by_side(&mut self, first: usize, second: usize) {
        let second = self.passes.split_off(second);
        let first = self.passes.split_off(first);
        assert_independent(&first, &second);
        let (mut first, mut second) = (first.into_iter(), second.into_iter());
        loop {
            let (one, other) = (first.next(), second.next());
            if one.is_none() && other.is_none() {
                return;
            }
            self.passes.extend(one);
            self.passes.extend(other);
        }
    }

    /// Passes from `first` on make what later frames may use again.
    pub fn keep_from(&mut self, first: usize) {
        self.passes[first..].iter_mut().for_each(|pass| pass.is_kept = true);
    }

    /// Call it when all passes are there: what kept passes have written and others read outlives the frame. Where others write it
    /// later on, so that it would not be the same again, nothing is kept; what they have written before, such as a counter that
    /// every frame begins anew, is theirs.
    pub fn keep_results(&mut self) {
        let mut kept = vec![false; self.resources.len()];
        let mut theirs = vec![false; self.resources.len()];
        let mut is_read = vec![false; self.resources.len()];
        let mut is_spoilt = false;
        for pass in &self.passes {
            for Use { resource: Handle(index), access, .. } in &pass.uses {
                match (pass.is_kept, access.is_write()) {
                    (true, true) => kept[*index] |= !theirs[*index],
                    (true, false) => {}
                    (false, is_write) => {
                        is_spoilt |= is_write && kept[*index];
                        theirs[*index] |= is_write;
                        is_read[*index] = true;
                    }
                }
            }
        }
        if is_spoilt {
            self.passes.iter_mut().for_each(|pass| pass.is_kept = false);
            return;
        }
        for (index, resource) in self.resources.iter_mut().enumerate() {
            if kept[index] && is_read[index] && resource.lifetime == Lifetime::Transient {
                resource.lifetime = Lifetime::Persistent;
            }
        }
    }

    /// Every resource; [`Handle::index`] is the position here.
    #[must_use]
    pub fn resources(&self) -> &[Resource] {
        &self.resources
    }

    /// Every pass, in the order they run.
    #[must_use]
    pub fn passes(&self) -> &[Pass<P>] {
        &self.passes
    }

    /// Usage flags resource `index` needs, as a buffer and as an image (one of them is empty).
    #[must_use]
    pub fn usage_of(&self, index: usize) -> (vk::BufferUsageFlags, vk::ImageUsageFlags) {
        self.accesses(Handle(index)).fold(Default::default(), |(buffer, image), access| {
            (buffer | access.buffer_usage(), image | access.image_usage())
        })
    }

    /// Usage flags the buffer needs for everything the passes do with it.
    #[must_use]
    pub fn buffer_usage(&self, buffer: BufferHandle) -> vk::BufferUsageFlags {
        self.accesses(buffer.into()).fold(vk::BufferUsageFlags::empty(), |all, access| all | access.buffer_usage())
    }

    /// Usage flags the image needs for everything the passes do with it.
    #[must_use]
    pub fn image_usage(&self, image: ImageHandle) -> vk::ImageUsageFlags {
        self.accesses(image.into()).fold(vk::ImageUsageFlags::empty(), |all, access| all | access.image_usage())
    }

    /// Accesses to a resource, and to the one that it changes places with.
    fn accesses(&self, resource: Handle) -> impl Iterator<Item = Access> {
        let partner = self.resources[resource.index()].lifetime.partner();
        self.passes
            .iter()
            .flat_map(|pass| &pass.uses)
            .filter(move |used| used.resource == resource || partner == Some(used.resource))
            .map(|used| used.access)
    }

    fn buffer(&mut self, name: &str, size_bytes: u64, lifetime: Lifetime) -> BufferHandle {
        BufferHandle(self.resource_slot(name, ResourceInfo::Buffer(BufferInfo { size_bytes }), lifetime))
    }

    fn resource_slot(&mut self, name: &str, info: ResourceInfo, lifetime: Lifetime) -> usize {
        self.resources.push(Resource { name: name.to_owned(), info, lifetime, contents: None });
        self.resources.len() - 1
    }
}

fn assert_independent<P>(first: &[Pass<P>], second: &[Pass<P>]) {
    let uses = |chain: &[Pass<P>]| chain.iter().flat_map(|pass| pass.uses.clone()).collect::<Vec<_>>();
    let (first, second) = (uses(first), uses(second));
    for one in &first {
        let conflict =
            |other: &&Use| one.resource == other.resource && (one.access.is_write() || other.access.is_write());
        assert!(second.iter().find(conflict).is_none(), "two chains side by side share what one of them writes");
    }
}
