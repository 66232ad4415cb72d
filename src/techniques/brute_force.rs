//! Every virtual point light at every pixel: the reference for the hierarchy over the same lights.

use super::{Added, AddedView, Count, Technique, TechniqueOutputs, TechniqueShape, many_lights, reference};
use crate::Result;
use crate::dump::Entry;
use crate::job::Job;
use crate::passes::compose::Indirect;
use crate::passes::gbuffer::GBuffer;
use crate::passes::light_shape::LightShape;
use crate::passes::{Frame, brute_force};
use crate::settings::{Settings, View};
use crate::shared::FrameData;
use crate::uploaded_scene::UploadedScene;

/// The technique.
pub struct BruteForce;

/// Its sizes: the lights.
#[derive(Clone, Debug, PartialEq)]
pub struct BruteForceShape(pub LightShape);

impl Technique for BruteForce {
    fn name(&self) -> &'static str {
        "brute-force"
    }

    fn has_view(&self, view: View) -> bool {
        view == View::Vpls
    }

    fn check(&self, settings: &Settings) -> Result<()> {
        many_lights::check_settings(settings)
    }

    fn own_lights(&self, scene: &UploadedScene, settings: &Settings) -> u32 {
        many_lights::scene_lights(scene, settings)
    }

    fn is_reference(&self) -> bool {
        true
    }

    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>> {
        many_lights::check_lights(job)?;
        let mut lights = many_lights::base_shape(job);
        if let Some(BruteForceShape(known)) = known.and_then(|known| known.as_any().downcast_ref()) {
            many_lights::take_measures(&mut lights, known);
        } else if many_lights::needs_lights(job.settings.render.view) {
            many_lights::measure_paths(job, &mut lights)?;
            many_lights::check_fit(job, 16.0 * f64::from(lights.light_capacity()))?;
        }
        Ok(Box::new(BruteForceShape(lights)))
    }

    fn keeps_measures(&self, now: &Settings, before: &Settings) -> bool {
        many_lights::keeps_measures(now, before, |_| ())
    }

    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[many_lights::DUMP, reference::DUMP]
    }
}

impl TechniqueShape for BruteForceShape {
    fn technique(&self) -> &'static dyn Technique {
        &BruteForce
    }

    fn write_constants(&self, job: &Job<'_>, data: &mut FrameData) {
        many_lights::write_constants(&self.0, job, data);
    }

    fn add_passes(&self, frame: &mut Frame, gbuffer: &GBuffer) -> Added {
        let lights = frame.kept(|frame| many_lights::add_lights(frame, &self.0));
        let lighting = brute_force::add(frame, gbuffer, &lights, &self.0);
        let indirect = Indirect { lighting, shadows: None, has_share: true };
        let outputs = TechniqueOutputs::new(vec![lights.counts], lights);
        Added { indirect: Some(indirect), outputs, inspect: None }
    }

    fn add_view(&self, frame: &mut Frame, gbuffer: &GBuffer, view: View) -> Option<AddedView> {
        (view == View::Vpls).then(|| many_lights::add_points(frame, &self.0, gbuffer))
    }

    fn counts(&self, words: &[Vec<u32>]) -> Vec<Count> {
        many_lights::counts(&self.0, words)
    }

    fn complaint(&self, words: &[Vec<u32>]) -> Option<String> {
        many_lights::complaint(&self.0, words, [0, 0])
    }
}
