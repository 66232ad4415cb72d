//! How far the mouse has been dragged. Relative devices report steps, also beyond the edges of the screen. Absolute ones (tablets, the
//! pointers of virtual machines and remote desktops) report places as if they were steps, or nothing: there the cursor tells, as far
//! as the window reaches.

/// No relative device moves so far between two events, in pixels.
const LONGEST_STEP_PX: f32 = 500.0;
/// By how much a place may be off the cursor's, in pixels.
const PLACE_ERROR_PX: f32 = 1.0;
/// Shorter moves of the cursor do not tell steps from places, in pixels.
const LEAST_STEP_PX: f32 = 3.0;
/// Moves of the cursor after which a device is known.
const VOTES: u32 = 3;

/// What a device reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Device {
    /// Not known yet: so many moves of the cursor looked like steps, so many like places.
    Unknown {
        steps: u32,
        places: u32,
    },
    Relative,
    Absolute,
}

/// A drag, and what is known of the device.
#[derive(Debug)]
pub struct Drag {
    is_on: bool,
    device: Device,
    /// Where the cursor was, and what the device had reported last, when it last moved in this drag.
    cursor_px: Option<[f32; 2]>,
    reported_then_px: Option<[f32; 2]>,
    /// What the device has reported last since then.
    reported_px: Option<[f32; 2]>,
}

impl Default for Drag {
    fn default() -> Self {
        let device = Device::Unknown { steps: 0, places: 0 };
        Self { is_on: false, device, cursor_px: None, reported_then_px: None, reported_px: None }
    }
}

impl Drag {
    /// Whether a button is down.
    pub fn is_on(&self) -> bool {
        self.is_on
    }

    /// A button goes down or up.
    pub fn set(&mut self, is_on: bool) {
        *self = Self { is_on, device: self.device, ..Self::default() };
    }

    /// The cursor stays where it is from now on: what devices report are steps.
    pub fn lock(&mut self) {
        self.device = Device::Relative;
    }

    /// The device reports something; gives how far to turn.
    pub fn device_moved(&mut self, reported_px: [f32; 2]) -> Option<[f32; 2]> {
        if !self.is_on {
            return None;
        }
        if !reported_px.iter().all(|step| step.abs() <= LONGEST_STEP_PX) {
            self.device = Device::Absolute;
        }
        self.reported_px = Some(reported_px);
        (self.device == Device::Relative).then_some(reported_px)
    }

    /// The cursor is elsewhere; gives how far to turn where the device does not tell.
    pub fn cursor_moved(&mut self, at_px: [f32; 2]) -> Option<[f32; 2]> {
        if !self.is_on {
            return None;
        }
        let reported_px = self.reported_px.take();
        let before_px = self.cursor_px.replace(at_px);
        let step_px = before_px.map(|before_px| difference(at_px, before_px));
        let tells = |step_px: &[f32; 2]| step_px.iter().any(|step| step.abs() >= LEAST_STEP_PX);
        if let Some((reported_px, step_px)) = reported_px.zip(step_px.filter(tells)) {
            self.vote(reported_px, step_px);
        }
        self.reported_then_px = reported_px.or(self.reported_then_px);
        step_px.filter(|_| reported_px.is_none() || self.device != Device::Relative)
    }

    /// Places change as the cursor's does; steps do not.
    fn vote(&mut self, reported_px: [f32; 2], step_px: [f32; 2]) {
        let (Device::Unknown { steps, places }, Some(then_px)) = (&mut self.device, self.reported_then_px) else {
            return;
        };
        let off_px = difference(difference(reported_px, then_px), step_px);
        let is_place = off_px.iter().all(|off| off.abs() <= PLACE_ERROR_PX);
        *(if is_place { &mut *places } else { &mut *steps }) += 1;
        self.device = match (*steps, *places) {
            (_, VOTES) => Device::Absolute,
            (VOTES, _) => Device::Relative,
            _ => return,
        };
    }
}

fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun() -> Drag {
        let mut drag = Drag::default();
        drag.set(true);
        drag
    }

    /// How far a drag turns by events of the device and the cursor in turn.
    fn turned(drag: &mut Drag, events: impl IntoIterator<Item = ([f32; 2], [f32; 2])>) -> [f32; 2] {
        events.into_iter().fold([0.0; 2], |sum, (reported, at)| {
            let steps = [drag.device_moved(reported), drag.cursor_moved(at)];
            steps.into_iter().flatten().fold(sum, |sum, step| [sum[0] + step[0], sum[1] + step[1]])
        })
    }

    #[test]
    fn steps_of_a_relative_device_count_once_and_go_on_at_the_edge() {
        let mut drag = begun();
        // Accelerated: the cursor moves twice as far. The first move has no place before it.
        let first = turned(&mut drag, (0..5).map(|i| ([3.0, -1.0], [10.0 + 6.0 * i as f32, 50.0 - 2.0 * i as f32])));
        assert_eq!(drag.device, Device::Relative);
        assert!(first[0] > 12.0 && first[0] <= 24.0, "{first:?}");
        assert_eq!(turned(&mut drag, (0..4).map(|_| ([3.0, -1.0], [34.0, 42.0]))), [12.0, -4.0]);
    }

    #[test]
    fn a_slow_hand_does_not_make_a_device_absolute() {
        let mut drag = begun();
        turned(&mut drag, (0..20).map(|i| ([1.0, 0.0], [10.0 + i as f32, 50.0])));
        assert_eq!(drag.device, Device::Unknown { steps: 0, places: 0 });
    }

    #[test]
    fn places_of_an_absolute_device_are_not_steps() {
        let at = |i: i32| [100.0 + 4.0 * i as f32, 80.0 + i as f32];
        // In pixels of the screen, in whose middle the window is.
        let mut drag = begun();
        let total = turned(&mut drag, (0..11).map(|i| ([at(i)[0] + 150.0, at(i)[1] + 60.0], at(i))));
        assert_eq!((drag.device, total), (Device::Absolute, [40.0, 10.0]));
        // In units of its own.
        let mut drag = begun();
        let total = turned(&mut drag, (0..11).map(|i| ([31_000.0 + i as f32, 12_000.0], at(i))));
        assert_eq!((drag.device, total), (Device::Absolute, [40.0, 10.0]));
        // It stays what it is in the next drag, which begins elsewhere.
        drag.set(false);
        drag.set(true);
        assert_eq!(turned(&mut drag, (0..3).map(|i| ([5.0, 7.0], at(10 * i)))), [80.0, 20.0]);
    }

    #[test]
    fn the_cursor_tells_where_the_device_says_nothing() {
        let mut drag = begun();
        assert_eq!(drag.cursor_moved([50.0, 50.0]), None);
        assert_eq!(drag.cursor_moved([58.0, 49.0]), Some([8.0, -1.0]));
        assert_eq!(drag.device_moved([f32::NAN, 0.0]), None, "nor is this a step");
    }

    #[test]
    fn a_cursor_that_is_locked_leaves_it_to_the_device() {
        let mut drag = begun();
        drag.lock();
        assert_eq!(drag.device_moved([3.0, 1.0]), Some([3.0, 1.0]));
    }

    #[test]
    fn nothing_turns_without_a_button() {
        let mut drag = Drag::default();
        assert_eq!((drag.device_moved([3.0, 1.0]), drag.cursor_moved([3.0, 1.0])), (None, None));
    }
}
