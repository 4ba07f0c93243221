//! Models with one part that is off: they load, and a warning names the part.

use lightwell::assets::Gltf;
use std::path::Path;

#[test]
fn a_model_with_a_faulty_part_loads_with_a_warning_that_names_it() {
    let cases = [
        ("anim_no_node.glb", "channel"),
        ("anim_equal_times.glb", "several keys"),
        ("image_missing.glb", "image"),
        ("spot_equal.glb", "cone angles"),
    ];
    for (file, part) in cases {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/cases").join(file);
        let model = Gltf::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(!model.nodes.is_empty(), "{file}");
        let told = model.warnings.iter().chain(&model.faults);
        assert!(told.clone().any(|what| what.contains(part)), "{file}: {:?}", told.collect::<Vec<_>>());
    }
}
