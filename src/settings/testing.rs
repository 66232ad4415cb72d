//! Settings for tests.

use super::{
    Antilag, BackFaces, CenterWeight, Coverage, EnvironmentSource, Exposure, FirstLevelBuild, GridUpdate, Hemisphere,
    IndirectSize, LevelBuild, Levels, LightSet, LightingMode, Lobe, MicroFill, PixelPlace, PresentMode, Rays,
    RenderScale, Reservoir, Selection, Settings, ShadowEstimate, ShadowFilter, ShadowPoints, Size, SunPlace, Switch,
    Technique, Temporal, TextureFilter, ToneMap, View, VplImportance, VplSeeds,
};

/// Settings of which none is the default.
pub fn every_value_changed() -> Settings {
    Settings::default().changed(|s| {
        s.scene.file = Some("a/b c.gltf".into());
        s.run.headless = true;
        s.run.frames = 8;
        s.run.warmup = 2;
        s.picture.size = Size { width: 320, height: 180 };
        s.scene.scene_name = Some("night".into());
        s.scene.camera = Some("atrium".into());
        s.scene.sun = Some(SunPlace { azimuth_deg: 10.0, height_deg: 20.5 });
        s.motion.time_s = 1.5;
        s.motion.fps = 25.0;
        s.motion.animation = Some("walk".into());
        s.many_lights.vpl_seeds = Some(VplSeeds::Fresh);
        s.environment.source = Some(EnvironmentSource::File("a/b c.hdr".into()));
        s.environment.scale = 0.5;
        s.environment.turn_deg = -30.0;
        s.environment.samples = 7;
        s.render.technique = Technique::PathTrace;
        s.path_trace.samples = 3;
        s.pbgi.points = 4096;
        s.pbgi.micro = MicroFill::Points;
        s.pbgi.coverage = Coverage::Binary;
        s.pbgi.hemisphere = Hemisphere::Concentric;
        s.pbgi.selection = Selection::Paper;
        s.pbgi.sun_leaves = 2;
        s.pbgi.point_bounces = 3;
        s.pbgi.reuse = Switch::On;
        s.render.accumulate = 4;
        s.render.taa = Switch::On;
        s.render.direct = Switch::Off;
        s.many_lights.lights = LightSet::Both;
        s.many_lights.vpls = 1_000_000;
        s.many_lights.bounces = 5;
        s.many_lights.vpl_importance = VplImportance::None;
        s.lgh.levels = Levels::Fixed(7);
        s.lgh.alpha = 1.7;
        s.lgh.lobe = Lobe::ClampedNormal;
        s.lgh.center = CenterWeight::Uniform;
        s.lgh.first_level = 0;
        s.lgh.interleave = 4;
        s.many_lights.shadow_samples = 16;
        s.many_lights.shadows = Switch::Off;
        s.lgh.shadow_from = 3;
        s.lgh.shadow_points = ShadowPoints::Deviation;
        s.lgh.shadow_estimate = Some(ShadowEstimate::Ratio);
        s.lgh.lighting = Some(LightingMode::Volumes);
        s.lgh.reservoir = Some(Reservoir::Lock);
        s.tracing.rays = Rays::Query;
        s.lgh.build = LevelBuild::Scatter;
        s.lgh.scatter = Some(FirstLevelBuild::Atomic);
        s.lgh.grid_update = GridUpdate::Full;
        s.lgh.filter = ShadowFilter::None;
        s.lgh.temporal = Some(Temporal::Shadows);
        s.lgh.temporal_weight = Some(0.2);
        s.lgh.antilag = Antilag::Tiles;
        s.lgh.temporal_rounds = Some(1);
        s.lgh.indirect_size = IndirectSize::Half;
        s.many_lights.clamp = 0.0;
        s.device.max_submit_ms = 50.5;
        s.tracing.seed = u32::MAX;
        s.picture.exposure = Exposure::Fixed(0.3);
        s.picture.exposure_compensation = -1.5;
        s.picture.tone_map = ToneMap::Agx;
        s.picture.back_faces = BackFaces::Cull;
        s.picture.texture_filter = TextureFilter::Trilinear;
        s.render.view = View::ShadowRatio;
        s.output.picture = Some("o.exr".into());
        s.output.timings = vec!["t.csv".into()];
        s.output.dump = Some("d".into());
        s.output.renderdoc_frame = Some(3);
        s.output.inspect = Some(PixelPlace([7, 8]));
        s.device.gpu = Some("llvmpipe".into());
        s.device.validation = true;
        s.device.no_pipeline_cache = true;
        s.window.present_mode = PresentMode::Mailbox;
        s.window.render_scale = RenderScale::Fixed(0.5);
    })
}
