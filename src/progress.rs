//! Progress bars on stderr, only where someone watches.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Decides once whether bars are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    shown: bool,
}

impl Progress {
    /// Bars when stderr is a terminal, unless `quiet`.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        Self { shown: !quiet && std::io::stderr().is_terminal() }
    }

    /// No bars, ever.
    #[must_use]
    pub fn hidden() -> Self {
        Self { shown: false }
    }

    /// Says something that is known before the work begins, to whoever watches.
    pub fn note(&self, line: &str) {
        if self.shown {
            eprintln!("{line}");
        }
    }

    /// Starts a named step of `total` parts.
    #[must_use]
    pub fn bar(&self, name: &str, total: u64) -> Bar {
        let target = if self.shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        if let Ok(style) = ProgressStyle::with_template("{msg:12} [{bar:40}] {percent:>3} %, {eta} left") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(name.to_owned());
        Bar { bar }
    }
}

/// One step in progress; may be shared between threads. It disappears when finished or dropped.
#[derive(Clone, Debug)]
pub struct Bar {
    bar: ProgressBar,
}

impl Bar {
    /// `done` parts are done.
    pub fn set(&self, done: u64) {
        self.bar.set_position(done);
    }

    /// The step is over: the bar disappears.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quiet_draws_nothing() {
        for progress in [Progress::new(true), Progress::hidden()] {
            let bar = progress.bar("loading", 3);
            assert!(bar.bar.is_hidden());
            bar.set(2);
            assert_eq!(bar.bar.position(), 2);
            bar.finish();
            assert!(bar.bar.is_finished());
        }
    }
}
