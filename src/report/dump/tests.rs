//! Every resource of every frame must be described.

use ash::vk;
use clap::ValueEnum;

use super::*;
use crate::frame;
use crate::light_grid::Levels;
use crate::settings::{Build, Filter, LightingMode, Reservoir, Scatter, ShadowPoints, Technique, View};

fn shape() -> FrameShape {
    FrameShape {
        lobe: crate::settings::Lobe::Mixture,
        center: crate::settings::Center::Intensity,
        width_px: 8,
        height_px: 8,
        direct: true,
        accumulate: true,
        samples: 2,
        interleave: 1,
        levels: Levels::new(4),
        first_level: 1,
        path_count: 8,
        bounces: 3,
        vpl_capacity: 24,
        scene_light_count: 1,
        grid_capacity: 64,
        upper_capacity: 32,
        shadow_points: ShadowPoints::Descent,
        shadow_samples: 4,
        lighting: LightingMode::Gather,
        reservoir: Reservoir::Exact,
        rays: crate::settings::Rays::Bvh,
        build: Build::Cascade,
        scatter: Scatter::Sorted,
        filter: Filter::Atrous,
        lighting_format: vk::Format::R32G32B32A32_SFLOAT,
        count_overdraw: true,
        view: View::Final,
        inspect: false,
    }
}

#[test]
fn every_resource_has_an_entry() {
    let plain = shape();
    let shapes = [
        plain.clone(),
        FrameShape { lighting: LightingMode::Volumes, interleave: 4, filter: Filter::None, ..plain.clone() },
        FrameShape {
            lighting: LightingMode::Volumes,
            reservoir: Reservoir::Lock,
            build: Build::Scatter,
            scatter: Scatter::Atomic,
            first_level: 0,
            ..plain.clone()
        },
        FrameShape { shadow_points: ShadowPoints::Deviation, ..plain.clone() },
        FrameShape { shadow_samples: 0, interleave: 2, ..plain },
    ];
    for technique in [Technique::Lgh, Technique::Direct, Technique::BruteForce, Technique::PathTrace] {
        for shape in &shapes {
            check_frame(technique, shape);
        }
    }
}

#[test]
fn every_resource_of_every_view_has_an_entry() {
    for view in View::value_variants() {
        check_frame(Technique::Lgh, &FrameShape { view: *view, ..shape() });
    }
}

fn check_frame(technique: Technique, shape: &FrameShape) {
    for resource in frame::build(technique, shape.clone()).0.resources() {
        let found = entry(&resource.name);
        let about = found.unwrap_or_else(|| panic!("{}: src/report/dump/table.rs has no entry", resource.name));
        let fits = match (resource.info, about.contents) {
            (ResourceInfo::Buffer(_), Contents::Buffer(_)) => true,
            (ResourceInfo::Image(info), Contents::Image(names)) => {
                let picture = Picture::from_texels(&info, names, &[0; 64]).unwrap();
                picture.channels.len() == names.len()
            }
            _ => false,
        };
        assert!(fits, "{}: the entry is of the other kind", resource.name);
    }
}
