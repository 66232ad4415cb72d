//! What the CPU and the shaders share: constants and structs. They reach GLSL through the includes `constants.glsl` and
//! `shared/<struct>.glsl`, generated here, so that nothing is typed twice.

use std::fmt::Write as _;

mod motion;
mod structs;
mod table;
mod texels;

pub use motion::{ALL as MOTION_STRUCTS, JointWeight, MorphOffset, MovedTree, MovingBody, NodeBox, RestVertex};
pub use structs::{
    ALL as STRUCTS, BuiltGrid, CacheCounts, CachePlace, Emitter, FrameData, GpuMaterial, GridLight, GridPlacement,
    InspectedLevel, InspectedPixel, InspectedSample, InspectedTexel, LEVEL_ROWS, MicroTexel, PointCounts,
    PunctualLight, ShownPoint, StartCell, StartSample,
};

pub use table::{FieldInfo, FieldKind, SharedStruct, StructInfo};
pub use texels::{ALL as TEXEL_STRUCTS, BvhNode, BvhTriangle, PackedNode};

/// The text of the generated include `shared/<name>.glsl`: the struct's declaration, and for those that are read as texels
/// how they are put together. `None` where there is no such struct.
#[must_use]
pub fn glsl_struct(name: &str) -> Option<String> {
    let named = |list: &'static [StructInfo]| list.iter().find(|info| info.name == name);
    let from_texels = |info: &StructInfo| info.glsl() + &info.glsl_from_texels();
    let laid_out = named(STRUCTS).or_else(|| named(MOTION_STRUCTS));
    laid_out.map(StructInfo::glsl).or_else(|| named(TEXEL_STRUCTS).map(from_texels))
}

macro_rules! shared_constants {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: u32 = $value;)*

        /// The text of the generated include `constants.glsl`.
        #[must_use]
        pub fn glsl_constants() -> String {
            let mut text = String::new();
            $(let _ = writeln!(text, "#define {} {}u", stringify!($name), $name);)*
            text
        }
    };
}

