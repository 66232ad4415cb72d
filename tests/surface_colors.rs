//! Colours of vertices and samplers of textures, in the G-buffer and along rays: against scenes that say the same otherwise.

mod support;

use std::collections::HashMap;
use std::path::Path;

use gridlight::files::pictures::read_exr;
use serde_json::{Value, json};
use support::{attribute, program, quad_glb, run, view};
use tempfile::TempDir;

/// The floor under a lamp and a white wall, which sees the floor's colour.
fn room(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    quad_glb(|document, bin| {
        let lamp = json!({"type": "point", "intensity": 10.0});
        document["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
        document["materials"] = json!([{}, {}]);
        document["meshes"] = json!([document["meshes"][0], document["meshes"][0]]);
        document["meshes"][1]["primitives"][0]["material"] = json!(1);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        document["nodes"] = json!([{"mesh": 0}, {"mesh": 1, "translation": [0, 2, -2], "rotation": [half, 0, 0, half]},
            {"translation": [0.3, 1.5, 0.2], "extensions": {"KHR_lights_punctual": {"light": 0}}}]);
        document["scenes"][0]["nodes"] = json!([0, 1, 2]);
        change(document, bin);
    })
}

/// Pictures of scenes with the same options, each rendered once.
struct Pictures<'a> {
    folder: TempDir,
    options: &'a str,
    rendered: HashMap<Vec<u8>, Vec<f32>>,
}

impl<'a> Pictures<'a> {
    fn with(options: &'a str) -> Self {
        Self { folder: tempfile::tempdir().unwrap(), options, rendered: HashMap::new() }
    }

    fn of(&mut self, glb: &[u8]) -> Vec<f32> {
        let Self { folder, options, rendered } = self;
        rendered.entry(glb.to_vec()).or_insert_with(|| render(folder.path(), glb, options)).clone()
    }

    /// Mean difference of two scenes' pictures, as a part of the mean.
    fn difference(&mut self, a: &[u8], b: &[u8]) -> f64 {
        let (a, b) = (self.of(a), self.of(b));
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / b.len() as f64;
        let size = mean(&mut b.iter().map(|v| f64::from(*v)));
        assert!(size > 1e-3, "{}: the picture is black", self.options);
        mean(&mut a.iter().zip(&b).map(|(a, b)| f64::from((a - b).abs()))) / size
    }
}

fn render(folder: &Path, glb: &[u8], options: &str) -> Vec<f32> {
    let (scene, picture) = (folder.join("a.glb"), folder.join("a.exr"));
    std::fs::write(&scene, glb).unwrap();
    let mut command = program();
    command.arg(&scene).args(["--headless", "--size", "96x54"]).args(options.split_whitespace());
    command.arg("--output").arg(&picture);
    let run = run(command);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options}");
    read_exr(picture).unwrap().2
}

const BY_RAYS: &str = "--technique path-trace --samples 4 --direct off";

#[test]
fn colours_of_vertices_are_factors() {
    let color = |factor: [f32; 3]| room(|document, bin| attribute(document, bin, "COLOR_0", "VEC3", &factor.repeat(4)));
    let orange = room(|document, _| {
        document["materials"][0]["pbrMetallicRoughness"] = json!({"baseColorFactor": [1.0, 0.5, 0.25, 1.0]});
    });
    let (same, other) = (color([1.0, 0.5, 0.25]), color([1.0, 0.5, 0.75]));
    let pbgi = "--technique pbgi --points 4096 --direct off";
    for options in ["--view albedo", "--direct off --vpls 500", pbgi, BY_RAYS] {
        let mut pictures = Pictures::with(options);
        let found = pictures.difference(&same, &orange);
        assert!(found < 1e-3, "{options}: {found}");
        let fault = pictures.difference(&other, &orange);
        assert!(fault > 0.01, "{options}: a wrong colour makes no difference: {fault}");
    }
}

/// The floor with a texture of four colours, and these samplers and texture coordinates.
fn tiles(sampler: &Value, uvs: [f32; 8], texture: &image::RgbImage) -> Vec<u8> {
    room(|document, bin| {
        attribute(document, bin, "TEXCOORD_0", "VEC2", &uvs);
        let mut png = std::io::Cursor::new(Vec::new());
        texture.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = view(document, bin, &png.into_inner());
        document["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        document["samplers"] = json!([sampler]);
        document["textures"] = json!([{"source": 0, "sampler": 0}]);
        document["materials"][0]["pbrMetallicRoughness"] = json!({"baseColorTexture": {"index": 0}});
    })
}

/// A texture that three times two texels are read of along each axis, against one that has these 36 texels.
#[test]
fn textures_go_on_beyond_their_edges_as_samplers_say() {
    let colors = [[250, 30, 30], [30, 240, 60], [60, 60, 230], [240, 240, 80]];
    let small = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(colors[(2 * y + x) as usize]));
    let thrice = [-1.0, 2.0, 2.0, 2.0, 2.0, -1.0, -1.0, -1.0];
    let once = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let nearest = |wrap: u32| json!({"magFilter": 9728, "minFilter": 9728, "wrapS": wrap, "wrapT": wrap});
    let texel = [[0, 1, 0, 1, 0, 1], [1, 0, 0, 1, 1, 0], [0, 0, 0, 1, 1, 1]];
    let explicit = texel
        .map(|row: [u32; 6]| image::RgbImage::from_fn(6, 6, |x, y| *small.get_pixel(row[x as usize], row[y as usize])));
    let explicit = explicit.map(|texture| tiles(&nearest(10497), once, &texture));
    for options in ["--view albedo", "--direct off --vpls 500", BY_RAYS] {
        let mut pictures = Pictures::with(options);
        for (i, wrap) in [10497, 33648, 33071].into_iter().enumerate() {
            let short = tiles(&nearest(wrap), thrice, &small);
            let found = pictures.difference(&short, &explicit[i]);
            assert!(found < 0.01, "{options}, {wrap}: {found}");
            let fault = pictures.difference(&short, &explicit[(i + 1) % 3]);
            assert!(fault > 0.01, "{options}, {wrap}: another wrap mode makes no difference: {fault}");
        }
    }
}
