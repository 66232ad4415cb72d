//! A technique of its own, written against the library alone as `docs/adding.md` says: light of the same strength
//! everywhere. The renderer treats it like those that come with the program.

mod common;

use ash::vk;
use common::rooms::lamp_room;
use glam::Vec3;
use gridlight::Result;
use gridlight::dump::{Entry, LIGHTING, RGBA, all_words, buffer, image};
use gridlight::gpu::{ColorTarget, RasterWork, Work};
use gridlight::graph::{Access, BufferHandle, ImageHandle, Pass};
use gridlight::passes::compose::Indirect;
use gridlight::passes::debug_view::{self, SurfaceView};
use gridlight::passes::gbuffer::GBuffer;
use gridlight::passes::{Frame, shader, tone_map};
use gridlight::renderer::{Job, Renderer, UploadedScene};
use gridlight::report::dump::table::entry;
use gridlight::settings::{Settings, Size, Switch, View};
use gridlight::shared::InspectedPixel;
use gridlight::techniques::{
    Added, AddedView, Cell, Count, InspectorTable, Technique, TechniqueOutputs, TechniqueShape, check_with,
};

const ALBEDO: Vec3 = Vec3::new(0.75, 0.5, 0.25);
/// Light per unit albedo.
const AMBIENT: [f32; 3] = [0.5, 1.0, 1.5];
/// What is kept of it, like a sum of samples of which half are in.
const SHARE: f32 = 0.5;

/// The technique.
struct Ambient;

/// Its sizes and modes.
#[derive(Clone, Debug, PartialEq)]
struct AmbientShape {
    lights: u32,
}

impl Technique for Ambient {
    fn name(&self) -> &'static str {
        "ambient"
    }

    fn has_view(&self, view: View) -> bool {
        view == View::Indirect
    }

    fn shape(&self, job: &Job<'_>, _known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        Ok(Box::new(AmbientShape { lights: job.settings.many_lights.vpls }))
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        const ENTRIES: &[Entry] = &[
            image("ambient_sum", LIGHTING, RGBA, "Half of the light that is everywhere; A is the half."),
            image("ambient_lighting", LIGHTING, RGBA, "The light that is everywhere."),
            buffer("ambient_count", "count", all_words, "How often it is said how many lights there are."),
        ];
        &[ENTRIES]
    }
}

impl AmbientShape {
    fn add_lighting(&self, frame: &mut Frame) -> (ImageHandle, BufferHandle) {
        let count = frame.graph.persistent_buffer("ambient_count", 16);
        frame.clear(&[(count, self.lights)]);
        let sum = frame.image("ambient_sum", vk::Format::R32G32B32A32_SFLOAT);
        let [r, g, b] = AMBIENT.map(|light| (light * SHARE).to_bits());
        let work = RasterWork {
            colors: vec![ColorTarget { target: sum.into(), clear: Some([r, g, b, SHARE.to_bits()]) }],
            depth: None,
            extent_px: [frame.shape.width_px, frame.shape.height_px],
            draws: Vec::new(),
            uses_scene: false,
        };
        let pass = Pass::new("ambient/fill", Work::Raster(work)).uses(sum, Access::ColorAttachmentWrite);
        frame.graph.add_pass(pass);
        let lighting = frame.image("ambient_lighting", vk::Format::R32G32B32A32_SFLOAT);
        let pass = frame
            .compute("ambient", shader("reference/resolve_sum", frame.per_pixel()))
            .bind("sum_image", sum, Access::ComputeSampled)
            .bind("out_lighting", lighting, Access::ComputeWrite);
        frame.graph.add_pass(pass);
        (lighting, count)
    }
}

impl TechniqueShape for AmbientShape {
    fn technique(&self) -> &'static dyn Technique {
        &Ambient
    }

    fn add_passes(&self, frame: &mut Frame, _gbuffer: &GBuffer) -> Added {
        let (lighting, count) = self.add_lighting(frame);
        let indirect = Indirect { lighting, shadows: None, has_share: true };
        Added { indirect: Some(indirect), outputs: TechniqueOutputs::new(vec![count], count), inspect: None }
    }

    fn add_view(&self, frame: &mut Frame, gbuffer: &GBuffer, _view: View) -> Option<AddedView> {
        let (lighting, count) = self.add_lighting(frame);
        let values = debug_view::show_surface(frame, gbuffer, SurfaceView::Indirect(lighting));
        let outputs = TechniqueOutputs::new(vec![count], count);
        Some(AddedView { values, picture: tone_map::add(frame, gbuffer, values), outputs })
    }

    fn counts(&self, words: &[Vec<u32>]) -> Vec<Count> {
        vec![Count::new("ambient", "lights everywhere", words[0][0])]
    }

    fn inspector_tables(&self, _pixel: &InspectedPixel) -> Vec<InspectorTable> {
        let rows = vec![vec![Cell::plain(self.lights.to_string())]];
        vec![InspectorTable { name: "ambient", columns: &[("lights", "Lights everywhere")], rows }]
    }
}

