//! Tests of the command line.

use std::path::Path;

use super::*;
use crate::settings::{
    Antilag, BackFaces, CenterWeight, Coverage, EnvironmentSource, Exposure, FirstLevelBuild, GridUpdate, IndirectSize,
    LevelBuild, Levels, LightSet, LightingMode, Lobe, MicroFill, PixelPlace, PresentMode, Rays, RenderScale, Reservoir,
    Selection, ShadowEstimate, ShadowFilter, ShadowPoints, Size, SunPlace, Switch, Technique, Temporal, TextureFilter,
    ToneMap, View, VplImportance, VplSeeds,
};

fn command(args: &[&str]) -> Result<Command> {
    parse(std::iter::once("gridlight").chain(args.iter().copied()))
}

fn settings(args: &[&str]) -> Settings {
    match command(&[&["--headless"], args].concat()) {
        Ok(Command::Render { settings, .. }) => *settings,
        other => panic!("{args:?}: expected to render, got {other:?}"),
    }
}

fn complaint(args: &[&str]) -> String {
    match command(args) {
        Err(error) => {
            assert_eq!(error.exit_code(), 2, "{args:?}: {error}");
            let sentence = error.to_string();
            assert!(!sentence.contains('\n') && !sentence.starts_with("error"), "{sentence}");
            sentence
        }
        Ok(command) => panic!("{args:?}: expected an error, got {command:?}"),
    }
}

fn shown(args: &[&str]) -> String {
    match command(args) {
        Ok(Command::Show(text)) => text,
        other => panic!("{args:?}: expected text, got {other:?}"),
    }
}

#[test]
fn timings_of_each_format_are_kept_and_the_last_of_one() {
    let found = settings(&["--headless", "--timings", "a.json", "--timings", "b.csv", "--timings", "c.JSON"]);
    assert_eq!(found.output.timings, ["b.csv", "c.JSON"].map(std::path::PathBuf::from));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    std::fs::write(&file, "timings = [\"a.json\", \"b.csv\"]\n").unwrap();
    let file = file.to_str().unwrap();
    assert_eq!(settings(&["--settings", file]).output.timings.len(), 2);
    let over = settings(&["--settings", file, "--timings", "c.csv"]);
    assert_eq!(over.output.timings, [std::path::PathBuf::from("c.csv")]);
}

#[test]
fn a_camera_may_begin_with_a_dash() {
    assert_eq!(settings(&["--headless", "--camera", "-9,1,0,90,0,60"]).scene.camera.unwrap(), "-9,1,0,90,0,60");
}

#[test]
fn clap_finds_no_fault() {
    use clap::CommandFactory;
    Args::command().debug_assert();
}

#[test]
fn no_options_are_the_defaults() {
    assert_eq!(settings(&[]), Settings::default().changed(|s| s.run.headless = true));
}

