//! The part of the glTF 2.0 schema that dermis reads, as a table, and the sieve that checks a file against it.
//!
//! What passes holds exactly the properties below, each of the right type and range and every index resolved, so that
//! the `gltf` crate (which panics on some wrong files, accepts many and refuses some good ones) sees nothing else.

use serde_json::{Map, Number, Value};

use super::fault::{Checked, Pointer, refuse};

/// What a value must be.
#[derive(Clone, Copy)]
enum Rule {
    /// Row of the named array of the root.
    Index(&'static str),
    /// Least, greatest, and what it must be a multiple of.
    Integer(u64, u64, u64),
    /// One of these integers.
    Among(&'static [u64]),
    Flag,
    /// Whatever the application put there.
    Any,
    Text,
    /// One of these words.
    Word(&'static [&'static str]),
    /// So many numbers, each with a magnitude of at most the bound.
    Numbers(usize, f64),
    /// At least so many items.
    List(usize, &'static Rule),
    /// Any keys.
    Each(&'static Rule),
    Object(&'static [Property]),
}

/// A property of an object; the sieve drops all others.
struct Property {
    name: &'static str,
    required: bool,
    rule: Rule,
}

const fn required(name: &'static str, rule: Rule) -> Property {
    Property {
        name,
        required: true,
        rule,
    }
}

const fn optional(name: &'static str, rule: Rule) -> Property {
    Property {
        name,
        required: false,
        rule,
    }
}

/// Byte counts and element counts; the GLB container cannot hold more.
const SIZE: Rule = Rule::Integer(1, u32::MAX as u64, 1);
const OFFSET: Rule = Rule::Integer(0, u32::MAX as u64, 1);
const FLOAT: f64 = f32::MAX as f64;
const ACCESSOR: Rule = Rule::Index("accessors");
const NODE: Rule = Rule::Index("nodes");

const ROOT: Rule = Rule::Object(&[
    required("asset", ASSET),
    optional("extensionsUsed", Rule::List(0, &Rule::Text)),
    optional("extensionsRequired", Rule::List(0, &Rule::Text)),
    optional("buffers", Rule::List(0, &BUFFER)),
    optional("bufferViews", Rule::List(0, &VIEW)),
    optional("accessors", Rule::List(0, &ACCESSORS)),
    optional("materials", Rule::List(0, &MATERIAL)),
    optional("meshes", Rule::List(0, &MESH)),
    optional("skins", Rule::List(0, &SKIN)),
    optional("nodes", Rule::List(0, &NODES)),
    optional("animations", Rule::List(0, &ANIMATION)),
]);

const ASSET: Rule = Rule::Object(&[
    required("version", Rule::Text),
    optional("minVersion", Rule::Text),
]);

const BUFFER: Rule = Rule::Object(&[required("byteLength", SIZE), optional("uri", Rule::Text)]);

const VIEW: Rule = Rule::Object(&[
    required("buffer", Rule::Index("buffers")),
    required("byteLength", SIZE),
    optional("byteOffset", OFFSET),
    optional("byteStride", Rule::Integer(4, 252, 4)),
]);

const ACCESSORS: Rule = Rule::Object(&[
    required(
        "componentType",
        Rule::Among(&[5120, 5121, 5122, 5123, 5125, 5126]),
    ),
    required("count", SIZE),
    required(
        "type",
        Rule::Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]),
    ),
    optional("bufferView", Rule::Index("bufferViews")),
    optional("byteOffset", OFFSET),
    optional("normalized", Rule::Flag),
    optional("sparse", SPARSE),
]);

const SPARSE: Rule = Rule::Object(&[
    required("count", SIZE),
    required(
        "indices",
        Rule::Object(&[
            required("bufferView", Rule::Index("bufferViews")),
            required("componentType", Rule::Among(&[5121, 5123, 5125])),
            optional("byteOffset", OFFSET),
        ]),
    ),
    required(
        "values",
        Rule::Object(&[
            required("bufferView", Rule::Index("bufferViews")),
            optional("byteOffset", OFFSET),
        ]),
    ),
]);

const MATERIAL: Rule = Rule::Object(&[optional(
    "pbrMetallicRoughness",
    Rule::Object(&[optional("baseColorFactor", Rule::Numbers(4, 1.0))]),
)]);

const MESH: Rule = Rule::Object(&[
    optional("name", Rule::Text),
    required("primitives", Rule::List(1, &PRIMITIVE)),
]);

const PRIMITIVE: Rule = Rule::Object(&[
    required("attributes", Rule::Each(&ACCESSOR)),
    optional("indices", ACCESSOR),
    optional("material", Rule::Index("materials")),
    optional("mode", Rule::Integer(0, 6, 1)),
    optional("targets", Rule::List(0, &Rule::Each(&ACCESSOR))),
]);

const SKIN: Rule = Rule::Object(&[
    required("joints", Rule::List(1, &NODE)),
    optional("inverseBindMatrices", ACCESSOR),
    optional("skeleton", NODE),
]);

const NODES: Rule = Rule::Object(&[
    optional("name", Rule::Text),
    optional("children", Rule::List(0, &NODE)),
    optional("mesh", Rule::Index("meshes")),
    optional("skin", Rule::Index("skins")),
    optional("matrix", Rule::Numbers(16, FLOAT)),
    optional("translation", Rule::Numbers(3, FLOAT)),
    optional("rotation", Rule::Numbers(4, 2.0)),
    optional("scale", Rule::Numbers(3, FLOAT)),
    optional("extras", Rule::Any),
]);

const ANIMATION: Rule = Rule::Object(&[
    optional("name", Rule::Text),
    required("channels", Rule::List(0, &CHANNEL)),
    required("samplers", Rule::List(0, &SAMPLER)),
]);

const CHANNEL: Rule = Rule::Object(&[
    required("sampler", OFFSET),
    required(
        "target",
        Rule::Object(&[optional("node", NODE), required("path", Rule::Text)]),
    ),
]);

const SAMPLER: Rule = Rule::Object(&[
    required("input", ACCESSOR),
    required("output", ACCESSOR),
    optional(
        "interpolation",
        Rule::Word(&["LINEAR", "STEP", "CUBICSPLINE"]),
    ),
]);

/// Checks a whole file and drops what dermis does not read.
///
/// # Errors
/// The JSON pointer of the first value that is missing, of a wrong type, out of range or an index of nothing.
pub(super) fn sieve(root: Value) -> Checked<Value> {
    let lengths = Lengths::of(&root);
    lengths.sieve(root, &ROOT, &Pointer::Root)
}

/// Lengths of the arrays of the root, which indices point into.
struct Lengths(Map<String, Value>);

impl Lengths {
    fn of(root: &Value) -> Self {
        let length = |(name, value): (&String, &Value)| {
            let items = value.as_array()?.len();
            Some((name.clone(), Value::from(items)))
        };
        let root = root.as_object();
        Self(root.into_iter().flatten().filter_map(length).collect())
    }

    fn length(&self, array: &str) -> u64 {
        self.0.get(array).and_then(Value::as_u64).unwrap_or(0)
    }

    fn sieve(&self, value: Value, rule: &Rule, at: &Pointer<'_>) -> Checked<Value> {
        match *rule {
            Rule::Index(array) => self.index(&value, array, at),
            Rule::Integer(least, most, step) => {
                let number = integer(&value, at)?;
                if !(least..=most).contains(&number) || !number.is_multiple_of(step) {
                    return refuse(at, format!("{number} is out of range"));
                }
                Ok(number.into())
            }
            Rule::Among(set) => {
                let number = integer(&value, at)?;
                if !set.contains(&number) {
                    return refuse(at, format!("{number} is none of {set:?}"));
                }
                Ok(number.into())
            }
            Rule::Any => Ok(value),
            Rule::Flag if value.is_boolean() => Ok(value),
            Rule::Flag => refuse(at, "not a boolean"),
            Rule::Text if value.is_string() => Ok(value),
            Rule::Text => refuse(at, "not a string"),
            Rule::Word(set) => match value.as_str() {
                Some(word) if set.contains(&word) => Ok(value),
                _ => refuse(at, format!("none of {set:?}")),
            },
            Rule::Numbers(count, bound) => numbers(value, count, bound, at),
            Rule::List(least, item) => self.list(value, least, item, at),
            Rule::Each(item) => self.each(value, item, at),
            Rule::Object(properties) => self.object(value, properties, at),
        }
    }

    fn index(&self, value: &Value, array: &str, at: &Pointer<'_>) -> Checked<Value> {
        let (index, length) = (integer(value, at)?, self.length(array));
        if index >= length {
            return refuse(at, format!("{index}, but there are {length} {array}"));
        }
        Ok(index.into())
    }

    fn list(&self, value: Value, least: usize, item: &Rule, at: &Pointer<'_>) -> Checked<Value> {
        let Value::Array(items) = value else {
            return refuse(at, "not an array");
        };
        if items.len() < least {
            return refuse(at, "empty");
        }
        let row = |(row, value)| self.sieve(value, item, &Pointer::Row(at, row));
        items.into_iter().enumerate().map(row).collect()
    }

    fn each(&self, value: Value, item: &Rule, at: &Pointer<'_>) -> Checked<Value> {
        let Value::Object(map) = value else {
            return refuse(at, "not an object");
        };
        let mut sieved = Map::new();
        for (key, value) in map {
            let value = self.sieve(value, item, &Pointer::Key(at, &key))?;
            sieved.insert(key, value);
        }
        Ok(Value::Object(sieved))
    }

    fn object(&self, value: Value, properties: &[Property], at: &Pointer<'_>) -> Checked<Value> {
        let Value::Object(mut map) = value else {
            return refuse(at, "not an object");
        };
        let mut sieved = Map::new();
        for property in properties {
            let pointer = Pointer::Key(at, property.name);
            match map.remove(property.name) {
                Some(value) => {
                    let value = self.sieve(value, &property.rule, &pointer)?;
                    sieved.insert(property.name.into(), value);
                }
                None if property.required => return refuse(pointer, "missing"),
                None => {}
            }
        }
        Ok(Value::Object(sieved))
    }
}

/// JSON Schema counts 3.0 as an integer.
fn integer(value: &Value, at: &Pointer<'_>) -> Checked<u64> {
    let whole = |x: f64| (x.fract() == 0.0 && (0.0..1e15).contains(&x)).then_some(x as u64);
    value
        .as_u64()
        .or_else(|| value.as_f64().and_then(whole))
        .map_or_else(|| refuse(at, "not an index or size"), Ok)
}

fn numbers(value: Value, count: usize, bound: f64, at: &Pointer<'_>) -> Checked<Value> {
    let Value::Array(items) = value else {
        return refuse(at, "not an array");
    };
    if items.len() != count {
        return refuse(at, format!("{} numbers, not {count}", items.len()));
    }
    for (row, item) in items.iter().enumerate() {
        let fits = |number: &Number| number.as_f64().is_some_and(|x| x.abs() <= bound);
        if !item.as_number().is_some_and(fits) {
            return refuse(Pointer::Row(at, row), "not a number in range");
        }
    }
    Ok(Value::Array(items))
}
