//! `KHR_animation_pointer`: channels of animations whose target is named by a JSON pointer.

use std::collections::BTreeMap;

use serde_json::Value;

use super::motion::{LightProperty, Property, Target};

/// The pointers of a file, by the indices of animation and channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Pointers(BTreeMap<(usize, usize), String>);

impl Pointers {
    /// Those in the `animations` of a glTF, of whatever form that is. The types of the `gltf` crate do not have them.
    pub fn of(animations: Option<&Value>) -> Self {
        let list = |value: Option<&Value>| value.and_then(Value::as_array).cloned().unwrap_or_default();
        let mut pointers = BTreeMap::new();
        for (animation, value) in list(animations).iter().enumerate() {
            for (channel, value) in list(value.get("channels")).iter().enumerate() {
                if value.pointer("/target/path").and_then(Value::as_str) == Some("pointer") {
                    let pointer = value.pointer("/target/extensions/KHR_animation_pointer/pointer");
                    let pointer = pointer.and_then(Value::as_str).unwrap_or_default();
                    pointers.insert((animation, channel), pointer.to_owned());
                }
            }
        }
        Self(pointers)
    }

    /// The pointer of a channel; empty where the channel has none although it says so.
    pub fn get(&self, animation: usize, channel: usize) -> Option<&str> {
        self.0.get(&(animation, channel)).map(String::as_str)
    }

    /// What any channel changes.
    pub fn targets(&self) -> impl Iterator<Item = Target> {
        self.0.values().filter_map(|pointer| target(pointer))
    }
}

/// What a pointer names; `None` for what stands still.
pub(super) fn target(pointer: &str) -> Option<Target> {
    let parts: Vec<&str> = pointer.strip_prefix('/')?.split('/').collect();
    let index = |text: &str| text.parse::<usize>().ok().filter(|index| index.to_string() == text);
    let node = |text: &str, property| Some(Target::Node { node: index(text)?, property });
    let light = |text: &str, property| Some(Target::Light { light: index(text)?, property });
    match parts[..] {
        ["nodes", i, "translation"] => node(i, Property::Translation),
        ["nodes", i, "rotation"] => node(i, Property::Rotation),
        ["nodes", i, "scale"] => node(i, Property::Scale),
        ["nodes", i, "weights"] => node(i, Property::Weights),
        ["nodes", i, "extensions", "KHR_node_visibility", "visible"] => node(i, Property::Visibility),
        ["cameras", i, "perspective", "yfov"] => Some(Target::FieldOfView { camera: index(i)? }),
        ["extensions", "KHR_lights_punctual", "lights", i, "intensity"] => light(i, LightProperty::Intensity),
        ["extensions", "KHR_lights_punctual", "lights", i, "color"] => light(i, LightProperty::Color),
        ["extensions", "KHR_lights_punctual", "lights", i, "spot", "innerConeAngle"] => {
            light(i, LightProperty::InnerConeAngle)
        }
        ["extensions", "KHR_lights_punctual", "lights", i, "spot", "outerConeAngle"] => {
            light(i, LightProperty::OuterConeAngle)
        }
        _ => None,
    }
}

/// A pointer without its indices, so that each kind is told once.
pub(super) fn kind(pointer: &str) -> String {
    let is_index = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let parts: Vec<&str> = pointer.split('/').map(|part| if is_index(part) { "*" } else { part }).collect();
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn pointers_name_what_moves() {
        let light = "/extensions/KHR_lights_punctual/lights/12";
        for (pointer, expected) in [
            ("/nodes/3/rotation".to_owned(), Some(Target::Node { node: 3, property: Property::Rotation })),
            (
                "/nodes/0/extensions/KHR_node_visibility/visible".to_owned(),
                Some(Target::Node { node: 0, property: Property::Visibility }),
            ),
            (format!("{light}/color"), Some(Target::Light { light: 12, property: LightProperty::Color })),
            (
                format!("{light}/spot/outerConeAngle"),
                Some(Target::Light { light: 12, property: LightProperty::OuterConeAngle }),
            ),
            ("/cameras/1/perspective/yfov".to_owned(), Some(Target::FieldOfView { camera: 1 })),
            (format!("{light}/range"), None),
            ("/nodes/03/rotation".to_owned(), None),
            ("/nodes/-1/rotation".to_owned(), None),
            ("/nodes/3".to_owned(), None),
            ("nodes/3/rotation".to_owned(), None),
            ("/materials/0/pbrMetallicRoughness/baseColorFactor".to_owned(), None),
            (String::new(), None),
        ] {
            assert_eq!(target(&pointer), expected, "{pointer}");
        }
        assert_eq!(kind("/materials/10/emissiveFactor"), "/materials/*/emissiveFactor");
    }

    #[test]
    fn only_channels_with_the_path_have_pointers() {
        let target = |path: &str| json!({"target": {"path": path, "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/1/scale"}}}});
        let animations =
            json!([3, {"channels": [target("pointer"), target("scale"), {"target": {"path": "pointer"}}, 7]}]);
        let pointers = Pointers::of(Some(&animations));
        assert_eq!(
            [0, 1, 2, 3].map(|channel| pointers.get(1, channel)),
            [Some("/nodes/1/scale"), None, Some(""), None]
        );
        assert_eq!(pointers.targets().count(), 1);
        assert_eq!(Pointers::of(None), Pointers::default());
    }
}