#[test]
fn every_option_arrives() {
    let line = "a.gltf --frames 8 --warmup 2 --size 320x180 --scene night --camera atrium --sun 10,-20.5 --time -2.5 --fps 12 --animation walk --environment 1,0.5,2 --environment-scale 0.5 --environment-turn -30 --environment-samples 9 --technique lgh --samples 3 --points 4096 --micro points --coverage binary --selection paper --sun-leaves 2 --point-bounces 2 --reuse on --taa on --direct off --lights both --vpls 7 --vpl-importance none --vpl-seeds fresh \
        --bounces 5 --levels 6 --alpha 2 --lobe sh1 --center uniform --first-level 0 --interleave 4 --shadow-samples 16 --shadows off --shadow-from 3 \
        --shadow-points descent --shadow-estimate unbiased --lighting volumes --reservoir race --rays query --build scatter --scatter atomic --grid-update full --filter none --temporal off --temporal-weight 0.2 --antilag tiles --temporal-rounds 1 --indirect-size full --clamp 0 --max-submit-ms 9 --seed 9 --exposure 0.5 --exposure-compensation -1.5 --tone-map agx --back-faces cull --texture-filter trilinear --view light-count --output a.exr \
        --timings a.json --dump d --renderdoc-frame 0 --inspect 7,8 --gpu llvmpipe --validation --no-pipeline-cache --present-mode mailbox --render-scale 0.25";
    let expected = Settings::default().changed(|s| {
        s.scene.file = Some("a.gltf".into());
        s.run.headless = true;
        s.run.frames = 8;
        s.run.warmup = 2;
        s.picture.size = Size { width: 320, height: 180 };
        s.scene.scene_name = Some("night".into());
        s.scene.camera = Some("atrium".into());
        s.scene.sun = Some(SunPlace { azimuth_deg: 10.0, height_deg: -20.5 });
        s.motion.time_s = -2.5;
        s.motion.fps = 12.0;
        s.motion.animation = Some("walk".into());
        s.environment.source = Some(EnvironmentSource::Uniform([1.0, 0.5, 2.0]));
        s.environment.scale = 0.5;
        s.environment.turn_deg = -30.0;
        s.environment.samples = 9;
        s.render.technique = Technique::Lgh;
        s.path_trace.samples = 3;
        s.pbgi.points = 4096;
        s.pbgi.micro = MicroFill::Points;
        s.pbgi.coverage = Coverage::Binary;
        s.pbgi.selection = Selection::Paper;
        s.pbgi.sun_leaves = 2;
        s.pbgi.point_bounces = 2;
        s.pbgi.reuse = Switch::On;
        s.render.accumulate = 1;
        s.render.taa = Switch::On;
        s.render.direct = Switch::Off;
        s.many_lights.lights = LightSet::Both;
        s.many_lights.vpls = 7;
        s.many_lights.vpl_importance = VplImportance::None;
        s.many_lights.vpl_seeds = Some(VplSeeds::Fresh);
        s.many_lights.bounces = 5;
        s.lgh.levels = Levels::Fixed(6);
        s.lgh.alpha = 2.0;
        s.lgh.lobe = Lobe::Sh1;
        s.lgh.center = CenterWeight::Uniform;
        s.lgh.first_level = 0;
        s.lgh.interleave = 4;
        s.many_lights.shadow_samples = 16;
        s.many_lights.shadows = Switch::Off;
        s.lgh.shadow_from = 3;
        s.lgh.shadow_points = ShadowPoints::Descent;
        s.lgh.shadow_estimate = Some(ShadowEstimate::Unbiased);
        s.lgh.lighting = Some(LightingMode::Volumes);
        s.lgh.reservoir = Some(Reservoir::Race);
        s.tracing.rays = Rays::Query;
        s.lgh.build = LevelBuild::Scatter;
        s.lgh.scatter = Some(FirstLevelBuild::Atomic);
        s.lgh.grid_update = GridUpdate::Full;
        s.lgh.filter = ShadowFilter::None;
        s.lgh.temporal = Some(Temporal::Off);
        s.lgh.temporal_weight = Some(0.2);
        s.lgh.antilag = Antilag::Tiles;
        s.lgh.temporal_rounds = Some(1);
        s.many_lights.clamp = 0.0;
        s.device.max_submit_ms = 9.0;
        s.tracing.seed = 9;
        s.picture.exposure = Exposure::Fixed(0.5);
        s.picture.exposure_compensation = -1.5;
        s.picture.tone_map = ToneMap::Agx;
        s.picture.back_faces = BackFaces::Cull;
        s.picture.texture_filter = TextureFilter::Trilinear;
        s.render.view = View::LightCount;
        s.output.picture = Some("a.exr".into());
        s.output.timings = vec!["a.json".into()];
        s.output.dump = Some("d".into());
        s.output.renderdoc_frame = Some(0);
        s.output.inspect = Some(PixelPlace([7, 8]));
        s.device.gpu = Some("llvmpipe".into());
        s.device.validation = true;
        s.device.no_pipeline_cache = true;
        s.window.present_mode = PresentMode::Mailbox;
        s.window.render_scale = RenderScale::Fixed(0.25);
    });
    assert_eq!(settings(&line.split_whitespace().collect::<Vec<_>>()), expected);
    // The technique that has most of them, one frame, the ends of shadow rays that the estimate needs, and the hemisphere that
    // points do.
    let as_by_default = ["technique", "accumulate", "shadow-points", "hemisphere", "indirect-size"];
    let keys = expected.differences(&Settings::default()).unwrap().len() + as_by_default.len();
    assert_eq!(keys, Settings::keys().count());
    assert_eq!(settings(&["--shadow-points", "deviation"]).lgh.shadow_points, ShadowPoints::Deviation);
    assert_eq!(settings(&["--technique", "direct"]).render.technique, Technique::Direct);
    assert_eq!(settings(&["--levels", "auto", "--exposure", "auto"]), settings(&[]));
    // Views are of one frame.
    assert_eq!(settings(&["--accumulate", "4"]).render.accumulate, 4);
    assert_eq!(settings(&["--indirect-size", "half"]).lgh.indirect_size, IndirectSize::Half);
}

