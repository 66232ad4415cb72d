//! What the stages of the error report render: a list of recipes, made from the settings alone.

use clap::ValueEnum;

use crate::cli::ErrorReportOptions;
use crate::settings::{LevelBuild, Settings, ShadowEstimate, ShadowFilter, ShadowPoints, Switch, Technique, name};

/// The frames that a picture comes from. All of them have the same light paths and sampling points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frames {
    /// One frame.
    One,
    /// The mean of so many frames with shadow samples of their own.
    Mean(u32),
    /// The mean of as many, each made as if it stood alone: its noise is filtered as that of a single frame is.
    MeanOfSingle(u32),
    /// One frame with shadow samples that no mean of so many frames has.
    OneAfter(u32),
}

/// How a picture comes about.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The settings of its frames.
    pub settings: Settings,
    /// The frames.
    pub frames: Frames,
}

/// One of the two pictures of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// What it shows, a few words.
    pub label: String,
    /// How it comes about.
    pub recipe: Recipe,
    /// Direct light to be added to it.
    pub direct: Option<Recipe>,
}

/// What a stage compares.
#[derive(Clone, Debug, PartialEq)]
pub struct StagePlan {
    /// Name of the stage.
    pub name: String,
    /// What makes the two pictures differ, one sentence.
    pub cause: String,
    /// The picture without the approximation.
    pub reference: Picture,
    /// The picture with it.
    pub test: Picture,
    /// What limits the comparison, one sentence each.
    pub notes: Vec<String>,
}

/// The stages in the order of the method's approximations. `has_environment` says whether the scene's surroundings send
/// light.
#[must_use]
pub fn plan(settings: &Settings, options: &ErrorReportOptions, has_environment: bool) -> Vec<StagePlan> {
    let samples_environment = has_environment && settings.environment.samples > 0;
    let planner = Planner { settings, options, samples_environment };
    let mut stages = vec![planner.vpl_sampling(), planner.clamp(), planner.hierarchy(), planner.build()];
    stages.extend([planner.shadow_sampling(), planner.noise(), planner.filter(), planner.filtered_shadows()]);
    stages.extend(planner.estimates());
    stages.extend([2, 4].map(|side| planner.interleave(side)));
    if samples_environment {
        stages.extend([planner.environment_noise(), planner.environment_filter()]);
    }
    stages.push(planner.whole_method());
    stages
}

/// Makes the stages' recipes from the settings.
struct Planner<'a> {
    settings: &'a Settings,
    options: &'a ErrorReportOptions,
    /// Shadow rays go towards the environment.
    samples_environment: bool,
}

