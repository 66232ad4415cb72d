//! From the bytes of what every frame and every scene has to arrays with named fields.

use crate::dump::{Array, DumpContext, f, u};
use crate::shared::{FrameData, GpuMaterial, PunctualLight, SharedStruct};

/// `FrameData`.
pub fn frame_data(bytes: &[u8], _: &DumpContext<'_>) -> Array {
    Array::structs(&FrameData::INFO, |_| true, 1, bytes)
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
    Array::structs(&GpuMaterial::INFO, |_| true, count, bytes)
}

/// `PunctualLight`s.
pub fn punctual_lights(bytes: &[u8], count: u64) -> Array {
    Array::structs(&PunctualLight::INFO, |_| true, count, bytes)
}