#[test]
fn a_repeated_option_takes_the_last_value() {
    let found = settings(&["--headless", "--size", "1x1", "--size", "2x3", "--output", "a.png", "--output", "b.exr"]);
    assert_eq!(found.picture.size, Size { width: 2, height: 3 });
    assert_eq!(found.output.picture.as_deref(), Some(Path::new("b.exr")));
}

#[test]
fn command_line_over_file_over_defaults() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let text = "headless = true\nframes = 5\nalpha = 2.0\nscene = \"f.glb\"\nreservoir = \"race\"\ncamera = 2\n";
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let Ok(Command::Render { settings, .. }) = command(&["--settings", path, "--frames", "9", "c.gltf"]) else {
        panic!("expected to render");
    };
    let expected = Settings::default().changed(|s| {
        s.scene.file = Some("c.gltf".into());
        s.run.headless = true;
        s.run.frames = 9;
        s.lgh.alpha = 2.0;
        s.lgh.reservoir = Some(Reservoir::Race);
        s.scene.camera = Some("2".into());
    });
    assert_eq!(*settings, expected);
    let sentence = complaint(&["--settings", path, "--technique", "direct"]);
    assert!(sentence.contains("technique direct has no reservoirs"), "{sentence}");
}

#[test]
fn settings_files_are_checked_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.json");
    std::fs::write(&path, "{\"vpls\": 0}").unwrap();
    let path = path.to_str().unwrap();
    assert_eq!(complaint(&["--headless", "--settings", path]), "--vpls must be at least 1, not 0");
    let sentence = complaint(&["--headless", "--vpls", "9", "--settings", path, "--timings", path]);
    assert_eq!(sentence, "--timings would overwrite the settings file: give another name");
    let error = command(&["--headless", "--settings", "/no/such.toml"]).unwrap_err();
    assert_eq!(error.exit_code(), 1);
}

#[test]
fn without_headless_there_is_a_window() {
    let Ok(Command::Window { settings, script, .. }) = command(&["a.glb", "--script", "s.txt"]) else { panic!() };
    assert_eq!((settings.scene.file, script), (Some("a.glb".into()), Some("s.txt".into())));
    let sentence = complaint(&["--headless", "--script", "s.txt"]);
    assert_eq!(sentence, "--script is for the window: leave out --headless and --print-graph");
    assert!(matches!(command(&["--print-graph"]), Ok(Command::Render { print_graph: true, .. })));
}

#[test]
fn files_are_left_by_runs_without_a_window() {
    for file in [["--output", "a.png"], ["--timings", "a.json"], ["--dump", "a"]] {
        let Ok(Command::Render { settings, print_graph: false, .. }) = command(&file) else { panic!("{file:?}") };
        assert!(settings.run.headless, "{file:?}");
    }
    let sentence = complaint(&["--script", "s.txt", "--output", "a.png"]);
    assert_eq!(sentence, "--script is for the window, which does not write --output a.png");
}

#[test]
fn listing_devices_needs_nothing_else() {
    let verbosity = Verbosity { verbose: 2, quiet: false };
    assert_eq!(command(&["--list-gpus", "-vv"]).unwrap(), Command::ListGpus { verbosity });
    let Ok(Command::Render { verbosity, .. }) = command(&["--headless", "--quiet"]) else { panic!() };
    assert_eq!(verbosity, Verbosity { verbose: 0, quiet: true });
    let Ok(Command::Render { verbosity, .. }) = command(&["--headless", "--verbose", "-v"]) else { panic!() };
    assert_eq!(verbosity, Verbosity { verbose: 2, quiet: false });
}

