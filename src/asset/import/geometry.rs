//! Primitives of skinned meshes: positions, normals, triangles.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat3, DMat4, Vec3};
use gltf::json::{
    Index, accessor,
    accessor::{ComponentType, Type},
    mesh::{self, Mode, Semantic},
    validation::Checked as Parsed,
};

use super::{
    accessor::{Accessor, Format},
    document::{Document, QUANTIZATION},
    fault::{Checked, refuse},
};

/// Vertices and triangles of one primitive, in the bind space of its skin.
pub(super) struct Geometry {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Attributes of a primitive and the JSON pointer to them.
pub(super) struct Attributes<'a> {
    map: &'a BTreeMap<Parsed<Semantic>, Index<accessor::Accessor>>,
    pub(super) element: String,
}

impl<'a> Attributes<'a> {
    pub(super) fn new(primitive: &'a mesh::Primitive, element: &str) -> Self {
        Self {
            map: &primitive.attributes,
            element: format!("{element}/attributes"),
        }
    }

    /// Row of the accessor.
    pub(super) fn get(&self, semantic: Semantic) -> Option<usize> {
        self.map
            .get(&Parsed::Valid(semantic))
            .map(|index| index.value())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&'a Semantic, usize)> {
        self.map
            .iter()
            .filter_map(|(semantic, index)| match semantic {
                Parsed::Valid(semantic) => Some((semantic, index.value())),
                Parsed::Invalid => None,
            })
    }
}

/// Reads a primitive; a sentence instead where it has nothing to deform.
pub(super) fn read(
    document: &Document,
    primitive: &mesh::Primitive,
    element: &str,
    warnings: &mut Vec<String>,
) -> Checked<Result<Geometry, String>> {
    let mode = match primitive.mode {
        Parsed::Valid(mode) => mode,
        Parsed::Invalid => return refuse(format!("{element}/mode"), "unknown"),
    };
    if !matches!(
        mode,
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
    ) {
        return Ok(Err(format!(
            "{element} has no triangles ({mode:?}) and is left out"
        )));
    }
    let attributes = Attributes::new(primitive, element);
    let Some(positions) = attributes.get(Semantic::Positions) else {
        return Ok(Err(format!("{element} has no positions and is left out")));
    };
    let positions = vectors(document, positions, "POSITION")?;
    let indices = indices(document, primitive, positions.len(), element)?;
    if mode == Mode::Triangles && indices.len() % 3 != 0 {
        warnings.push(format!(
            "{element} has {} indices left over",
            indices.len() % 3
        ));
    }
    let triangles = assemble(mode, &indices);
    if triangles.is_empty() {
        return Ok(Err(format!("{element} has no triangles and is left out")));
    }
    let normals = match attributes.get(Semantic::Normals) {
        Some(row) => Some(vectors(document, row, "NORMAL")?),
        None => None,
    };
    if let Some(normals) = &normals
        && normals.len() != positions.len()
    {
        let reason = format!(
            "{} elements for {} positions",
            normals.len(),
            positions.len()
        );
        return refuse(format!("{}/NORMAL", attributes.element), reason);
    }
    let (normals, replaced) = unit_normals(normals, &positions, &triangles);
    if replaced > 0 {
        let what = format!("{element}: {replaced} normals are missing or 0 and were computed");
        warnings.push(what);
    }
    Ok(Ok(Geometry {
        positions,
        normals,
        triangles,
    }))
}

/// Floats, or with KHR_mesh_quantization the integers which that allows.
pub(super) fn vectors(document: &Document, row: usize, role: &str) -> Checked<Vec<Vec3>> {
    let mut formats = vec![Format::float(Type::Vec3)];
    if document
        .root
        .extensions_used
        .iter()
        .any(|name| name == QUANTIZATION)
    {
        let signed = [ComponentType::I8, ComponentType::I16];
        let unsigned = [ComponentType::U8, ComponentType::U16];
        let quantized = |component, normalized| Format {
            shape: Type::Vec3,
            component,
            normalized,
        };
        formats.extend(signed.map(|component| quantized(component, true)));
        if role == "POSITION" {
            formats.extend(signed.map(|component| quantized(component, false)));
            formats.extend(unsigned.map(|component| quantized(component, false)));
            formats.extend(unsigned.map(|component| quantized(component, true)));
        }
    }
    let accessor = Accessor::new(document, row)?.expect(&formats, role)?;
    Ok(accessor.rows::<3>()?.into_iter().map(Vec3::from).collect())
}

