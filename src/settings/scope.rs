//! What a group of settings is about, and how the program treats it therefore.

/// What a group of settings is about. Presets, the split view, settings files that a window loads, comparisons of dumps
/// and error reports treat a group by this alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// What is looked at; a run's files describe it by name.
    Scene,
    /// What a picture is like, whoever renders it.
    Picture,
    /// Which technique renders what, and how many samples it takes.
    Technique,
    /// How techniques go about it: lights, approximations, random numbers.
    Parameters,
    /// How long a run goes, and which files it leaves.
    Run,
    /// The device, and how it is treated.
    Device,
    /// How a window shows pictures.
    Window,
}

impl Scope {
    /// Whether it is about how a picture is rendered: presets set this, and the sides of a split view differ in it.
    #[must_use]
    pub fn is_method(self) -> bool {
        matches!(self, Self::Technique | Self::Parameters)
    }

    /// Whether it is about a run or a window rather than about its pictures: a window that loads a settings file keeps
    /// its own, and dumps may differ in it.
    #[must_use]
    pub fn is_session(self) -> bool {
        matches!(self, Self::Run | Self::Device | Self::Window)
    }

    /// Whether an error report decides it for each of its stages, so that nobody else can.
    #[must_use]
    pub fn is_decided_by_stages(self) -> bool {
        matches!(self, Self::Technique | Self::Run)
    }

    /// Whether the panel of a window has rows for it: what a frame can change while the window is open. Camera and sun
    /// are steered instead.
    #[must_use]
    pub fn is_in_panel(self) -> bool {
        self.is_method() || matches!(self, Self::Picture | Self::Window)
    }
}
