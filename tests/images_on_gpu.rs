//! Images with mip levels, layers and three dimensions, written and read by passes on the GPU.

mod common;

use ash::vk::{self, Format};
use common::counter::Counter;
use common::{GpuTest, gpu};
use gridlight::gpu::{ColorTarget, ComputeWork, Dispatch, Executor, RasterWork, Work};
use gridlight::graph::{Access, Graph, ImageHandle, ImageInfo, Pass};
use gridlight::passes::{Extent, shader, threads};

const FORMAT: Format = Format::R32_UINT;
/// What the test's images have at most.
const MOST_LEVELS: usize = 4;

/// The texels of one level: rows, slices and layers packed, with the size that shaders see.
struct Level {
    size_px: [u32; 3],
    texels: Vec<u32>,
}

impl Level {
    /// As `fill_texels` makes it.
    fn filled(info: &ImageInfo, level: u32, base: u32) -> Self {
        let [width, height, depth] = info.level_size_px(level);
        let size_px = [width, height, depth * info.layer_count()];
        let place = |i: u32| base + i % width + 10 * (i / width % height) + 100 * (i / (width * height));
        Self { size_px, texels: (0..size_px.iter().product()).map(place).collect() }
    }

    /// As `reduce_level` makes it.
    fn reduced(&self, [width, height, _]: [u32; 3]) -> Self {
        let at = |x: u32, y: u32| {
            let [x, y] = [x.min(self.size_px[0] - 1), y.min(self.size_px[1] - 1)];
            self.texels[(y * self.size_px[0] + x) as usize]
        };
        let sum = |i: u32| {
            let [x, y] = [2 * (i % width), 2 * (i / width)];
            at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)
        };
        Self { size_px: [width, height, 1], texels: (0..width * height).map(sum).collect() }
    }

    /// As `sum_texels` makes it.
    fn sum(&self) -> u32 {
        let [width, height, _] = self.size_px;
        let weight = |i: u32| 1 + i % width + 3 * (i / width % height) + 7 * (i / (width * height));
        self.texels.iter().zip(0..).fold(0, |sum: u32, (texel, i)| sum.wrapping_add(texel.wrapping_mul(weight(i))))
    }
}

/// A graph of an image, and the sums of its levels, at its end.
struct Images {
    graph: Graph<Work>,
    image: ImageHandle,
    info: ImageInfo,
    /// Ending of the shaders' names.
    kind: &'static str,
}

impl Images {
    /// A graph whose image only lives within the frame, or is kept so that it can be read.
    fn new(info: ImageInfo, kind: &'static str, is_kept: bool) -> Self {
        let mut graph = Graph::new();
        let image = if is_kept { graph.persistent_image("image", info) } else { graph.transient_image("image", info) };
        Self { graph, image, info, kind }
    }

    fn fill(&mut self, level: u32, base: u32) {
        let [width, height, depth] = self.info.level_size_px(level);
        let groups = [width, height, depth * self.info.layer_count()].map(|size| size.div_ceil(4));
        let fill = shader(&format!("tests/fill_texels{}", self.kind), Dispatch::Groups(groups));
        let work = Work::Compute(ComputeWork { push: vec![base], ..fill });
        let pass = Pass::new(format!("fill_level_{level}"), work);
        self.graph.add_pass(pass.bind("out_texels", self.image.level(level), Access::ComputeWrite));
    }

    fn reduce_to(&mut self, level: u32) {
        let [width, height, _] = self.info.level_size_px(level);
        let work = Work::Compute(shader("tests/reduce_level", Extent::Pixels([width, height])));
        let pass = Pass::new(format!("reduce_to_{level}"), work)
            .bind("finer_level", self.image.level(level - 1), Access::ComputeSampled)
            .bind("out_level", self.image.level(level), Access::ComputeWrite);
        self.graph.add_pass(pass);
    }

    /// Sets every texel of a level by clearing an attachment.
    fn clear(&mut self, level: u32, value: u32) {
        let [width, height, _] = self.info.level_size_px(level);
        let target = self.image.level(level);
        let work = RasterWork {
            colors: vec![ColorTarget { target, clear: Some([value; 4]) }],
            depth: None,
            extent_px: [width, height],
            draws: Vec::new(),
            uses_scene: false,
        };
        let pass = Pass::new(format!("clear_level_{level}"), Work::Raster(work));
        self.graph.add_pass(pass.uses(target, Access::ColorAttachmentWrite));
    }

