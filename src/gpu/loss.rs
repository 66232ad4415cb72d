//! What is said of a lost device: where it was, from the marks that it left on its way through a frame, and what the driver
//! knows of the fault. No Vulkan calls.

use std::ops::Range;

use ash::vk;

use super::features::OptionalFeatures;

/// How a device leaves marks on its way through a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkerScheme {
    /// A word filled before each batch of barriers: on any driver.
    Fills,
    /// Two words for each pass, written as it begins and when it is done, without a barrier (`VK_AMD_buffer_marker`).
    BufferMarkers,
    /// A checkpoint before each pass, which the driver keeps (`VK_NV_device_diagnostic_checkpoints`).
    Checkpoints,
}

impl MarkerScheme {
    /// The one that tells most. Where the device is only taken for lost, the driver must not be asked for checkpoints.
    #[must_use]
    pub fn of(features: OptionalFeatures, is_planted: bool) -> Self {
        if features.buffer_marker {
            Self::BufferMarkers
        } else if features.checkpoints && !is_planted {
            Self::Checkpoints
        } else {
            Self::Fills
        }
    }
}

/// The passes of the last group that has begun. Words are written in order, each when all before it is done.
pub(super) fn suspects_of_fills(
    words: impl Iterator<Item = u32>,
    stamp: u32,
    groups: &[usize],
    pass_count: usize,
) -> Option<Range<usize>> {
    let begun = words.take_while(|word| *word == stamp).count();
    let first = *groups[..begun].last()?;
    Some(first..groups.get(begun).copied().unwrap_or(pass_count))
}

/// The passes that have begun and are not done. Words of either kind are written in order; passes overlap.
pub(super) fn suspects_of_buffer_markers(begun: &[u32], done: &[u32], stamp: u32) -> Option<Range<usize>> {
    let count = |words: &[u32]| words.iter().take_while(|word| **word == stamp).count();
    let (begun, done) = (count(begun), count(done));
    (begun > 0).then_some(done.min(begun)..begun)
}

/// The passes between the last checkpoint that the bottom of the pipeline has reached and the last one of any stage. Each is
/// a stage with the pass that its checkpoint stands before; `None` is a checkpoint of another frame.
pub(super) fn suspects_of_checkpoints(reached: &[(vk::PipelineStageFlags, Option<usize>)]) -> Option<Range<usize>> {
    let last = reached.iter().filter_map(|(_, pass)| *pass).max()?;
    let bottom = reached.iter().find(|(stage, _)| *stage == vk::PipelineStageFlags::BOTTOM_OF_PIPE);
    // All before the checkpoint at the bottom is done. While it is one of another frame, nothing of this one is.
    let first = bottom.and_then(|(_, pass)| *pass).unwrap_or(0);
    Some(first..last + 1)
}

/// Where the device was lost, as it reads after "the device was lost". Once the last passes have begun, nothing tells
/// whether they are over.
pub(super) fn place(names: &[&str], suspects: Range<usize>) -> String {
    let quoted: Vec<String> = names[suspects.clone()].iter().map(|name| format!("`{name}`")).collect();
    let place = match quoted.as_slice() {
        [] if suspects.start == 0 => return "before the first pass of a frame".to_owned(),
        [] if suspects.end == names.len() => return "after the last pass of a frame".to_owned(),
        [] => return format!("between the passes `{}` and `{}`", names[suspects.start - 1], names[suspects.end]),
        [one] => format!("in pass {one}"),
        several => format!("in one of the passes {}", several.join(", ")),
    };
    if suspects.end == names.len() { format!("{place} or after the frame") } else { place }
}

/// What a driver knows of a fault (`VK_EXT_device_fault`).
#[derive(Default)]
pub(super) struct DeviceFault {
    /// In the driver's words.
    pub description: String,
    pub addresses: Vec<vk::DeviceFaultAddressInfoEXT>,
    /// The vendor's words, code and datum.
    pub vendor: Vec<(String, u64, u64)>,
}

impl DeviceFault {
    /// What it says, as it reads after the place of the loss and a semicolon; `None` when it says nothing.
    pub fn sentence(&self) -> Option<String> {
        let description = (!self.description.is_empty()).then(|| format!("\"{}\"", self.description));
        let addresses = self.addresses.iter().filter_map(address);
        let vendor = self.vendor.iter().map(|(words, code, datum)| format!("\"{words}\" (code {code:#x}, {datum:#x})"));
        let parts: Vec<String> = description.into_iter().chain(addresses).chain(vendor).collect();
        (!parts.is_empty()).then(|| format!("the driver reports {}", parts.join(", ")))
    }
}

