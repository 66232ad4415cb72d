//! Checks the passes of a frame against what their shaders ask for, without a device.

use ash::vk::PipelineStageFlags2 as Stages;

use super::work::{ComputeWork, Constants, RasterWork, Work};
use crate::graph::{Access, BindingName, Graph, ImageDepth, Kind, Pass, ResourceInfo, Use};
use crate::shader::interface::{Binding, BindingKind, ImageDimension, Interface};
use crate::shader::spirv;
use crate::shader::variants::Stage;

/// Why a pass does not fit its shaders.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pass `{pass}`: {fault}")]
pub struct InterfaceError {
    /// The pass.
    pub pass: String,
    /// What is wrong.
    pub fault: Fault,
}

/// What can be wrong between a pass and its shaders.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// A shader that is not among the compiled ones.
    #[error("there is no shader `{0}`")]
    NoShader(String),
    /// A binding that a shader has and the pass leaves out.
    #[error("nothing is bound to `{0}`")]
    MissingBinding(String),
    /// A binding of the pass that no shader has.
    #[error("`{0}` is bound, which no shader has")]
    ExtraBinding(String),
    /// Two shaders of the pass with different bindings of one name.
    #[error("its shaders disagree about `{0}`")]
    Disagreement(String),
    /// A buffer where the shader has an image, or the like.
    #[error("`{binding}` is bound as a {bound:?}, the shader has a {wanted:?}")]
    WrongKind {
        /// The binding.
        binding: String,
        /// As what the pass binds it.
        bound: BindingKind,
        /// As what the shader declares it.
        wanted: BindingKind,
    },
    /// A flat image where the shader has an array, or the like.
    #[error("`{binding}` is bound as a {bound:?} image, the shader has a {wanted:?} one")]
    WrongDimension {
        /// The binding.
        binding: String,
        /// The image that the pass binds.
        bound: ImageDimension,
        /// The image that the shader declares.
        wanted: ImageDimension,
    },
    /// A declared write through something that the shader does not write.
    #[error("`{0}` is declared as written, but the shader only reads it")]
    NeverWritten(String),
    /// A write that the pass does not declare.
    #[error("`{0}` is declared as only read, but the shader writes it")]
    UndeclaredWrite(String),
    /// Contents that the pass says it does not need.
    #[error("`{0}` is declared as overwritten, but the shader reads it")]
    UndeclaredRead(String),
    /// An access whose stages leave out a shader that has the binding.
    #[error("`{0}` is used in a stage that its access leaves out")]
    WrongStage(String),
    /// Push constants of another size.
    #[error("{given} bytes are pushed, `{shader}` takes {wanted}")]
    PushSize {
        /// The shader.
        shader: String,
        /// Bytes that the pass gives.
        given: u32,
        /// Bytes that the shader takes.
        wanted: u32,
    },
    /// A specialization constant that no shader has.
    #[error("no shader has the constant `{0}`")]
    ExtraConstant(String),
    /// A specialization constant that the pass does not give.
    #[error("the constant `{0}` is not given")]
    MissingConstant(String),
    /// Reads the scene without saying so, or the other way round.
    #[error("whether it uses the scene is said wrongly")]
    Scene,
}

impl From<InterfaceError> for crate::Error {
    fn from(error: InterfaceError) -> Self {
        Self::Failure(format!("the frame graph is wrong: {error}"))
    }
}

/// The shaders of one pipeline.
struct Shaders {
    modules: Vec<(String, Interface)>,
}

impl Shaders {
    fn new(names: &[&String]) -> Result<Self, Fault> {
        let module = |name: &&String| {
            let interface = spirv::interface(name).map_err(|_| Fault::NoShader((*name).clone()))?;
            Ok(((*name).clone(), interface))
        };
        Ok(Self { modules: names.iter().map(module).collect::<Result<_, Fault>>()? })
    }

    fn bindings(&self) -> impl Iterator<Item = (Stage, &Binding)> {
        self.modules.iter().flat_map(|(_, i)| i.bindings.iter().map(|b| (i.stage, b)))
    }

