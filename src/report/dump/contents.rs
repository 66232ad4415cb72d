//! From the bytes of what every frame and every scene has to arrays with named fields.

use crate::dump::{Array, DumpContext, Scalar, f, u};
use crate::environment::upload::PreparedEnvironment;
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

/// What is stored of an environment's image, three half floats a texel.
pub fn environment_map(environment: &PreparedEnvironment) -> Array {
    let [width, height] = environment.size_px.map(u64::from);
    let colors: Vec<u8> =
        environment.texels.iter().flat_map(|[r, g, b, _]| [r, g, b]).flat_map(|h| h.to_le_bytes()).collect();
    Array::plain(Scalar::F16, &[height, width, 3], &colors)
}

/// The sums that directions of an environment are drawn from.
pub fn environment_table(environment: &PreparedEnvironment) -> Array {
    Array::plain(Scalar::F32, &[environment.table.len() as u64], bytemuck::cast_slice(&environment.table))
}
