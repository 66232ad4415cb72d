//! The options of `gridlight error-report`.

use std::path::{Path, PathBuf};

use super::Command;
use super::options::{DiagnosticsArgs, FileArgs, Overrides};
use crate::settings::{
    DeviceSettings, EnvironmentSettings, LghSettings, LightSet, ManyLightSettings, MotionSettings, PbgiSettings,
    PictureSettings, SceneSettings, Scope, Settings, Size, TracingSettings,
};
use crate::{Error, Result, techniques};

pub(super) const HELP: &str = "Every stage is a picture with one approximation against a picture without it, of \
    indirect light alone, those of an environment of direct light; the last is the whole method against path tracing. \
    Options are those of rendering, except what the stages decide themselves: technique, samples, frames, direct light, \
    view and output.";

/// Where neither the command line nor the settings file says otherwise: a report in minutes on a software driver.
const SIZE: Size = Size { width: 320, height: 180 };
const VPLS: u32 = 10_000;
const REFERENCE_SAMPLES: u32 = 256;
const FRAMES_PER_STAGE: u32 = 16;
/// Interleaving 4x4 needs this many pixels on each side.
const LEAST_SIDE_PX: u32 = 4;

/// The files of a report's folder.
pub const REPORT_FILES: [&str; 3] = ["report.json", "report.md", "report.html"];

#[derive(Debug, clap::Args)]
pub(super) struct ErrorReportArgs {
    #[command(flatten)]
    scene: Overrides<SceneSettings>,
    #[command(flatten)]
    motion: Overrides<MotionSettings>,
    #[command(flatten)]
    environment: Overrides<EnvironmentSettings>,
    #[command(flatten)]
    file: FileArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    picture: Overrides<PictureSettings>,
    #[command(flatten)]
    tracing: Overrides<TracingSettings>,
    #[command(flatten)]
    many_lights: Overrides<ManyLightSettings>,
    #[command(flatten)]
    lgh: Overrides<LghSettings>,
    #[command(flatten)]
    pbgi: Overrides<PbgiSettings>,
    #[command(flatten)]
    device: Overrides<DeviceSettings>,
    #[command(flatten)]
    diagnostics: DiagnosticsArgs,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Report")]
struct ReportArgs {
    /// Write report.json, report.md and report.html into this folder, which is created if it is missing
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Paths per pixel of the path-traced reference, 1 or more [default: 256]
    #[arg(long, value_name = "N")]
    reference_samples: Option<u32>,
    /// Frames that stages with shadow samples are the mean of, 1 or more [default: 16]
    #[arg(long, value_name = "N")]
    frames_per_stage: Option<u32>,
}

/// How much a report renders, and where it goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ErrorReportOptions {
    /// The folder of the report's files; `None` prints the table alone.
    pub folder: Option<PathBuf>,
    /// Paths per pixel of the path-traced reference.
    pub reference_samples: u32,
    /// Frames that stages with shadow samples are the mean of.
    pub frames_per_stage: u32,
}

/// Puts the defaults of the report into the help of the options that it shares with rendering.
pub(super) fn state_defaults(command: clap::Command) -> clap::Command {
    command.mut_subcommand("error-report", |report| {
        report
            .mut_arg("size", |size| size.help(format!("Size in pixels, at least 4x4 [default: {SIZE}]")))
            .mut_arg("vpls", |vpls| {
                vpls.help(format!("Virtual point lights, about this many, 1 or more [default: {VPLS}]"))
            })
            .mut_arg("quiet", |quiet| quiet.help("Print no progress, and no table where --report writes it"))
    })
}

impl ErrorReportArgs {
    pub fn into_command(self) -> Result<Command> {
        let verbosity = self.diagnostics.verbosity();
        let options = self.report.into_options()?;
        let file = self.file.settings;
        let mut settings = Box::new(base_settings(file.as_deref())?);
        self.scene.apply(&mut settings.scene)?;
        self.motion.apply(&mut settings.motion)?;
        self.environment.apply(&mut settings.environment)?;
        self.picture.apply(&mut settings.picture)?;
        self.tracing.apply(&mut settings.tracing)?;
        self.many_lights.apply(&mut settings.many_lights)?;
        self.lgh.apply(&mut settings.lgh)?;
        self.pbgi.apply(&mut settings.pbgi)?;
        self.device.apply(&mut settings.device)?;
        settings.validate()?;
        techniques::check(&settings)?;
        check_stages(&settings)?;
        check_that_input_stays(file.as_deref(), options.folder.as_deref())?;
        Ok(Command::ErrorReport { settings, options, verbosity })
    }
}

