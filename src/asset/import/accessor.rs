//! Accessors: strided, sparse, without a buffer view, quantised; read into flat arrays (glTF 2.0, chapter 3.6.2).

use std::ops::Range;

use gltf::json::accessor::{ComponentType, Type, sparse::Sparse};
use gltf::json::validation::Checked as Parsed;

use super::{
    document::Document,
    fault::{Checked, refuse},
};

/// Greatest number of elements of one accessor.
const ELEMENT_LIMIT: usize = 1 << 24;

/// The same where the file holds no data for it, all zeros; a few bytes must not ask for much work.
const ZEROS_LIMIT: usize = 1 << 20;

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
        let limit = match raw.buffer_view {
            Some(_) => ELEMENT_LIMIT,
            None => ZEROS_LIMIT,
        };
        if count > limit {
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
            self.substitute(sparse, &mut packed)?;
        }
        Ok(packed)
    }

    /// Checks that the sparse elements lie in their buffers; returns the bytes of an index.
    fn check_sparse(&self, sparse: &Sparse) -> Checked<usize> {
        let element = format!("{}/sparse", self.element());
        let (indices, values) = (&sparse.indices, &sparse.values);
        let Parsed::Valid(kind) = indices.component_type else {
            return refuse(element, "unknown format of indices");
        };
        let (count, width) = (sparse.count.0 as usize, kind.0.size());
        if count > self.count {
            let reason = format!("{count} of {} elements", self.count);
            return refuse(format!("{element}/count"), reason);
        }
        let (view, offset) = (indices.buffer_view.value(), indices.byte_offset.0 as usize);
        self.stride(view, offset, count, width, "/sparse/indices")?;
        let (view, offset) = (values.buffer_view.value(), values.byte_offset.0 as usize);
        self.stride(view, offset, count, self.format.bytes(), "/sparse/values")?;
        Ok(width)
    }

    /// Writes the sparse elements over the packed ones.
    fn substitute(&self, sparse: &Sparse, packed: &mut [u8]) -> Checked<()> {
        let width = self.check_sparse(sparse)?;
        let (indices, values) = (&sparse.indices, &sparse.values);
        let (count, size) = (sparse.count.0 as usize, self.format.bytes());
        let (view, offset) = (indices.buffer_view.value(), indices.byte_offset.0 as usize);
        let rows = self.gather(view, offset, count, width, "/sparse/indices")?;
        let (view, offset) = (values.buffer_view.value(), values.byte_offset.0 as usize);
        let new = self.gather(view, offset, count, size, "/sparse/values")?;
        let mut least = 0;
        for (index, value) in rows.chunks_exact(width).zip(new.chunks_exact(size)) {
            let row = index
                .iter()
                .rev()
                .fold(0, |row, &b| row << 8 | usize::from(b));
            if row < least || row >= self.count {
                let element = format!("{}/sparse/indices", self.element());
                return refuse(
                    element,
                    format!("index {row} is out of range or does not rise"),
                );
            }
            least = row + 1;
            packed[row * size..][..size].copy_from_slice(value);
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
        let stride = self.stride(view, offset, count, size, part)?;
        let bytes = &view_bytes(self.document, view)?[offset..];
        if stride == size {
            return Ok(bytes[..count * size].to_vec());
        }
        let mut packed = Vec::with_capacity(count * size);
        for row in bytes.chunks(stride).take(count) {
            packed.extend_from_slice(&row[..size]);
        }
        Ok(packed)
    }

    /// Stride of those elements, which must lie in the buffer view.
    fn stride(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
        part: &str,
    ) -> Checked<usize> {
        let element = || format!("{}{part}", self.element());
        let raw = &self.document.root.buffer_views[view];
        let stride = raw.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            let reason = format!("elements of {size} bytes every {stride}");
            return refuse(element(), reason);
        }
        // Counts and offsets are below 2³², strides at most 252: no overflow in 64 bits.
        let end = offset as u64 + (count as u64 - 1) * stride as u64 + size as u64;
        let length = raw.byte_length.0;
        if end > length {
            let reason = format!("needs {end} bytes of /bufferViews/{view}, which has {length}");
            return refuse(element(), reason);
        }
        Ok(stride)
    }

    /// Checks that all elements lie in the buffer, without reading them.
    fn check_extent(&self) -> Checked<()> {
        let raw = &self.document.root.accessors[self.row];
        let size = self.format.bytes();
        if let Some(view) = raw.buffer_view {
            let offset = raw.byte_offset.map_or(0, |offset| offset.0 as usize);
            let step = self.format.component.size();
            if !offset.is_multiple_of(step) {
                return refuse(
                    format!("{}/byteOffset", self.element()),
                    format!("not a multiple of {step}"),
                );
            }
            self.stride(view.value(), offset, self.count, size, "")?;
        }
        if let Some(sparse) = &raw.sparse {
            self.check_sparse(sparse)?;
        }
        Ok(())
    }
}

/// Start and end of a buffer view in its buffer.
fn view_range(document: &Document, view: usize) -> Checked<Range<usize>> {
    let raw = &document.root.buffer_views[view];
    let buffer = raw.buffer.value();
    let start = raw.byte_offset.map_or(0, |offset| offset.0);
    let (end, length) = (
        start + raw.byte_length.0,
        document.root.buffers[buffer].byte_length.0,
    );
    if end > length {
        let reason = format!("bytes {start}..{end} of /buffers/{buffer}, which has {length}");
        return refuse(format!("/bufferViews/{view}"), reason);
    }
    Ok(start as usize..end as usize)
}

fn view_bytes(document: &Document, view: usize) -> Checked<&[u8]> {
    let range = view_range(document, view)?;
    let buffer = document.root.buffer_views[view].buffer.value();
    match &document.buffers[buffer] {
        Some(bytes) => Ok(&bytes[range]),
        None => refuse(format!("/buffers/{buffer}"), "has no data"),
    }
}

fn map<const N: usize, T>(bytes: &[u8], convert: impl Fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().map(|&chunk| convert(chunk)).collect()
}

/// Checks every buffer view and accessor of the file, used or not, so that a broken file is refused as a whole.
pub(super) fn check_all(document: &Document) -> Checked<()> {
    for view in 0..document.root.buffer_views.len() {
        view_range(document, view)?;
    }
    for row in 0..document.root.accessors.len() {
        Accessor::new(document, row)?.check_extent()?;
    }
    Ok(())
}
