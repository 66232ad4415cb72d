//! Reads the interface of a module from its SPIR-V: when shaders are compiled, and in the test of the committed table.

use std::collections::{BTreeMap, BTreeSet};

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Dim, ExecutionMode, ExecutionModel, Op, StorageClass};

use super::interface::{Binding, BindingKind, ImageDimension, Interface};
use super::variants::Stage;

/// The interface of a module.
///
/// # Errors
/// With a sentence when the words are no SPIR-V, or use what this does not know, such as arrays of descriptors.
pub fn reflect(words: &[u32]) -> Result<Interface, String> {
    let module = rspirv::dr::load_words(words).map_err(|e| format!("this is no SPIR-V: {e}"))?;
    Reflection::new(&module).interface()
}

/// A module with what is looked up in it.
struct Reflection<'a> {
    module: &'a Module,
    names: BTreeMap<u32, &'a str>,
    member_names: BTreeMap<(u32, u32), &'a str>,
    /// Types, constants and variables by their identifiers.
    globals: BTreeMap<u32, &'a Instruction>,
    /// Decorations of whole things, with their operand where they have one.
    decorations: BTreeSet<(u32, Decoration, u32)>,
    /// Decorations of members.
    member_decorations: BTreeSet<(u32, u32, Decoration, u32)>,
    accesses: BTreeMap<u32, Access>,
}

/// What the instructions of a module do to a variable.
#[derive(Clone, Copy, Default)]
struct Access {
    reads: bool,
    writes: bool,
}

fn id(operand: Option<&Operand>) -> Result<u32, String> {
    match operand {
        Some(Operand::IdRef(id)) => Ok(*id),
        other => Err(format!("{other:?} is no identifier")),
    }
}

fn number(operand: Option<&Operand>) -> Option<u32> {
    if let Some(Operand::LiteralBit32(value)) = operand { Some(*value) } else { None }
}

fn text(operand: Option<&Operand>) -> &str {
    if let Some(Operand::LiteralString(text)) = operand { text } else { "" }
}

impl<'a> Reflection<'a> {
    fn new(module: &'a Module) -> Self {
        let globals = module.types_global_values.iter().filter_map(|i| Some((i.result_id?, i))).collect();
        let mut found = Self {
            module,
            names: BTreeMap::new(),
            member_names: BTreeMap::new(),
            globals,
            decorations: BTreeSet::new(),
            member_decorations: BTreeSet::new(),
            accesses: BTreeMap::new(),
        };
        found.read_names();
        found.read_decorations();
        found.read_accesses();
        found
    }

    fn read_names(&mut self) {
        for i in &self.module.debug_names {
            let Ok(target) = id(i.operands.first()) else { continue };
            match i.class.opcode {
                Op::Name => drop(self.names.insert(target, text(i.operands.get(1)))),
                Op::MemberName => {
                    let member = number(i.operands.get(1)).unwrap_or_default();
                    self.member_names.insert((target, member), text(i.operands.get(2)));
                }
                _ => {}
            }
        }
    }

    fn read_decorations(&mut self) {
        for i in &self.module.annotations {
            let Ok(target) = id(i.operands.first()) else { continue };
            match (i.operands.get(1), i.operands.get(2)) {
                (Some(Operand::Decoration(decoration)), operand) => {
                    self.decorations.insert((target, *decoration, number(operand).unwrap_or_default()));
                }
                (Some(Operand::LiteralBit32(member)), Some(Operand::Decoration(decoration))) => {
                    let operand = number(i.operands.get(3)).unwrap_or_default();
                    self.member_decorations.insert((target, *member, *decoration, operand));
                }
                _ => {}
            }
        }
    }

