//! Every shared struct, member by member: the offsets in the committed SPIR-V against those in Rust.

use std::collections::{BTreeMap, BTreeSet};

use gridlight::shader::spirv;
use gridlight::shared::{FieldInfo, FieldKind, MOTION_STRUCTS, STRUCTS, StructInfo};
use rspirv::dr::{Module, Operand};
use rspirv::spirv::{Decoration, Op};

/// A struct of a shader.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Layout {
    /// Offset and name of each member.
    members: Vec<(u32, String)>,
    /// Stride of the arrays of it, where there are any.
    stride: Option<u32>,
}

/// A struct as Rust has it, which a test can change.
struct Shared {
    name: &'static str,
    size: usize,
    members: Vec<(usize, &'static str)>,
}

fn shared_structs() -> Vec<Shared> {
    let members = |info: &StructInfo| info.fields.iter().map(|field| (field.offset_bytes, field.name)).collect();
    let all = STRUCTS.iter().chain(MOTION_STRUCTS);
    all.map(|info| Shared { name: info.name, size: info.size_bytes, members: members(info) }).collect()
}

fn id(operand: &Operand) -> u32 {
    if let Operand::IdRef(id) = operand { *id } else { panic!("{operand:?} is not an id") }
}

fn literal(operand: Option<&Operand>) -> u32 {
    if let Some(Operand::LiteralBit32(value)) = operand { *value } else { panic!("{operand:?} is not a number") }
}

fn text(operand: &Operand) -> String {
    if let Operand::LiteralString(text) = operand { text.clone() } else { panic!("{operand:?} is not a string") }
}

/// The structs of a module that have explicit offsets, by name.
fn layouts(module: &Module) -> Vec<(String, Layout)> {
    let mut names = BTreeMap::new();
    let mut member_names = BTreeMap::new();
    for i in &module.debug_names {
        match i.class.opcode {
            Op::Name => drop(names.insert(id(&i.operands[0]), text(&i.operands[1]))),
            Op::MemberName => {
                let member = (id(&i.operands[0]), literal(i.operands.get(1)));
                member_names.insert(member, text(&i.operands[2]));
            }
            _ => {}
        }
    }
    let mut structs: BTreeMap<u32, Layout> = BTreeMap::new();
    let mut strides = BTreeMap::new();
    for i in &module.annotations {
        if i.operands.get(2) == Some(&Operand::Decoration(Decoration::Offset)) {
            let (target, member) = (id(&i.operands[0]), literal(i.operands.get(1)));
            let name = member_names.get(&(target, member)).cloned().unwrap_or_default();
            structs.entry(target).or_default().members.push((literal(i.operands.get(3)), name));
        }
        if i.operands.get(1) == Some(&Operand::Decoration(Decoration::ArrayStride)) {
            strides.insert(id(&i.operands[0]), literal(i.operands.get(2)));
        }
    }
    for i in
        module.types_global_values.iter().filter(|i| matches!(i.class.opcode, Op::TypeArray | Op::TypeRuntimeArray))
    {
        if let (Some(layout), Some(array)) = (structs.get_mut(&id(&i.operands[0])), i.result_id) {
            layout.stride = strides.get(&array).copied();
        }
    }
    structs.into_iter().map(|(id, layout)| (names.get(&id).cloned().unwrap_or_default(), layout)).collect()
}

/// Every struct of every committed shader.
fn all_layouts() -> BTreeMap<String, BTreeSet<Layout>> {
    let mut all: BTreeMap<String, BTreeSet<Layout>> = BTreeMap::new();
    for name in spirv::names() {
        let module = rspirv::dr::load_words(spirv::words(name).unwrap()).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (name, layout) in layouts(&module) {
            all.entry(name).or_default().insert(layout);
        }
    }
    all
}

/// What differs between a struct in the shaders and in Rust.
fn compare(found: &BTreeMap<String, BTreeSet<Layout>>, shared: &Shared) -> Result<(), String> {
    let name = shared.name;
    let layouts = found.get(name).ok_or_else(|| format!("{name} is in no shader"))?;
    let wanted: Vec<(u32, String)> = shared.members.iter().map(|(o, m)| (*o as u32, (*m).to_owned())).collect();
    for layout in layouts {
        if layout.members != wanted {
            return Err(format!("{name}: {:?} in a shader, {wanted:?} in Rust", layout.members));
        }
        if layout.stride.is_some_and(|stride| stride as usize != shared.size) {
            return Err(format!("{name}: stride {:?} in a shader, {} in Rust", layout.stride, shared.size));
        }
    }
    Ok(())
}

#[test]
fn offsets_in_the_shaders_are_those_in_rust() {
    let found = all_layouts();
    let failures: Vec<String> = shared_structs().iter().filter_map(|s| compare(&found, s).err()).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn arrays_of_structs_have_strides() {
    let found = all_layouts();
    for name in ["GridLight", "Material", "PunctualLight"] {
        assert!(found[name].iter().any(|layout| layout.stride.is_some()), "{name} is in no array");
    }
}

#[test]
fn planted_faults_are_noticed() {
    let found = all_layouts();
    for index in 0..shared_structs().len() {
        let fault = |plant: &dyn Fn(&mut Shared)| {
            let mut shared = shared_structs().remove(index);
            plant(&mut shared);
            compare(&found, &shared).is_err()
        };
        assert!(fault(&|s| s.members[1].0 += 4), "an offset");
        assert!(fault(&|s| s.members.swap(0, 1)), "swapped members");
        assert!(fault(&|s| s.members.truncate(1)), "a missing member");
        assert!(fault(&|s| s.name = "Nowhere"), "a struct in no shader");
    }
    let mut grid_light = shared_structs().into_iter().find(|s| s.name == "GridLight").unwrap();
    grid_light.size += 16;
    assert!(compare(&found, &grid_light).is_err(), "the stride");
}

/// The fields of a struct as `docs/dumps.md` writes them: `position_ws f4 x 3, luminance f4`.
fn on_the_page(info: &StructInfo) -> String {
    let text = |field: &FieldInfo| {
        let kind = if field.kind == FieldKind::Float { "f4" } else { "u4" };
        let axes: String = field.shape.iter().map(|axis| format!(" x {axis}")).collect();
        format!("{} {kind}{axes}", field.name)
    };
    info.fields.iter().map(text).collect::<Vec<_>>().join(", ")
}

#[test]
fn the_page_about_dumps_has_the_fields() {
    let page = include_str!("../docs/dumps.md");
    let resources = [
        ("frame_data", "FrameData"),
        ("grid_placement", "GridPlacement"),
        ("merged_lights", "GridLight"),
        ("materials", "Material"),
        ("punctual_lights", "PunctualLight"),
    ];
    for (resource, name) in resources {
        let info = STRUCTS.iter().find(|info| info.name == name).unwrap();
        let mut fields = on_the_page(info);
        if resource == "grid_placement" {
            fields = fields.trim_end_matches(", padding u4").to_owned();
        }
        assert!(
            page.contains(&format!("| `{resource}` | {fields} |")),
            "docs/dumps.md lacks | `{resource}` | {fields} |"
        );
    }
}
