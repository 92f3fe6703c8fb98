//! A pass has its three files, and every shader its SPIR-V.

use std::collections::BTreeSet;

use super::Tree;

/// Shaders that are no pass of a frame, with the reason why they need no twin.
const NO_PASS: &[(&str, &str)] = &[];

/// All findings about passes and shaders.
pub(crate) fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    let mut passes: BTreeSet<&str> = stems(tree, "shaders/", ".comp").collect();
    passes.extend(stems(tree, "src/pass/", ".rs"));
    for pass in passes
        .iter()
        .filter(|p| NO_PASS.iter().all(|(name, _)| name != *p))
    {
        let files = [
            format!("shaders/{pass}.comp"),
            format!("src/pass/{pass}.rs"),
            format!("src/twin/{pass}.rs"),
        ];
        for file in files.iter().filter(|f| tree.text(f).is_none()) {
            findings.push(format!("pass {pass}: {file} is missing"));
        }
    }
    for (extension, spirv) in [
        (".comp", ".spv"),
        (".vert", ".vert.spv"),
        (".frag", ".frag.spv"),
    ] {
        for shader in stems(tree, "shaders/", extension) {
            compiled(
                tree,
                &format!("{shader}{extension}"),
                &format!("{shader}{spirv}"),
                &mut findings,
            );
        }
    }
    findings
}

/// Names of the files of one folder that have the extension, without it.
fn stems<'a>(tree: &'a Tree, folder: &'a str, extension: &'a str) -> impl Iterator<Item = &'a str> {
    tree.files()
        .filter_map(move |(path, _)| path.strip_prefix(folder)?.strip_suffix(extension))
        .filter(|stem| !stem.contains('/') && *stem != "mod" && *stem != "tests")
}

fn compiled(tree: &Tree, shader: &str, spirv: &str, findings: &mut Vec<String>) {
    if tree.text(&format!("shaders/spirv/{spirv}")).is_none() {
        findings.push(format!(
            "shaders/{shader}: spirv/{spirv} is missing: run `cargo xtask shaders`"
        ));
    }
    let manifest = tree.text("shaders/spirv/manifest.txt").unwrap_or_default();
    if !manifest
        .lines()
        .any(|line| line.split(' ').next() == Some(shader))
    {
        findings.push(format!(
            "shaders/{shader}: not in the manifest: run `cargo xtask shaders`"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMPLETE: [(&str, &str); 7] = [
        ("shaders/relax.comp", ""),
        ("shaders/skin.frag", ""),
        ("shaders/spirv/manifest.txt", "relax.comp 1\nskin.frag 2\n"),
        ("shaders/spirv/relax.spv", ""),
        ("shaders/spirv/skin.frag.spv", ""),
        ("src/pass/relax.rs", ""),
        ("src/twin/relax.rs", ""),
    ];

    #[test]
    fn a_complete_pass_is_accepted() {
        assert_eq!(check(&Tree::of(&COMPLETE)), [""; 0]);
    }

    #[test]
    fn each_file_of_a_pass_is_needed() {
        for missing in [
            "shaders/relax.comp",
            "src/pass/relax.rs",
            "src/twin/relax.rs",
        ] {
            let rest: Vec<_> = COMPLETE
                .into_iter()
                .filter(|(path, _)| *path != missing)
                .collect();
            let findings = check(&Tree::of(&rest));
            assert!(
                findings.iter().any(|f| f.contains(missing)),
                "{missing}: {findings:?}"
            );
        }
    }

    #[test]
    fn spirv_and_manifest_are_needed() {
        for missing in ["shaders/spirv/relax.spv", "shaders/spirv/skin.frag.spv"] {
            let rest: Vec<_> = COMPLETE
                .into_iter()
                .filter(|(path, _)| *path != missing)
                .collect();
            assert_eq!(check(&Tree::of(&rest)).len(), 1, "{missing}");
        }
        let rest: Vec<_> = COMPLETE
            .into_iter()
            .filter(|(path, _)| !path.ends_with("txt"))
            .collect();
        assert_eq!(check(&Tree::of(&rest)).len(), 2);
    }
}
