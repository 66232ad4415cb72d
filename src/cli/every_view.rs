//! `--view all`, which is no view but asks for each of them.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::settings::{Settings, View, name};
use crate::{Error, Result, techniques};

/// What stands for all views on the command line.
pub const ALL: &str = "all";

/// The command line without `--view all`, and whether that is its last word on views.
pub(super) fn take(args: Vec<OsString>) -> (Vec<OsString>, bool) {
    let (mut kept, mut asked) = (Vec::with_capacity(args.len()), false);
    let mut args = args.into_iter().peekable();
    while let Some(argument) = args.next() {
        let value = match argument.to_str() {
            Some("--view") => args.peek().cloned(),
            Some(word) => word.strip_prefix("--view=").map(OsString::from),
            None => None,
        };
        match value {
            None => kept.push(argument),
            Some(value) if value == ALL => {
                asked = true;
                if argument == "--view" {
                    args.next();
                }
            }
            Some(_) => {
                asked = false;
                kept.push(argument);
            }
        }
    }
    (kept, asked)
}

/// The settings of each view that technique and settings have something to show in, with the picture's file named after
/// it.
///
/// # Errors
/// [`Error::Usage`] when the settings ask for more than one picture of each.
pub(super) fn settings_of_each(settings: &Settings) -> Result<Vec<Settings>> {
    let Some(path) = &settings.output.picture else {
        return Err(Error::Usage("--view all needs --output, after which the file of each view is named".to_owned()));
    };
    if settings.render.accumulate > 1 {
        let frames = settings.render.accumulate;
        return Err(Error::Usage(format!("--view all is of one frame, not of {frames}: leave --accumulate at 1")));
    }
    if settings.output.is_sequence() {
        let path = path.display();
        return Err(Error::Usage(format!(
            "--view all is of one frame: leave the number of frames out of --output {path}"
        )));
    }
    let beside = [!settings.output.timings.is_empty(), settings.output.dump.is_some()];
    if beside.contains(&true) {
        return Err(Error::Usage("--view all writes pictures alone: leave out --timings and --dump".to_owned()));
    }
    let of = |view: &View| {
        settings.clone().changed(|s| {
            s.render.view = *view;
            s.output.picture = Some(file_of(path, *view));
        })
    };
    Ok(View::value_variants().iter().map(of).filter(|settings| techniques::check(settings).is_ok()).collect())
}

/// `a.png` is `a-depth.png` for the depth.
fn file_of(path: &Path, view: View) -> PathBuf {
    let part = |part: Option<&OsStr>| part.unwrap_or_default().to_owned();
    let mut file = part(path.file_stem());
    file.push(format!("-{}.", name(&view)));
    file.push(part(path.extension()));
    path.with_file_name(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Technique;

    fn words(line: &str) -> Vec<OsString> {
        line.split_whitespace().map(OsString::from).collect()
    }

    #[test]
    fn all_is_taken_out() {
        for (line, left, asked) in [
            ("g a.glb --view all --seed 2", "g a.glb --seed 2", true),
            ("g --view=all", "g", true),
            ("g --view all --view depth", "g --view depth", false),
            ("g --view depth --view all", "g --view depth", true),
            ("g all --view", "g all --view", false),
            ("g --views all", "g --views all", false),
        ] {
            assert_eq!(take(words(line)), (words(left), asked), "{line}");
        }
    }

    #[test]
    fn each_view_has_a_file() {
        let settings = Settings::default().changed(|s| s.output.picture = Some("d.x/a.b.png".into()));
        let each = settings_of_each(&settings).unwrap();
        let points = settings_of_each(&settings.clone().changed(|s| s.render.technique = Technique::Pbgi)).unwrap();
        let has = |list: &[Settings], view: &View| list.iter().any(|s| s.render.view == *view);
        assert!(View::value_variants().iter().all(|view| has(&each, view) || has(&points, view)));
        let files: Vec<_> = each.iter().map(|s| s.output.picture.clone().unwrap()).collect();
        assert_eq!(files[3], Path::new("d.x/a.b-depth.png"));
        let direct = settings_of_each(&settings.changed(|s| s.render.technique = Technique::Direct)).unwrap();
        assert!((2..files.len()).contains(&direct.len()), "those that the technique has");
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let complaint = |change: fn(&mut Settings)| {
            let settings = Settings::default().changed(|s| s.output.picture = Some("a.png".into())).changed(change);
            settings_of_each(&settings).unwrap_err().to_string()
        };
        assert!(complaint(|s| s.output.picture = None).contains("needs --output"));
        assert!(complaint(|s| s.render.accumulate = 4).contains("leave --accumulate at 1"));
        assert!(complaint(|s| s.output.picture = Some("a-{frame}.png".into())).contains("is of one frame"));
        assert!(complaint(|s| s.output.timings.push("a.csv".into())).contains("leave out --timings"));
    }
}