    /// The bindings called `name`, one for each module that has it.
    fn named(&self, name: BindingName) -> impl Iterator<Item = (Stage, &Binding)> {
        self.bindings().filter(move |(_, b)| is_called(b, name))
    }

    /// Bytes of push constants and specialization constants against those that the pass gives.
    fn check_constants(&self, push_words: usize, constants: &Constants) -> Result<(), Fault> {
        let given = 4 * push_words as u32;
        let (shader, wanted) = self.modules.iter().map(|(n, i)| (n, i.push_bytes)).max_by_key(|(_, p)| *p).unzip();
        if let (Some(shader), Some(wanted)) = (shader, wanted.filter(|wanted| *wanted != given)) {
            return Err(Fault::PushSize { shader: shader.clone(), given, wanted });
        }
        let known = |name: &str| self.modules.iter().any(|(_, i)| i.constants.contains_key(name));
        if let Some((name, _)) = constants.iter().find(|(name, _)| !known(name)) {
            return Err(Fault::ExtraConstant((*name).to_owned()));
        }
        let mut wanted = self.modules.iter().flat_map(|(_, i)| i.constants.keys());
        match wanted.find(|name| constants.iter().all(|(given, _)| given != name)) {
            Some(name) => Err(Fault::MissingConstant(name.clone())),
            None => Ok(()),
        }
    }
}

/// Whether a pass means this binding by a name.
fn is_called(binding: &Binding, name: BindingName) -> bool {
    match name {
        BindingName::Name(name) => binding.name == name,
        BindingName::Number(number) => binding.set == 0 && binding.binding == number,
    }
}

/// The set-0 number of each binding of a pass, in the order of its uses that have one.
///
/// # Errors
/// When its shaders have no such binding, or are missing themselves.
pub(super) fn binding_numbers(pass: &Pass<Work>) -> Result<Vec<(u32, Use)>, InterfaceError> {
    let in_pass = |fault| InterfaceError { pass: pass.name.clone(), fault };
    let pipelines = pipelines(pass).map_err(in_pass)?;
    let number = |used: &Use| {
        let name = used.binding?;
        let found = pipelines.iter().flat_map(|p| p.named(name)).next();
        Some(found.map(|(_, b)| (b.binding, *used)).ok_or_else(|| in_pass(Fault::ExtraBinding(name.to_string()))))
    };
    pass.uses.iter().filter_map(number).collect()
}

/// Checks every pass of a frame against its shaders.
///
/// # Errors
/// Names the first pass that does not fit, and its binding or constant.
pub fn check_interfaces(graph: &Graph<Work>) -> Result<(), InterfaceError> {
    graph
        .passes()
        .iter()
        .try_for_each(|pass| check_pass(graph, pass).map_err(|fault| InterfaceError { pass: pass.name.clone(), fault }))
}

fn pipelines(pass: &Pass<Work>) -> Result<Vec<Shaders>, Fault> {
    match &pass.payload {
        Work::Compute(work) => Ok(vec![Shaders::new(&[&work.shader])?]),
        Work::Raster(work) => work.draws.iter().map(|d| Shaders::new(&[&d.vertex, &d.fragment])).collect(),
        Work::Transfer(_) | Work::BuildStructure { .. } | Work::Overlay => Ok(Vec::new()),
    }
}

fn check_pass(graph: &Graph<Work>, pass: &Pass<Work>) -> Result<(), Fault> {
    let pipelines = pipelines(pass)?;
    match &pass.payload {
        Work::Compute(work) => check_compute(&pipelines, work)?,
        Work::Raster(work) => check_raster(&pipelines, work)?,
        Work::Transfer(_) | Work::BuildStructure { .. } | Work::Overlay => {}
    }
    for used in pass.uses.iter().filter(|used| used.binding.is_some()) {
        check_binding(&pipelines, used, graph.resources()[used.resource.index()].info)?;
    }
    let bound = |b: &Binding| pass.uses.iter().filter_map(|used| used.binding).any(|name| is_called(b, name));
    let mut wanted = pipelines.iter().flat_map(Shaders::bindings).filter(|(_, b)| b.set == 0);
    match wanted.find(|(_, b)| !bound(b)) {
        Some((_, binding)) => Err(Fault::MissingBinding(binding.name.clone())),
        None => Ok(()),
    }
}