    /// Follows pointers and loaded images back to the variables that they are of.
    fn read_accesses(&mut self) {
        let mut origins: BTreeMap<u32, u32> = BTreeMap::new();
        let instructions = self.module.functions.iter().flat_map(|f| f.all_inst_iter());
        for i in instructions {
            let place = |index: usize| {
                let id = id(i.operands.get(index)).ok()?;
                let variable = self.globals.get(&id).is_some_and(|g| g.class.opcode == Op::Variable);
                if variable { Some(id) } else { origins.get(&id).copied() }
            };
            // Which operand is the pointer or image, whether it is read, and whether written.
            let (operand, reads, writes) = match i.class.opcode {
                Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject | Op::Image | Op::SampledImage => {
                    (0, false, false)
                }
                // Loading an image's handle touches no texel; those of `origin` below do.
                Op::Load => (0, place(0).is_some_and(|v| !self.is_image(v)), false),
                Op::Store | Op::ImageWrite => (0, false, true),
                Op::ArrayLength | Op::ImageQuerySize | Op::ImageQuerySizeLod => continue,
                Op::AtomicLoad => (0, true, false),
                Op::AtomicStore => (0, false, true),
                opcode if format!("{opcode:?}").starts_with("Atomic") => (0, true, true),
                opcode if format!("{opcode:?}").starts_with("Image") && opcode != Op::ImageTexelPointer => {
                    (0, true, false)
                }
                // A pointer given to a function or copied as a whole: anything may be done to it.
                Op::FunctionCall | Op::CopyMemory | Op::ImageTexelPointer => {
                    for operand in 0..i.operands.len() {
                        if let Some(variable) = place(operand) {
                            self.accesses.insert(variable, Access { reads: true, writes: true });
                        }
                    }
                    continue;
                }
                Op::RayQueryInitializeKHR => (1, true, false),
                _ => continue,
            };
            if let Some(variable) = place(operand) {
                let access = self.accesses.entry(variable).or_default();
                *access = Access { reads: access.reads || reads, writes: access.writes || writes };
                if let Some(result) = i.result_id.filter(|_| self.leads_to_its_operand(i.class.opcode, variable)) {
                    origins.insert(result, variable);
                }
            }
        }
    }

    /// Whether the result of an instruction stands for the variable: a pointer into it, or an image that it names.
    fn leads_to_its_operand(&self, opcode: Op, variable: u32) -> bool {
        match opcode {
            Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject | Op::Image | Op::SampledImage => true,
            Op::Load => self.is_image(variable),
            _ => false,
        }
    }