    /// Adds the sums and runs two frames.
    fn run(mut self, gpu: &GpuTest) -> (Executor, Vec<u32>) {
        let sums = self.graph.persistent_buffer("sums", 4 * MOST_LEVELS as u64);
        let work = Work::Compute(shader(&format!("tests/sum_texels{}", self.kind), threads(1)));
        let pass = Pass::new("sum_texels", work).bind("texels", self.image, Access::ComputeSampled).bind(
            "sums",
            sums,
            Access::ComputeWrite,
        );
        self.graph.add_pass(pass);
        let mut executor = Executor::new(&gpu.gpu, self.graph, None).unwrap();
        for _ in 0..2 {
            let ticket = executor.submit(&[]).unwrap();
            executor.wait(ticket).unwrap();
        }
        let sums = words(&executor.read_buffer(sums).unwrap());
        (executor, sums[..self.info.level_count as usize].to_vec())
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
}

fn check(gpu: &GpuTest, make: impl Fn(bool) -> Images, expected: &[Level]) {
    let sums: Vec<u32> = expected.iter().map(Level::sum).collect();
    assert_eq!(make(false).run(gpu).1, sums, "within the frame");
    let kept = make(true);
    let image = kept.image;
    let (executor, found) = kept.run(gpu);
    assert_eq!(found, sums, "kept");
    for (level, expected) in expected.iter().enumerate() {
        assert_eq!(words(&executor.read_image(image.level(level as u32)).unwrap()), expected.texels, "level {level}");
    }
}

#[test]
fn a_pyramid_is_made_level_by_level() {
    let info = ImageInfo::new(FORMAT, 13, 7).with_levels(4);
    let make = |is_kept| {
        let mut images = Images::new(info, "", is_kept);
        images.fill(0, 5);
        (1..4).for_each(|level| images.reduce_to(level));
        images
    };
    let mut expected = vec![Level::filled(&info, 0, 5)];
    for level in 1..4 {
        expected.push(expected[level - 1].reduced(info.level_size_px(level as u32)));
    }
    assert_eq!(expected[3].texels.len(), 1);
    check(&gpu(), make, &expected);
}

#[test]
fn a_level_is_drawn_to() {
    let info = ImageInfo::new(FORMAT, 9, 8).with_levels(3);
    let make = |is_kept| {
        let mut images = Images::new(info, "", is_kept);
        images.fill(0, 1);
        images.clear(1, 77);
        images.reduce_to(2);
        images
    };
    let [full, drawn] = [0, 1].map(|level| Level::filled(&info, level, 1));
    let drawn = Level { texels: vec![77; drawn.texels.len()], ..drawn };
    let reduced = drawn.reduced([2, 2, 1]);
    check(&gpu(), make, &[full, drawn, reduced]);
}

#[test]
fn layers_and_volumes_are_filled_level_by_level() {
    let gpu = gpu();
    for (info, kind) in [
        (ImageInfo::new(FORMAT, 5, 3).with_layers(6).with_levels(3), "_layers"),
        (ImageInfo::new(FORMAT, 4, 4).with_layers(1), "_layers"),
        (ImageInfo::new(FORMAT, 5, 3).with_depth(9).with_levels(4), "_volume"),
        (ImageInfo::new(FORMAT, 65, 1).with_depth(1), "_volume"),
    ] {
        let base = |level: u32| 1000 * level + 7;
        let make = |is_kept| {
            let mut images = Images::new(info, kind, is_kept);
            (0..info.level_count).for_each(|level| images.fill(level, base(level)));
            images
        };
        let expected: Vec<_> = (0..info.level_count).map(|level| Level::filled(&info, level, base(level))).collect();
        check(&gpu, make, &expected);
    }
}

#[test]
fn a_history_has_levels_of_its_own() {
    let gpu = gpu();
    for level in 0..3 {
        let mut counter = Counter::new(&gpu, ImageInfo::new(FORMAT, 4, 4).with_levels(3), level);
        for frame in 1..6 {
            assert_eq!(counter.run(1), [frame; 2], "level {level}");
        }
    }
}

#[test]
fn what_was_written_is_read_level_by_level() {
    let gpu = gpu();
    let info = ImageInfo::new(FORMAT, 5, 3).with_depth(9).with_levels(2);
    let mut images = Images::new(info, "_volume", false);
    (0..2).for_each(|level| images.fill(level, level));
    let (executor, _) = images.run(&gpu);
    let mut written = Vec::new();
    let visit = |_, left: Vec<gridlight::gpu::Written>| {
        written.extend(left.into_iter().map(|left| (left.resource, left.level, left.bytes.len())));
        Ok(())
    };
    executor.run_and_read(&[], visit).unwrap();
    assert_eq!(written[..2], [(0, 0, 4 * 5 * 3 * 9), (0, 1, 4 * 2 * 4)]);
}

#[test]
fn an_image_begins_with_the_contents_that_it_is_given() {
    let gpu = gpu();
    let texels: Vec<u32> = (0..15).map(|i| i * i).collect();
    let given = Level { size_px: [5, 3, 1], texels };
    let mut graph = Graph::new();
    let info = ImageInfo::new(FORMAT, 5, 3);
    let image = graph.filled_image("filled", info, bytemuck::cast_slice(&given.texels).into());
    let (executor, sums) = Images { graph, image, info, kind: "" }.run(&gpu);
    assert_eq!(sums, [given.sum()]);
    assert_eq!(words(&executor.read_image(image).unwrap()), given.texels, "after two frames");
}

#[test]
fn an_image_that_the_device_does_not_have_is_an_error() {
    let gpu = gpu();
    for (info, what) in [
        (ImageInfo::new(FORMAT, 1 << 20, 1), "1048576x1x1 texels"),
        (ImageInfo::new(FORMAT, 1, 1).with_layers(1 << 20), "1048576 layers"),
        (ImageInfo::new(FORMAT, 1, 1).with_depth(1 << 20), "1x1x1048576 texels"),
        (ImageInfo::new(vk::Format::R8G8B8_UINT, 4, 4), "R8G8B8_UINT"),
    ] {
        let mut graph = Graph::new();
        let image = graph.persistent_image("huge", info);
        graph.add_pass(Pass::new("nothing", Work::Overlay).uses(image, Access::ComputeWrite));
        let error = Executor::new(&gpu.gpu, graph, None).err().expect("no device has it");
        assert!(
            error.to_string().starts_with("this device has no image `huge`") && error.to_string().contains(what),
            "{error}"
        );
    }
}