fn check_compute(pipelines: &[Shaders], work: &ComputeWork) -> Result<(), Fault> {
    pipelines.iter().try_for_each(|p| p.check_constants(work.push_words(), &work.constants))?;
    check_scene(pipelines, work.uses_scene)
}

fn check_raster(pipelines: &[Shaders], work: &RasterWork) -> Result<(), Fault> {
    for (shaders, draw) in pipelines.iter().zip(&work.draws) {
        shaders.check_constants(draw.push.len(), &draw.constants)?;
    }
    check_scene(pipelines, work.uses_scene)
}

/// The scene is in set 1, its materials' textures in set 2.
fn check_scene(pipelines: &[Shaders], uses_scene: bool) -> Result<(), Fault> {
    let has_scene = pipelines.iter().flat_map(Shaders::bindings).any(|(_, b)| b.set > 0);
    if has_scene == uses_scene { Ok(()) } else { Err(Fault::Scene) }
}

fn check_binding(pipelines: &[Shaders], used: &Use, info: ResourceInfo) -> Result<(), Fault> {
    let resource = info.kind();
    let Some(name) = used.binding else { return Ok(()) };
    let declared: Vec<(Stage, &Binding)> = pipelines.iter().flat_map(|p| p.named(name)).collect();
    let Some((_, first)) = declared.first() else { return Err(Fault::ExtraBinding(name.to_string())) };
    let binding = first.name.clone();
    let same = |b: &Binding| (b.set, b.binding, b.kind, b.dimension) == (0, first.binding, first.kind, first.dimension);
    if !declared.iter().all(|(_, b)| same(b)) {
        return Err(Fault::Disagreement(binding));
    }
    let bound = kind_of(used.access, resource);
    if bound != first.kind {
        return Err(Fault::WrongKind { binding, bound, wanted: first.kind });
    }
    if let (Some(bound), Some(wanted)) = (dimension_of(info).filter(|d| Some(*d) != first.dimension), first.dimension) {
        return Err(Fault::WrongDimension { binding, bound, wanted });
    }
    let stages = used.access.sync(resource).stages;
    if declared.iter().any(|(stage, _)| !stages.contains(pipeline_stage(*stage))) {
        return Err(Fault::WrongStage(binding));
    }
    let (reads, writes) = (declared.iter().any(|(_, b)| b.reads), declared.iter().any(|(_, b)| b.writes));
    if used.access.is_write() && !writes {
        return Err(Fault::NeverWritten(binding));
    }
    if !used.access.is_write() && writes {
        return Err(Fault::UndeclaredWrite(binding));
    }
    if !used.access.is_read() && reads {
        return Err(Fault::UndeclaredRead(binding));
    }
    Ok(())
}

/// As what an access binds a resource.
pub(super) fn kind_of(access: Access, resource: Kind) -> BindingKind {
    match (resource, access) {
        (Kind::Buffer, Access::ComputeUniform | Access::GraphicsUniform) => BindingKind::UniformBuffer,
        (Kind::Buffer, _) => BindingKind::StorageBuffer,
        (_, Access::ComputeSampled | Access::FragmentSampled | Access::DepthAttachmentReadSampled) => {
            BindingKind::SampledImage
        }
        _ => BindingKind::StorageImage,
    }
}

fn dimension_of(info: ResourceInfo) -> Option<ImageDimension> {
    let ResourceInfo::Image(info) = info else { return None };
    Some(match info.depth {
        ImageDepth::Flat => ImageDimension::D2,
        ImageDepth::Layers(_) => ImageDimension::D2Array,
        ImageDepth::Texels(_) => ImageDimension::D3,
    })
}

fn pipeline_stage(stage: Stage) -> Stages {
    match stage {
        Stage::Vertex => Stages::VERTEX_SHADER,
        Stage::Fragment => Stages::FRAGMENT_SHADER,
        Stage::Compute => Stages::COMPUTE_SHADER,
    }
}
