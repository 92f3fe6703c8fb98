//! The costly part of a preparation as bytes for the cache.

use bytemuck::{AnyBitPattern, NoUninit};
use glam::{DVec3, Mat3, Vec3};

use super::Weights;
use crate::field::{Field, FieldBox, Hrbf};

/// What takes long to prepare and is cached.
#[derive(Clone, Debug)]
pub(super) struct Prepared {
    pub(super) weights: Weights,
    pub(super) part: Vec<u16>,
    pub(super) radius: Vec<f32>,
    pub(super) fields: Vec<Field>,
    pub(super) geometric: Vec<bool>,
    pub(super) warnings: Vec<String>,
}

/// Writes slices of plain values, each after its length in bytes.
#[derive(Default)]
struct Writer(Vec<u8>);

impl Writer {
    fn put<T: NoUninit>(&mut self, values: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.0.extend((bytes.len() as u64).to_le_bytes());
        self.0.extend(bytes);
    }
}

/// Reads what [`Writer`] wrote; `None` where the bytes do not fit.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<T: NoUninit + AnyBitPattern>(&mut self) -> Option<Vec<T>> {
        let (length, rest) = self.0.split_first_chunk::<8>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (bytes, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        (length % size_of::<T>() == 0).then(|| bytemuck::pod_collect_to_vec(bytes))
    }

    fn one<T: NoUninit + AnyBitPattern>(&mut self) -> Option<T> {
        let values = self.take()?;
        (values.len() == 1).then(|| values[0])
    }
}

impl Prepared {
    /// All of it as bytes.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.put(&[self.weights.width as u64]);
        w.put(&self.weights.joints);
        w.put(&self.weights.weights);
        w.put(&self.part);
        w.put(&self.radius);
        w.put(
            &self
                .geometric
                .iter()
                .map(|g| u8::from(*g))
                .collect::<Vec<_>>(),
        );
        w.put(self.warnings.join("\n").as_bytes());
        w.put(&[self.fields.len() as u64]);
        for field in &self.fields {
            put_field(&mut w, field);
        }
        w.0
    }

    /// Reads it back; `None` where the bytes are no such thing.
    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut r = Reader(bytes);
        let weights = Weights {
            width: r.one::<u64>()? as usize,
            joints: r.take()?,
            weights: r.take()?,
        };
        let part = r.take()?;
        let radius = r.take()?;
        let geometric = r.take::<u8>()?.iter().map(|g| *g != 0).collect();
        let text = String::from_utf8(r.take()?).ok()?;
        let count = r.one::<u64>()?;
        let fields = (0..count)
            .map(|_| take_field(&mut r))
            .collect::<Option<_>>()?;
        r.0.is_empty().then_some(Self {
            weights,
            part,
            radius,
            fields,
            geometric,
            warnings: text.lines().map(String::from).collect(),
        })
    }
}

fn put_field(w: &mut Writer, field: &Field) {
    let Field {
        joint,
        segments,
        radius,
        bounds,
        hrbf,
    } = field;
    w.put(&[*joint]);
    w.put(&segments.concat());
    w.put(&[*radius]);
    w.put(&[bounds.origin, bounds.size]);
    w.put(&[bounds.axes]);
    w.put(&[hrbf.origin]);
    w.put(&[hrbf.scale]);
    w.put(&hrbf.centers);
    w.put(&hrbf.lambda);
    w.put(&hrbf.beta);
}

fn take_field(r: &mut Reader) -> Option<Field> {
    let joint = r.one()?;
    let ends = r.take::<Vec3>()?;
    let radius = r.one()?;
    let corners = r.take::<Vec3>()?;
    let [origin, size] = corners[..] else {
        return None;
    };
    Some(Field {
        joint,
        segments: ends.chunks_exact(2).map(|e| [e[0], e[1]]).collect(),
        radius,
        bounds: FieldBox {
            origin,
            axes: r.one::<Mat3>()?,
            size,
        },
        hrbf: Hrbf {
            origin: r.one::<DVec3>()?,
            scale: r.one()?,
            centers: r.take()?,
            lambda: r.take()?,
            beta: r.take()?,
        },
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn prepared() -> Prepared {
        let field = |joint| Field {
            joint,
            segments: vec![[Vec3::X, Vec3::Y]; usize::from(joint)],
            radius: 0.25,
            bounds: FieldBox {
                origin: Vec3::Z,
                axes: Mat3::from_rotation_x(0.3),
                size: Vec3::new(1.0, 2.0, 3.0),
            },
            hrbf: Hrbf {
                origin: DVec3::splat(0.1),
                scale: 1.0 / 3.0,
                centers: vec![DVec3::splat(1e-300); 4],
                lambda: vec![0.1 + 0.2; 4],
                beta: vec![DVec3::NEG_X; 4],
            },
        };
        Prepared {
            weights: Weights {
                width: 4,
                joints: vec![1, 0, 0, 0],
                weights: vec![1.0, 0.0, 0.0, 0.0],
            },
            part: vec![1],
            radius: vec![0.0, 0.25],
            fields: vec![field(1), field(2)],
            geometric: vec![true],
            warnings: vec!["one".into(), "two".into()],
        }
    }

    #[test]
    fn everything_comes_back_bit_for_bit() {
        let p = prepared();
        let back = Prepared::from_bytes(&p.to_bytes()).unwrap();
        assert_eq!(format!("{back:?}"), format!("{p:?}"));
        assert_eq!(back.to_bytes(), p.to_bytes());
    }

    #[test]
    fn truncated_or_lengthened_bytes_are_refused() {
        let bytes = prepared().to_bytes();
        for k in 0..bytes.len() {
            assert!(Prepared::from_bytes(&bytes[..k]).is_none(), "{k}");
        }
        let longer = [bytes, vec![0]].concat();
        assert!(Prepared::from_bytes(&longer).is_none());
    }
}