/// An address of a fault: what happened there, and between which addresses, as drivers know them by pages only.
fn address(info: &vk::DeviceFaultAddressInfoEXT) -> Option<String> {
    use vk::DeviceFaultAddressTypeEXT as Kind;
    let what = match info.address_type {
        Kind::NONE => return None,
        Kind::READ_INVALID => "an invalid read",
        Kind::WRITE_INVALID => "an invalid write",
        Kind::EXECUTE_INVALID => "an attempt to run what is no code",
        Kind::INSTRUCTION_POINTER_INVALID => "an invalid instruction pointer",
        Kind::INSTRUCTION_POINTER_FAULT => "an instruction that failed",
        _ => "an instruction pointer of unknown meaning",
    };
    let within = info.address_precision.max(1) - 1;
    let (first, last) = (info.reported_address & !within, info.reported_address | within);
    Some(if first == last { format!("{what} at {first:#x}") } else { format!("{what} from {first:#x} to {last:#x}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 6] = ["a", "b", "c", "d", "e", "f"];

    fn features(buffer_marker: bool, checkpoints: bool) -> OptionalFeatures {
        OptionalFeatures { buffer_marker, checkpoints, ..OptionalFeatures::default() }
    }

    #[test]
    fn the_scheme_that_tells_most_is_chosen() {
        assert_eq!(MarkerScheme::of(features(false, false), false), MarkerScheme::Fills);
        assert_eq!(MarkerScheme::of(features(true, false), false), MarkerScheme::BufferMarkers);
        assert_eq!(MarkerScheme::of(features(false, true), false), MarkerScheme::Checkpoints);
        assert_eq!(MarkerScheme::of(features(true, true), false), MarkerScheme::BufferMarkers);
        assert_eq!(MarkerScheme::of(features(false, true), true), MarkerScheme::Fills, "no device is lost");
        assert_eq!(MarkerScheme::of(features(true, true), true), MarkerScheme::BufferMarkers);
    }

    /// Groups of the passes 1, 2 to 4, and 5; nothing waits before pass 0.
    fn filled(words: [u32; 3]) -> Option<String> {
        Some(place(&NAMES, suspects_of_fills(words.into_iter(), 7, &[1, 2, 5], NAMES.len())?))
    }

    #[test]
    fn the_last_group_that_began_is_named() {
        assert_eq!(filled([7, 0, 0]).unwrap(), "in pass `b`");
        assert_eq!(filled([7, 7, 0]).unwrap(), "in one of the passes `c`, `d`, `e`");
        assert_eq!(filled([7, 7, 7]).unwrap(), "in pass `f` or after the frame");
    }

    #[test]
    fn words_of_other_frames_say_nothing() {
        assert_eq!(filled([5, 5, 5]), None);
        assert_eq!(filled([7, 5, 5]).unwrap(), "in pass `b`");
        assert_eq!(filled([5, 7, 7]), None, "words are written in order");
        assert_eq!(marked(0, 0), None);
    }

    /// So many passes have begun and are done in frame 7; the other words are those of frame 5.
    fn marked(begun: usize, done: usize) -> Option<String> {
        let words = |count: usize| (0..NAMES.len()).map(|pass| if pass < count { 7 } else { 5 }).collect::<Vec<u32>>();
        Some(place(&NAMES, suspects_of_buffer_markers(&words(begun), &words(done), 7)?))
    }

    #[test]
    fn passes_between_both_words_are_named() {
        assert_eq!(marked(1, 0).unwrap(), "in pass `a`");
        assert_eq!(marked(4, 1).unwrap(), "in one of the passes `b`, `c`, `d`");
        assert_eq!(marked(4, 4).unwrap(), "between the passes `d` and `e`");
        assert_eq!(marked(6, 5).unwrap(), "in pass `f` or after the frame");
        assert_eq!(marked(6, 6).unwrap(), "after the last pass of a frame");
        assert_eq!(marked(2, 3).unwrap(), "between the passes `b` and `c`", "done before begun cannot be");
    }

    fn reached(top: Option<usize>, bottom: Option<usize>) -> Option<String> {
        use vk::PipelineStageFlags as Stage;
        let reached = [(Stage::TOP_OF_PIPE, top), (Stage::BOTTOM_OF_PIPE, bottom)];
        Some(place(&NAMES, suspects_of_checkpoints(&reached)?))
    }

    #[test]
    fn passes_between_both_checkpoints_are_named() {
        assert_eq!(reached(Some(3), Some(1)).unwrap(), "in one of the passes `b`, `c`, `d`");
        assert_eq!(reached(Some(3), Some(3)).unwrap(), "in pass `d`");
        assert_eq!(
            reached(Some(1), None).unwrap(),
            "in one of the passes `a`, `b`",
            "the bottom is in the frame before"
        );
        assert_eq!(reached(Some(5), Some(5)).unwrap(), "in pass `f` or after the frame");
        assert_eq!(reached(None, None), None);
        assert_eq!(suspects_of_checkpoints(&[]), None);
        let top_only = [(vk::PipelineStageFlags::TOP_OF_PIPE, Some(2))];
        assert_eq!(suspects_of_checkpoints(&top_only), Some(0..3), "nothing tells what is done");
    }

    #[test]
    fn passes_before_the_first_word_can_be_named_too() {
        assert_eq!(place(&NAMES, 0..1), "in pass `a`");
        assert_eq!(place(&NAMES, 0..0), "before the first pass of a frame");
    }

    #[test]
    fn faults_become_sentences() {
        use vk::DeviceFaultAddressTypeEXT as Kind;
        let address = |kind, at, precision| {
            let info = vk::DeviceFaultAddressInfoEXT::default();
            info.address_type(kind).reported_address(at).address_precision(precision)
        };
        assert_eq!(DeviceFault::default().sentence(), None);
        let page = DeviceFault {
            description: "page fault".to_owned(),
            addresses: vec![address(Kind::WRITE_INVALID, 0x12_3456, 0x1000), address(Kind::NONE, 1, 1)],
            vendor: vec![("SM 3".to_owned(), 0x1f, 7)],
        };
        assert_eq!(
            page.sentence().unwrap(),
            "the driver reports \"page fault\", an invalid write from 0x123000 to 0x123fff, \"SM 3\" (code 0x1f, 0x7)"
        );
        let exact = DeviceFault { addresses: vec![address(Kind::READ_INVALID, 16, 1)], ..DeviceFault::default() };
        assert_eq!(exact.sentence().unwrap(), "the driver reports an invalid read at 0x10");
        let odd = DeviceFault { addresses: vec![address(Kind::from_raw(99), 16, 0)], ..DeviceFault::default() };
        assert_eq!(odd.sentence().unwrap(), "the driver reports an instruction pointer of unknown meaning at 0x10");
    }
}
