//! Scripts: actions at frames, one to a line. `docs/window.md` has the format.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::Duration;

use winit::keyboard::KeyCode;

use super::action::Action;
use super::keys;
use crate::files::read_text;
use crate::settings::Size;
use crate::{Error, Result};

/// Actions in the order of their frames.
#[derive(Debug, Default, PartialEq)]
pub struct Script {
    actions: VecDeque<(u64, Action)>,
    /// Those at moments, from when the first scene is there.
    timed: VecDeque<(Duration, Action)>,
}

/// When an action is due.
#[derive(Clone, Copy)]
enum Moment {
    Frame(u64),
    Time(Duration),
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// [`Error::File`] when the file cannot be read, [`Error::Usage`] with file and line when a line is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path).map_err(|error| Error::file(path, format!("cannot read the script: {error}")))?;
        Self::parse(&text)
            .map_err(|(line, what)| Error::Usage(format!("script {}, line {line}: {}", path.display(), what)))
    }

    fn parse(text: &str) -> std::result::Result<Self, (usize, String)> {
        let (mut actions, mut timed) = (Vec::new(), Vec::new());
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                for (moment, action) in parse_line(line).map_err(|what| (index + 1, what))? {
                    match moment {
                        Moment::Frame(frame) => actions.push((frame, action)),
                        Moment::Time(time) => timed.push((time, action)),
                    }
                }
            }
        }
        // Stable: actions of one frame stay in their order.
        actions.sort_by_key(|(frame, _)| *frame);
        timed.sort_by_key(|(time, _)| *time);
        Ok(Self { actions: actions.into(), timed: timed.into() })
    }

    /// Takes the next action that is due at `frame`.
    pub fn next(&mut self, frame: u64) -> Option<Action> {
        self.actions.front().filter(|(due, _)| *due <= frame)?;
        self.actions.pop_front().map(|(_, action)| action)
    }

    /// Takes the next action that is due at a time.
    pub fn next_timed(&mut self, time: Duration) -> Option<Action> {
        self.timed.front().filter(|(due, _)| *due <= time)?;
        self.timed.pop_front().map(|(_, action)| action)
    }

    /// Whether there is something left to do.
    pub fn is_over(&self) -> bool {
        self.actions.is_empty() && self.timed.is_empty()
    }
}

fn parse_line(line: &str) -> std::result::Result<Vec<(Moment, Action)>, String> {
    let (first, rest) = word(line);
    let (frame, rest) = word(rest);
    let (name, rest) = word(rest);
    if first != "at" || name.is_empty() {
        return Err(format!("`{line}` is not of the form `at FRAME ACTION`"));
    }
    let moment = moment(frame).ok_or_else(|| format!("`{frame}` is not the number of a frame"))?;
    if name == "key" {
        return held_key(moment, rest);
    }
    Ok(vec![(moment, action(name, rest)?)])
}

fn action(name: &str, rest: &str) -> std::result::Result<Action, String> {
    let file = || match rest {
        "" => Err(format!("`{name}` needs a file")),
        path => Ok(PathBuf::from(path)),
    };
    let alone = |action| match rest {
        "" => Ok(action),
        rest => Err(format!("`{name}` takes nothing, not `{rest}`")),
    };
    match name {
        "resize" => rest.parse::<Size>().map(|size| Action::Resize([size.width, size.height])),
        "look" => two_numbers(rest).map(Action::Look).ok_or_else(|| format!("`look {rest}` needs two numbers")),
        "camera" => rest.parse().map(Action::Camera).map_err(|_| format!("`{rest}` is not the index of a camera")),
        "technique" => Ok(Action::Set("technique".to_owned(), rest.to_owned())),
        "set" => match word(rest) {
            ("", _) | (_, "") => Err("`set` needs a setting and a value".to_owned()),
            (key, value) => Ok(Action::Set(key.to_owned(), value.to_owned())),
        },
        "drop" => file().map(Action::Open),
        "screenshot" => file().map(|path| Action::Screenshot(Some(path))),
        "render" => file().map(|path| Action::Render(Some(path))),
        "save-settings" => file().map(Action::SaveSettings),
        "load-settings" => file().map(Action::LoadSettings),
        "split" => alone(Action::Split),
        "swap" => alone(Action::Swap),
        "divider" => match rest.parse::<f32>() {
            Ok(at) if (0.0..=1.0).contains(&at) => Ok(Action::Divider(at)),
            _ => Err(format!("`divider {rest}` needs a number from 0 to 1")),
        },
        "inspect" if rest.is_empty() => Ok(Action::Inspect),
        "inspect" => match two_numbers(rest) {
            Some(at) if at.iter().all(|v| (0.0..=1.0).contains(v)) => Ok(Action::InspectAt(at)),
            _ => Err(format!("`inspect {rest}` needs two numbers from 0 to 1")),
        },
        "time" => match rest.parse::<f64>() {
            Ok(time_s) if time_s.is_finite() => Ok(Action::Time(time_s)),
            _ => Err(format!("`time {rest}` needs a number of seconds")),
        },
        "panel" => alone(Action::Panel),
        "pause" => alone(Action::Pause),
        "step" => alone(Action::Step),
        "fullscreen" => alone(Action::Fullscreen),
        "minimise" => alone(Action::Minimise),
        "restore" => alone(Action::Restore),
        "quit" => alone(Action::Quit),
        other => Err(format!("there is no action `{other}`")),
    }
}

