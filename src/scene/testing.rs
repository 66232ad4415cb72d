//! Support for tests: tiny scenes in memory, a GLB writer and the place of the large shared assets.
//!
//! Part of the library so that integration tests can use it; the program itself does not.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::gltf::bounds;
use super::gltf_materials::default_material;
use super::gltf_nodes::{default_sun, framing_camera};
use super::motion::Motion;
use super::octahedral::pack_octahedral;
use super::{Draw, LitBy, Material, Scene, Vertex};

/// A white square in the plane y = 0, centred at the origin, `size` metres wide, facing up.
#[must_use]
pub fn plane(size: f32) -> Scene {
    let h = 0.5 * size;
    let corners = [Vec3::new(-h, 0.0, h), Vec3::new(h, 0.0, h), Vec3::new(h, 0.0, -h), Vec3::new(-h, 0.0, -h)];
    scene_from_quads("plane", &[corners], default_material())
}

/// A small generator, so that failures of tests repeat.
pub struct Random(pub u64);

impl Random {
    /// From 0 to 1.
    pub fn next_unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Each component from -1 to 1.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next_unit(), self.next_unit(), self.next_unit()) * 2.0 - 1.0
    }
}

/// So many small parallelograms anywhere within 5 m of the origin along each axis.
#[must_use]
pub fn soup(count: usize, random: &mut Random) -> Scene {
    let quads: Vec<[Vec3; 4]> = (0..count)
        .map(|_| {
            let (at, u, v) = (random.vector() * 5.0, random.vector() * 0.4, random.vector() * 0.4);
            [at, at + u, at + u + v, at + v]
        })
        .collect();
    scene_from_quads("soup", &quads, default_material())
}

/// A closed cube around the origin, `size` metres wide, seen from inside: all walls of one diffuse `albedo`.
#[must_use]
pub fn box_room(size: f32, albedo: Vec3) -> Scene {
    let h = 0.5 * size;
    let quads: Vec<[Vec3; 4]> = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z]
        .map(|out| {
            let u = Vec3::new(out.y, out.z, out.x).abs();
            let v = out.cross(u);
            // Clockwise seen from outside, so that the front faces inwards.
            [out - u - v, out - u + v, out + u + v, out + u - v].map(|p| p * h)
        })
        .into();
    scene_from_quads("box room", &quads, diffuse("wall", albedo))
}

/// A plain diffuse material.
#[must_use]
pub fn diffuse(name: &str, albedo: Vec3) -> Material {
    Material { name: name.into(), base_color: albedo.extend(1.0).to_array(), ..default_material() }
}

/// A scene of planar quads, each counter-clockwise seen from its front, with uv over the unit square.
#[must_use]
pub fn scene_from_quads(name: &str, quads: &[[Vec3; 4]], material: Material) -> Scene {
    let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for quad in quads {
        let first = vertices.len() as u32;
        let normal_oct = pack_octahedral((quad[1] - quad[0]).cross(quad[2] - quad[0]).normalize_or(Vec3::Z));
        vertices.extend(quad.iter().zip(uvs).map(|(p, uv)| Vertex {
            position_ws: p.to_array(),
            normal_oct,
            uv,
            color: Vertex::WHITE,
        }));
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }
    let bounds = bounds(&vertices, &indices);
    Scene {
        name: name.into(),
        triangle_materials: vec![0; indices.len() / 3],
        draws: vec![Draw { first_index: 0, index_count: indices.len() as u32, material: 0 }],
        vertices,
        tangents: Vec::new(),
        indices,
        materials: vec![material],
        textures: Vec::new(),
        cameras: vec![framing_camera(&bounds)],
        lights: vec![default_sun()],
        lit_by: LitBy::Lights,
        environment: None,
        sky_sun: None,
        motion: Motion::default(),
        bounds,
    }
}

/// The bytes of a GLB with the given JSON text and binary chunk (left out when empty).
#[must_use]
pub fn glb_from(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    let mut chunk = |kind: &[u8; 4], data: &[u8], pad: u8| {
        let padded = data.len().next_multiple_of(4);
        chunks.extend((padded as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(data);
        chunks.resize(chunks.len() + padded - data.len(), pad);
    };
    chunk(b"JSON", json.as_bytes(), b' ');
    if !bin.is_empty() {
        chunk(b"BIN\0", bin, 0);
    }
    let length = 12 + chunks.len() as u32;
    [b"glTF".as_slice(), &2u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}

/// What a KTX2 file of one level says of itself.
#[derive(Clone, Copy)]
pub struct Ktx2<'a> {
    /// Vulkan's number of the format; 0 where `color_model` says what the texels are.
    pub format: u32,
    /// The model of the data format descriptor.
    pub color_model: u8,
    /// Width and height.
    pub size: [u32; 2],
    /// How the level is compressed: 0 not at all, 2 by Zstandard, 3 by zlib.
    pub scheme: u32,
    /// Bytes of the level when it is decompressed.
    pub level_bytes: u64,
    /// The level as the file has it.
    pub level: &'a [u8],
}

impl Ktx2<'_> {
    /// The file: header, list of levels, descriptor, level.
    #[must_use]
    pub fn file(&self) -> Vec<u8> {
        let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        let [width, height] = self.size;
        let magic = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
        let header = words(&[self.format, 1, width, height, 0, 0, 1, 1, self.scheme, 104, 44, 0, 0, 0, 0, 0, 0]);
        let levels = [148, self.level.len() as u64, self.level_bytes].map(u64::to_le_bytes).concat();
        // One block of version 2 with one sample.
        let descriptor =
            words(&[44, 0, 0x0028_0002, u32::from(self.color_model), 0, 0, 0, 0x007f_0000, 0, 0, u32::MAX]);
        [magic, header, levels, descriptor, self.level.to_vec()].concat()
    }
}

/// The folder with the large assets and references: `$GRIDLIGHT_SHARED`, or `../shared` beside the checkout.
///
/// Tests that need it print that they are skipped where it is absent.
#[must_use]
pub fn shared_dir() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let folder = std::env::var_os("GRIDLIGHT_SHARED").map_or_else(beside, PathBuf::from);
    folder.join("assets").is_dir().then_some(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::octahedral::unpack_octahedral;

    #[test]
    fn the_room_faces_inwards() {
        let room = box_room(2.0, Vec3::splat(0.5));
        assert_eq!((room.indices.len(), room.bounds.min, room.bounds.max), (36, Vec3::NEG_ONE, Vec3::ONE));
        for v in &room.vertices {
            assert!(unpack_octahedral(v.normal_oct).dot(Vec3::from_array(v.position_ws)) < -0.99);
        }
        for t in room.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| Vec3::from_array(room.vertices[t[i] as usize].position_ws));
            assert!((b - a).cross(c - a).dot(a) < 0.0);
        }
    }

    #[test]
    fn the_plane_faces_up() {
        let plane = plane(4.0);
        assert!(unpack_octahedral(plane.vertices[0].normal_oct).y > 0.9999);
        assert_eq!((plane.bounds.min.x, plane.bounds.max.z), (-2.0, 2.0));
    }
}
