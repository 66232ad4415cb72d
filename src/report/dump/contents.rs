//! From the bytes of a buffer to an array that can be read without knowing how the passes pack things: only the part
//! that the pass wrote, records with named fields. What a pass left unwritten is 0 in the array, since the memory
//! there holds whatever was in it before.

use super::array::{Array, Field, Scalar};
use crate::passes::FrameShape;
use crate::settings::Reservoir;
use crate::shared::{LEVEL_ROWS, MAX_LEVEL, MOMENT_WORDS, NO_LIGHT};

/// Words of a sub-image in `tiles`, and rows of the level table.
const LEVELS: u64 = MAX_LEVEL as u64 + 2;
/// Parts in a descent table (`descent/tables.glsl`).
const DESCENT_PARTS: usize = 27;
/// Representatives of an S1 light (`descent/representatives.glsl`).
const REPRESENTATIVES: u64 = 4;

/// What is known of the frame when a buffer is taken apart.
#[derive(Clone, Debug)]
pub struct Known {
    /// Sizes, capacities and modes.
    pub shape: FrameShape,
    /// The pass that wrote the buffer.
    pub pass: String,
    /// Its push constants.
    pub push: Vec<u32>,
    light_counts: Vec<u32>,
    level_table: Vec<u32>,
    tiles: Vec<u32>,
    slot_bits: Vec<u32>,
}

impl Known {
    /// Nothing but the shape.
    #[must_use]
    pub fn new(shape: FrameShape) -> Self {
        let words = |count: u64| vec![0; count as usize];
        Self {
            shape,
            pass: String::new(),
            push: Vec::new(),
            light_counts: words(4),
            level_table: words(2 * LEVELS + 1),
            tiles: Vec::new(),
            slot_bits: Vec::new(),
        }
    }

    /// Remembers what tells how much of other buffers is in use. Call it for everything that a pass wrote before
    /// anything of that pass is taken apart.
    pub fn note(&mut self, resource: &str, bytes: &[u8]) {
        let slot = match resource {
            "light_counts" => &mut self.light_counts,
            "level_table" => &mut self.level_table,
            "tiles" => &mut self.tiles,
            "vpl_slot_bits" => &mut self.slot_bits,
            _ => return,
        };
        *slot = words(bytes);
    }

    /// First light of a level in the grid lights, and number of lights.
    fn level(&self, level: u32) -> (u64, u64) {
        let row = 2 * level as usize;
        (self.level_table[row].into(), self.level_table[row + 1].into())
    }

    /// First light and number of lights of the levels that the pass was pushed.
    fn pushed_levels(&self) -> (u64, u64) {
        let first = self.push.first().copied().unwrap_or(1);
        let last = self.push.get(1).copied().unwrap_or(first);
        (self.level(first).0, (first..=last).map(|l| self.level(l).1).sum())
    }

    fn pixels(&self) -> [u64; 2] {
        [self.shape.height_px.into(), self.shape.width_px.into()]
    }

    fn interleaved_pixels(&self) -> [u64; 2] {
        let [width, height] = self.shape.interleaved_px();
        [height.into(), width.into()]
    }

