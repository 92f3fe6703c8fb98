//! Building a GLB: arrays to buffer views and accessors, then header, JSON chunk and binary chunk (glTF 2.0, chapter 4).

use std::{collections::HashMap, path::Path};

use glam::Vec3;
use serde_json::{Map, Value, json};

use super::write_atomic;
use crate::{Error, Result};

/// What an accessor's elements are.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    Scalar,
    Vec3,
    Vec4,
    Mat4,
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Shape::Scalar => "SCALAR",
            Shape::Vec3 => "VEC3",
            Shape::Vec4 => "VEC4",
            Shape::Mat4 => "MAT4",
        }
    }

    fn components(self) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vec3 => 3,
            Shape::Vec4 => 4,
            Shape::Mat4 => 16,
        }
    }
}

/// What a buffer view is for; the numbers are glTF's.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Vertices = 34962,
    Indices = 34963,
    /// Key times, values, matrices.
    Other = 0,
}

/// A component that glTF knows.
pub(super) trait Component: bytemuck::Pod {
    const TYPE: u32;
}

impl Component for u8 {
    const TYPE: u32 = 5121;
}
impl Component for u16 {
    const TYPE: u32 = 5123;
}
impl Component for u32 {
    const TYPE: u32 = 5125;
}
impl Component for f32 {
    const TYPE: u32 = 5126;
}

/// Arrays collected so far; each has its own buffer view, aligned to four bytes.
#[derive(Default)]
pub(super) struct Builder {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    /// Accessors of key times by their bits: most channels of a clip share them.
    times: HashMap<Vec<u32>, usize>,
}

impl Builder {
    /// Appends an array of flat components; returns the row of its accessor.
    pub(super) fn array<T: Component>(&mut self, shape: Shape, usage: Use, items: &[T]) -> usize {
        debug_assert!(!items.is_empty() && items.len().is_multiple_of(shape.components()));
        let mut view = json!({
            "buffer": 0,
            "byteOffset": self.binary.len(),
            "byteLength": size_of_val(items),
        });
        if usage != Use::Other {
            view["target"] = (usage as u32).into();
        }
        for item in items {
            self.binary.extend_from_slice(bytemuck::bytes_of(item));
            // glTF is little endian.
            if cfg!(target_endian = "big") {
                let start = self.binary.len() - size_of::<T>();
                self.binary[start..].reverse();
            }
        }
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": T::TYPE,
            "count": items.len() / shape.components(),
            "type": shape.name(),
        }));
        self.accessors.len() - 1
    }

    /// Appends positions, which carry their bounds.
    pub(super) fn positions(&mut self, rows: &[Vec3]) -> usize {
        let accessor = self.vectors(rows);
        let least = rows.iter().fold(Vec3::INFINITY, |a, &b| a.min(b));
        let greatest = rows.iter().fold(Vec3::NEG_INFINITY, |a, &b| a.max(b));
        self.bounds(accessor, &least.to_array(), &greatest.to_array());
        accessor
    }

    /// Appends vectors of vertices.
    pub(super) fn vectors(&mut self, rows: &[Vec3]) -> usize {
        let flat = rows.iter().flat_map(|row| row.to_array());
        let flat: Vec<f32> = flat.collect();
        self.array(Shape::Vec3, Use::Vertices, &flat)
    }

    /// Appends rising key times, which carry their bounds; the same times are kept once.
    pub(super) fn times(&mut self, times: &[f32]) -> usize {
        let bits: Vec<u32> = times.iter().map(|time| time.to_bits()).collect();
        if let Some(&accessor) = self.times.get(&bits) {
            return accessor;
        }
        let accessor = self.array(Shape::Scalar, Use::Other, times);
        if let (Some(&first), Some(&last)) = (times.first(), times.last()) {
            self.bounds(accessor, &[first], &[last]);
        }
        self.times.insert(bits, accessor);
        accessor
    }

    /// Appends the triangles' indices, each less by `first`; as half-words where they fit.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]], first: u32) -> usize {
        let flat: Vec<u32> = triangles.iter().flatten().map(|row| row - first).collect();
        // The greatest half-word would mean a restart.
        if flat.iter().all(|&row| row < 0xFFFF) {
            let flat: Vec<u16> = flat.iter().map(|&row| row as u16).collect();
            return self.array(Shape::Scalar, Use::Indices, &flat);
        }
        self.array(Shape::Scalar, Use::Indices, &flat)
    }

    fn bounds(&mut self, accessor: usize, least: &[f32], greatest: &[f32]) {
        self.accessors[accessor]["min"] = json!(least);
        self.accessors[accessor]["max"] = json!(greatest);
    }

    /// Writes the file; `root` holds everything but `asset`, `buffers`, `bufferViews` and `accessors`.
    pub(super) fn write(self, path: &Path, mut root: Map<String, Value>) -> Result<()> {
        let generator = concat!("dermis ", env!("CARGO_PKG_VERSION"));
        root.insert(
            "asset".into(),
            json!({ "version": "2.0", "generator": generator }),
        );
        root.insert(
            "buffers".into(),
            json!([{ "byteLength": self.binary.len() }]),
        );
        root.insert("bufferViews".into(), Value::Array(self.views));
        root.insert("accessors".into(), Value::Array(self.accessors));
        let mut text = Value::Object(root).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() as u64 + 8 + self.binary.len() as u64;
        let total = u32::try_from(total).map_err(|_| too_large(path, total))?;
        write_atomic(path, |file| {
            let mut words = |words: &[u32]| {
                words
                    .iter()
                    .try_for_each(|word| file.write_all(&word.to_le_bytes()))
            };
            words(&[0x4654_6C67, 2, total, text.len() as u32, 0x4E4F_534A])?;
            file.write_all(&text)?;
            for word in [self.binary.len() as u32, 0x004E_4942] {
                file.write_all(&word.to_le_bytes())?;
            }
            file.write_all(&self.binary)
        })
    }
}

/// A GLB counts its bytes in 32 bits.
pub(super) fn too_large(path: &Path, bytes: u64) -> Error {
    let reason = format!("{bytes} bytes, but a GLB holds at most 4 GiB");
    Error::asset(path, "GLB", reason)
}

/// `[{"name": …, "pbrMetallicRoughness": …}]` of the primitives' colours, one a primitive.
pub(super) fn materials(primitives: &[crate::asset::Primitive]) -> Value {
    let material = |primitive: &crate::asset::Primitive| {
        json!({ "pbrMetallicRoughness": {
            "baseColorFactor": primitive.base_color,
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        } })
    };
    primitives.iter().map(material).collect()
}
