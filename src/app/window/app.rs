//! The event loop's side: makes the window, hands events on, keeps the first error.

use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::PhysicalKey;
use winit::window::{Window, WindowId};

use super::script::Script;
use super::session::{Pace, Session};
use crate::settings::Settings;
use crate::{Error, Result};

/// The window before and after it is there.
pub struct App {
    settings: Settings,
    script: Script,
    session: Option<Session>,
    error: Option<Error>,
}

impl App {
    /// Nothing is opened yet.
    pub fn new(settings: Settings, script: Script) -> Self {
        Self { settings, script, session: None, error: None }
    }

    /// Closes everything; what went wrong, be it only that validation has reported something.
    ///
    /// # Errors
    /// The first error, else [`Error::Validation`].
    pub fn finish(mut self) -> Result<()> {
        let messages = self.session.take().map(Session::close).transpose();
        match (self.error, messages) {
            (Some(error), _) | (None, Err(error)) => Err(error),
            (None, Ok(_)) => Ok(()),
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<()> {
        let size = self.settings.picture.size;
        let attributes = Window::default_attributes()
            .with_title("gridlight")
            .with_inner_size(PhysicalSize::new(size.width, size.height));
        let window = event_loop
            .create_window(attributes)
            .map_err(|error| Error::Failure(format!("no window could be opened ({error}): add --headless")))?;
        let script = std::mem::take(&mut self.script);
        self.session = Some(Session::open(Arc::new(window), self.settings.clone(), script)?);
        Ok(())
    }

    fn turn(&mut self, event_loop: &ActiveEventLoop) {
        let Some(session) = &mut self.session else { return };
        match session.turn() {
            Ok(Pace::Quit) => event_loop.exit(),
            Ok(Pace::In(wait)) => event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait)),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        self.error.get_or_insert(error);
        event_loop.exit();
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.session.is_none()
            && let Err(error) = self.open(event_loop)
        {
            self.fail(event_loop, error);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(session) = &mut self.session else { return };
        if matches!(event, WindowEvent::CloseRequested | WindowEvent::Destroyed) {
            event_loop.exit();
            return;
        }
        let taken = session.panel_takes(&event);
        match event {
            WindowEvent::Resized(size) => session.resized([size.width, size.height]),
            WindowEvent::Occluded(hidden) => session.hidden(hidden),
            WindowEvent::Focused(false) => session.lose_focus(),
            WindowEvent::DroppedFile(path) => session.drop_file(path),
            WindowEvent::KeyboardInput { event, .. } => {
                if let PhysicalKey::Code(key) = event.physical_key {
                    let down = event.state == ElementState::Pressed;
                    if !taken || !down {
                        session.key(key, down, event.repeat);
                    }
                }
            }
            WindowEvent::MouseInput { state, .. } => session.mouse(state == ElementState::Pressed && !taken),
            WindowEvent::CursorMoved { position, .. } => session.cursor_moved([position.x as f32, position.y as f32]),
            WindowEvent::MouseWheel { delta, .. } if !taken => session.wheel(delta),
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (DeviceEvent::MouseMotion { delta }, Some(session)) = (event, &mut self.session) {
            session.device_moved([delta.0 as f32, delta.1 as f32]);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.turn(event_loop);
    }
}

/// How long to wait while nothing can be drawn.
pub const IDLE: Duration = Duration::from_millis(10);