fn indices(
    document: &Document,
    primitive: &mesh::Primitive,
    vertices: usize,
    element: &str,
) -> Checked<Vec<u32>> {
    let Some(row) = primitive.indices else {
        return Ok((0..vertices as u32).collect());
    };
    let scalar = |component| Format {
        shape: Type::Scalar,
        component,
        normalized: false,
    };
    let formats = [ComponentType::U8, ComponentType::U16, ComponentType::U32].map(scalar);
    let accessor = Accessor::new(document, row.value())?.expect(&formats, "indices")?;
    let indices = accessor.integers()?;
    if let Some(bad) = indices.iter().position(|&index| index as usize >= vertices) {
        let reason = format!(
            "element {bad}: index {} of {vertices} vertices",
            indices[bad]
        );
        return refuse(format!("{element}/indices"), reason);
    }
    let restart = match accessor.format.component {
        ComponentType::U8 => 0xFF,
        ComponentType::U16 => 0xFFFF,
        _ => u32::MAX,
    };
    if let Some(bad) = indices.iter().position(|&index| index == restart) {
        let reason = format!("element {bad}: {restart} means a restart, which glTF forbids");
        return refuse(format!("{element}/indices"), reason);
    }
    Ok(indices)
}

/// Triangles of a list, strip or fan (glTF 2.0, 3.7.2.1); the degenerate ones that stitch strips are dropped.
fn assemble(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let proper = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        Mode::TriangleStrip => {
            let windows = indices.windows(3).enumerate();
            let turned = windows.map(|(i, w)| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[1], w[0], w[2]],
            });
            turned.filter(proper).collect()
        }
        Mode::TriangleFan => {
            let pairs = indices.get(1..).unwrap_or_default().windows(2);
            let fan = pairs.map(|pair| [indices[0], pair[0], pair[1]]);
            fan.filter(proper).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// Unit normals and how many of them had to be computed.
pub(in crate::asset) fn unit_normals(
    given: Option<Vec<Vec3>>,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
) -> (Vec<Vec3>, usize) {
    let mut normals = given.unwrap_or_else(|| vec![Vec3::ZERO; positions.len()]);
    normals
        .iter_mut()
        .for_each(|normal| *normal = unit(*normal));
    let missing = normals
        .iter()
        .filter(|&&normal| normal == Vec3::ZERO)
        .count();
    if missing > 0 {
        let computed = area_weighted(positions, triangles);
        for (normal, computed) in normals.iter_mut().zip(computed) {
            if *normal == Vec3::ZERO {
                *normal = computed;
            }
        }
    }
    (normals, missing)
}

/// Bit for bit itself where unit up to rounding, zero where it has no direction.
fn unit(normal: Vec3) -> Vec3 {
    if (normal.length_squared() - 1.0).abs() <= 1e-5 {
        return normal;
    }
    normal.as_dvec3().normalize_or_zero().as_vec3()
}

/// Sum of the doubled area vectors of the triangles at a position; rows of one position (a seam) share their normal.
fn area_weighted(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let key = |row: u32| {
        positions[row as usize]
            .to_array()
            .map(|x| (x + 0.0).to_bits())
    };
    let mut sums = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|row| positions[row as usize].as_dvec3());
        for &row in triangle {
            *sums.entry(key(row)).or_insert(glam::DVec3::ZERO) += (b - a).cross(c - a);
        }
    }
    let normal = |row| {
        let sum = sums.get(&key(row)).copied().unwrap_or_default();
        // Vertices of no triangle, or of degenerate ones only, get some direction: nobody sees it.
        sum.try_normalize().map_or(Vec3::Z, |sum| sum.as_vec3())
    };
    (0..positions.len() as u32).map(normal).collect()
}

impl Geometry {
    /// Carries everything into another space; a mirroring turns the triangles over, so that they keep facing outwards.
    pub(super) fn carry(&mut self, carry: &DMat4) {
        let linear = DMat3::from_mat4(*carry);
        let cofactor = linear.inverse().transpose();
        for position in &mut self.positions {
            *position = carry.transform_point3(position.as_dvec3()).as_vec3();
        }
        for normal in &mut self.normals {
            *normal = (cofactor * normal.as_dvec3())
                .normalize_or(glam::DVec3::Z)
                .as_vec3();
        }
        if linear.determinant() < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
}