impl ReportArgs {
    fn into_options(self) -> Result<ErrorReportOptions> {
        let options = ErrorReportOptions {
            folder: self.report,
            reference_samples: self.reference_samples.unwrap_or(REFERENCE_SAMPLES),
            frames_per_stage: self.frames_per_stage.unwrap_or(FRAMES_PER_STAGE),
        };
        let counts = [("reference-samples", options.reference_samples), ("frames-per-stage", options.frames_per_stage)];
        match counts.into_iter().find(|(_, count)| *count == 0) {
            None => Ok(options),
            Some((option, _)) => Err(Error::Usage(format!("--{option} must be at least 1, not 0"))),
        }
    }
}

/// The report's own defaults, and a settings file over them.
fn base_settings(file: Option<&Path>) -> Result<Settings> {
    let defaults = Settings::default().changed(|s| {
        s.picture.size = SIZE;
        s.many_lights.vpls = VPLS;
    });
    let Some(file) = file else { return Ok(defaults) };
    let settings = defaults.clone().read_over(file)?;
    check_that_settings_apply(&settings, &defaults)?;
    Ok(settings)
}

/// A settings file can ask for what the command line of the report cannot.
fn check_that_settings_apply(settings: &Settings, defaults: &Settings) -> Result<()> {
    let decided = settings.clone().with_groups_of(defaults, Scope::is_decided_by_stages);
    match settings.differences(&decided)?.first() {
        None => Ok(()),
        Some((key, _)) => Err(Error::Usage(format!(
            "{key} in the settings file does not apply to error-report, whose stages decide it: leave it out"
        ))),
    }
}

/// What every stage needs beyond valid settings.
fn check_stages(settings: &Settings) -> Result<()> {
    if settings.many_lights.lights != LightSet::Vpl {
        let sentence = "error-report looks at indirect light, which virtual point lights carry: leave --lights at vpl";
        return Err(Error::Usage(sentence.to_owned()));
    }
    settings.require_shadow_samples("error-report")?;
    let size = settings.picture.size;
    if size.width < LEAST_SIDE_PX || size.height < LEAST_SIDE_PX {
        return Err(Error::Usage(format!(
            "--size {size} is too small for error-report: each side needs at least {LEAST_SIDE_PX} pixels"
        )));
    }
    Ok(())
}

