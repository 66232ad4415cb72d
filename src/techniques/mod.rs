//! Techniques: each owns its sizes, what is measured for it before the first frame, its passes, views, counts,
//! descriptions in dumps, and what the inspector tells. `docs/adding.md` says how to add one.

pub mod brute_force;
mod counts;
pub mod direct;
pub mod lgh;
pub mod many_lights;
pub mod path_trace;
pub mod pbgi;
mod reference;
mod rules;
mod shape;
mod spacing;
mod starts;
mod unused;

use crate::dump::Entry;
use crate::job::Job;
use crate::passes::temporal::Reuse;
use crate::settings::{self, Settings, View};
use crate::uploaded_scene::UploadedScene;
use crate::{Error, Result};

pub use brute_force::BruteForceShape;
pub use counts::{Cell, Count, InspectorImage, InspectorTable};
pub use rules::{check, check_with};
pub use shape::{Added, AddedView, AnyShape, InspectPass, Shapes, TechniqueOutputs, TechniqueShape};
pub use unused::why_unused;

/// Every technique, in the order in which they are offered.
pub static TECHNIQUES: &[&dyn Technique] = &[
    &lgh::Lgh,
    &pbgi::Pbgi,
    &pbgi::FinalGather,
    &direct::Direct,
    &brute_force::BruteForce,
    &path_trace::PathTrace,
    &pbgi::PbgiReference,
];

/// A way to light a scene.
pub trait Technique: Sync {
    /// The word that asks for it in settings.
    fn name(&self) -> &'static str;

    /// Whether its frames have what a view shows, besides what every frame has.
    fn has_view(&self, _view: View) -> bool {
        false
    }

    /// Checks settings without a scene or a device.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence about the first thing wrong.
    fn check(&self, _settings: &Settings) -> Result<()> {
        Ok(())
    }

    /// Checks that settings which it alone reads are left alone; called while another technique, `chosen`, renders.
    ///
    /// # Errors
    /// [`Error::Usage`] with one sentence about the first that is not.
    fn check_unused(&self, _settings: &Settings, _chosen: &str) -> Result<()> {
        Ok(())
    }

    /// Punctual lights of the scene that it shades itself; the direct light leaves them out.
    fn own_lights(&self, _scene: &UploadedScene, _settings: &Settings) -> u32 {
        0
    }

    /// Binary logarithm of the number of points that it needs spread over the scene's surfaces.
    fn point_count_log2(&self, _settings: &Settings) -> Option<u32> {
        None
    }

    /// Whether it gathers samples over many rounds, so that a frame may take long.
    fn is_reference(&self) -> bool {
        false
    }

    /// Whether the noise of the environment's direct light is filtered. References have many samples of their own.
    fn filters_area_light(&self, _settings: &Settings) -> bool {
        !self.is_reference()
    }

    /// What its frames take over from what the frames before had of the same surfaces.
    fn reuse(&self, _job: &Job<'_>) -> Option<Reuse> {
        None
    }

    /// Settings for two independent parts of a frame's samples; their difference tells the noise of their mean.
    /// `None` where there is nothing to divide.
    fn halves(&self, _settings: &Settings) -> Option<[Settings; 2]> {
        None
    }

    /// Its sizes and modes for a job, which may take frames that measure. `known` is a shape that was measured before
    /// for settings of which [`Self::keeps_measures`] holds.
    ///
    /// # Errors
    /// [`Error::Usage`] when the settings do not fit the scene or the device; device errors.
    fn shape(&self, job: &Job<'_>, known: Option<&dyn TechniqueShape>) -> Result<Box<dyn TechniqueShape>>;

    /// Whether what was measured with the settings `before` holds for the settings `now`.
    fn keeps_measures(&self, _now: &Settings, _before: &Settings) -> bool {
        true
    }

    /// Descriptions of its resources for dumps.
    fn dump_entries(&self) -> &'static [&'static [Entry]] {
        &[]
    }
}

/// The technique that settings ask for.
///
/// # Errors
/// [`Error::Usage`] when there is none of that name.
pub fn of(settings: &Settings) -> Result<&'static dyn Technique> {
    let wanted = settings::name(&settings.render.technique);
    TECHNIQUES.iter().copied().find(|technique| technique.name() == wanted).ok_or_else(|| {
        let names: Vec<_> = TECHNIQUES.iter().map(|technique| technique.name()).collect();
        Error::Usage(format!("there is no technique {wanted}: choose {}", names.join(", ")))
    })
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use std::sync::Arc;

    use super::pbgi::PbgiReferenceShape;
    use crate::passes::light_shape::LightShape;
    use crate::passes::pbgi_shape::PbgiShape;
    use crate::points::PointCloud;
    use crate::scene::testing::plane;
    use crate::settings::{Coverage, Hemisphere, MicroFill, Selection};

    /// Shapes of the techniques that have few sizes.
    pub fn all_shapes(lights: LightShape) -> [Box<dyn TechniqueShape>; 3] {
        [
            Box::new(direct::Direct),
            Box::new(brute_force::BruteForceShape(lights)),
            Box::new(path_trace::PathTraceShape { samples: 2 }),
        ]
    }

    /// Shapes of point-based global illumination, with every pass that it can have.
    pub fn pbgi_shapes() -> [Box<dyn TechniqueShape>; 3] {
        let rays = PbgiShape {
            cloud: Arc::new(PointCloud::of_scene(&plane(1.0), 6).unwrap()),
            primary_capacity: 16,
            reference_capacity: 64,
            reuse: true,
            micro: MicroFill::Rays,
            coverage: Coverage::Fraction,
            hemisphere: Hemisphere::Paraboloid,
            selection: Selection::Levels,
            bounces: 3,
            environment_means: vec![[0.0; 4]; 4].into(),
        };
        let points = PbgiShape { micro: MicroFill::Points, selection: Selection::Arrival, ..rays.clone() };
        [Box::new(rays.clone()), Box::new(points), Box::new(PbgiReferenceShape(rays))]
    }
}