fn settings(view: View) -> Settings {
    Settings::default().changed(|s| {
        s.picture.size = Size { width: 33, height: 17 };
        s.render.direct = Switch::Off;
        s.render.view = view;
        s.many_lights.vpls = 7;
    })
}

/// One frame; gives its radiance and what it counted.
fn render(technique: &dyn Technique, settings: &Settings, inspect: bool) -> (Vec<Vec3>, Vec<Count>) {
    let test = common::gpu();
    let scene = lamp_room(ALBEDO);
    let uploaded = UploadedScene::new(&test.gpu, &scene).unwrap();
    let job = Job::new(&test.gpu, &uploaded, &scene.cameras[0], settings);
    let mut renderer = Renderer::with_technique(technique, &job).unwrap();
    if inspect {
        let mut shapes = renderer.shapes().clone();
        shapes.frame.inspect = true;
        renderer = Renderer::with_shapes(&job, shapes).unwrap();
    }
    let ticket = renderer.submit().unwrap();
    renderer.wait(ticket).unwrap();
    if let Some(inspected) = renderer.outputs().inspected {
        let pixel: InspectedPixel = bytemuck::pod_read_unaligned(&renderer.executor().read_buffer(inspected).unwrap());
        assert_eq!(pixel.found, 1);
        assert_eq!(pixel.lighting[..3], AMBIENT);
        assert_eq!(renderer.shapes().technique.inspector_tables(&pixel)[0].rows[0][0].text, "7");
    }
    assert!(renderer.shapes().of::<AmbientShape>().is_some());
    assert!(renderer.outputs().technique.of::<BufferHandle>().is_some());
    let counts = renderer.shapes().technique.counts(&renderer.read_counters().unwrap());
    (renderer.read_radiance().unwrap().chunks_exact(3).map(Vec3::from_slice).collect(), counts)
}

/// The first pixel that is not albedo times the ambient light.
fn first_wrong(radiance: &[Vec3]) -> Option<usize> {
    let expected = ALBEDO * Vec3::from(AMBIENT);
    // The G-buffer keeps 11 bits of the albedo.
    let near = |found: &Vec3| (*found - expected).to_array().iter().all(|difference| difference.abs() <= 1e-3);
    radiance.iter().position(|found| !near(found))
}

#[test]
fn it_lights_the_room_evenly() {
    for (view, inspect) in [(View::Final, false), (View::Final, true), (View::Indirect, false)] {
        let (mut radiance, counts) = render(&Ambient, &settings(view), inspect);
        assert_eq!(radiance.len(), 33 * 17);
        assert_eq!(first_wrong(&radiance), None, "{view:?}");
        assert_eq!(counts, [Count::new("ambient", "lights everywhere", 7)]);
        for fault in [Vec3::splat(0.002), Vec3::splat(f32::NAN)] {
            let right = radiance[100];
            radiance[100] += fault;
            assert_eq!(first_wrong(&radiance), Some(100));
            radiance[100] = right;
        }
    }
}

#[test]
fn it_has_the_views_that_it_says() {
    check_with(&Ambient, &settings(View::Normal)).unwrap();
    check_with(&Ambient, &settings(View::Indirect)).unwrap();
    let error = check_with(&Ambient, &settings(View::LightsTested)).unwrap_err();
    assert_eq!(error.to_string(), "--technique ambient has no --view lights-tested: choose --technique lgh");
}

#[test]
fn dumps_know_what_its_resources_are() {
    for name in ["ambient_sum", "ambient_lighting", "ambient_count", "gbuffer_depth"] {
        assert!(entry(&Ambient, name).is_some(), "{name}");
    }
    assert!(entry(&Ambient, "moments").is_none());
}
