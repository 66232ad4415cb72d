//! Keys, mouse and what else the window is told.

use std::path::PathBuf;

use winit::event::{MouseScrollDelta, WindowEvent};
use winit::keyboard::KeyCode;
use winit::window::CursorGrabMode;

use super::Session;
use crate::app::window::action::Action;

impl Session {
    /// Lets the panel see an event; true when it is the panel's alone.
    pub fn panel_takes(&mut self, event: &WindowEvent) -> bool {
        if !matches!(event, WindowEvent::RedrawRequested) {
            self.dirty = true;
        }
        self.panel.on_event(&self.window, event)
    }

    /// A key goes down or up.
    pub fn key(&mut self, key: KeyCode, down: bool, repeat: bool) {
        // The keys that were held until now have moved the camera until now.
        if let Err(error) = self.pass_time() {
            log::error!("{error}");
        }
        self.keys.set(key, down);
        if let Some(action) = self.keys.action(key).filter(|_| down && !repeat)
            && let Err(error) = self.act(action)
        {
            log::error!("{error}");
            self.panel.show_error(error.to_string());
        }
    }

    /// The window lost the keyboard.
    pub fn lose_focus(&mut self) {
        self.keys.release_all();
        self.mouse(false);
    }

    /// A button goes down over the picture, or up.
    pub fn mouse(&mut self, down: bool) {
        if self.drag.is_on() == down {
            return;
        }
        self.drag.set(down);
        let modes: &[_] =
            if down { &[CursorGrabMode::Locked, CursorGrabMode::Confined] } else { &[CursorGrabMode::None] };
        match modes.iter().find(|mode| self.window.set_cursor_grab(**mode).is_ok()) {
            Some(CursorGrabMode::Locked) => self.drag.lock(),
            Some(_) => {}
            None => log::debug!("the cursor cannot be held"),
        }
        self.window.set_cursor_visible(!down);
    }

    /// A pointing device moves, right and down, in pixels.
    pub fn device_moved(&mut self, step_px: [f32; 2]) {
        if let Some([dx, dy]) = self.drag.device_moved(step_px) {
            self.camera.look(dx, dy);
        }
    }

    /// The cursor is elsewhere in the window.
    pub fn cursor_moved(&mut self, at_px: [f32; 2]) {
        if let Some([dx, dy]) = self.drag.cursor_moved(at_px) {
            self.camera.look(dx, dy);
        }
    }

    /// The wheel turns over the picture.
    pub fn wheel(&mut self, delta: MouseScrollDelta) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => lines,
            MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
        };
        if self.camera.orbits() {
            self.camera.zoom(notches);
        } else {
            let speed = self.keys.wheel(notches);
            self.say_speed(speed);
        }
    }

    /// The window has another size.
    pub fn resized(&mut self, size_px: [u32; 2]) {
        self.size_px = size_px;
        self.scale.forget(size_px);
        self.presenter.resized();
        self.dirty = true;
    }

    /// The window is out of sight, or back.
    pub fn hidden(&mut self, hidden: bool) {
        self.hidden = hidden;
        self.dirty = true;
    }

    /// A file was dropped on the window.
    pub fn drop_file(&mut self, path: PathBuf) {
        if let Err(error) = self.act(Action::Open(path)) {
            self.panel.show_error(error.to_string());
        }
    }
}