    /// End of the merged list.
    fn merged_count(&self) -> u64 {
        let tiles = (self.shape.interleave * self.shape.interleave) as usize;
        let index = (tiles - 1) * LEVELS as usize + self.shape.levels.top as usize + 1;
        self.tiles.get(index).copied().unwrap_or(0).into()
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn bytes_of(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

fn f(name: &str, shape: &[u64]) -> Field {
    Field::new(name, Scalar::F32, shape)
}

fn u(name: &str, shape: &[u64]) -> Field {
    Field::new(name, Scalar::U32, shape)
}

/// All of it as words.
pub fn all_words(bytes: &[u8], _: &Known) -> Array {
    Array::plain(Scalar::U32, &[bytes.len() as u64 / 4], bytes)
}

/// `FrameData`.
pub fn frame_data(bytes: &[u8], _: &Known) -> Array {
    let vectors = ["eye_near", "forward", "right", "up", "scene_sphere"].map(|name| f(name, &[4]));
    let integers = ["size", "sampling", "counts", "lights"].map(|name| u(name, &[4]));
    let mut fields = vec![f("clip_from_world", &[4, 4])];
    fields.extend(vectors);
    fields.extend(integers);
    fields.extend([f("tuning", &[4]), u("accumulation", &[4]), u("levels", &[LEVEL_ROWS as u64, 4])]);
    Array::records(fields, &[1], bytes)
}

/// Packed position and octahedral normal.
fn position_fields() -> Vec<Field> {
    vec![f("position_ws", &[3]), Field::new("normal_octahedral", Scalar::I16, &[2])]
}

fn flux_fields() -> Vec<Field> {
    vec![f("flux", &[3]), f("is_vpl", &[])]
}

/// Records of 16 bytes in path slots, those without a VPL zeroed.
fn slots(fields: Vec<Field>, bytes: &[u8], known: &Known) -> Array {
    let count = known.shape.slot_count();
    let mut array = Array::records(fields, &[count.into()], bytes);
    for slot in 0..count as usize {
        if known.slot_bits.get(slot / 32).is_none_or(|word| word >> (slot % 32) & 1 == 0) {
            array.bytes[16 * slot..16 * (slot + 1)].fill(0);
        }
    }
    array
}

/// Positions and normals where paths left them.
pub fn slot_positions(bytes: &[u8], known: &Known) -> Array {
    slots(position_fields(), bytes, known)
}

/// Fluxes where paths left them.
pub fn slot_fluxes(bytes: &[u8], known: &Known) -> Array {
    slots(flux_fields(), bytes, known)
}

/// Positions and normals of S0.
pub fn light_positions(bytes: &[u8], known: &Known) -> Array {
    Array::records(position_fields(), &[known.light_counts[0].into()], bytes)
}

/// Fluxes of S0.
pub fn light_fluxes(bytes: &[u8], known: &Known) -> Array {
    Array::records(flux_fields(), &[known.light_counts[0].into()], bytes)
}

/// Lights of S0 by cell. Before they are sorted their order within a cell is left to chance, so that only which they are
/// is told: in the order of their numbers.
pub fn light_bucket_lights(bytes: &[u8], known: &Known) -> Array {
    let count = known.light_counts[0];
    let mut lights = words(bytes);
    lights.truncate(count as usize);
    if known.pass.ends_with("list_lights") {
        lights.sort_unstable();
    }
    Array::plain(Scalar::U32, &[count.into()], &bytes_of(&lights))
}

/// The three counts.
pub fn light_counts(bytes: &[u8], _: &Known) -> Array {
    Array::records(vec![u("lights", &[]), u("vpls", &[]), u("vpls_lost", &[])], &[1], bytes)
}

/// The scanned range of the ranks: after the second step of the scan only the entry past its end is there.
pub fn ranks(bytes: &[u8], known: &Known) -> Array {
    let [first, count] = [0, 1].map(|i| u64::from(known.push.get(i).copied().unwrap_or(0)));
    let (start, length) = if known.pass.ends_with("scan_block_sums") { (first + count, 1) } else { (first, count + 1) };
    Array::plain(Scalar::U32, &[length], &bytes[4 * start as usize..]).starting_at(start)
}

/// Bounds, from integers that are ordered like the floats back to floats.
pub fn bounds(bytes: &[u8], _: &Known) -> Array {
    let float = |ordered: u32| if ordered >> 31 == 1 { ordered & 0x7fff_ffff } else { !ordered };
    let mut floats: Vec<u32> = words(bytes).into_iter().take(7).map(float).collect();
    // Minima are kept as maxima of the negated coordinate.
    floats[3..6].iter_mut().for_each(|bits| *bits ^= 0x8000_0000);
    let fields = vec![f("highest_ws", &[3]), f("lowest_ws", &[3]), f("largest_flux", &[])];
    Array::records(fields, &[1], &bytes_of(&floats))
}

/// `GridPlacement`.
pub fn grid_placement(bytes: &[u8], _: &Known) -> Array {
    let floats = [f("origin_ws", &[3]), f("h_top", &[]), f("inverse_h_top", &[]), f("flux_scale", &[])];
    let mut fields = floats.to_vec();
    fields.push(u("light_count", &[]));
    // The padding is left out: 28 of 32 bytes.
    Array::records(fields, &[1], bytes)
}

fn grid_light_fields() -> Vec<Field> {
    vec![
        f("position_ws", &[3]),
        f("luminance", &[]),
        f("variance", &[3]),
        u("level", &[]),
        f("lobe", &[3]),
        f("weight", &[]),
        f("flux", &[3]),
        u("vertex", &[]),
    ]
}

/// Grid lights of the levels that the pass made; of a listed vertex only its level and index.
pub fn grid_lights(bytes: &[u8], known: &Known) -> Array {
    let (first, count) = known.pushed_levels();
    let part = &bytes[64 * first as usize..64 * (first + count) as usize];
    if known.pass.starts_with("compaction/") {
        let listed: Vec<u8> = part.chunks_exact(64).flat_map(|l| [&l[28..32], &l[60..64]].concat()).collect();
        return Array::records(vec![u("level", &[]), u("vertex", &[])], &[count], &listed).starting_at(first);
    }
    Array::records(grid_light_fields(), &[count], part).starting_at(first)
}

/// The merged list up to its end.
pub fn merged_lights(bytes: &[u8], known: &Known) -> Array {
    Array::records(grid_light_fields(), &[known.merged_count()], bytes)
}

/// Fixed-point sums of the levels that the pass added to.
pub fn moments(bytes: &[u8], known: &Known) -> Array {
    let (first, count) = known.pushed_levels();
    let record = 4 * MOMENT_WORDS as usize;
    let part = &bytes[record * first as usize..];
    Array::plain(Scalar::I64, &[count, u64::from(MOMENT_WORDS) / 2], part).starting_at(first)
}

/// First light and number of lights by level, and the lights lost.
pub fn level_table(bytes: &[u8], _: &Known) -> Array {
    Array::records(vec![u("first_and_count", &[LEVELS, 2]), u("lost", &[])], &[1], bytes)
}

/// Indirect dispatches; those not yet written are zeroed.
pub fn level_dispatches(bytes: &[u8], known: &Known) -> Array {
    let last = known.push.get(1).copied().unwrap_or(MAX_LEVEL);
    let mut words = words(bytes);
    for (slot, dispatch) in words.chunks_exact_mut(3).enumerate() {
        let slot = slot as u32;
        let level = if slot > MAX_LEVEL { slot - MAX_LEVEL - 1 } else { slot };
        if slot != 0 && (level == 0 || level > last) {
            dispatch.fill(0);
        }
    }
    Array::plain(Scalar::U32, &[words.len() as u64 / 3, 3], &bytes_of(&words))
}

/// One dispatch.
pub fn merge_dispatch(bytes: &[u8], _: &Known) -> Array {
    Array::plain(Scalar::U32, &[1, 3], bytes)
}

/// Starts of the used levels of every sub-image.
pub fn tiles(bytes: &[u8], known: &Known) -> Array {
    let (first, end) = (known.shape.first_level as usize, known.shape.levels.top as usize + 1);
    let mut words = words(bytes);
    for tile in words.chunks_exact_mut(LEVELS as usize) {
        tile[..first].fill(0);
        tile[end + 1..].fill(0);
    }
    Array::plain(Scalar::U32, &[words.len() as u64 / LEVELS, LEVELS], &bytes_of(&words))
}

/// `VkDrawIndirectCommand`s.
pub fn draws(bytes: &[u8], _: &Known) -> Array {
    let fields = ["vertex_count", "instance_count", "first_vertex", "first_instance"].map(|name| u(name, &[]));
    Array::records(fields.to_vec(), &[bytes.len() as u64 / 16], bytes)
}

/// Fragments by pixel in the interleaved layout; nothing where they are not counted.
pub fn overdraw(bytes: &[u8], known: &Known) -> Array {
    let shape = known.interleaved_pixels();
    // Views leave the counting out whatever the shape says.
    let counted = known.shape.count_overdraw && bytes.len() as u64 == 4 * shape[0] * shape[1];
    Array::plain(Scalar::U32, &if counted { shape } else { [0, 0] }, bytes)
}

/// Reservoirs by pixel in the interleaved layout.
pub fn reservoirs(bytes: &[u8], known: &Known) -> Array {
    let [height, width] = known.interleaved_pixels();
    let samples = u64::from(known.shape.shadow_samples);
    match known.shape.reservoir {
        // One 64-bit word: the key above the light.
        Reservoir::Exact => Array::records(vec![u("light", &[]), f("key", &[])], &[height, width, samples], bytes),
        Reservoir::Race | Reservoir::Lock => {
            let fields = vec![u("lock", &[]), f("total", &[]), u("light", &[samples])];
            Array::records(fields, &[height, width], bytes)
        }
    }
}

/// A word for every pixel of the picture.
pub fn per_pixel(bytes: &[u8], known: &Known) -> Array {
    Array::plain(Scalar::U32, &known.pixels(), bytes)
}

/// Descent tables of the lights above S1; unused parts have no light.
pub fn descent_tables(bytes: &[u8], known: &Known) -> Array {
    let stride = 2 * DESCENT_PARTS + 2;
    let upper: u64 = (2..=known.shape.levels.top).map(|l| known.level(l).1).sum();
    let count = upper.min((bytes.len() / (4 * stride)) as u64);
    let words = words(bytes);
    let mut unpacked = Vec::new();
    for table in words.chunks_exact(stride).take(count as usize) {
        let parts = table[0].min(DESCENT_PARTS as u32);
        let part =
            |i: usize, unused: u32, offset: usize| if i < parts as usize { table[2 * i + offset] } else { unused };
        unpacked.push(parts);
        unpacked.extend((0..DESCENT_PARTS).map(|i| part(i, 0, 2)));
        unpacked.extend((0..DESCENT_PARTS).map(|i| part(i, NO_LIGHT, 3)));
    }
    let parts = DESCENT_PARTS as u64;
    let fields = vec![u("parts", &[]), f("cumulative_luminance", &[parts]), u("light", &[parts])];
    Array::records(fields, &[count], &bytes_of(&unpacked))
}

/// Representatives of the S1 lights: race key and light of S0.
pub fn representatives(bytes: &[u8], known: &Known) -> Array {
    let index_bits = known.push.first().copied().unwrap_or(1);
    let count = known.level(1).1;
    let split = |word: u32| match word {
        // No light has been drawn.
        u32::MAX => [NO_LIGHT, u32::MAX >> index_bits],
        word => [word & ((1 << index_bits) - 1), word >> index_bits],
    };
    let used = (count * REPRESENTATIVES) as usize;
    let unpacked: Vec<u32> = words(bytes).into_iter().take(used).flat_map(split).collect();
    Array::records(vec![u("light", &[]), u("key", &[])], &[count, REPRESENTATIVES], &bytes_of(&unpacked))
}

/// One float.
pub fn exposure(bytes: &[u8], _: &Known) -> Array {
    Array::plain(Scalar::F32, &[1], bytes)
}

/// `BvhTriangle`s.
pub fn triangles(bytes: &[u8], count: u64) -> Array {
    let fields = vec![
        f("v0_ws", &[3]),
        u("triangle", &[]),
        f("edge1", &[3]),
        u("material", &[]),
        f("edge2", &[3]),
        u("flags", &[]),
    ];
    Array::records(fields, &[count], bytes)
}

/// `GpuMaterial`s.
pub fn materials(bytes: &[u8], count: u64) -> Array {
    let numbers = [f("alpha_cutoff", &[]), f("normal_scale", &[])];
    let mut fields = vec![f("base_color", &[4]), u("albedo_layer", &[])];
    fields.extend(numbers);
    fields.push(u("has_normal_map", &[]));
    Array::records(fields, &[count], bytes)
}

/// `PunctualLight`s.
pub fn punctual_lights(bytes: &[u8], count: u64) -> Array {
    let fields = vec![
        f("position_ws", &[3]),
        u("kind", &[]),
        f("direction_ws", &[3]),
        f("inner_cos", &[]),
        f("intensity", &[3]),
        f("outer_cos", &[]),
        f("path_cdf", &[]),
        f("path_probability", &[]),
        f("padding", &[2]),
    ];
    Array::records(fields, &[count], bytes)
}
