//! Reflection of compute shaders: what a SPIR-V module itself says about its bindings, constants and workgroup.
//!
//! Opcodes, decorations and enums: SPIR-V 1.5 specification, section 3.

use std::collections::HashMap;

use super::image::Format;

/// What a compute shader uses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Reflection {
    /// Bindings, ascending by set and number.
    pub(crate) bindings: Vec<Reflected>,
    /// End of the last member of the push constants in bytes, 0 without any.
    pub(crate) constants: u32,
    /// Size of a workgroup.
    pub(crate) local_size: [u32; 3],
    /// Name of the entry point.
    pub(crate) entry: String,
}

/// One binding of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Reflected {
    pub(crate) set: u32,
    pub(crate) binding: u32,
    pub(crate) kind: Kind,
    /// The shader cannot write it.
    pub(crate) readonly: bool,
    /// The shader cannot read it.
    pub(crate) writeonly: bool,
}

/// Kind of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Storage,
    Uniform,
    /// Combined image and sampler.
    Sampled {
        volume: bool,
    },
    /// Storage image; the format is `None` where the shader has another one or none.
    Image {
        volume: bool,
        format: Option<Format>,
    },
    /// Buffer of `vec4` texels.
    Texels,
    /// Buffer of unsigned words as texels.
    Words,
    /// Something dermis has no name for.
    Other,
}

/// Execution model of a graphics shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    Vertex = 0,
    Fragment = 4,
}

const MAGIC: u32 = 0x0723_0203;
const HEADER: usize = 5;

mod op {
    pub(super) const ENTRY_POINT: u32 = 15;
    pub(super) const EXECUTION_MODE: u32 = 16;
    pub(super) const TYPE_INT: u32 = 21;
    pub(super) const TYPE_FLOAT: u32 = 22;
    pub(super) const TYPE_VECTOR: u32 = 23;
    pub(super) const TYPE_MATRIX: u32 = 24;
    pub(super) const TYPE_IMAGE: u32 = 25;
    pub(super) const TYPE_SAMPLED_IMAGE: u32 = 27;
    pub(super) const TYPE_ARRAY: u32 = 28;
    pub(super) const TYPE_STRUCT: u32 = 30;
    pub(super) const TYPE_POINTER: u32 = 32;
    pub(super) const CONSTANT: u32 = 43;
    pub(super) const VARIABLE: u32 = 59;
    pub(super) const DECORATE: u32 = 71;
    pub(super) const MEMBER_DECORATE: u32 = 72;
}

mod decoration {
    pub(super) const BUFFER_BLOCK: u32 = 3;
    pub(super) const ARRAY_STRIDE: u32 = 6;
    pub(super) const MATRIX_STRIDE: u32 = 7;
    pub(super) const NON_WRITABLE: u32 = 24;
    pub(super) const NON_READABLE: u32 = 25;
    pub(super) const BINDING: u32 = 33;
    pub(super) const DESCRIPTOR_SET: u32 = 34;
    pub(super) const OFFSET: u32 = 35;
}

mod storage {
    pub(super) const UNIFORM_CONSTANT: u32 = 0;
    pub(super) const UNIFORM: u32 = 2;
    pub(super) const PUSH_CONSTANT: u32 = 9;
    pub(super) const STORAGE_BUFFER: u32 = 12;
}

const COMPUTE: u32 = 5;
const LOCAL_SIZE: u32 = 17;
const DIM_3D: u32 = 2;
const DIM_BUFFER: u32 = 5;

/// Types, constants and decorations by result id.
#[derive(Default)]
struct Module<'a> {
    /// Opcode and operands after the result id.
    types: HashMap<u32, (u32, &'a [u32])>,
    constants: HashMap<u32, u32>,
    /// Pointer type, id and storage class.
    variables: Vec<(u32, u32, u32)>,
    decorations: HashMap<(u32, u32), u32>,
    members: HashMap<(u32, u32, u32), u32>,
}

/// The words of a module.
pub(crate) fn words(bytes: &[u8]) -> Result<Vec<u32>, String> {
    if !bytes.len().is_multiple_of(4) {
        return Err(format!(
            "SPIR-V of {} bytes is not made of words",
            bytes.len()
        ));
    }
    let words = bytes
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    Ok(words.collect())
}

/// Reads a module with one compute entry point.
pub(crate) fn reflect(words: &[u32]) -> Result<Reflection, String> {
    let reflection = read(words, COMPUTE)?;
    if reflection.local_size.contains(&0) {
        return Err("SPIR-V has no compute entry point with a local size".into());
    }
    Ok(reflection)
}

