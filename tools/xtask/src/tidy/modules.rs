//! Who may use whom: the table of modules, the crates with a single user, and where `unsafe` may stand.

use super::{
    Tree,
    code::{bare, line, without_tests, words},
};

/// For each module those it may use; `error` and `report` are open to all.
const MODULES: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("report", &[]),
    ("asset", &[]),
    ("mesh", &[]),
    ("compose", &[]),
    ("flesh", &[]),
    // The skeleton that a field is fitted to is one of the rig's raw types.
    ("field", &["mesh", "rig", "layout"]),
    ("rig", &["asset", "mesh", "field", "compose", "flesh"]),
    ("sphere_mesh", &["mesh", "asset", "layout"]),
    ("layout", &[]),
    ("gpu", &[]),
    // The method's constants, which a pass hands to its shader.
    ("pass", &["layout", "gpu", "field"]),
    (
        "twin",
        &["layout", "pass", "rig", "mesh", "compose", "field", "flesh"],
    ),
    ("frame", &["gpu", "pass"]),
    (
        "deformer",
        &[
            "rig", "frame", "gpu", "pass", "twin", "layout", "mesh", "field", "compose",
        ],
    ),
    (
        "particles",
        &[
            "sphere_mesh",
            "deformer",
            "frame",
            "gpu",
            "pass",
            "twin",
            "layout",
        ],
    ),
    ("render", &["gpu", "sphere_mesh"]),
    (
        "capi",
        &[
            "asset",
            "mesh",
            "compose",
            "flesh",
            "field",
            "rig",
            "sphere_mesh",
            "gpu",
            "deformer",
            "particles",
            "render",
        ],
    ),
];

/// Modules that every module may use.
const OPEN: [&str; 2] = ["error", "report"];

/// Crates with one user.
const SOLE_USER: [(&str, &str); 2] = [("gltf", "src/asset/"), ("gpu_allocator", "src/gpu/")];

/// Where `unsafe` may stand.
const UNSAFE: [&str; 2] = ["src/gpu/", "src/capi/"];

/// All findings about modules.
pub(crate) fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, source) in tree.rust() {
        let code = bare(without_tests(path, source));
        table(path, &code, &mut findings);
        sole_user(path, &code, &mut findings);
        unsafe_code(path, &code, &mut findings);
    }
    findings
}

/// The module that a file of the library belongs to.
fn module(path: &str) -> Option<&str> {
    let inner = path.strip_prefix("src/")?;
    let name = inner.split('/').next().unwrap_or(inner);
    let name = name.strip_suffix(".rs").unwrap_or(name);
    (name != "lib").then_some(name)
}

fn table(path: &str, code: &str, findings: &mut Vec<String>) {
    let Some(user) = module(path) else { return };
    let Some((_, allowed)) = MODULES.iter().find(|(name, _)| *name == user) else {
        findings.push(format!(
            "{path}: module {user} is not in the table of modules"
        ));
        return;
    };
    let known = |name: &str| MODULES.iter().any(|(n, _)| *n == name);
    for (at, used) in uses(path, code) {
        let fine = used == user || OPEN.contains(&used) || allowed.contains(&used) || !known(used);
        if !fine {
            findings.push(format!(
                "{path}:{}: {user} may not use {used}",
                line(code, at)
            ));
        }
    }
}

/// First names of all paths that start at the crate's root, with their positions.
fn uses<'a>(path: &str, code: &'a str) -> Vec<(usize, &'a str)> {
    // `super` of a module's own file is the root as well.
    let depth = path.matches('/').count() - usize::from(path.ends_with("/mod.rs"));
    let root = "super::".repeat(depth);
    let mut found = Vec::new();
    for prefix in ["crate::", &root] {
        for (at, _) in code.match_indices(prefix) {
            let stands_alone =
                !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
            if stands_alone {
                names(code, at + prefix.len(), &mut found);
            }
        }
    }
    found
}

/// The name at `at`, or the first names within the braces there.
fn names<'a>(code: &'a str, at: usize, found: &mut Vec<(usize, &'a str)>) {
    let rest = &code[at..];
    if !rest.starts_with('{') {
        found.push((at, name(rest)));
        return;
    }
    let mut depth = 0;
    for (i, c) in rest.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return;
        }
        if depth == 1 && (c == ',' || i == 0) {
            let item = rest[i + 1..].trim_start();
            found.push((code.len() - item.len(), name(item)));
        }
    }
}

