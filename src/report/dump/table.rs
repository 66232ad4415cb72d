//! What the resources are that frames of any technique have. Techniques describe theirs
//! ([`Technique::dump_entries`]); names, units and meanings are written nowhere else.

use super::contents;
use crate::dump::{COUNT, DEPTH, Entry, RADIANCE, RGBA, all_words, buffer, image, one_float};
use crate::techniques::Technique;

const NORMALS: &[&str] = &["shading", "geometric"];
/// The same in an image with two more channels.
const HALF_NORMALS: &[&str] = &["shading", "geometric", "zero_b", "zero_a"];

/// What is kept over frames of the light that surfaces get from `$source`, in resources whose names begin with `$label`.
macro_rules! over_time {
    ($label:literal, $source:literal) => {
        [
    image(
        concat!($label, "_temporal_tiles"),
        RADIANCE,
        RGBA,
        concat!("The temporal_tiles of the light of ", $source, "; the unit is its unshadowed light in the frames before."),
    ),
    image(
        concat!($label, "_temporal_*"),
        RADIANCE,
        RGBA,
        concat!("Means over the frames of both estimates of the light of ", $source, "; A is the number of frames, and of the unshadowed one the variance of one frame's shadowed luminance."),
    ),
    image(
        concat!($label, "_reprojected_*"),
        RADIANCE,
        RGBA,
        "What was found of the same means for the visible surface, where it was in the frame before.",
    ),
    image(
        concat!($label, "_tile_sums"),
        RADIANCE,
        RGBA,
        concat!("The tile_sums of the light of ", $source, "; the unit is its unshadowed light in the frames before."),
    ),
    image(concat!($label, "_given_up"), "share", RGBA, concat!("The given_up of the light of ", $source, ".")),
        ]
    };
}

const ENVIRONMENT_OVER_TIME: &[Entry] = &over_time!("environment", "the environment");
const EMITTERS_OVER_TIME: &[Entry] = &over_time!("emitter", "surfaces that shine");

/// The resource of this name in frames of a technique.
#[must_use]
pub fn entry(technique: &dyn Technique, resource: &str) -> Option<&'static Entry> {
    entries(technique).find(|entry| entry.fits(resource))
}

/// Those of all frames, and those of a technique.
fn entries(technique: &dyn Technique) -> impl Iterator<Item = &'static Entry> {
    let of_all = [TABLE, ENVIRONMENT_OVER_TIME, EMITTERS_OVER_TIME];
    of_all.into_iter().chain(technique.dump_entries().iter().copied()).flatten()
}