shared_constants! {
    /// Invocations of a one-dimensional workgroup; the portability baseline allows 256.
    WORKGROUP_SIZE = 256;
    /// Edge of a two-dimensional workgroup.
    TILE_SIZE = 8;
    /// Invocations that gather one grid vertex together.
    GATHER_SIZE = 64;
    /// Fewest levels of the hierarchy.
    MIN_TOP_LEVEL = 2;
    /// Coarsest level that the tables have room for; levels are 1..=MAX_LEVEL, level 0 is the lights.
    MAX_LEVEL = 10;
    /// Entries of a sub-image in `sub_images`: its first merged light of each level, and the end.
    SUB_IMAGE_STRIDE = MAX_LEVEL + 2;
    /// Grid lights of the level below that a grid light is made of: vertices 2v + {-1, 0, 1}^3.
    DESCENT_PARTS = 27;
    /// Words of a descent table: the number of parts, then (cumulative luminance, grid light) of each.
    DESCENT_STRIDE = 2 * DESCENT_PARTS + 2;
    /// Lights of S0 drawn for each S1 light.
    REPRESENTATIVES = 4;
    /// Words per S1 moment record: 14 sums, each a 64-bit fixed-point number in two words.
    MOMENT_WORDS = 28;
    /// Most shadow samples (reservoirs) per pixel.
    MAX_SHADOW_SAMPLES = 16;
    /// Most shadow rays per pixel towards the environment.
    MAX_ENVIRONMENT_SAMPLES = 64;
    /// Tiles that one dispatch of a reference technique covers: 4,096 pixels.
    REFERENCE_TILES = 64;
    /// Words that one workgroup of the exclusive scan covers at a time.
    SCAN_CHUNK = 1024;
    /// Most blocks of an exclusive scan: each adds up the sums of those before it.
    SCAN_MAX_BLOCKS = 1024;
    /// Light kind in `PunctualLight`.
    LIGHT_DIRECTIONAL = 0;
    /// Light kind in `PunctualLight`.
    LIGHT_POINT = 1;
    /// Light kind in `PunctualLight`.
    LIGHT_SPOT = 2;
    /// Light kind in `PunctualLight`: all surfaces that shine by themselves together.
    LIGHT_EMITTERS = 3;
    /// `--lobe mixture`.
    LOBE_MIXTURE = 0;
    /// `--lobe clamped-normal`.
    LOBE_CLAMPED_NORMAL = 1;
    /// `--lobe sh1`.
    LOBE_SH1 = 2;
    /// `--lobe sh1-nonlinear`.
    LOBE_SH1_NONLINEAR = 3;
    /// Bins of the exposure's histogram, once for surfaces and once for the background.
    EXPOSURE_BINS = 1024;
    /// Stops that they cover, half of them below luminance 1: limits of the automatic exposure.
    EXPOSURE_STOPS = 64;
    /// `--tone-map reinhard`.
    TONE_MAP_REINHARD = 0;
    /// `--tone-map agx`.
    TONE_MAP_AGX = 1;
    /// `--tone-map neutral`.
    TONE_MAP_NEUTRAL = 2;
    /// Workgroups in a row of a dispatch that has several; one with fewer has one row.
    DISPATCH_WIDTH = 32_768;
    /// Vertices of a light volume: an icosahedron.
    LIGHT_VOLUME_VERTICES = 60;
    /// Merged lights in a row of the image that holds them once more.
    LIGHTS_PER_ROW = 1024;
    /// Texels of a light in that image.
    LIGHT_TEXELS = 3;
    /// A reservoir that holds no light.
    SAMPLE_EMPTY = 0;
    /// A shadow sample whose light sends nothing to the pixel.
    SAMPLE_UNLIT = 1;
    /// A shadow sample with nothing before its light.
    SAMPLE_VISIBLE = 2;
    /// A shadow sample with something before its light.
    SAMPLE_BLOCKED = 3;
    /// Texels in a row of the images that hold BVH nodes and triangles: the edge that every device's images can have.
    WORD_ROW_TEXELS = 4096;
    /// No eight-wide BVH is deeper: a traversal stacks at most one group of siblings for each level.
    MAX_WIDE_DEPTH = 32;
    /// Flag of a `MovingBody` whose triangles have the order of their corners turned, because the node mirrors.
    BODY_IS_TURNED = 1;
    /// Flag of a `MovingBody` whose vertices have tangents.
    BODY_HAS_TANGENTS = 2;
    /// Flag of a `MovingBody` whose vertices have the normals of their triangles.
    BODY_IS_FLAT = 4;
    /// What stands for no packed tangent: no direction has this y.
    NO_TANGENT = 0x8000_0000;
    /// The bit of a packed tangent that is set where the bitangent is on the other side; x has the bits below.
    TANGENT_SIDE = 0x8000;
    /// Largest x of a packed tangent, which has 15 bits.
    MOST_TANGENT_X = 16_383;
    /// Words of a matrix in a pose: four columns of three numbers.
    POSE_MATRIX_WORDS = 12;
    /// The farthest a vertex may be from the origin along an axis, in metres.
    MOST_METRES = 1_000_000_000;
    /// Flag of a `BvhTriangle` whose material is alpha-masked.
    TRIANGLE_ALPHA_MASKED = 1;
    /// In the last word of a `PackedNode`: its representative leaf.
    POINT_LEAF_MASK = 0x001f_ffff;
    /// Flag there: all its leaves lie on closed surfaces, of which only the outside is seen.
    POINT_IS_SOLID = 0x4000_0000;
    /// Flag there: its normal opposes its parent's, so that the two name their sides the other way round.
    POINT_IS_TURNED = 0x8000_0000;
    /// Most points that a view draws: they fill 128 MiB.
    MOST_SHOWN_POINTS = 4_194_304;
    /// A point with a micro-buffer of its own.
    LIGHT_OF_ITS_OWN = 0;
    /// A point that has the mean of its children's light.
    LIGHT_OF_CHILDREN = 1;
    /// A point that is a primary point or lies under one, and has its light.
    LIGHT_OF_PRIMARY = 2;
    /// A point that borrows the light of the one above.
    LIGHT_OF_PARENT = 3;
    /// A pixel with caches in whose reach it lies.
    CACHES_IN_REACH = 0;
    /// A pixel with caches in twice whose reach it lies.
    CACHES_STRETCHED = 1;
    /// A pixel that has the light of the nearest cache.
    CACHES_NEAREST = 2;
    /// A pixel without any.
    CACHES_NONE = 3;
    /// The list of keys that has the primary points.
    POINT_LIST_PRIMARIES = 0;
    /// The list of keys that need a micro-buffer of their own.
    POINT_LIST_NEEDED = 1;
    /// Indirect dispatches of each list of keys.
    POINT_DISPATCHES = 3;
    /// Of these: a workgroup for each key.
    POINT_DISPATCH_GROUP_EACH = 0;
    /// A thread for each key, in workgroups of `WORKGROUP_SIZE`.
    POINT_DISPATCH_THREAD_EACH = 1;
    /// A workgroup for four keys.
    POINT_DISPATCH_GROUP_OF_FOUR = 2;
    /// Edge in texels of the micro-buffer of a primary point.
    PRIMARY_EDGE = 16;
    /// Edge in texels of the micro-buffer of a secondary point.
    SECONDARY_EDGE = 8;
    /// Edge of the square of lobes that a micro-buffer is convolved with.
    LOBE_EDGE = 5;
    /// Invocations that light a point or fill its micro-buffer together.
    POINT_LANES = 64;
    /// Edge in pixels of the tiles that caches are listed for.
    CACHE_TILE = 16;
    /// Most caches that a tile has room for.
    MOST_TILE_CACHES = 2048;
    /// Sides of leaves that a dispatch of `pbgi-reference` lights.
    KEYS_PER_PART = 4096;
    /// Fewest points that stand for a scene's surfaces.
    MIN_POINTS = 4096;
    /// Most points.
    MAX_POINTS = 2_097_152;
    /// Most primary points: their micro-buffers fill 128 MiB.
    MAX_PRIMARIES = 131_072;
    /// Leaves that are kept for a point.
    POINT_LEAVES = 4;
    /// Columns of the environment's means.
    BLURRED_COLUMNS = 64;
    /// Rows of the environment's means.
    BLURRED_ROWS = 32;
    /// Sizes of the caps that the environment's means are taken over.
    BLURRED_LEVELS = 3;
    /// Words of a scene vertex: `scene::Vertex`.
    VERTEX_WORDS = 8;
    /// Bit of a material's flags: it has a normal map.
    MATERIAL_NORMAL_MAP = 1;
    /// Bit of a material's flags: the colours of its vertices are factors of the base colour.
    MATERIAL_VERTEX_COLORS = 2;
    /// Bit of a material's flags: between texels of the base colour it has the nearest one.
    MATERIAL_NEAREST = 4;
    /// Where two bits for each axis begin that say what the base colour's texture is beyond its edges: a `WRAP_`.
    MATERIAL_WRAP_SHIFT = 3;
    /// Bit of a material's flags: its surface has a front alone.
    MATERIAL_SINGLE_SIDED = 128;
    /// Where bits begin that say of the emission's texture what the lowest say of that of the base colour.
    MATERIAL_EMISSION_SHIFT = 8;
    /// Bit of a material's flags: it is seen as its base colour, in whatever light.
    MATERIAL_UNLIT = 32_768;
    /// The same again.
    WRAP_REPEAT = 0;
    /// The same again, every other time mirrored.
    WRAP_MIRROR = 1;
    /// The texels at the edge.
    WRAP_CLAMP = 2;
    /// Marks "no texture layer".
    NO_LAYER = 0xffff_ffff;
    /// Marks "no light" in a reservoir.
    NO_LIGHT = 0xffff_ffff;
}