    fn interface(&self) -> Result<Interface, String> {
        let mut interface = Interface {
            stage: self.stage()?,
            workgroup_size: self.workgroup_size()?,
            shared_bytes: 0,
            push_bytes: 0,
            constants: self.constants(),
            bindings: Vec::new(),
        };
        for i in self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable) {
            let variable = i.result_id.unwrap_or_default();
            let pointed = self.pointed(variable)?;
            match i.operands.first() {
                Some(Operand::StorageClass(StorageClass::Workgroup)) => {
                    interface.shared_bytes += self.size_bytes(pointed)?;
                }
                Some(Operand::StorageClass(StorageClass::PushConstant)) => {
                    interface.push_bytes = self.size_bytes(pointed)?;
                }
                _ => interface.bindings.extend(self.binding(variable, pointed)?),
            }
        }
        interface.bindings.sort_by_key(|b| (b.set, b.binding));
        Ok(interface)
    }

    fn stage(&self) -> Result<Stage, String> {
        match self.module.entry_points.first().and_then(|i| i.operands.first()) {
            Some(Operand::ExecutionModel(ExecutionModel::Vertex)) => Ok(Stage::Vertex),
            Some(Operand::ExecutionModel(ExecutionModel::Fragment)) => Ok(Stage::Fragment),
            Some(Operand::ExecutionModel(ExecutionModel::GLCompute)) => Ok(Stage::Compute),
            other => Err(format!("{other:?} is no stage that is known")),
        }
    }

    fn workgroup_size(&self) -> Result<[u32; 3], String> {
        for i in &self.module.execution_modes {
            match i.operands.get(1) {
                Some(Operand::ExecutionMode(ExecutionMode::LocalSize)) => {
                    return Ok([2, 3, 4].map(|axis| number(i.operands.get(axis)).unwrap_or(1)));
                }
                Some(Operand::ExecutionMode(ExecutionMode::LocalSizeId)) => {
                    return Err("workgroups of a specialised size are not known".to_owned());
                }
                _ => {}
            }
        }
        Ok([1; 3])
    }

    fn constants(&self) -> BTreeMap<String, u32> {
        let name = |target: &u32| self.names.get(target).map_or(String::new(), |name| (*name).to_owned());
        let ids = self.decorations.iter().filter(|(_, decoration, _)| *decoration == Decoration::SpecId);
        ids.map(|(target, _, id)| (name(target), *id)).collect()
    }

    /// What is bound to a variable; `None` when it has no set.
    fn binding(&self, variable: u32, pointed: u32) -> Result<Option<Binding>, String> {
        let Some(set) = self.decoration(variable, Decoration::DescriptorSet) else { return Ok(None) };
        let binding = self.decoration(variable, Decoration::Binding).ok_or("a descriptor without a binding")?;
        let name = self.binding_name(variable, pointed);
        let kind = self.kind(variable, pointed).map_err(|e| format!("{name}: {e}"))?;
        let dimension = self.dimension(pointed).map_err(|e| format!("{name}: {e}"))?;
        let has = |decoration| self.has(variable, pointed, decoration);
        let (readonly, writeonly) = (has(Decoration::NonWritable), has(Decoration::NonReadable));
        let Access { reads, writes } = self.accesses.get(&variable).copied().unwrap_or_default();
        Ok(Some(Binding { name, set, binding, kind, dimension, readonly, writeonly, reads, writes }))
    }

    /// The variable's name, or that of the only member of a block without an instance name.
    fn binding_name(&self, variable: u32, pointed: u32) -> String {
        let members = self.globals.get(&pointed).map_or(0, |i| i.operands.len());
        let named = [
            self.names.get(&variable),
            self.member_names.get(&(pointed, 0)).filter(|_| members == 1),
            self.names.get(&pointed),
        ];
        named.into_iter().flatten().find(|name| !name.is_empty()).map_or(String::new(), |name| (*name).to_owned())
    }

    fn kind(&self, variable: u32, pointed: u32) -> Result<BindingKind, String> {
        let ty = self.global(pointed)?;
        match (ty.class.opcode, self.storage_class(variable)) {
            (Op::TypeStruct, Some(StorageClass::Uniform)) => Ok(BindingKind::UniformBuffer),
            (Op::TypeStruct, Some(StorageClass::StorageBuffer)) => Ok(BindingKind::StorageBuffer),
            (Op::TypeAccelerationStructureKHR, _) => Ok(BindingKind::AccelerationStructure),
            (Op::TypeSampledImage, _) => Ok(BindingKind::CombinedImageSampler),
            // Operands: type, dimension, depth, arrayed, multisampled, sampled (1) or storage (2).
            (Op::TypeImage, _) => Ok(if number(ty.operands.get(5)) == Some(2) {
                BindingKind::StorageImage
            } else {
                BindingKind::SampledImage
            }),
            (opcode, class) => Err(format!("{opcode:?} in {class:?} is no kind of binding that is known")),
        }
    }

    /// Of an image's type; `None` for other types.
    fn dimension(&self, ty: u32) -> Result<Option<ImageDimension>, String> {
        let ty = self.global(ty)?;
        match ty.class.opcode {
            Op::TypeSampledImage => self.dimension(id(ty.operands.first())?),
            Op::TypeImage => match (ty.operands.get(1), number(ty.operands.get(3))) {
                (Some(Operand::Dim(Dim::Dim2D)), Some(0)) => Ok(Some(ImageDimension::D2)),
                (Some(Operand::Dim(Dim::Dim2D)), Some(1)) => Ok(Some(ImageDimension::D2Array)),
                (Some(Operand::Dim(Dim::Dim3D)), Some(0)) => Ok(Some(ImageDimension::D3)),
                (dimension, _) => Err(format!("images of {dimension:?} are not known")),
            },
            _ => Ok(None),
        }
    }

    /// Whether a variable, or every member of its block, is decorated.
    fn has(&self, variable: u32, pointed: u32, decoration: Decoration) -> bool {
        let members = self.globals.get(&pointed).filter(|i| i.class.opcode == Op::TypeStruct).map(|i| i.operands.len());
        let member = |m: usize| self.member_decorations.contains(&(pointed, m as u32, decoration, 0));
        self.decoration(variable, decoration).is_some() || members.is_some_and(|count| (0..count).all(member))
    }

    fn decoration(&self, target: u32, decoration: Decoration) -> Option<u32> {
        let mut all = self.decorations.range((target, decoration, 0)..=(target, decoration, u32::MAX));
        all.next().map(|(_, _, value)| *value)
    }

    fn global(&self, id: u32) -> Result<&'a Instruction, String> {
        self.globals.get(&id).copied().ok_or_else(|| format!("%{id} is not declared"))
    }

    fn storage_class(&self, variable: u32) -> Option<StorageClass> {
        match self.globals.get(&variable)?.operands.first() {
            Some(Operand::StorageClass(class)) => Some(*class),
            _ => None,
        }
    }

    /// The type that a variable's pointer points at.
    fn pointed(&self, variable: u32) -> Result<u32, String> {
        let pointer = self.global(variable)?.result_type.ok_or("a variable without a type")?;
        id(self.global(pointer)?.operands.get(1))
    }

    fn is_image(&self, variable: u32) -> bool {
        let ty = self.pointed(variable).and_then(|pointed| self.global(pointed));
        ty.is_ok_and(|ty| {
            matches!(ty.class.opcode, Op::TypeImage | Op::TypeSampledImage | Op::TypeAccelerationStructureKHR)
        })
    }

    /// Size of a type: by its offsets and strides where it has them, packed otherwise.
    fn size_bytes(&self, ty: u32) -> Result<u32, String> {
        let i = self.global(ty)?;
        let part = || self.size_bytes(id(i.operands.first())?);
        match i.class.opcode {
            Op::TypeBool => Ok(4),
            Op::TypeInt | Op::TypeFloat => Ok(number(i.operands.first()).unwrap_or(32) / 8),
            Op::TypeVector | Op::TypeMatrix => Ok(number(i.operands.get(1)).unwrap_or(1) * part()?),
            Op::TypeArray => {
                let length = self.global(id(i.operands.get(1))?)?;
                let count = number(length.operands.first()).filter(|_| length.class.opcode == Op::Constant);
                let stride = self.decoration(ty, Decoration::ArrayStride);
                let count = count.ok_or("an array of a length that is no constant")?;
                Ok(count * stride.map_or_else(part, Ok)?)
            }
            Op::TypeStruct => {
                let mut end = 0;
                for (index, member) in i.operands.iter().enumerate() {
                    let key = (ty, index as u32, Decoration::Offset);
                    let mut offsets =
                        self.member_decorations.range((key.0, key.1, key.2, 0)..=(key.0, key.1, key.2, u32::MAX));
                    let offset = offsets.next().map_or(end, |(_, _, _, offset)| *offset);
                    end = end.max(offset + self.size_bytes(id(Some(member))?)?);
                }
                Ok(end)
            }
            opcode => Err(format!("{opcode:?} has no size")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::interface::{Table, embedded, to_text};
    use super::super::spirv;
    use super::*;

    /// The smallest limit of a Vulkan device on the shared memory of a workgroup.
    const PORTABLE_SHARED_BYTES: u32 = 16_384;
    /// The smallest limit on push constants.
    const PORTABLE_PUSH_BYTES: u32 = 128;

    fn reflected() -> Table {
        let of = |name: &str| reflect(&spirv::words(name).unwrap()).unwrap_or_else(|e| panic!("{name}: {e}"));
        spirv::names().map(|name| (name.to_owned(), of(name))).collect()
    }

    /// `GRIDLIGHT_WRITE_INTERFACES=1` writes the table instead; `tools/compile-shaders` does so too.
    #[test]
    fn the_committed_table_is_that_of_the_spirv() {
        let table = reflected();
        if std::env::var_os("GRIDLIGHT_WRITE_INTERFACES").is_some() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/spirv/interfaces.json");
            std::fs::write(path, to_text(&table)).unwrap();
            return;
        }
        assert_eq!(embedded().len(), table.len());
        for (name, interface) in &table {
            assert_eq!(embedded().get(name), Some(interface), "{name}: run tools/compile-shaders");
        }
    }

    #[test]
    fn every_module_keeps_within_the_portable_limits() {
        for (name, interface) in reflected() {
            let threads: u32 = interface.workgroup_size.iter().product();
            assert!(threads <= 256, "{name}: {threads} invocations");
            let (shared, push) = (interface.shared_bytes, interface.push_bytes);
            assert!(shared <= PORTABLE_SHARED_BYTES, "{name}: {shared} bytes of shared memory");
            assert!(push <= PORTABLE_PUSH_BYTES, "{name}: {push} bytes of push constants");
        }
    }

    #[test]
    fn everything_has_a_name_of_its_own() {
        for (name, interface) in reflected() {
            let names: BTreeSet<&str> = interface.bindings.iter().map(|b| b.name.as_str()).collect();
            assert!(names.len() == interface.bindings.len() && !names.contains(""), "{name}: {names:?}");
            assert!(!interface.constants.contains_key(""), "{name}");
        }
    }

    #[test]
    fn words_that_are_no_module_are_an_error() {
        assert!(reflect(&[1, 2, 3]).unwrap_err().contains("no SPIR-V"));
    }
}
