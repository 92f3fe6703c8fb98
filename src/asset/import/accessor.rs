//! Accessors: strided, sparse, without a buffer view, quantised; read into flat arrays (glTF 2.0, chapter 3.6.2).

use gltf::json::accessor::{ComponentType, Type, sparse::Sparse};
use gltf::json::validation::Checked as Parsed;

use super::{
    document::Document,
    fault::{Checked, Fault, refuse},
};

/// Greatest number of elements of one accessor.
pub(super) const ELEMENT_LIMIT: usize = 1 << 24;

/// Shape and type of an accessor's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    pub(super) shape: Type,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
}

impl Format {
    /// Plain floats.
    pub(super) const fn float(shape: Type) -> Self {
        Self {
            shape,
            component: ComponentType::F32,
            normalized: false,
        }
    }

    fn components(self) -> usize {
        self.shape.multiplicity()
    }

    fn bytes(self) -> usize {
        self.components() * self.component.size()
    }
}

/// One accessor of a document whose format and extent are checked.
pub(super) struct Accessor<'a> {
    document: &'a Document,
    row: usize,
    pub(super) format: Format,
    pub(super) count: usize,
}

impl<'a> Accessor<'a> {
    /// Looks the accessor up and checks what can be checked without its data.
    pub(super) fn new(document: &'a Document, row: usize) -> Checked<Self> {
        let element = format!("/accessors/{row}");
        let raw = &document.root.accessors[row];
        let (Parsed::Valid(component), Parsed::Valid(shape)) = (raw.component_type, raw.type_)
        else {
            return refuse(element, "unknown format");
        };
        let format = Format {
            shape,
            component: component.0,
            normalized: raw.normalized,
        };
        if raw.normalized && matches!(format.component, ComponentType::F32 | ComponentType::U32) {
            return refuse(format!("{element}/normalized"), "only for 8 and 16 bits");
        }
        let count = raw.count.0 as usize;
        if count > ELEMENT_LIMIT {
            return refuse(format!("{element}/count"), format!("{count} is too many"));
        }
        if raw.buffer_view.is_none() && raw.byte_offset.is_some() {
            return refuse(format!("{element}/byteOffset"), "without a bufferView");
        }
        Ok(Self {
            document,
            row,
            format,
            count,
        })
    }

    fn element(&self) -> String {
        format!("/accessors/{}", self.row)
    }

    /// Refuses formats other than those given; `role` says what the accessor is for.
    pub(super) fn expect(self, formats: &[Format], role: &str) -> Checked<Self> {
        if formats.contains(&self.format) {
            return Ok(self);
        }
        let Format {
            shape,
            component,
            normalized,
        } = self.format;
        let normalized = if normalized { " normalized" } else { "" };
        let reason = format!("{shape:?} of{normalized} {component:?} cannot be {role}");
        refuse(self.element(), reason)
    }

    /// All components as floats, normalised integers mapped to [0, 1] or [−1, 1].
    ///
    /// # Errors
    /// NaN and infinity, by element; data outside of buffers.
    pub(super) fn floats(&self) -> Checked<Vec<f32>> {
        let bytes = self.bytes()?;
        let Format {
            component,
            normalized,
            ..
        } = self.format;
        let scale = |greatest: f32| if normalized { greatest } else { 1.0 };
        // Two's complement has one value more on the negative side (glTF 2.0, 3.11).
        let least = if normalized { -1.0 } else { f32::MIN };
        let values: Vec<f32> = match component {
            ComponentType::I8 => map(&bytes, |[b]| (f32::from(b as i8) / scale(127.0)).max(least)),
            ComponentType::U8 => map(&bytes, |[b]| f32::from(b) / scale(255.0)),
            ComponentType::I16 => map(&bytes, |b| {
                (f32::from(i16::from_le_bytes(b)) / scale(32767.0)).max(least)
            }),
            ComponentType::U16 => map(&bytes, |b| {
                f32::from(u16::from_le_bytes(b)) / scale(65535.0)
            }),
            ComponentType::U32 => map(&bytes, |b| u32::from_le_bytes(b) as f32),
            ComponentType::F32 => map(&bytes, f32::from_le_bytes),
        };
        if let Some(bad) = values.iter().position(|value| !value.is_finite()) {
            let reason = format!(
                "element {} is {}",
                bad / self.format.components(),
                if values[bad].is_nan() {
                    "NaN"
                } else {
                    "infinite"
                }
            );
            return refuse(self.element(), reason);
        }
        Ok(values)
    }

    /// [`Self::floats`] in rows of `N` components, which the format must have.
    pub(super) fn rows<const N: usize>(&self) -> Checked<Vec<[f32; N]>> {
        debug_assert_eq!(self.format.components(), N);
        Ok(self.floats()?.as_chunks::<N>().0.to_vec())
    }

    /// All components as unsigned integers; the format must be U8, U16 or U32.
    pub(super) fn integers(&self) -> Checked<Vec<u32>> {
        let bytes = self.bytes()?;
        match self.format.component {
            ComponentType::U8 => Ok(map(&bytes, |[b]| u32::from(b))),
            ComponentType::U16 => Ok(map(&bytes, |b| u32::from(u16::from_le_bytes(b)))),
            ComponentType::U32 => Ok(map(&bytes, u32::from_le_bytes)),
            other => refuse(self.element(), format!("{other:?} is no index")),
        }
    }

