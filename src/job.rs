//! What is to be rendered.

use std::f64::consts::PI;
use std::sync::Arc;

use bytemuck::Zeroable;
use glam::Vec2;

use crate::camera::View;
use crate::color::MIDDLE_GREY;
use crate::gpu::Gpu;
use crate::scene::Camera;
use crate::settings::{BackFaces, Exposure, Settings};
use crate::shared::FrameData;
use crate::uploaded_scene::UploadedScene;
use crate::{Error, Result};

/// How far below a white surface in the faintest light of the scene the automatic exposure follows, in stops: indoors,
/// far from the window, is about ten below outdoors.
const DARKEST_STOPS: f64 = 10.0;

/// What is rendered, from where, how, and on which device.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The device.
    pub gpu: &'a Arc<Gpu>,
    /// The scene on this device.
    pub scene: &'a UploadedScene,
    /// Where it is seen from.
    pub camera: &'a Camera,
    /// How it is rendered.
    pub settings: &'a Settings,
}

impl<'a> Job<'a> {
    /// All of it together.
    #[must_use]
    pub fn new(gpu: &'a Arc<Gpu>, scene: &'a UploadedScene, camera: &'a Camera, settings: &'a Settings) -> Self {
        Self { gpu, scene, camera, settings }
    }

    /// Whether anything comes from the environment.
    #[must_use]
    pub fn has_environment(&self) -> bool {
        self.scene.environment_cells[0] > 0 && self.settings.environment.scale > 0.0
    }

    /// Luminance of the flux of all light paths: that of the scene's lights and of the environment.
    #[must_use]
    pub fn emitted_luminance(&self) -> f64 {
        self.scene.light_flux + self.environment_luminance()
    }

    fn environment_luminance(&self) -> f64 {
        f64::from(self.settings.environment.scale) * self.scene.environment_flux
    }

    /// Share of the light paths that start at the environment.
    fn environment_share(&self) -> f32 {
        let environment = self.environment_luminance();
        if environment > 0.0 { (environment / self.emitted_luminance()) as f32 } else { 0.0 }
    }

    /// The most that the automatic exposure may be: what shows as middle grey what is [`DARKEST_STOPS`] below a white
    /// surface in the faintest of the scene's lights. What is darker than that is noise, or as good as black. The
    /// faintest, as a lamp in a room without windows has a picture of its own, however bright the sun is outside. A
    /// sun's flux passes through the cross section of the scene's bounding sphere, an environment's through the sphere
    /// from all around, and a lamp counts as half the sphere's radius away.
    #[must_use]
    pub fn most_exposure(&self) -> f32 {
        let radius = f64::from(self.scene.bounds.radius());
        let cross_section_m2 = PI * radius * radius;
        let fluxes = [self.scene.faintest_light_flux, 0.25 * self.environment_luminance()];
        let faintest = fluxes.into_iter().filter(|flux| *flux > 0.0).fold(f64::INFINITY, f64::min);
        let white = faintest / cross_section_m2 / PI;
        let most = MIDDLE_GREY / (white * (-DARKEST_STOPS).exp2());
        if most > 0.0 { most.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32 } else { f32::MAX }
    }

    /// Whether the automatic exposure of a picture is the most that it may be.
    #[must_use]
    pub fn is_most_exposed(&self, exposure: Option<f32>) -> bool {
        let picture = &self.settings.picture;
        let most = self.most_exposure() * picture.exposure_compensation.exp2();
        picture.exposure == Exposure::Auto && exposure.is_some_and(|exposure| exposure >= most)
    }

    /// The frame's constants, without those of a technique.
    #[must_use]
    pub fn frame_data(&self) -> FrameData {
        let Self { gpu, scene, camera, settings } = self;
        let size = settings.picture.size;
        let view = View::new(camera, size.width, size.height, Vec2::ZERO);
        let radius = scene.bounds.radius();
        // A rasteriser moves corners to the nearest of 2^bits positions per pixel; this is that step at distance 1.
        let subpixels = (1_u32 << gpu.report().limits.subpixel_bits) as f32;
        let snap = view.up_ws.length() * 2.0 / size.height as f32 / subpixels;
        let exposure = match settings.picture.exposure {
            Exposure::Auto => -self.most_exposure(),
            Exposure::Fixed(factor) => factor,
        };
        let environment = &settings.environment;
        let environment_cells = if self.has_environment() { scene.environment_cells } else { [0; 2] };
        FrameData {
            inspected_pixel: settings.output.inspect.map_or([0; 2], |place| place.0),
            clip_from_world: view.clip_from_world.to_cols_array_2d(),
            eye_ws: view.eye_ws.to_array(),
            near: view.near,
            forward_ws: view.forward_ws.to_array(),
            right_ws: view.right_ws.to_array(),
            rasteriser_step: snap,
            up_ws: view.up_ws.to_array(),
            scene_center_ws: scene.bounds.center().to_array(),
            scene_radius: radius,
            size_px: [size.width, size.height],
            sub_image_px: [size.width, size.height],
            interleave: 1,
            seed: settings.tracing.seed,
            sampling_seed: settings.tracing.seed,
            direct_lights: scene.light_count,
            emitter_count: scene.emitter_count,
            culls_back_faces: (settings.picture.back_faces == BackFaces::Cull).into(),
            first_point_light: scene.first_point_light,
            environment_cells,
            environment_scale: environment.scale * scene.environment_scale,
            environment_share: self.environment_share(),
            environment_turn: environment.turn_deg / 360.0,
            exposure,
            exposure_compensation: settings.picture.exposure_compensation.exp2(),
            tone_map: settings.picture.tone_map.code(),
            largest_triangle: scene.largest_triangle,
            ..FrameData::zeroed()
        }
    }

    /// Checks that an image of this size fits the device.
    ///
    /// # Errors
    /// [`Error::Usage`] when it does not.
    pub fn check_image_size(&self, [width, height]: [u32; 2]) -> Result<()> {
        let limit = self.gpu.report().limits.image_edge_px;
        if width <= limit && height <= limit {
            return Ok(());
        }
        Err(Error::Usage(format!("--size {width}x{height} is beyond this device's limit of {limit}x{limit}")))
    }
}
