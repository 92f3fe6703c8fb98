use super::*;
use crate::gpu::{Binding, testing};

const ADD: Declaration = Declaration {
    name: "add",
    spirv: include_bytes!("testdata/add.spv"),
    bindings: &[
        Binding {
            name: "source",
            access: Access::Read,
        },
        Binding {
            name: "target",
            access: Access::Write,
        },
    ],
    constants: 8,
    local_size: [64, 1, 1],
};

/// What `check` says about `ADD`'s shader and another declaration of it.
fn refusal(declaration: Declaration) -> String {
    let words = spirv::words(ADD.spirv).unwrap();
    check(&declaration, &spirv::reflect(&words).unwrap()).unwrap_err()
}

fn agrees_with(bytes: &[u8], declared: Access) -> bool {
    let words = spirv::words(bytes).unwrap();
    agrees(declared, &spirv::reflect(&words).unwrap().bindings[0])
}

#[test]
fn a_true_declaration_passes() {
    let words = spirv::words(ADD.spirv).unwrap();
    check(&ADD, &spirv::reflect(&words).unwrap()).unwrap();
}

#[test]
fn every_wrong_declaration_is_refused_by_what_is_wrong() {
    let local = refusal(Declaration {
        local_size: [32, 1, 1],
        ..ADD
    });
    assert!(
        local.contains("[32, 1, 1]") && local.contains("[64, 1, 1]"),
        "{local}"
    );
    let short = refusal(Declaration {
        constants: 4,
        ..ADD
    });
    assert!(
        short.contains("4 bytes") && short.contains("has 8"),
        "{short}"
    );
    let long = refusal(Declaration {
        constants: 20,
        ..ADD
    });
    assert!(long.contains("20 bytes"), "{long}");
    let few = refusal(Declaration {
        bindings: &ADD.bindings[..1],
        ..ADD
    });
    assert!(few.contains("binding 1 is not declared"), "{few}");
    let third = Binding {
        name: "third",
        access: Access::Read,
    };
    let bindings: &'static [Binding] =
        Box::leak(Box::new([ADD.bindings[0], ADD.bindings[1], third]));
    let many = refusal(Declaration { bindings, ..ADD });
    assert!(
        many.contains("binding 2 (third)") && many.contains("lacks"),
        "{many}"
    );
    let swapped: &'static [Binding] = Box::leak(Box::new([ADD.bindings[1], ADD.bindings[0]]));
    let swapped = refusal(Declaration {
        bindings: swapped,
        ..ADD
    });
    assert!(
        swapped.contains("declared Write") && swapped.contains("readonly Storage"),
        "{swapped}"
    );
}

#[test]
fn each_kind_of_binding_agrees_with_its_own_access_only() {
    let shaders: [(&[u8], Access); 7] = [
        (include_bytes!("testdata/add.spv"), Access::Read),
        (include_bytes!("testdata/double.spv"), Access::ReadWrite),
        (include_bytes!("testdata/extent.spv"), Access::Uniform),
        (include_bytes!("testdata/texels.spv"), Access::Texels),
        (include_bytes!("testdata/words.spv"), Access::Words),
        (include_bytes!("testdata/sample.spv"), Access::Sampled),
        (include_bytes!("testdata/paint.spv"), Access::ImageWrite),
    ];
    let all = [
        Access::Read,
        Access::Write,
        Access::ReadWrite,
        Access::Uniform,
        Access::Texels,
        Access::Words,
        Access::Sampled,
        Access::ImageWrite,
    ];
    for (bytes, own) in shaders {
        for declared in all {
            assert_eq!(
                agrees_with(bytes, declared),
                declared == own,
                "{declared:?} {own:?}"
            );
        }
    }
}

#[test]
fn constants_may_be_padded_to_sixteen_and_no_further() {
    assert!(check_constants(20, 20).is_ok() && check_constants(32, 20).is_ok());
    assert!(check_constants(36, 20).is_err() && check_constants(16, 20).is_err());
    assert!(check_constants(132, 132).is_err() && check_constants(0, 0).is_ok());
}

#[test]
fn pipelines_are_made_once_and_names_are_unique() {
    let Some(gpu) = testing::gpu() else { return };
    let first = gpu.shared.pipeline(&ADD, 0).unwrap();
    let second = gpu.shared.pipeline(&ADD, 0).unwrap();
    assert!(Arc::ptr_eq(&first, &second));
    let other = Declaration {
        spirv: include_bytes!("testdata/double.spv"),
        ..ADD
    };
    let error = gpu.shared.pipeline(&other, 0).err().unwrap().to_string();
    assert!(
        error.contains("add") && error.contains("same name"),
        "{error}"
    );
}
