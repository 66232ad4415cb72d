//! Every resource of every frame must be described.

use ash::vk;
use clap::ValueEnum;

use super::*;
use crate::frame;
use crate::graph::Lifetime;
use crate::light_grid::Levels;
use crate::passes::lgh_shape::LghShape;
use crate::passes::light_shape::LightShape;
use crate::passes::temporal::{Estimated, Reuse};
use crate::passes::{AreaLightShape, FrameShape, SurfaceMotion};
use crate::settings::{
    FirstLevelBuild, GridUpdate, IndirectSize, LevelBuild, LightingMode, Reservoir, ShadowEstimate, ShadowFilter,
    ShadowPoints, View,
};
use crate::techniques::testing::{all_shapes, pbgi_shapes};

const REUSE: Reuse =
    Reuse { of: Estimated::Light, least_weight: 0.05, antilag: crate::settings::Antilag::Tiles, step_px: 1, rounds: 3 };

const AREA_LIGHT: AreaLightShape = AreaLightShape { samples: 4, is_filtered: true, reuse: None };

fn frame_shape() -> FrameShape {
    FrameShape {
        width_px: 8,
        height_px: 8,
        direct: true,
        environment: Some(AREA_LIGHT),
        emitters: Some(AREA_LIGHT),
        has_emission: true,
        culls_back_faces: false,
        texture_filter: crate::settings::TextureFilter::Anisotropic,
        accumulate: true,
        taa: true,
        rays: crate::settings::Rays::Bvh,
        view: View::Final,
        inspect: false,
        surface_motion: Some(SurfaceMotion::Camera),
        keeps_lights: false,
    }
}

const LIGHTS: LightShape = LightShape {
    path_count: 8,
    starts: None,
    lacks_paths: false,
    bounces: 3,
    slots_at_once: crate::passes::light_shape::SLOTS_AT_ONCE,
    vpl_capacity: 24,
    scene_light_count: 1,
    shadow_samples: 4,
    vpl_radius: 0.0,
    vpl_flux_share: 0.0,
};

fn lgh() -> LghShape {
    LghShape {
        lights: LIGHTS,
        picture_px: [8, 8],
        interleave: 1,
        levels: Levels::new(4),
        indirect_size: IndirectSize::Full,
        anchor: None,
        lobe: crate::settings::Lobe::Mixture,
        center: crate::settings::CenterWeight::Intensity,
        first_level: 1,
        grid_capacity: 64,
        upper_capacity: 32,
        shadow_points: ShadowPoints::Descent,
        shadow_estimate: ShadowEstimate::Corrected,
        lighting: LightingMode::Gather,
        reservoir: Reservoir::Exact,
        build: LevelBuild::Cascade,
        scatter: FirstLevelBuild::Sorted,
        grid_update: GridUpdate::Full,
        filter: ShadowFilter::Atrous,
        reuse: None,
        lighting_format: vk::Format::R32G32B32A32_SFLOAT,
        count_lights_tested: true,
    }
}

#[test]
fn every_resource_has_an_entry() {
    let plain = lgh();
    let light = Some(AreaLightShape { reuse: Some(REUSE), ..AREA_LIGHT });
    let surface_motion = Some(SurfaceMotion::Camera);
    let reusing = FrameShape { environment: light, emitters: light, surface_motion, ..frame_shape() };
    check_frame(&Shapes { frame: reusing, technique: Box::new(LghShape { reuse: Some(REUSE), ..plain.clone() }) });
    let shapes = [
        plain.clone(),
        LghShape { lighting: LightingMode::Volumes, interleave: 4, filter: ShadowFilter::None, ..plain.clone() },
        LghShape {
            lighting: LightingMode::Volumes,
            reservoir: Reservoir::Lock,
            build: LevelBuild::Scatter,
            scatter: FirstLevelBuild::Atomic,
            first_level: 0,
            ..plain.clone()
        },
        LghShape { shadow_points: ShadowPoints::Deviation, ..plain.clone() },
        LghShape { grid_update: GridUpdate::Check, ..plain.clone() },
        LghShape { indirect_size: IndirectSize::Half, picture_px: [2, 2], ..plain.clone() },
        LghShape { lights: LightShape { shadow_samples: 0, ..LIGHTS }, interleave: 2, ..plain },
    ];
    for shape in shapes {
        check_frame(&Shapes { frame: frame_shape(), technique: Box::new(shape) });
    }
    for technique in all_shapes(LIGHTS).into_iter().chain(pbgi_shapes()) {
        check_frame(&Shapes { frame: frame_shape(), technique });
    }
}

#[test]
fn every_resource_of_every_view_has_an_entry() {
    for view in View::value_variants() {
        let frame = FrameShape { view: *view, ..frame_shape() };
        check_frame(&Shapes { frame: frame.clone(), technique: Box::new(lgh()) });
        if let Some(technique) = pbgi_shapes().into_iter().find(|shape| shape.technique().has_view(*view)) {
            check_frame(&Shapes { frame, technique });
        }
    }
}

fn check_frame(shapes: &Shapes) {
    let graph = frame::build(shapes).0;
    // The scene's parts are dumped on their own, and no pass writes them but for new lights, nor what the frame before left.
    let is_dumped = |lifetime| !matches!(lifetime, Lifetime::Imported | Lifetime::Previous { .. });
    for resource in graph.resources().iter().filter(|resource| is_dumped(resource.lifetime)) {
        let found = entry(shapes.technique.technique(), &resource.name);
        let about = found.unwrap_or_else(|| panic!("{}: no table has an entry", resource.name));
        let fits = match (resource.info, about.contents) {
            (ResourceInfo::Buffer(_), Contents::Buffer(_)) => true,
            (ResourceInfo::Image(info), Contents::Image(names)) => {
                let picture = Picture::from_texels(info.format, [1, 1], names, &[0; 64]).unwrap();
                picture.channels.len() == names.len()
            }
            _ => false,
        };
        assert!(fits, "{}: the entry is of the other kind", resource.name);
    }
}

#[test]
fn an_image_has_a_file_for_each_level_layer_and_slice() {
    let flat = ImageInfo::new(vk::Format::R32_UINT, 4, 2);
    let names = |info: ImageInfo, level: u32| {
        let [width, height, depth] = info.level_size_px(level);
        let count = depth * info.layer_count();
        let texels: Vec<u8> = (0..count as u8).flat_map(|slice| vec![slice; (4 * width * height) as usize]).collect();
        let parts = slices(&info, level, &texels);
        for (index, (_, part)) in parts.iter().enumerate() {
            assert_eq!(*part, vec![index as u8; (4 * width * height) as usize]);
        }
        parts.into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names(flat, 0), "");
    assert_eq!(names(flat.with_levels(3), 2), "_level_2");
    assert_eq!(names(flat.with_layers(2), 0), "_layer_0 _layer_1");
    assert_eq!(names(flat.with_depth(4).with_levels(2), 1), "_level_1_slice_0 _level_1_slice_1");
}
