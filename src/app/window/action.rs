//! What can be done in the window, by keys, by the panel or by a script.

use std::path::PathBuf;

use winit::keyboard::KeyCode;

/// One thing to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Give the window this size in pixels; 0 in either takes its area away, as minimising does on some systems.
    Resize([u32; 2]),
    /// Press a key.
    Press(KeyCode),
    /// Let go of a key.
    Release(KeyCode),
    /// Turn the camera as the mouse does, right and down in pixels.
    Look([f32; 2]),
    /// Go to a camera of the scene, counted from 0.
    Camera(usize),
    /// Show or hide the panel.
    Panel,
    /// Give a setting a value, both as in a settings file.
    Set(String, String),
    /// Give a setting its default.
    Reset(String),
    /// Take all settings from others, but for the scene, the device and the window.
    Preset(&'static str),
    /// Make the picture brighter by so many stops.
    Expose(f32),
    /// Turn the sun: azimuth and elevation in degrees.
    Sun([f32; 2]),
    /// Let the sun turn by itself, degrees in a second.
    SunSpeed(f32),
    /// Begin or end the split view; it begins with the settings in use on both sides, and those on the left are held.
    Split,
    /// Exchange the sides of the split view.
    Swap,
    /// Put the divider of the split view here, 0 to 1 from the left of the window.
    Divider(f32),
    /// Begin or end to inspect the pixel under the cursor.
    Inspect,
    /// Inspect this point of the window, 0 to 1 from the top left corner.
    InspectAt([f32; 2]),
    /// Open a scene, or an image as its environment.
    Open(PathBuf),
    /// Save the picture: to a `.png` or `.exr` file, or both beside the settings under a name without an extension;
    /// without any name under the next free one.
    Screenshot(Option<PathBuf>),
    /// The same for a picture of the window's size with the settings in use, once there is one.
    Render(Option<PathBuf>),
    /// Save the settings.
    SaveSettings(PathBuf),
    /// Load settings.
    LoadSettings(PathBuf),
    /// Go to this moment of the animation, in seconds.
    Time(f64),
    /// Stop or resume time.
    Pause,
    /// One step of time, which then stands still.
    Step,
    /// Compile the shaders that have changed.
    Reload,
    /// Full screen or not.
    Fullscreen,
    /// Minimise the window.
    Minimise,
    /// Bring it back.
    Restore,
    /// Move back until all of the scene is in sight, and orbit it.
    FrameScene,
    /// Orbit the scene, or fly.
    Orbit,
    /// Fly as fast as suits the scene.
    ResetSpeed,
    /// Show or hide what the keys do.
    Help,
    /// Leave, unless something would be lost: then ask first.
    Leave,
    /// Leave.
    Quit,
}
