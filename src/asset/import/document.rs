//! From bytes to a checked document: JSON, version, extensions, schema, the `gltf` crate's types, buffers.

use std::{
    cell::Cell,
    panic::{self, AssertUnwindSafe},
    path::Path,
    sync::Once,
};

use gltf::json::{self, Root};
use serde_json::Value;

use super::{
    container::{self, Container},
    fault::{Checked, Fault, refuse},
    schema, uri,
};
use crate::{Error, Result};

/// Greatest sum of all buffers, bytes.
const BUFFER_LIMIT: u64 = 2 << 30;

/// Greatest sum of what is read from accessors, bytes.
const READ_LIMIT: u64 = 1 << 30;

/// Extensions that change nothing which dermis reads; a trailing `_` stands for a whole family.
const HARMLESS: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_dds",
    "KHR_lights_punctual",
    "EXT_lights_",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_xmp_json_ld",
];

/// Quantised vertex attributes, which dermis reads.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// A file whose structure is right: every property that is read has its type and range, every index resolves.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) root: Root,
    /// Bytes of each buffer; `None` where the file gives none (extensions may, dermis then refuses who asks).
    pub(super) buffers: Vec<Option<Vec<u8>>>,
    /// Bytes of accessors read so far.
    read: Cell<u64>,
}

impl Document {
    /// Reads a file, and what it names beside it.
    ///
    /// # Errors
    /// [`Error::File`] where the system refuses it; [`Error::Asset`] with a JSON pointer where its structure is wrong.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let bytes = container::read(path).map_err(|source| Error::file(path, source))?;
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        let document = Self::parse(&bytes, folder.unwrap_or(Path::new(".")));
        document.map_err(|fault| fault.with_path(path))
    }

    /// Reads the content of a file that lies in `folder`.
    pub(super) fn parse(bytes: &[u8], folder: &Path) -> Checked<Self> {
        let container = container::split(bytes)?;
        let value: Value = serde_json::from_slice(container.json)
            .map_err(|error| Fault::new("/", format!("not valid JSON: {error}")))?;
        let mut value = schema::sieve(value)?;
        check_version(&value["asset"])?;
        check_extensions(&value)?;
        disarm_channels(&mut value);
        let root = deserialize(value)?;
        let buffers = load_buffers(&root, &container, folder)?;
        Ok(Self {
            root,
            buffers,
            read: Cell::new(0),
        })
    }

    /// Counts bytes that an accessor is about to read. Accessors may share bytes or have none, so that a small file can
    /// ask for more than any machine has.
    pub(super) fn charge(&self, bytes: usize) -> Checked<()> {
        self.read.set(self.read.get().saturating_add(bytes as u64));
        if self.read.get() > READ_LIMIT {
            let limit = READ_LIMIT >> 20;
            return refuse(
                "/accessors",
                format!("reading them takes more than {limit} MiB"),
            );
        }
        Ok(())
    }
}

fn check_version(asset: &Value) -> Checked<()> {
    for property in ["version", "minVersion"] {
        let Some(version) = asset[property].as_str() else {
            continue;
        };
        let element = format!("/asset/{property}");
        let parts = version.split_once('.');
        let numbers = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        let Some((major, minor)): Option<(u32, u32)> = numbers else {
            return refuse(element, format!("{version:?} is not a version"));
        };
        // A file may be of any 2.x, but one that needs more than 2.0 says so in minVersion.
        if major != 2 || (property == "minVersion" && minor > 0) {
            return refuse(element, format!("glTF {version} is not supported"));
        }
    }
    Ok(())
}

fn check_extensions(root: &Value) -> Checked<()> {
    let names = |key: &str| -> Vec<String> {
        let items = root[key].as_array().into_iter().flatten();
        items.filter_map(Value::as_str).map(String::from).collect()
    };
    let used = names("extensionsUsed");
    for (row, name) in names("extensionsRequired").iter().enumerate() {
        let element = format!("/extensionsRequired/{row}");
        if !used.contains(name) {
            return refuse(element, format!("{name} is not in extensionsUsed"));
        }
        let harmless = HARMLESS
            .iter()
            .any(|&known| name == known || (known.ends_with('_') && name.starts_with(known)));
        if !harmless && name != QUANTIZATION {
            return refuse(
                element,
                format!("extension {name} is not supported{}", hint(name)),
            );
        }
    }
    Ok(())
}

fn hint(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" => " (Draco): export without mesh compression",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            " (meshopt): export without compression"
        }
        _ => "",
    }
}