/// Reads a module with one entry point of a graphics `stage`; its local size stays 0.
pub(crate) fn reflect_graphics(words: &[u32], stage: Stage) -> Result<Reflection, String> {
    let reflection = read(words, stage as u32)?;
    match reflection.entry.is_empty() {
        true => Err("SPIR-V has no entry point".into()),
        false => Ok(reflection),
    }
}

fn read(words: &[u32], model: u32) -> Result<Reflection, String> {
    if words.len() < HEADER || words[0] != MAGIC {
        return Err("not a SPIR-V module".into());
    }
    let (mut module, mut reflection) = (Module::default(), Reflection::default());
    let mut rest = &words[HEADER..];
    while let Some(first) = rest.first() {
        let (opcode, length) = (first & 0xffff, (first >> 16) as usize);
        let operands = rest.get(1..length).ok_or("SPIR-V is cut off")?;
        if opcode == op::ENTRY_POINT || opcode == op::EXECUTION_MODE {
            entry(opcode, operands, model, &mut reflection)?;
        } else {
            module
                .read(opcode, operands)
                .ok_or("SPIR-V instruction is too short")?;
        }
        rest = &rest[length..];
    }
    module.fill(&mut reflection)?;
    Ok(reflection)
}

fn entry(
    opcode: u32,
    operands: &[u32],
    model: u32,
    reflection: &mut Reflection,
) -> Result<(), String> {
    match (opcode, operands) {
        (op::ENTRY_POINT, [found, _, name @ ..]) if *found == model => {
            let bytes = name
                .iter()
                .flat_map(|w| w.to_le_bytes())
                .take_while(|b| *b != 0);
            reflection.entry = String::from_utf8_lossy(&bytes.collect::<Vec<_>>()).into_owned();
        }
        (op::ENTRY_POINT, _) if model == COMPUTE => {
            return Err("SPIR-V is not a compute shader".into());
        }
        (op::ENTRY_POINT, _) => return Err("SPIR-V is a shader of another stage".into()),
        (_, [_, LOCAL_SIZE, x, y, z]) => reflection.local_size = [*x, *y, *z],
        _ => {}
    }
    Ok(())
}

impl<'a> Module<'a> {
    /// Takes note of one instruction; `None` where it has too few operands.
    fn read(&mut self, opcode: u32, operands: &'a [u32]) -> Option<()> {
        let at = |i: usize| operands.get(i).copied();
        match opcode {
            op::TYPE_INT..=op::TYPE_SAMPLED_IMAGE | op::TYPE_ARRAY..=op::TYPE_POINTER => {
                self.types.insert(at(0)?, (opcode, &operands[1..]));
            }
            op::CONSTANT => {
                self.constants.insert(at(1)?, at(2)?);
            }
            op::VARIABLE => self.variables.push((at(0)?, at(1)?, at(2)?)),
            op::DECORATE => {
                self.decorations
                    .insert((at(0)?, at(1)?), at(2).unwrap_or(0));
            }
            op::MEMBER_DECORATE => {
                self.members
                    .insert((at(0)?, at(1)?, at(2)?), at(3).unwrap_or(0));
            }
            _ => {}
        }
        Some(())
    }

    fn fill(&self, reflection: &mut Reflection) -> Result<(), String> {
        for &(pointer, id, class) in &self.variables {
            let Some((op::TYPE_POINTER, [_, pointee])) = self.types.get(&pointer) else {
                return Err(format!("SPIR-V variable %{id} is no pointer"));
            };
            match class {
                storage::PUSH_CONSTANT => reflection.constants = self.size(*pointee, None, 0)?,
                storage::UNIFORM_CONSTANT | storage::UNIFORM | storage::STORAGE_BUFFER => {
                    reflection.bindings.push(self.binding(id, class, *pointee));
                }
                _ => {}
            }
        }
        reflection.bindings.sort_by_key(|b| (b.set, b.binding));
        Ok(())
    }

    fn binding(&self, id: u32, class: u32, pointee: u32) -> Reflected {
        let decoration = |d| self.decorations.get(&(id, d)).copied();
        Reflected {
            set: decoration(decoration::DESCRIPTOR_SET).unwrap_or(0),
            binding: decoration(decoration::BINDING).unwrap_or(0),
            kind: self.kind(class, pointee),
            readonly: self.qualified(id, pointee, decoration::NON_WRITABLE),
            writeonly: self.qualified(id, pointee, decoration::NON_READABLE),
        }
    }