    /// The elements, tightly packed.
    fn bytes(&self) -> Checked<Vec<u8>> {
        let raw = &self.document.root.accessors[self.row];
        let size = self.format.bytes();
        let mut packed = match raw.buffer_view {
            Some(view) => {
                let offset = raw.byte_offset.map_or(0, |offset| offset.0 as usize);
                self.gather(view.value(), offset, self.count, size, "")?
            }
            None => {
                self.document.charge(self.count * size)?;
                vec![0; self.count * size]
            }
        };
        if let Some(sparse) = &raw.sparse {
            self.substitute(sparse, Some(&mut packed))?;
        }
        Ok(packed)
    }

    /// Checks the sparse elements and writes them over the packed ones.
    fn substitute(&self, sparse: &Sparse, mut packed: Option<&mut [u8]>) -> Checked<()> {
        let element = format!("{}/sparse", self.element());
        let Parsed::Valid(kind) = sparse.indices.component_type else {
            return refuse(element, "unknown format of indices");
        };
        let (count, width, size) = (sparse.count.0 as usize, kind.0.size(), self.format.bytes());
        if count > self.count {
            let reason = format!("{count} of {} elements", self.count);
            return refuse(format!("{element}/count"), reason);
        }
        let (indices, values) = (&sparse.indices, &sparse.values);
        let offset = indices.byte_offset.0 as usize;
        let view = indices.buffer_view.value();
        let rows = self.gather(view, offset, count, width, "/sparse/indices")?;
        let offset = values.byte_offset.0 as usize;
        let view = values.buffer_view.value();
        let new = self.gather(view, offset, count, size, "/sparse/values")?;
        let mut least = 0;
        for (index, value) in rows.chunks_exact(width).zip(new.chunks_exact(size)) {
            let row = index
                .iter()
                .rev()
                .fold(0, |row, &b| row << 8 | usize::from(b));
            if row < least || row >= self.count {
                let reason = format!("index {row} is out of range or does not rise");
                return refuse(format!("{element}/indices"), reason);
            }
            least = row + 1;
            if let Some(packed) = &mut packed {
                packed[row * size..][..size].copy_from_slice(value);
            }
        }
        Ok(())
    }

    /// `count` elements of `size` bytes from a buffer view; `part` is appended to the accessor's pointer in errors.
    fn gather(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
        part: &str,
    ) -> Checked<Vec<u8>> {
        self.document.charge(count * size)?;
        let (bytes, stride) = self.locate(view, offset, count, size, part)?;
        if stride == size {
            return Ok(bytes[..count * size].to_vec());
        }
        let mut packed = Vec::with_capacity(count * size);
        for row in bytes.chunks(stride).take(count) {
            packed.extend_from_slice(&row[..size]);
        }
        Ok(packed)
    }

    /// Where those elements begin, and their stride.
    fn locate(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
        part: &str,
    ) -> Checked<(&'a [u8], usize)> {
        let element = || format!("{}{part}", self.element());
        let raw = &self.document.root.buffer_views[view];
        let stride = raw.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return refuse(
                element(),
                format!("elements of {size} bytes every {stride}"),
            );
        }
        let bytes = view_bytes(self.document, view)?;
        // Counts and offsets are below 2³², strides at most 252: no overflow in 64 bits.
        let end = offset as u64 + (count as u64 - 1) * stride as u64 + size as u64;
        if end > bytes.len() as u64 {
            let length = bytes.len();
            let reason = format!("needs {end} bytes of /bufferViews/{view}, which has {length}");
            return refuse(element(), reason);
        }
        Ok((&bytes[offset..], stride))
    }

    /// Checks that all elements lie in the buffer, without reading them.
    fn check_extent(&self) -> Checked<()> {
        let raw = &self.document.root.accessors[self.row];
        let size = self.format.bytes();
        if let Some(view) = raw.buffer_view {
            let offset = raw.byte_offset.map_or(0, |offset| offset.0 as usize);
            let step = self.format.component.size();
            if offset % step != 0 {
                return refuse(
                    format!("{}/byteOffset", self.element()),
                    format!("not a multiple of {step}"),
                );
            }
            self.locate(view.value(), offset, self.count, size, "")?;
        }
        if let Some(sparse) = &raw.sparse {
            self.substitute(sparse, None)?;
        }
        Ok(())
    }
}

fn view_bytes(document: &Document, view: usize) -> Checked<&[u8]> {
    let raw = &document.root.buffer_views[view];
    let buffer = raw.buffer.value();
    let bytes = document.buffers[buffer]
        .as_deref()
        .ok_or_else(|| Fault::new(format!("/buffers/{buffer}"), "has no data"))?;
    let start = raw.byte_offset.map_or(0, |offset| offset.0 as usize);
    let length = document.root.buffers[buffer].byte_length.0 as usize;
    let end = start.saturating_add(raw.byte_length.0 as usize);
    bytes[..length].get(start..end).ok_or_else(|| {
        let reason = format!("bytes {start}..{end} of /buffers/{buffer}, which has {length}");
        Fault::new(format!("/bufferViews/{view}"), reason)
    })
}

fn map<const N: usize, T>(bytes: &[u8], convert: impl Fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().map(|&chunk| convert(chunk)).collect()
}

/// Checks every buffer view and accessor of the file, used or not, so that a broken file is refused as a whole.
pub(super) fn check_all(document: &Document) -> Checked<()> {
    for view in 0..document.root.buffer_views.len() {
        let buffer = document.root.buffer_views[view].buffer.value();
        if document.buffers[buffer].is_some() {
            view_bytes(document, view)?;
        }
    }
    let held = |view: usize| {
        let buffer = document.root.buffer_views[view].buffer.value();
        document.buffers[buffer].is_some()
    };
    for (row, raw) in document.root.accessors.iter().enumerate() {
        let accessor = Accessor::new(document, row)?;
        if raw.buffer_view.is_none_or(|view| held(view.value())) {
            accessor.check_extent()?;
        }
    }
    Ok(())
}