#[test]
fn mistakes_get_one_sentence() {
    let cases: [(&[&str], &str); 12] = [
        (&["--vlps", "3"], "unexpected argument '--vlps' found; a similar argument exists: '--vpls'"),
        (&["--vpls", "many"], "invalid value 'many' for '--vpls <N>'"),
        (&["--vpls"], "a value is required for '--vpls <N>'"),
        (&["--size", "big"], "`big` is not a size of the form WIDTHxHEIGHT"),
        (&["--technique", "magic"], "lgh, pbgi, final-gather, direct, brute-force, path-trace, pbgi-reference"),
        (&["--levels", "few"], "`few` is not `auto` or a whole number of levels"),
        (&["--quiet", "-v"], "cannot be used with"),
        (&["a.gltf", "b.gltf"], "unexpected argument 'b.gltf' found"),
        (&["--sun", "90"], "`90` is not AZIMUTH,HEIGHT in degrees"),
        (&["--sun", "-10,95"], "sun -10,95 needs a finite azimuth and a height from -90 to 90"),
        (&["--alpha", "-1"], "--alpha must be a finite number above 0, not -1"),
        (&["--headless", "--output", "a.bmp"], "--output a.bmp must end in .exr or .png"),
    ];
    for (args, part) in cases {
        let sentence = complaint(args);
        assert!(sentence.contains(part), "{args:?}: {sentence}");
    }
}

#[test]
fn help_names_every_option() {
    let help = shown(&["--help"]);
    let options = "--headless --frames --warmup --size --camera --sun --technique --vpls --vpl-importance --bounces --levels --alpha \
        --first-level --interleave --shadow-samples --shadow-from --shadow-points --shadow-estimate --lighting --reservoir --rays --build --scatter --filter --clamp --seed \
        --exposure --exposure-compensation --tone-map --output --timings --settings --gpu --list-gpus --validation --no-pipeline-cache --print-graph --verbose -v, --quiet \
        --lights --samples --accumulate --taa --direct --lobe --center --max-submit-ms --shadows --view --dump --renderdoc-frame --present-mode --render-scale --script --help --version [SCENE]";
    for option in options.split_whitespace() {
        assert!(help.contains(option), "{option} is missing in\n{help}");
    }
    for heading in ["Run:", "Picture:", "Method:", "Shadows:", "Device:", "Window:", "Output:", "Diagnostics:"] {
        assert!(help.lines().any(|line| line == heading), "{heading} is missing in\n{help}");
    }
    for heading in ["Options:", "Arguments:"] {
        assert!(!help.contains(heading), "an option without a group in\n{help}");
    }
}

#[test]
fn help_states_the_defaults() {
    let help = shown(&["-h"]).split_whitespace().collect::<Vec<_>>().join(" ");
    let settings = Settings::default();
    for (option, default) in [
        ("--size <WxH>", settings.picture.size.to_string()),
        ("--frames <N>", settings.run.frames.to_string()),
        ("--warmup <N>", settings.run.warmup.to_string()),
        ("--samples <N>", settings.path_trace.samples.to_string()),
        ("--points <N>", settings.pbgi.points.to_string()),
        ("--sun-leaves <N>", settings.pbgi.sun_leaves.to_string()),
        ("--point-bounces <N>", settings.pbgi.point_bounces.to_string()),
        ("--accumulate <N>", settings.render.accumulate.to_string()),
        ("--max-submit-ms <MS>", settings.device.max_submit_ms.to_string()),
        ("--vpls <N>", settings.many_lights.vpls.to_string()),
        ("--bounces <N>", settings.many_lights.bounces.to_string()),
        ("--alpha <CELLS>", settings.lgh.alpha.to_string()),
        ("--clamp <RADII>", settings.many_lights.clamp.to_string()),
        ("--seed <N>", settings.tracing.seed.to_string()),
        ("--exposure-compensation <STOPS>", settings.picture.exposure_compensation.to_string()),
        ("--tone-map <reinhard|agx|neutral>", crate::settings::name(&settings.picture.tone_map)),
    ] {
        let (_, rest) = help.split_once(option).unwrap_or_else(|| panic!("no {option}"));
        let (_, stated) = rest.split_once("[default: ").unwrap();
        assert_eq!(stated.split(']').next(), Some(default.as_str()), "{option}");
    }
}

fn compare(args: &[&str]) -> CompareArgs {
    match command(&[&["compare"], args].concat()) {
        Ok(Command::Compare(args)) => *args,
        other => panic!("{args:?}: expected to compare, got {other:?}"),
    }
}