impl Planner<'_> {
    fn vpl_sampling(&self) -> StagePlan {
        let notes = vec![
            "One set of VPLs stands for all light: its noise is the same at every pixel, and bright spots next to VPLs \
             belong to it."
                .to_owned(),
        ];
        let cause = "Virtual point lights carry the light instead of paths from every pixel.";
        stage("VPL sampling", cause, self.path_traced(), self.every_vpl(0.0, Switch::On), notes)
    }

    fn clamp(&self) -> StagePlan {
        let clamp = self.settings.many_lights.clamp;
        let notes = if clamp == 0.0 { vec!["The settings do not clamp.".to_owned()] } else { Vec::new() };
        let cause = format!(
            "VPLs nearer than {clamp} radii of the disc that one stands for count as if they were that far away."
        );
        stage("clamp", &cause, self.every_vpl(0.0, Switch::On), self.every_vpl(clamp, Switch::On), notes)
    }

    fn hierarchy(&self) -> StagePlan {
        let cause = "Grid lights stand for the VPLs further away, without shadows on either side.";
        stage(
            "hierarchy",
            cause,
            self.every_vpl(self.settings.many_lights.clamp, Switch::Off),
            self.unshadowed(self.settings.lgh.build),
            Vec::new(),
        )
    }

    fn build(&self) -> StagePlan {
        let cause = "Coarse levels gather from finer ones instead of from every VPL.";
        let build = match self.settings.lgh.build {
            LevelBuild::Scatter => LevelBuild::Cascade,
            other => other,
        };
        let (reference, test) = (self.unshadowed(LevelBuild::Scatter), self.unshadowed(build));
        stage("build", cause, reference, test, Vec::new())
    }

    fn shadow_sampling(&self) -> StagePlan {
        let mut notes = self.shadow_notes();
        notes.push(
            "Where no sample of a frame carries light, the shadow of the pixels around it takes its place.".to_owned(),
        );
        let cause = match self.settings.lgh.shadow_estimate_or_default() {
            ShadowEstimate::Ratio => "A few shadow rays to chosen lights darken all of the light by one ratio.",
            ShadowEstimate::Corrected | ShadowEstimate::Unbiased => "A few shadow rays to chosen lights stand for all.",
        };
        let reference = self.every_vpl(self.settings.many_lights.clamp, Switch::On);
        stage("shadow sampling", cause, reference, self.mean(ShadowFilter::None, 1), notes)
    }

    fn noise(&self) -> StagePlan {
        let frames = self.options.frames_per_stage;
        let label = "one frame, unfiltered".to_owned();
        let recipe = Recipe { frames: Frames::OneAfter(frames), ..self.mean(ShadowFilter::None, 1).recipe };
        let notes = vec![format!("The mean's own noise, 1/{frames} of the variance, is in it.")];
        let cause = "The shadow samples of a single frame.";
        stage(
            "noise of a frame",
            cause,
            self.mean(ShadowFilter::None, 1),
            Picture { label, recipe, direct: None },
            notes,
        )
    }

    fn filter(&self) -> StagePlan {
        let cause = "The shadow estimates are blurred across each surface.";
        let mut notes = Vec::new();
        if self.settings.lgh.filter == ShadowFilter::None {
            notes.push("The settings leave this filter out.".to_owned());
        }
        stage("filter", cause, self.mean(ShadowFilter::None, 1), self.mean(ShadowFilter::Atrous, 1), notes)
    }

    fn filtered_shadows(&self) -> StagePlan {
        let cause = "Shadow samples and their filter together.";
        let reference = self.every_vpl(self.settings.many_lights.clamp, Switch::On);
        stage("filtered shadows", cause, reference, self.mean(ShadowFilter::Atrous, 1), self.shadow_notes())
    }

    /// Each estimate of the light in shadow beside the light itself. Only rays that end on lights can make them all.
    fn estimates(&self) -> Vec<StagePlan> {
        let lgh = &self.settings.lgh;
        let all = ShadowEstimate::value_variants().iter().filter(|_| lgh.shadow_points == ShadowPoints::Descent);
        let stage_of = |estimate: &ShadowEstimate| {
            let cause = match estimate {
                ShadowEstimate::Ratio => {
                    "The hierarchy's light times the part of it that shadow samples find unblocked."
                }
                ShadowEstimate::Corrected => "What shadow samples find, those that stand out cut before the filter.",
                ShadowEstimate::Unbiased => "What shadow samples find, whatever the grid lights stand for.",
            };
            let mut test = self.mean(lgh.filter, 1);
            test.label += &format!(", {}", name(estimate));
            // What is set is rendered for other stages as well.
            if *estimate != lgh.shadow_estimate_or_default() {
                test.recipe.settings.lgh.shadow_estimate = Some(*estimate);
            }
            let reference = self.every_vpl(self.settings.many_lights.clamp, Switch::On);
            stage(&format!("estimate {}", name(estimate)), cause, reference, test, Vec::new())
        };
        all.map(stage_of).collect()
    }

    fn shadow_notes(&self) -> Vec<String> {
        let mut notes = vec!["The error of the hierarchy itself is in it.".to_owned()];
        if self.settings.lgh.shadow_from > 0 {
            notes.push(format!("Lights below level {} get no shadow samples.", self.settings.lgh.shadow_from));
        }
        notes
    }

    fn interleave(&self, side: u32) -> StagePlan {
        let filter = self.settings.lgh.filter;
        let cause =
            format!("Each pixel is lit by 1 of {} parts of the lights, and its neighbours fill in.", side * side);
        let name = format!("interleave {side}x{side}");
        stage(&name, &cause, self.mean(filter, 1), self.mean(filter, side), Vec::new())
    }

    fn environment_noise(&self) -> StagePlan {
        let frames = self.options.frames_per_stage;
        let label = "direct light, one frame, unfiltered".to_owned();
        let reference = self.direct_mean();
        let recipe = Recipe { frames: Frames::OneAfter(frames), ..reference.recipe.clone() };
        let notes = vec![
            "Both pictures are of direct light, that of lamps and the background included.".to_owned(),
            format!("The mean's own noise, 1/{frames} of the variance, is in it."),
        ];
        let rays = self.settings.environment.samples;
        let cause = format!("The environment's direct light comes from {rays} shadow rays per pixel.");
        stage("environment noise", &cause, reference, Picture { label, recipe, direct: None }, notes)
    }

    fn environment_filter(&self) -> StagePlan {
        let frames = self.options.frames_per_stage;
        let label = format!("direct light, mean of {frames} filtered frames");
        let settings = self.of(Technique::Direct, Switch::On);
        let settings = settings.changed(|s| s.lgh.filter = ShadowFilter::Atrous);
        let recipe = Recipe { settings, frames: Frames::MeanOfSingle(frames) };
        let mut notes = vec!["The filter's frames have the same samples as the mean's.".to_owned()];
        if self.settings.lgh.filter == ShadowFilter::None {
            notes.push("The settings leave this filter out.".to_owned());
        }
        let cause = "The environment's direct light is blurred across each surface.";
        let test = Picture { label, recipe, direct: None };
        stage("environment filter", cause, self.direct_mean(), test, notes)
    }

    /// Direct light with little noise of the environment's samples, and no filter.
    fn direct_mean(&self) -> Picture {
        let frames = self.options.frames_per_stage;
        let label = format!("direct light, mean of {frames} frames, unfiltered");
        let settings = self.of(Technique::Direct, Switch::On).changed(|s| s.lgh.filter = ShadowFilter::None);
        Picture { label, recipe: Recipe { settings, frames: Frames::Mean(frames) }, direct: None }
    }

    fn whole_method(&self) -> StagePlan {
        let mut reference = self.path_traced();
        reference.label += ", with direct light";
        // Lamps alone leave no noise.
        let one_frame = || Recipe { settings: self.of(Technique::Direct, Switch::On), frames: Frames::One };
        reference.direct = Some(if self.samples_environment { self.direct_mean().recipe } else { one_frame() });
        let settings = self.of(Technique::Lgh, Switch::On);
        let settings = settings.changed(|s| s.lgh.interleave = self.settings.lgh.interleave);
        let recipe = Recipe { settings, frames: Frames::One };
        let test = Picture { label: "one frame as set".to_owned(), recipe, direct: None };
        let cause = "Everything together: one frame as the settings say, with direct light.";
        stage("whole method", cause, reference, test, Vec::new())
    }

    /// The settings with another technique, not interleaved; direct light on or off.
    fn of(&self, technique: Technique, direct: Switch) -> Settings {
        self.settings.clone().changed(|s| {
            s.render.technique = technique;
            s.render.direct = direct;
            s.lgh.interleave = 1;
            // Every picture stands alone.
            (s.render.taa, s.lgh.temporal) = (Switch::Off, None);
        })
    }

    fn path_traced(&self) -> Picture {
        let samples = self.options.reference_samples;
        let label = format!("path tracing, {samples} paths per pixel");
        let settings = self.of(Technique::PathTrace, Switch::Off).changed(|s| s.path_trace.samples = samples);
        Picture { label, recipe: Recipe { settings, frames: Frames::One }, direct: None }
    }

    fn every_vpl(&self, clamp: f32, shadows: Switch) -> Picture {
        let shadowed = if shadows.is_on() { "shadowed" } else { "unshadowed" };
        let clamped = if clamp > 0.0 { "clamped" } else { "not clamped" };
        let label = format!("every VPL, {shadowed}, {clamped}");
        let settings = self.of(Technique::BruteForce, Switch::Off).changed(|s| {
            s.many_lights.clamp = clamp;
            s.many_lights.shadows = shadows;
        });
        Picture { label, recipe: Recipe { settings, frames: Frames::One }, direct: None }
    }

    fn unshadowed(&self, build: LevelBuild) -> Picture {
        let built = match build {
            LevelBuild::Cascade => "cascaded",
            LevelBuild::Gather => "gathered",
            LevelBuild::Scatter => "scattered",
        };
        let label = format!("hierarchy, {built}, unshadowed");
        let settings = self.of(Technique::Lgh, Switch::Off).changed(|s| {
            s.lgh.build = build;
            s.many_lights.shadows = Switch::Off;
        });
        Picture { label, recipe: Recipe { settings, frames: Frames::One }, direct: None }
    }

    fn mean(&self, filter: ShadowFilter, interleave: u32) -> Picture {
        let frames = self.options.frames_per_stage;
        let interleaved =
            if interleave > 1 { format!(", interleaved {interleave}x{interleave}") } else { String::new() };
        let filtered = match filter {
            ShadowFilter::Atrous => "filtered",
            ShadowFilter::None => "unfiltered",
        };
        let label = format!("mean of {frames} frames, {filtered}{interleaved}");
        let settings = self.of(Technique::Lgh, Switch::Off).changed(|s| {
            s.lgh.filter = filter;
            s.lgh.interleave = interleave;
        });
        Picture { label, recipe: Recipe { settings, frames: Frames::Mean(frames) }, direct: None }
    }
}