/// Longer names stand before names that they begin with.
const TABLE: &[Entry] = &[
    buffer(
        "frame_data",
        "see docs/dumps.md",
        contents::frame_data,
        "The frame's constants, from which every pass starts.",
    ),
    buffer(
        "ray_count",
        COUNT,
        all_words,
        "Rays traced so far: [0] by light paths, [1] for shadows of lights, [2] towards the environment.",
    ),
    image("gbuffer_albedo", "1", RGBA, "Linear base colour of the visible surface; A is 1 where there is one."),
    image(
        "gbuffer_normals",
        "two 16-bit snorm in a word",
        NORMALS,
        "Shading and geometric normal of the visible surface, octahedral.",
    ),
    image("gbuffer_depth", "near / view z", DEPTH, "Reversed depth of the visible surface, 0 where there is none."),
    image(
        "gbuffer_motion",
        "pixels; near / view z",
        RGBA,
        "Offset in pixels to where the visible surface was in the frame before, y down, its reversed depth there, 0 where it was behind the camera, and 0.",
    ),
    image(
        "gbuffer_emission",
        RADIANCE,
        RGBA,
        "Radiance of the visible surface itself: what it sends out, or its colour where it is unlit; only where something does.",
    ),
    buffer(
        "half_frame_data",
        "see docs/dumps.md",
        contents::frame_data,
        "The frame's constants where indirect light is found for every second pixel of every second row.",
    ),
    image(
        "half_normals",
        "two 16-bit snorm in a word",
        HALF_NORMALS,
        "Shading and geometric normal of every second pixel of every second row, octahedral, and twice 0.",
    ),
    image("half_depth", "near / view z", DEPTH, "Reversed depth of every second pixel of every second row."),
    image(
        "half_motion",
        "half pixels; near / view z",
        RGBA,
        "Of the same pixels the offset to where the surface was in the frame before, in pixels that are twice as wide, and its reversed depth there.",
    ),
    image(
        "half_indirect",
        RADIANCE,
        RGBA,
        "Indirect light with its shadows, per unit albedo, of every second pixel of every second row; A is 1.",
    ),
    image(
        "indirect_enlarged",
        RADIANCE,
        RGBA,
        "The same of every pixel, from those around it that show the same surface; A is 1 where there is one.",
    ),
    buffer("scan_block_sums_*", COUNT, all_words, "Set bits of each block of words."),
    image(
        "environment_shadowed*",
        RADIANCE,
        RGBA,
        "Light of the environment per unit albedo: as its shadow rays found it, its mean over the frames (blended), or after this many iterations of the filter, with its standard deviation in alpha.",
    ),
    image(
        "environment_unshadowed*",
        RADIANCE,
        RGBA,
        "The same light without occlusion; A is 1 where there is a surface.",
    ),
    image(
        "emitter_shadowed*",
        RADIANCE,
        RGBA,
        "Light of surfaces that shine by themselves per unit albedo: as its shadow rays found it, its mean over the frames (blended), or after this many iterations of the filter, with its standard deviation in alpha.",
    ),
    image("emitter_unshadowed*", RADIANCE, RGBA, "The same light without occlusion; A is 1 where there is a surface."),
    image(
        "direct",
        RADIANCE,
        RGBA,
        "Outgoing radiance due to direct light, shadows included, with what surfaces send out by themselves, and the environment where no surface hides it.",
    ),
    image("radiance", RADIANCE, RGBA, "The frame in linear radiance; A is the share of its samples that was taken."),
    image(
        "accumulated_sum",
        RADIANCE,
        RGBA,
        "Sum of the frames so far, each weighted by the share of its samples; A is the sum of the weights.",
    ),
    image("accumulated_mean", RADIANCE, RGBA, "The picture in linear radiance, the mean of the frames so far."),
    image(
        "antialiased",
        RADIANCE,
        RGBA,
        "The picture in linear radiance, the mean of the frames before, moved to where their surfaces are now, and of this one; A is the number of frames, at most 25, below 0 where something moves.",
    ),
    image("view_values", "those of the view, docs/views.md", RGBA, "The numbers that a view shows in colours."),
    buffer(
        "inspected_pixel",
        "several",
        all_words,
        "Everything about one pixel, in the order of the struct of that name.",
    ),
    image("level_mix", "1", RGBA, "The colour of each pixel in the view of the level weights."),
    buffer("view_scale", "those of the view", one_float, "The number at the upper end of a view's colour scale."),
    buffer(
        "direct_exposure_histogram",
        COUNT,
        all_words,
        "The histogram of the direct light under the points of a view, like that of the exposure.",
    ),
    buffer(
        "exposure_histogram",
        COUNT,
        all_words,
        "Pixels by luminance in 1024 equal steps of log2 from -32 to 32: of surfaces, then of the background.",
    ),
    buffer(
        "direct_exposure",
        "1 / radiance",
        one_float,
        "The exposure of the direct light under the points of a view.",
    ),
    buffer("exposure", "1 / radiance", one_float, "The factor on the radiance before tone mapping."),
    image("picture", "0 to 255", RGBA, "The tone-mapped picture, sRGB."),
];

/// Meanings of the files that are no resource of the graph.
pub mod others {
    /// Triangles.
    pub const TRIANGLES: (&str, &str, &str) = (
        "triangles",
        "metres",
        "The scene's triangles in the order of the BVH's leaves: first corner, two edges, material.",
    );
    /// Materials.
    pub const MATERIALS: (&str, &str, &str) = (
        "materials",
        "1",
        "The scene's materials as traced rays see them; albedo_layer is 4294967295 without a texture.",
    );
    /// Lights.
    pub const PUNCTUAL_LIGHTS: (&str, &str, &str) = (
        "punctual_lights",
        "metres; irradiance (kind 0, directional) or radiant intensity (1 point, 2 spot)",
        "The lights of the scene file, directional and spot lights first.",
    );
    /// Image of the environment.
    pub const ENVIRONMENT_MAP: (&str, &str, &str) = (
        "environment_map",
        "radiance / environment_scale",
        "Light from all around, equirectangular, row 0 towards +y; only where there is any.",
    );
    /// Sums of the environment.
    pub const ENVIRONMENT_TABLE: (&str, &str, &str) = (
        "environment_table",
        "1",
        "What directions of the environment are drawn from: running sums of the rows' probabilities, then of each row's cells.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::TECHNIQUES;

    const DOCS: &str = include_str!("../../../docs/dumps.md");

    #[test]
    fn every_entry_is_documented_and_is_reached() {
        for listed in TECHNIQUES.iter().flat_map(|technique| entries(*technique)) {
            let name = listed.name.trim_end_matches('*');
            assert!(listed.meaning.ends_with('.') && !listed.units.is_empty(), "{name}");
            let row = format!("| {} |", listed.meaning);
            let documented = DOCS.lines().any(|l| l.starts_with(&format!("| `{}` ", listed.name)) && l.ends_with(&row));
            assert!(documented, "{name} is missing in docs/dumps.md, or is described differently there");
        }
        for technique in TECHNIQUES {
            for listed in entries(*technique) {
                let name = listed.name.trim_end_matches('*');
                let found = entry(*technique, name).map(|e| e.name);
                assert_eq!(found, Some(listed.name), "{name} is hidden by an entry before it");
            }
            assert!(entry(*technique, "no such resource").is_none());
        }
    }
}