#[test]
fn every_option_of_a_comparison_arrives() {
    let line = "a.exr b.EXR --exposure 30 --direct d.exr --max-flip 0.05 --max-relmse 0 --energy-within 1.5 \
        --heatmap h.png --json o.json --quiet";
    let expected = CompareArgs {
        reference: "a.exr".into(),
        test: "b.EXR".into(),
        exposure: Some(Exposure::Fixed(30.0)),
        direct: Some("d.exr".into()),
        max_flip: Some(0.05),
        max_relmse: Some(0.0),
        energy_within: Some(1.5),
        heatmap: Some("h.png".into()),
        json: Some("o.json".into()),
        quiet: true,
        ..CompareArgs::default()
    };
    assert_eq!(compare(&line.split_whitespace().collect::<Vec<_>>()), expected);
    assert_eq!(compare(&["a.json", "b.json", "--max-regression", "10"]).max_regression, Some(10.0));
    assert_eq!(compare(&["a.png", "b.png"]).kind().unwrap(), CompareKind::Png);
    assert_eq!(settings(&["./compare"]).scene.file, Some("./compare".into()));
    for option in "--exposure --direct --max-flip --max-relmse --energy-within --max-regression --help".split(' ') {
        assert!(shown(&["compare", "--help"]).contains(option), "{option}");
    }
}

#[test]
fn mistakes_in_comparisons_get_one_sentence() {
    let cases = [
        ("a.exr", "required arguments were not provided: <TEST>"),
        ("a.exr b.json", "a.exr and b.json are of different kinds and cannot be compared"),
        ("a.exr b.png", "a.exr and b.png are of different kinds and cannot be compared"),
        ("a.csv b.csv", "a.csv cannot be compared: it must end in .exr, .png or .json"),
        ("a.png b.png --exposure 2", "--exposure applies to EXR pictures only, and a.png is none"),
        ("a.png b.png --direct d.exr", "--direct applies to EXR pictures only, and a.png is none"),
        ("a.json b.json --max-flip 1", "--max-flip applies to pictures only, and a.json is none"),
        ("a.json b.json --heatmap a.png", "--heatmap applies to pictures only, and a.json is none"),
        ("a.exr b.exr --max-regression 5", "--max-regression applies to timings files only, and a.exr is none"),
        ("a.exr b.exr --max-flip nan", "--max-flip must be a finite number of at least 0, not NaN"),
        ("a.exr b.exr --max-relmse -1", "--max-relmse must be a finite number of at least 0, not -1"),
        ("a.json b.json --max-regression inf", "--max-regression must be a finite number of at least 0, not inf"),
        ("a.exr b.exr --exposure 0", "--exposure must be a finite number above 0, not 0"),
        ("a.exr b.exr --exposure bright", "`bright` is not `auto` or a number"),
        ("a.exr b.exr --heatmap h.exr", "--heatmap h.exr must end in .png"),
        ("a.exr b.exr --json o.txt", "--json o.txt must end in .json"),
        ("a.exr b.exr --direct d.png", "--direct d.png must end in .exr"),
        ("a.png b.png --heatmap b.png", "--heatmap b.png would overwrite what is compared"),
        ("a.exr b.exr --vpls 3", "unexpected argument '--vpls' found"),
        ("a.exr b.exr c.exr", "unexpected argument 'c.exr' found"),
    ];
    for (line, part) in cases {
        let sentence = complaint(&[vec!["compare"], line.split(' ').collect()].concat());
        assert!(sentence.contains(part), "{line}: {sentence}");
    }
    let sentence = complaint(&["--headless", "compare", "a.exr", "b.exr"]);
    assert!(sentence.contains("'a.exr' found") && sentence.contains("a command comes before"), "{sentence}");
}

#[test]
fn dumps_are_compared() {
    let diff = |args: &[&str]| match command(&[&["diff-dumps"], args].concat()) {
        Ok(Command::DiffDumps(args)) => args,
        other => panic!("{args:?}: expected to compare dumps, got {other:?}"),
    };
    let plain = DiffDumpsArgs { a: "a".into(), b: "b".into(), ..DiffDumpsArgs::default() };
    assert_eq!(diff(&["a", "b"]), plain);
    let loose = DiffDumpsArgs { tolerance: 1e-4, ignore_settings: true, ..plain };
    assert_eq!(diff(&["a", "b", "--tolerance", "1e-4", "--ignore-settings"]), loose);
    for bad in ["-1", "nan", "inf"] {
        assert!(complaint(&["diff-dumps", "a", "b", "--tolerance", bad]).starts_with("--tolerance must be a finite"));
    }
    assert!(complaint(&["diff-dumps", "a"]).contains("<B>"));
}

#[test]
fn version_names_program_and_commit() {
    let text = shown(&["--version"]);
    assert!(text.starts_with(concat!("gridlight ", env!("CARGO_PKG_VERSION"), " (")), "{text}");
}