/// A report must not replace the settings that it was made from.
fn check_that_input_stays(file: Option<&Path>, folder: Option<&Path>) -> Result<()> {
    let (Some(file), Some(folder)) = (file.and_then(|file| file.canonicalize().ok()), folder) else { return Ok(()) };
    let outputs = REPORT_FILES.map(|name| folder.join(name));
    match outputs.iter().find(|output| output.canonicalize().is_ok_and(|output| output == file)) {
        None => Ok(()),
        Some(output) => {
            Err(Error::Usage(format!("{} would overwrite the settings file: give another folder", output.display())))
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::cli::Verbosity;

    fn command(line: &str) -> Result<Command> {
        crate::cli::parse(["gridlight", "error-report"].into_iter().chain(line.split_whitespace()))
    }

    fn report(line: &str) -> (Settings, ErrorReportOptions, Verbosity) {
        match command(line) {
            Ok(Command::ErrorReport { settings, options, verbosity }) => (*settings, options, verbosity),
            other => panic!("{line}: expected an error report, got {other:?}"),
        }
    }

    fn complaint(line: &str) -> String {
        let error = command(line).expect_err("a usage error");
        assert_eq!(error.exit_code(), 2, "{line}: {error}");
        let sentence = error.to_string();
        assert!(!sentence.contains('\n'), "{sentence}");
        sentence
    }

    #[test]
    fn the_report_has_its_own_defaults() {
        let (settings, options, verbosity) = report("");
        assert_eq!(
            settings,
            Settings::default().changed(|s| {
                s.picture.size = SIZE;
                s.many_lights.vpls = VPLS;
            })
        );
        let expected = ErrorReportOptions { folder: None, reference_samples: 256, frames_per_stage: 16 };
        assert_eq!((options, verbosity), (expected, Verbosity::default()));
    }

    #[test]
    fn every_option_arrives() {
        let line = "a.gltf --report d --reference-samples 9 --frames-per-stage 3 --size 64x32 --camera 1 --exposure 2 \
            --vpls 7 --bounces 2 --alpha 2 --interleave 2 --seed 5 --clamp 0 --build scatter --shadow-samples 8 \
            --reservoir race --gpu 0 --validation -v";
        let (settings, options, verbosity) = report(line);
        let expected = ErrorReportOptions { folder: Some("d".into()), reference_samples: 9, frames_per_stage: 3 };
        assert_eq!((options, verbosity), (expected, Verbosity { verbose: 1, quiet: false }));
        assert_eq!((settings.scene.file, settings.scene.camera), (Some("a.gltf".into()), Some("1".to_owned())));
        assert_eq!(
            (settings.many_lights.vpls, settings.lgh.interleave, settings.many_lights.shadow_samples),
            (7, 2, 8)
        );
        assert!(settings.device.validation && settings.picture.size == Size { width: 64, height: 32 });
    }

    #[test]
    fn help_states_the_defaults() {
        let Ok(Command::Show(help)) = command("--help") else { panic!("expected help") };
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for (option, default) in [
            ("--size <WxH>", SIZE.to_string()),
            ("--vpls <N>", VPLS.to_string()),
            ("--reference-samples <N>", REFERENCE_SAMPLES.to_string()),
            ("--frames-per-stage <N>", FRAMES_PER_STAGE.to_string()),
            ("--alpha <CELLS>", "1".to_owned()),
        ] {
            let (_, rest) = help.split_once(option).unwrap_or_else(|| panic!("no {option}"));
            let (_, stated) = rest.split_once("[default: ").unwrap();
            assert_eq!(stated.split(']').next(), Some(default.as_str()), "{option}");
        }
        for heading in ["Options:", "Arguments:"] {
            assert!(!help.contains(heading), "an option without a group in\n{help}");
        }
    }

    #[test]
    fn options_of_rendering_that_the_stages_decide_are_named() {
        for option in "--technique --view --dump --output --timings --accumulate --samples --frames --warmup --direct \
            --headless --print-graph --list-gpus"
            .split_whitespace()
        {
            let sentence = complaint(&format!("{option} 3"));
            assert!(sentence.contains(&format!("unexpected argument '{option}'")), "{sentence}");
        }
    }

    #[test]
    fn options_are_those_that_no_stage_decides() {
        let command = crate::cli::Args::command();
        let report = command.get_subcommands().find(|command| command.get_name() == "error-report").unwrap();
        for key in Settings::keys() {
            let scope = Settings::scope_of(&key).unwrap();
            let is_option = report.get_arguments().any(|a| a.get_long() == Some(&*key) || a.get_id() == &*key);
            assert_eq!(is_option, !scope.is_decided_by_stages() && scope != Scope::Window, "{key}");
        }
    }

    #[test]
    fn mistakes_get_one_sentence() {
        let cases = [
            ("--reference-samples 0", "--reference-samples must be at least 1, not 0"),
            ("--frames-per-stage 0", "--frames-per-stage must be at least 1, not 0"),
            ("--vpls 0", "--vpls must be at least 1, not 0"),
            ("--lights both", "leave --lights at vpl"),
            ("--shadow-samples 0", "error-report needs shadow samples, and --shadow-samples 0 leaves none"),
            ("--shadows off", "error-report needs shadow samples, and --shadows off leaves none"),
            ("--size 9x3", "--size 9x3 is too small for error-report: each side needs at least 4 pixels"),
            ("a.gltf b.gltf", "unexpected argument 'b.gltf' found"),
        ];
        for (line, part) in cases {
            let sentence = complaint(line);
            assert!(sentence.contains(part), "{line}: {sentence}");
        }
    }

    #[test]
    fn settings_files_keep_the_defaults_of_the_report() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.to_str().unwrap().to_owned()
        };
        let (settings, ..) = report(&format!("--settings {} --seed 3", file("a.toml", "alpha = 2.0\nvpls = 50\n")));
        let expected = Settings::default().changed(|s| {
            s.picture.size = SIZE;
            s.many_lights.vpls = 50;
            s.lgh.alpha = 2.0;
            s.tracing.seed = 3;
        });
        assert_eq!(settings, expected);
        let (settings, ..) = report(&format!("--settings {}", file("a.json", "{\"size\": \"1280x720\"}")));
        assert_eq!((settings.picture.size, settings.many_lights.vpls), (Settings::default().picture.size, VPLS));
        for text in ["technique = \"direct\"", "view = \"depth\"", "output = \"a.png\"", "frames = 2", "samples = 4"] {
            let sentence = complaint(&format!("--settings {}", file("b.toml", text)));
            let key = text.split(' ').next().unwrap();
            assert!(sentence.starts_with(&format!("{key} in the settings file does not apply")), "{sentence}");
        }
        let path = file("report.json", "{}");
        let sentence = complaint(&format!("--settings {path} --report {}", folder.path().display()));
        assert!(sentence.ends_with("report.json would overwrite the settings file: give another folder"), "{sentence}");
    }
}
