//! Parts that a scene can do without. Where the JSON of a file does not have the types that it should, these are looked
//! at one by one, and what is wrong in one is taken out of it: a camera that lacks its field of view costs that camera.

use ::gltf::json;
use ::gltf::json::extensions::scene::khr_lights_punctual::Light;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_path_to_error::Segment;

use super::gltf_lenient::Lenient;
use super::gltf_notes::Thing;

/// Something that was taken out of the file.
pub(super) struct WrongPart {
    pub thing: Thing,
    /// What there is to say of the thing; where it is lost, why.
    pub fault: String,
    /// Nothing that could be used is left of the thing.
    pub is_lost: bool,
}

/// Why a value cannot be read, and the way to the place within it.
type Wrong = (Vec<Segment>, String);

/// A kind of things of which a file has a list.
struct Kind {
    /// The list, as a JSON pointer.
    list: &'static str,
    thing: &'static str,
    read: fn(&Value) -> Result<(), Wrong>,
    /// What a thing can do without.
    spare: Spare,
}

/// What a thing can do without.
#[derive(Clone, Copy)]
enum Spare {
    /// Any part; this stands for one that cannot be read at all.
    All { stand: &'static str },
    /// As before, but the thing is of no use without these parts.
    AllBut { parts: &'static [&'static str], stand: &'static str },
    /// These parts.
    Only(&'static [&'static str]),
}

const PLAIN: Spare = Spare::All { stand: "{}" };
/// The type is that of no lens and no light.
const NO_TYPE: &str = r#"{"type": ""}"#;

