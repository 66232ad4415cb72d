//! What a frame told about one pixel, in words.

use comfy_table::Table;
use comfy_table::presets::ASCII_MARKDOWN;

use crate::shared::InspectedPixel;
use crate::techniques::{InspectorImage, InspectorTable, TechniqueShape};
use crate::views::plain_number;

/// Name, help and value.
pub type InspectedRow = (&'static str, &'static str, String);

/// Surface and light of a pixel.
#[must_use]
pub fn rows(pixel: &InspectedPixel) -> Vec<InspectedRow> {
    let indirect = [0, 1, 2].map(|i| pixel.albedo[i] * pixel.lighting[i] * pixel.shadow_ratio[i]);
    let rgb = |v: [f32; 4]| three([v[0], v[1], v[2]]);
    let [x, y] = pixel.pixel;
    vec![
        ("pixel", "Counted from the top left corner of the picture", format!("{x}, {y}")),
        ("distance", "Along the viewing direction, in metres", format!("{:.4} m", pixel.depth)),
        ("position", "World space, in metres", three(pixel.position_ws)),
        ("normal", "Shading normal, normal map included", three(pixel.normal)),
        ("triangle", "Normal of the triangle", three(pixel.geometric_normal)),
        ("albedo", "Linear base colour", three(pixel.albedo)),
        ("radiance", "What the pixel shows before exposure; the values of a view", rgb(pixel.radiance)),
        ("direct", "Direct light of the scene's lights and the environment", rgb(pixel.direct)),
        ("environment", "Direct light of the environment", rgb(pixel.environment)),
        ("indirect", "Albedo times lighting times shadow ratio", three(indirect)),
        ("lighting", "Unshadowed indirect lighting for a white surface", rgb(pixel.lighting)),
        ("shadow ratio", "Filtered S / U; 1 is unshadowed", rgb(pixel.shadow_ratio)),
    ]
}

/// What a pixel without a surface is called.
#[must_use]
pub fn no_surface(pixel: &InspectedPixel) -> String {
    let [x, y] = pixel.pixel;
    format!("pixel {x}, {y}: no surface")
}

fn three(v: [f32; 3]) -> String {
    v.map(plain_number).join(" ")
}

/// All of it as plain text.
#[must_use]
pub fn text(technique: &dyn TechniqueShape, pixel: &InspectedPixel) -> String {
    if pixel.found == 0 {
        return no_surface(pixel);
    }
    let mut parts: Vec<String> =
        rows(pixel).into_iter().map(|(name, _, value)| format!("{name:<12} {value}")).collect();
    parts.extend(technique.inspector_tables(pixel).iter().map(table));
    parts.extend(technique.inspector_images(pixel).iter().map(drawing));
    parts.join("\n")
}

fn table(described: &InspectorTable) -> String {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(described.columns.iter().map(|(name, _)| *name));
    for row in &described.rows {
        table.add_row(row.iter().map(|cell| cell.text.as_str()));
    }
    format!("{}:\n{}", described.name, table.trim_fmt())
}

/// Characters from dark to bright.
const RAMP: [char; 10] = [' ', '.', ':', '-', '=', '+', '*', '#', '%', '@'];

/// A picture of characters, two for each of its pixels; a brighter one for a brighter colour.
fn drawing(image: &InspectorImage) -> String {
    let character = |color: &Option<u32>| {
        let brightest = color.map_or(0, |color| color.to_be_bytes()[1..].iter().copied().max().unwrap_or(0));
        RAMP[usize::from(brightest) * (RAMP.len() - 1) / 255]
    };
    let row = |colors: &[Option<u32>]| colors.iter().flat_map(|color| [character(color); 2]).collect::<String>();
    let rows: Vec<String> =
        image.colors.chunks(image.edge as usize).map(|colors| row(colors).trim_end().to_owned()).collect();
    format!("{}:\n{}", image.name, rows.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_brighter_where_colours_are() {
        let colors = vec![Some(0), Some(0xff_ffff), Some(0x00_0080), None];
        let image = InspectorImage { name: "seen", help: "", edge: 2, colors };
        assert_eq!(drawing(&image), "seen:\n  @@\n==");
    }

    #[test]
    fn a_pixel_without_a_surface_says_so() {
        let pixel = InspectedPixel { pixel: [3, 4], ..bytemuck::Zeroable::zeroed() };
        assert_eq!(no_surface(&pixel), "pixel 3, 4: no surface");
        assert!(rows(&pixel).iter().any(|(name, _, value)| *name == "pixel" && value == "3, 4"));
    }
}
