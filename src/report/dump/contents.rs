//! From the bytes of what every frame and every scene has to arrays with named fields.

use crate::dump::{Array, DumpContext, f, u};
use crate::shared::LEVEL_ROWS;

/// `FrameData`.
pub fn frame_data(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    let vectors = ["eye_near", "forward", "right", "up", "scene_sphere"].map(|name| f(name, &[4]));
    let integers = ["size", "sampling", "counts", "lights"].map(|name| u(name, &[4]));
    let mut fields = vec![f("clip_from_world", &[4, 4])];
    fields.extend(vectors);
    fields.extend(integers);
    fields.extend([f("tuning", &[4]), u("accumulation", &[4]), u("levels", &[LEVEL_ROWS as u64, 4])]);
    Array::records(fields, &[1], bytes)
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