    fn kind(&self, class: u32, pointee: u32) -> Kind {
        let buffer_block = self
            .decorations
            .contains_key(&(pointee, decoration::BUFFER_BLOCK));
        match (class, self.types.get(&pointee)) {
            (storage::STORAGE_BUFFER, Some((op::TYPE_STRUCT, _))) => Kind::Storage,
            (storage::UNIFORM, Some((op::TYPE_STRUCT, _))) if buffer_block => Kind::Storage,
            (storage::UNIFORM, Some((op::TYPE_STRUCT, _))) => Kind::Uniform,
            (_, Some((op::TYPE_SAMPLED_IMAGE, [image]))) => self.sampled(*image),
            (_, Some((op::TYPE_IMAGE, _))) => match self.image(pointee) {
                Some((volume, format)) => Kind::Image { volume, format },
                None => Kind::Other,
            },
            _ => Kind::Other,
        }
    }

    /// Kind of a sampled image.
    fn sampled(&self, image: u32) -> Kind {
        let Some((op::TYPE_IMAGE, [texel, DIM_BUFFER, ..])) = self.types.get(&image) else {
            let volume = self.image(image).is_some_and(|(volume, _)| volume);
            return Kind::Sampled { volume };
        };
        match self.types.get(texel) {
            Some((op::TYPE_FLOAT, [32, ..])) => Kind::Texels,
            Some((op::TYPE_INT, [32, 0])) => Kind::Words,
            _ => Kind::Other,
        }
    }

    /// Whether an image has three dimensions, and its format.
    fn image(&self, id: u32) -> Option<(bool, Option<Format>)> {
        // Operands after the id: sampled type, dim, depth, arrayed, multisampled, sampled, format.
        let (op::TYPE_IMAGE, [_, dim, _, arrayed, _, _, format, ..]) = self.types.get(&id)? else {
            return None;
        };
        let format = match format {
            1 => Some(Format::Rgba32F),
            2 => Some(Format::Rgba16F),
            _ => None,
        };
        Some((*dim == DIM_3D && *arrayed == 0, format))
    }

    /// The variable carries the decoration, or every member of its block does (as glslang writes it).
    fn qualified(&self, id: u32, pointee: u32, decoration: u32) -> bool {
        let members = match self.types.get(&pointee) {
            Some((op::TYPE_STRUCT, members)) => members.len() as u32,
            _ => 0,
        };
        let member = |m| self.members.contains_key(&(pointee, m, decoration));
        self.decorations.contains_key(&(id, decoration)) || members > 0 && (0..members).all(member)
    }

    /// Bytes of a type with an explicit layout; `stride` is that of a matrix's columns. `depth` bounds the recursion.
    fn size(&self, id: u32, stride: Option<u32>, depth: u32) -> Result<u32, String> {
        let strange = || format!("SPIR-V type %{id} has no layout known to dermis");
        if depth > 8 {
            return Err(strange());
        }
        let size = |id, stride| self.size(id, stride, depth + 1);
        match self.types.get(&id) {
            Some((op::TYPE_INT | op::TYPE_FLOAT, [width, ..])) => Ok(width / 8),
            Some((op::TYPE_VECTOR, [element, count])) => {
                Ok(size(*element, None)?.saturating_mul(*count))
            }
            Some((op::TYPE_MATRIX, [column, count])) => {
                let column = size(*column, None)?;
                let before = stride
                    .unwrap_or(column)
                    .saturating_mul(count.saturating_sub(1));
                Ok(before.saturating_add(column))
            }
            Some((op::TYPE_ARRAY, [_, length])) => {
                let stride = self.decorations.get(&(id, decoration::ARRAY_STRIDE));
                let count = self.constants.get(length);
                let (stride, count) = stride.zip(count).ok_or_else(strange)?;
                Ok(stride.saturating_mul(*count))
            }
            Some((op::TYPE_STRUCT, members)) => {
                let mut ends =
                    members.iter().zip(0..).map(|(member, m)| {
                        let decoration = |d| self.members.get(&(id, m, d)).copied();
                        let offset = decoration(decoration::OFFSET).ok_or_else(strange)?;
                        Ok(offset
                            .saturating_add(size(*member, decoration(decoration::MATRIX_STRIDE))?))
                    });
                ends.try_fold(0, |end: u32, e: Result<u32, String>| Ok(end.max(e?)))
            }
            _ => Err(strange()),
        }
    }
}

#[cfg(test)]
#[path = "spirv_tests.rs"]
#[allow(clippy::unwrap_used)]
mod tests;