const KINDS: [Kind; 14] = [
    Kind::of::<json::Camera>(
        ("/cameras", "camera"),
        Spare::AllBut { parts: &["perspective", "orthographic"], stand: NO_TYPE },
    ),
    Kind::of::<Light>(("/extensions/KHR_lights_punctual/lights", "light"), Spare::All { stand: NO_TYPE }),
    Kind::of::<json::texture::Sampler>(("/samplers", "sampler"), PLAIN),
    Kind::of::<json::Texture>(("/textures", "texture"), PLAIN),
    Kind::of::<json::Image>(("/images", "image"), PLAIN),
    Kind::of::<json::Material>(("/materials", "material"), PLAIN),
    Kind::of::<json::Animation>(
        ("/animations", "animation"),
        Spare::AllBut { parts: &["channels", "samplers"], stand: r#"{"channels": [], "samplers": []}"# },
    ),
    Kind::of::<json::Node>(("/nodes", "node"), Spare::Only(&["camera", "extensions", "name"])),
    Kind::of::<json::Scene>(("/scenes", "scene"), Spare::Only(&["extensions", "name"])),
    Kind::of::<json::Skin>(("/skins", "skin"), Spare::Only(&["name", "skeleton"])),
    Kind::of::<json::Mesh>(("/meshes", "mesh"), Spare::Only(&["name"])),
    Kind::of::<json::Accessor>(("/accessors", "accessor"), Spare::Only(&["name"])),
    Kind::of::<json::Buffer>(("/buffers", "buffer"), Spare::Only(&["name"])),
    Kind::of::<json::buffer::View>(("/bufferViews", "buffer view"), Spare::Only(&["name", "target"])),
];

/// Keys of the file with what can be spared of each.
const WHOLES: [Kind; 2] = [
    Kind::of::<json::Asset>(("/asset", "asset"), Spare::Only(&["copyright", "generator", "extensions"])),
    Kind::of::<Vec<String>>(("/extensionsUsed", "extensionsUsed"), Spare::All { stand: "[]" }),
];

impl Kind {
    const fn of<T: DeserializeOwned>((list, thing): (&'static str, &'static str), spare: Spare) -> Self {
        Self { list, thing, read: read::<T>, spare }
    }
}

impl Spare {
    /// Whether a thing is read without the part at the beginning of this path.
    fn allows(self, path: &[Segment]) -> bool {
        match self {
            Self::All { .. } | Self::AllBut { .. } => true,
            Self::Only(parts) => matches!(path.first(), Some(Segment::Map { key }) if parts.contains(&key.as_str())),
        }
    }

    fn is_of_use_without(self, part: &str) -> bool {
        !matches!(self, Self::AllBut { parts, .. } if parts.contains(&part))
    }

    fn stand(self) -> Option<Value> {
        match self {
            Self::All { stand } | Self::AllBut { stand, .. } => serde_json::from_str(stand).ok(),
            Self::Only(_) => None,
        }
    }
}

/// Takes out what is wrong in such parts, so that the rest can be read; tells what it was.
pub(super) fn take_out_wrong(file: &mut Value) -> Vec<WrongPart> {
    let mut wrong = Vec::new();
    for whole in &WHOLES {
        if let Some(value) = file.pointer_mut(whole.list) {
            wrong.extend(mended(whole, value).into_iter().map(|Lost { path, why, .. }| {
                let path = if path.is_empty() { whole.thing.to_owned() } else { format!("{}.{path}", whole.thing) };
                WrongPart { thing: Thing::file(), fault: read_without(&path, &why), is_lost: false }
            }));
        }
    }
    for kind in &KINDS {
        let can_be_spared = kind.spare.stand().is_some();
        match file.pointer_mut(kind.list) {
            Some(Value::Array(things)) => {
                for (index, value) in things.iter_mut().enumerate() {
                    let name = value.get("name").and_then(Value::as_str).map(str::to_owned);
                    let thing = Thing::new(kind.thing, index, name.as_ref());
                    wrong.extend(mended(kind, value).into_iter().map(|lost| lost.told(thing.clone())));
                }
            }
            Some(value) if can_be_spared => {
                *value = Value::Array(Vec::new());
                let fault = read_without(&kind.list[1..].replace('/', "."), "it is no list");
                wrong.push(WrongPart { thing: Thing::file(), fault, is_lost: false });
            }
            _ => {}
        }
    }
    wrong
}

/// What was taken out of a thing.
struct Lost {
    /// Where it was; empty for all of it.
    path: String,
    why: String,
    /// The thing is of no use without it.
    is_vital: bool,
}

impl Lost {
    fn told(self, thing: Thing) -> WrongPart {
        let Self { path, why, is_vital } = self;
        let fault = match (is_vital, path.as_str()) {
            (true, "") => why,
            (true, path) => format!("{path}: {why}"),
            (false, path) => read_without(path, &why),
        };
        WrongPart { thing, fault, is_lost: is_vital }
    }
}

fn read_without(path: &str, why: &str) -> String {
    format!("is read without its {path}: {why}")
}

/// Takes out of a thing what is wrong, until it can be read or nothing more can be spared.
fn mended(kind: &Kind, value: &mut Value) -> Vec<Lost> {
    let mut all: Vec<Lost> = Vec::new();
    while let Err((path, why)) = (kind.read)(value) {
        let cut_out = if kind.spare.allows(&path) { cut(value, &path) } else { None };
        let (path, is_vital) = match (cut_out, kind.spare.stand()) {
            (Some(path), _) => {
                let is_vital = !kind.spare.is_of_use_without(&path);
                (path, is_vital)
            }
            (None, Some(stand)) if *value != stand => {
                *value = stand;
                (String::new(), true)
            }
            _ => break,
        };
        // What is missing now may be what was taken out before.
        let cause = all.iter().position(|lost| lost.path.starts_with(path.as_str())).map(|place| all.remove(place));
        let why = cause.map_or(why, |cause| format!("{}: {}", cause.path, cause.why));
        all.push(Lost { path, why, is_vital });
    }
    all
}

/// Removes the value at the last key of a path, and tells the way to it; `None` where there is none.
fn cut(value: &mut Value, path: &[Segment]) -> Option<String> {
    let last = path.iter().rposition(|segment| matches!(segment, Segment::Map { .. }))?;
    let Segment::Map { key } = &path[last] else { return None };
    let mut parent = value;
    for segment in &path[..last] {
        parent = match segment {
            Segment::Map { key } => parent.get_mut(key)?,
            Segment::Seq { index } => parent.get_mut(index)?,
            _ => return None,
        };
    }
    parent.as_object_mut()?.remove(key)?;
    let steps = path[..=last].iter().map(ToString::to_string);
    Some(steps.collect::<Vec<_>>().join("."))
}

fn read<T: DeserializeOwned>(value: &Value) -> Result<(), Wrong> {
    let mut track = serde_path_to_error::Track::new();
    let tracked = serde_path_to_error::Deserializer::new(Lenient::new(value), &mut track);
    T::deserialize(tracked).map(drop).map_err(|e| (track.path().iter().cloned().collect(), e.to_string()))
}