fn stage(name: &str, cause: &str, reference: Picture, test: Picture, notes: Vec<String>) -> StagePlan {
    StagePlan { name: name.to_owned(), cause: cause.to_owned(), reference, test, notes }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options() -> ErrorReportOptions {
        ErrorReportOptions { folder: None, reference_samples: 64, frames_per_stage: 8 }
    }

    /// The settings that differ between two recipes.
    fn differing(a: &Recipe, b: &Recipe) -> Vec<String> {
        let [a, b] = [a, b].map(|recipe| serde_json::to_value(&recipe.settings).unwrap());
        let (a, b) = (a.as_object().unwrap(), b.as_object().unwrap());
        a.keys().filter(|key| a[*key] != b[*key]).cloned().collect()
    }

    #[test]
    fn each_stage_changes_its_cause_alone() {
        let settings = Settings::default().changed(|s| s.lgh.interleave = 2);
        let plan = plan(&settings, &options(), false);
        let changes: Vec<(&str, Vec<String>)> =
            plan.iter().map(|s| (s.name.as_str(), differing(&s.reference.recipe, &s.test.recipe))).collect();
        let expected: [(&str, &[&str]); 14] = [
            ("VPL sampling", &["clamp", "samples", "technique"]),
            ("clamp", &["clamp"]),
            ("hierarchy", &["technique"]),
            ("build", &["build"]),
            ("shadow sampling", &["filter", "technique"]),
            ("noise of a frame", &[]),
            ("filter", &["filter"]),
            ("filtered shadows", &["technique"]),
            ("estimate ratio", &["shadow-estimate", "technique"]),
            ("estimate corrected", &["technique"]),
            ("estimate unbiased", &["shadow-estimate", "technique"]),
            ("interleave 2x2", &["interleave"]),
            ("interleave 4x4", &["interleave"]),
            ("whole method", &["direct", "interleave", "samples", "technique"]),
        ];
        assert_eq!(changes, expected.map(|(name, keys)| (name, keys.iter().map(|k| (*k).to_owned()).collect())));
    }

    #[test]
    fn the_whole_method_is_one_frame_as_set() {
        let settings = Settings::default().changed(|s| {
            s.lgh.interleave = 4;
            s.lgh.filter = ShadowFilter::None;
            s.lgh.alpha = 2.0;
        });
        let plan = plan(&settings, &options(), false);
        let whole = plan.last().unwrap();
        assert_eq!(whole.test.recipe, Recipe { settings, frames: Frames::One });
        let direct = whole.reference.direct.as_ref().unwrap();
        assert_eq!((direct.settings.render.technique, direct.settings.render.direct), (Technique::Direct, Switch::On));
        // Path tracing is done once, for the first stage and the last.
        assert_eq!(whole.reference.recipe, plan[0].reference.recipe);
        assert!(!plan[0].reference.recipe.settings.render.direct.is_on() && plan[0].reference.direct.is_none());
    }

    #[test]
    fn pictures_are_shared_between_stages() {
        let plan = plan(&Settings::default(), &options(), false);
        let mut recipes: Vec<&Recipe> = Vec::new();
        for picture in plan.iter().flat_map(|stage| [&stage.reference, &stage.test]) {
            if !recipes.contains(&&picture.recipe) {
                recipes.push(&picture.recipe);
            }
        }
        assert_eq!(recipes.len(), 14, "path tracing, three brute forces, and ten of the hierarchy");
    }

    #[test]
    fn estimates_need_rays_that_end_on_lights() {
        let settings = Settings::default().changed(|s| s.lgh.shadow_points = ShadowPoints::Deviation);
        assert!(plan(&settings, &options(), false).iter().all(|stage| !stage.name.starts_with("estimate")));
    }

    #[test]
    fn the_single_frame_is_none_of_the_mean() {
        let plan = plan(&Settings::default(), &options(), false);
        let noise = &plan[5];
        assert_eq!(noise.reference.recipe.frames, Frames::Mean(8));
        assert_eq!(noise.test.recipe.frames, Frames::OneAfter(8));
    }

    #[test]
    fn an_environment_has_stages_where_rays_go_there() {
        let settings = Settings::default();
        let plan_of = |settings: &Settings| plan(settings, &options(), true);
        let found = plan_of(&settings);
        let [noise, filter, whole] = &found[found.len() - 3..] else { panic!("{} stages", found.len()) };
        assert_eq!((noise.name.as_str(), filter.name.as_str()), ("environment noise", "environment filter"));
        // Nothing but the frame differs, then nothing but the filter; the whole method is compared with the same mean.
        assert_eq!(differing(&noise.reference.recipe, &noise.test.recipe), [""; 0]);
        assert_eq!(differing(&filter.reference.recipe, &filter.test.recipe), ["filter"]);
        assert_eq!(filter.test.recipe.frames, Frames::MeanOfSingle(8));
        for picture in [&noise.reference, &filter.reference] {
            assert_eq!(whole.reference.direct.as_ref(), Some(&picture.recipe));
        }
        let without_rays = settings.changed(|s| s.environment.samples = 0);
        assert_eq!(plan_of(&without_rays), plan(&without_rays, &options(), false));
    }
}
