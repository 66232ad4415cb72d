//! Pictures as passes leave them.

use glam::{DVec3, UVec2, Vec2};
use gridlight::camera::View;
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::scene::octahedral::unpack_octahedral;
use gridlight::scene::{Camera, Scene};
use gridlight::settings::{Settings, Size};

use super::written::Written;
use super::{GpuTest, compare};

/// Sizes at which tiles of 8 and sub-images of 2 and 4 are cut off, and one that is whole.
pub const SIZES: [Size; 6] = [px(1, 1), px(3, 5), px(7, 9), px(16, 8), px(37, 21), px(65, 3)];

const fn px(width: u32, height: u32) -> Size {
    Size { width, height }
}

pub type Texel = [f64; 4];

/// What every pass of one frame left.
pub struct Frame {
    pub size: Size,
    /// Interleave n.
    pub n: i32,
    pub written: Written,
    pub surfaces: Surfaces,
}

/// What the G-buffer says.
pub struct Surfaces {
    size: Size,
    view: View,
    /// near / view z; 0 without a surface.
    depth: Vec<f32>,
    normals: Vec<DVec3>,
    geometric_normals: Vec<DVec3>,
}

impl Frame {
    /// Renders one frame of the default technique.
    pub fn of(test: &GpuTest, scene: &Scene, settings: &Settings) -> Self {
        let uploaded = UploadedScene::new(&test.gpu, scene).unwrap();
        let camera = &scene.cameras[0];
        Self::by(&Renderer::new(&Job::new(&test.gpu, &uploaded, camera, settings)).unwrap(), camera, settings)
    }

    /// The last frame of a renderer again, or a first one.
    pub fn by(renderer: &Renderer, camera: &Camera, settings: &Settings) -> Self {
        let written = Written::by(renderer);
        let size = settings.picture.size;
        let normals: Vec<[u32; 2]> = written.all("gbuffer", "gbuffer_normals");
        let unpacked = |kind: usize| normals.iter().map(|words| unpack_octahedral(words[kind]).as_dvec3()).collect();
        let surfaces = Surfaces {
            size,
            view: View::new(camera, size.width, size.height, Vec2::ZERO),
            depth: written.all("gbuffer", "gbuffer_depth"),
            normals: unpacked(0),
            geometric_normals: unpacked(1),
        };
        Self { size, n: settings.lgh.interleave as i32, written, surfaces }
    }

    /// What a pass left in an image of four floats.
    pub fn floats(&self, pass: &str, resource: &str) -> Vec<Texel> {
        let texels: Vec<[f32; 4]> = self.written.all(pass, resource);
        texels.iter().map(|texel| texel.map(f64::from)).collect()
    }

    fn interleaved_size(&self) -> Size {
        let edge = |px: u32| px.div_ceil(self.n as u32) * self.n as u32;
        Size { width: edge(self.size.width), height: edge(self.size.height) }
    }

    /// Where a pixel lies in the interleaved layout.
    pub fn interleaved_index(&self, x: i32, y: i32) -> usize {
        let interleaved = self.interleaved_size();
        let (n, at) = (self.n as u32, UVec2::new(x as u32, y as u32));
        let place = at % n * (UVec2::new(interleaved.width, interleaved.height) / n) + at / n;
        (place.y * interleaved.width + place.x) as usize
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let Size { width, height } = self.size;
        (0..height as i32).flat_map(move |y| (0..width as i32).map(move |x| (x, y)))
    }
}

impl Surfaces {
    /// Index of a pixel; `None` outside the picture.
    pub fn index(&self, x: i32, y: i32) -> Option<usize> {
        let inside = x >= 0 && y >= 0 && x < self.size.width as i32 && y < self.size.height as i32;
        inside.then(|| y as usize * self.size.width as usize + x as usize)
    }

    /// The same where there is a surface.
    pub fn surface(&self, x: i32, y: i32) -> Option<usize> {
        self.index(x, y).filter(|index| self.depth[*index] > 0.0)
    }

    pub fn normal(&self, index: usize) -> DVec3 {
        self.normals[index]
    }

    /// Of the triangle itself.
    pub fn geometric_normal(&self, index: usize) -> DVec3 {
        self.geometric_normals[index]
    }

    /// Distance along the viewing direction.
    pub fn view_z(&self, index: usize) -> f64 {
        self.view_z_of(f64::from(self.depth[index]))
    }

    /// The same of what the G-buffer has for it.
    pub fn view_z_of(&self, depth: f64) -> f64 {
        f64::from(self.view.near) / depth
    }

    /// Edge of a pixel on a surface that faces the viewer.
    pub fn footprint(&self, index: usize) -> f64 {
        self.footprint_at(self.view_z(index))
    }

    /// The same at this distance along the viewing direction.
    pub fn footprint_at(&self, view_z: f64) -> f64 {
        2.0 * f64::from(self.view.up_ws.length()) / f64::from(self.size.height) * view_z
    }

    /// Where the surface at a pixel lies.
    pub fn position_ws(&self, x: i32, y: i32, index: usize) -> DVec3 {
        self.place_ws([f64::from(x), f64::from(y)], self.view_z(index))
    }

    /// What lies at a place of the picture, counted in pixels from the centre of the first one, at this distance along the viewing direction.
    pub fn place_ws(&self, [x, y]: [f64; 2], view_z: f64) -> DVec3 {
        let ndc = |at: f64, size: u32| (at + 0.5) / f64::from(size) * 2.0 - 1.0;
        let View { eye_ws, forward_ws, right_ws, up_ws, .. } = self.view;
        let ray = forward_ws.as_dvec3() + ndc(x, self.size.width) * right_ws.as_dvec3()
            - ndc(y, self.size.height) * up_ws.as_dvec3();
        eye_ws.as_dvec3() + ray * view_z
    }
}

/// How many of `gpu`'s texels differ from `twin`'s in one of the first `channels`: by more than `relative` of the texel's
/// largest channel and `absolute`.
pub fn wrong_texels(gpu: &[Texel], twin: &[Texel], channels: usize, relative: f64, absolute: f64) -> Vec<usize> {
    assert_eq!(gpu.len(), twin.len());
    let wrong = |index: &usize| {
        let (a, b) = (&gpu[*index][..channels], &twin[*index][..channels]);
        let largest = b.iter().fold(0.0_f64, |largest, channel| largest.max(channel.abs()));
        !a.iter().zip(b).all(|(a, b)| compare::within(a - b, relative * largest + absolute))
    };
    (0..gpu.len()).filter(wrong).collect()
}

/// No texel differs.
pub fn compare_texels(
    what: &str,
    gpu: &[Texel],
    twin: &[Texel],
    channels: usize,
    tolerance: [f64; 2],
) -> compare::Verdict {
    let wrong = wrong_texels(gpu, twin, channels, tolerance[0], tolerance[1]);
    match wrong.first() {
        None => Ok(()),
        Some(first) => Err(format!(
            "{what}: {} of {} texels differ, the first {first}: {:?} on the GPU, {:?} in the twin",
            wrong.len(),
            gpu.len(),
            gpu[*first],
            twin[*first]
        )),
    }
}