/// A channel without a node drives nothing (glTF 2.0, 3.11) but the crate demands a node: give it a path that nobody reads.
fn disarm_channels(root: &mut Value) {
    let animations = root.get_mut("animations").and_then(Value::as_array_mut);
    for animation in animations.into_iter().flatten() {
        let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
        for channel in channels.into_iter().flatten() {
            let target = &mut channel["target"];
            if target["node"].is_null() {
                target["node"] = 0.into();
                target["path"] = "nothing".into();
            }
        }
    }
}

thread_local! {
    /// Whether a panic on this thread is caught and reported as an error of the file.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// The one call into the crate's parser; should it panic, that is an error of the file.
fn deserialize(value: Value) -> Checked<Root> {
    match quietly(|| json::deserialize::from_value(value)) {
        Some(Ok(root)) => Ok(root),
        Some(Err(error)) => refuse("/", error.to_string()),
        None => refuse("/", "the glTF parser gave up on it"),
    }
}

/// `None` where `call` panics, which prints nothing; panics of other threads are printed as ever.
fn quietly<T>(call: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                previous(info);
            }
        }));
    });
    QUIET.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call));
    QUIET.set(false);
    result.ok()
}

fn load_buffers(
    root: &Root,
    container: &Container<'_>,
    folder: &Path,
) -> Checked<Vec<Option<Vec<u8>>>> {
    let total: u64 = root.buffers.iter().map(|b| b.byte_length.0).sum();
    if total > BUFFER_LIMIT {
        return refuse("/buffers", format!("{total} bytes are too many"));
    }
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (row, buffer) in root.buffers.iter().enumerate() {
        let element = format!("/buffers/{row}");
        let bytes = match &buffer.uri {
            Some(uri) => Some(uri::resolve(uri, folder, &format!("{element}/uri"))?),
            None if row == 0 && container.is_glb => match container.binary {
                Some(binary) => Some(binary.to_vec()),
                None => return refuse(element, "the GLB has no binary chunk"),
            },
            None => None,
        };
        let length = buffer.byte_length.0;
        if let Some(bytes) = &bytes
            && (bytes.len() as u64) < length
        {
            let reason = format!("says {length} bytes, there are {}", bytes.len());
            return refuse(element, reason);
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn fault(json: &str) -> String {
        let fault = Document::parse(json.as_bytes(), Path::new(".")).unwrap_err();
        fault.with_path(Path::new("f")).to_string()
    }

    #[test]
    fn required_extensions_are_refused_by_name() {
        let json = |name| {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{name}"],"extensionsRequired":["{name}"]}}"#
            )
        };
        for name in [
            "KHR_draco_mesh_compression",
            "EXT_meshopt_compression",
            "ACME_x",
        ] {
            let message = fault(&json(name));
            assert!(message.contains(name), "{message}");
            assert!(message.contains("/extensionsRequired/0"), "{message}");
        }
        for name in [QUANTIZATION, "KHR_materials_unlit"] {
            assert!(Document::parse(json(name).as_bytes(), Path::new(".")).is_ok());
        }
    }

    #[test]
    fn errors_point_into_the_file() {
        let cases = [
            ("", "/: the file is empty"),
            ("[1]", "/: neither"),
            ("{", "/: not valid JSON"),
            ("{}", "/asset: missing"),
            ("{\"asset\":1}", "/asset: not an object"),
            (r#"{"asset":{"version":"1.0"}}"#, "/asset/version: glTF 1.0"),
            (
                r#"{"asset":{"version":"2.0"},"nodes":[{"children":[0,7]}]}"#,
                "/nodes/0/children/1: 7, but there are 1 nodes",
            ),
            (
                r#"{"asset":{"version":"2.0"},"nodes":[{"scale":[1,2,1e39]}]}"#,
                "/nodes/0/scale/2: not a number in range",
            ),
            (
                r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"data:;base64,AAA="}]}"#,
                "/buffers/0: says 4 bytes, there are 2",
            ),
        ];
        for (json, expected) in cases {
            let message = fault(json);
            assert!(message.contains(expected), "{json}: {message}");
        }
    }

    #[test]
    fn a_panic_of_the_parser_is_caught() {
        assert_eq!(quietly(|| 3), Some(3));
        assert_eq!(quietly(|| -> u32 { panic!("not to be seen") }), None);
        assert!(!QUIET.get());
    }

    #[test]
    fn deep_nesting_is_an_error_and_not_a_stack_overflow() {
        let json = format!("{{\"extras\":{}", "[".repeat(100_000));
        assert!(fault(&json).contains("recursion limit"));
    }
}