fn name(text: &str) -> &str {
    let end = text
        .find(|c: char| !c.is_alphanumeric() && c != '_')
        .unwrap_or(text.len());
    &text[..end]
}

fn sole_user(path: &str, code: &str, findings: &mut Vec<String>) {
    for (name, home) in SOLE_USER {
        let foreign = words(code, name).find(|at| {
            let root = !code[..*at].ends_with("::") || code[..*at].ends_with("{::");
            let used = code[at + name.len()..].starts_with("::") || code[..*at].ends_with("use ");
            root && used
        });
        if let Some(at) = foreign.filter(|_| !path.starts_with(home)) {
            findings.push(format!(
                "{path}:{}: only {home} uses {name}",
                line(code, at)
            ));
        }
    }
}

fn unsafe_code(path: &str, code: &str, findings: &mut Vec<String>) {
    if UNSAFE.iter().any(|home| path.starts_with(home)) {
        return;
    }
    if let Some(at) = words(code, "unsafe").next() {
        findings.push(format!(
            "{path}:{}: unsafe outside {}",
            line(code, at),
            UNSAFE.join(", ")
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(path: &str, source: &str) -> Vec<String> {
        check(&Tree::of(&[(path, source)]))
    }

    fn rejected(path: &str, source: &str) {
        assert_eq!(
            findings(path, source).len(),
            1,
            "{path}: {source}: {:?}",
            findings(path, source)
        );
    }

    fn accepted(path: &str, source: &str) {
        assert_eq!(findings(path, source), [""; 0], "{path}: {source}");
    }

    #[test]
    fn the_twin_never_uses_the_gpu() {
        rejected("src/twin/project.rs", "use crate::gpu::Gpu;");
        rejected(
            "src/twin/project.rs",
            "use crate::{\n    mesh::Csr,\n    gpu::{Gpu, Buffer},\n};",
        );
        rejected(
            "src/twin/project.rs",
            "fn f() { let g = crate::gpu::Gpu::new(); }",
        );
        rejected("src/twin/project.rs", "use super::super::gpu::Gpu;");
        rejected("src/twin/mod.rs", "use super::gpu::Gpu;");
        accepted(
            "src/twin/project.rs",
            "use crate::{mesh::Csr, layout};\nuse super::skin;",
        );
        accepted(
            "src/twin/project.rs",
            "//! Unlike crate::gpu.\n#[cfg(test)]\nmod tests { use crate::gpu; }",
        );
    }

    #[test]
    fn the_gpu_uses_nothing_of_the_domain() {
        for name in [
            "asset", "mesh", "rig", "field", "compose", "pass", "twin", "deformer", "render",
        ] {
            rejected(
                "src/gpu/memory.rs",
                &format!("use crate::{{error::Error, {name}}};"),
            );
        }
        accepted(
            "src/gpu/memory.rs",
            "use crate::{Error, Result, report::MemoryReport};",
        );
    }

    #[test]
    fn nobody_uses_capi() {
        for (user, _) in MODULES.iter().filter(|(user, _)| *user != "capi") {
            rejected(&format!("src/{user}/mod.rs"), "use crate::capi;");
        }
        accepted("src/capi/mod.rs", "use crate::deformer;");
    }

    #[test]
    fn every_module_is_in_the_table() {
        rejected("src/novelty/mod.rs", "");
        rejected("src/novelty.rs", "");
    }

    #[test]
    fn crates_with_one_user_keep_it() {
        rejected("src/rig/mod.rs", "use gltf::Gltf;");
        rejected("tools/cli/src/main.rs", "fn f() { gltf::import(path); }");
        rejected("src/frame/mod.rs", "use gpu_allocator::vulkan;");
        accepted("src/asset/import.rs", "use gltf::Gltf;");
        accepted("src/gpu/memory.rs", "use gpu_allocator::vulkan;");
        accepted(
            "src/rig/mod.rs",
            "fn gltf() { dermis::asset::gltf::read() } // use gltf::Gltf",
        );
    }

    #[test]
    fn unsafe_stands_in_the_gpu_module_only() {
        rejected("src/mesh/mod.rs", "fn f() { unsafe { g() } }");
        rejected("tools/cli/src/main.rs", "unsafe impl Send for A {}");
        accepted("src/gpu/memory.rs", "fn f() { unsafe { g() } }");
        accepted("src/mesh/mod.rs", "// unsafe\nconst S: &str = \"unsafe\";");
    }
}