/// A key that is held for some frames, 1 unless it is said; from a time on for some seconds.
fn held_key(from: Moment, rest: &str) -> std::result::Result<Vec<(Moment, Action)>, String> {
    let (name, held) = word(rest);
    let key: KeyCode = keys::NAMES
        .iter()
        .find_map(|(known, key)| (*known == name).then_some(*key))
        .ok_or_else(|| format!("there is no key `{name}`; keys are {}", key_names()))?;
    let held = if held.is_empty() { "1" } else { held };
    let until = match from {
        Moment::Frame(frame) => held.parse().ok().map(|frames| Moment::Frame(frame.saturating_add(frames))),
        Moment::Time(time) => seconds(held).map(|held| Moment::Time(time.saturating_add(held))),
    };
    let unit = if matches!(from, Moment::Frame(_)) { "frames" } else { "seconds" };
    let until = until.ok_or_else(|| format!("`{held}` is not a number of {unit}"))?;
    Ok(vec![(from, Action::Press(key)), (until, Action::Release(key))])
}

/// A frame, or a time with an `s` behind it.
fn moment(text: &str) -> Option<Moment> {
    match text.strip_suffix('s') {
        Some(time) => seconds(time).map(Moment::Time),
        None => text.parse().ok().map(Moment::Frame),
    }
}

fn seconds(text: &str) -> Option<Duration> {
    text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
}

fn key_names() -> String {
    keys::NAMES.map(|(name, _)| name).join(" ")
}

fn two_numbers(text: &str) -> Option<[f32; 2]> {
    let (a, b) = word(text);
    Some([a.parse().ok().filter(|x: &f32| x.is_finite())?, b.parse().ok().filter(|x: &f32| x.is_finite())?])
}

/// The first word and the rest.
fn word(text: &str) -> (&str, &str) {
    let text = text.trim();
    text.split_once(char::is_whitespace).map_or((text, ""), |(first, rest)| (first, rest.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn actions_come_in_the_order_of_their_frames() {
        let text =
            "# a comment\n\nat 5 quit\nat 2 key w 2\nat 2 resize 640x360\nat 3 set alpha 2\nat 0 drop a b.gltf\n";
        let mut script = Script::parse(text).unwrap();
        assert_eq!(script.next(0), Some(Action::Open("a b.gltf".into())));
        assert_eq!(script.next(1), None);
        assert_eq!(script.next(2), Some(Action::Press(KeyCode::KeyW)));
        assert_eq!(script.next(2), Some(Action::Resize([640, 360])));
        assert_eq!(script.next(9), Some(Action::Set("alpha".into(), "2".into())));
        assert_eq!(script.next(9), Some(Action::Release(KeyCode::KeyW)));
        assert!(!script.is_over());
        assert_eq!(script.next(9), Some(Action::Quit));
        assert!(script.is_over());
    }

    #[test]
    fn actions_come_at_their_times() {
        let mut script = Script::parse("at 2.5s key w 0.5\nat 1s pause\nat 3 quit\n").unwrap();
        let time = Duration::from_secs_f64;
        assert_eq!(script.next_timed(time(0.9)), None);
        assert_eq!(script.next_timed(time(2.6)), Some(Action::Pause));
        assert_eq!(script.next_timed(time(2.6)), Some(Action::Press(KeyCode::KeyW)));
        assert_eq!(script.next_timed(time(2.9)), None);
        assert_eq!(script.next_timed(time(3.0)), Some(Action::Release(KeyCode::KeyW)));
        assert_eq!((script.is_over(), script.next(3)), (false, Some(Action::Quit)));
        assert!(script.is_over());
        // What ends after all time ends with it.
        assert!(Script::parse("at 1e19s key w 1e19").is_ok());
    }

    #[test]
    fn mistakes_name_the_line() {
        let cases = [
            ("at 1 quit\nquit", 2, "`quit` is not of the form `at FRAME ACTION`"),
            ("at x quit", 1, "`x` is not the number of a frame"),
            ("at 1 dance", 1, "there is no action `dance`"),
            ("at 1 resize big", 1, "`big` is not a size"),
            ("at 1 key hyper", 1, "there is no key `hyper`"),
            ("at 1 key w long", 1, "`long` is not a number of frames"),
            ("at 1s key w long", 1, "`long` is not a number of seconds"),
            ("at -1s quit", 1, "`-1s` is not the number of a frame"),
            ("at 1 divider 2", 1, "`divider 2` needs a number from 0 to 1"),
            ("at 1 inspect 0.5", 1, "`inspect 0.5` needs two numbers from 0 to 1"),
            ("at 1 look 3", 1, "`look 3` needs two numbers"),
            ("at 1 drop", 1, "`drop` needs a file"),
            ("at 1 time later", 1, "`time later` needs a number of seconds"),
            ("at 1 time inf", 1, "`time inf` needs a number of seconds"),
            ("at 1 set alpha", 1, "`set` needs a setting and a value"),
            ("at 1 quit now", 1, "`quit` takes nothing, not `now`"),
        ];
        for (text, line, part) in cases {
            let (found, what) = Script::parse(text).unwrap_err();
            assert!(found == line && what.contains(part), "{text}: line {found}, {what}");
        }
    }
}
