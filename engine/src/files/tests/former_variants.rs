//! Variants of earlier versions: files that say them load, and nothing suggests them.

use super::*;
use crate::world::{LightBounds, LightCulling, StochasticLightCulling};

#[test]
fn variants_that_are_gone_load_as_those_that_stand_for_them() {
    let text = r#"Scene(entities: [(name: "A", slc: (culling: Splatting, bounds: EnclosingSphere)),
        (name: "B", slc: (culling: Clustered))])"#;
    let world = Folder::new(&[("a.scene.ron", text)]).load("a.scene.ron").unwrap();
    let [a, b] = ["A", "B"].map(|name| at(&world, name).unwrap());
    let slc = world.ecs.get::<StochasticLightCulling>(a).unwrap();
    assert_eq!((slc.culling, slc.bounds), (LightCulling::Tiled, LightBounds::CentredSphere));
    assert_eq!(world.ecs.get::<StochasticLightCulling>(b).unwrap().culling, LightCulling::Tiled);
}

/// They are read, and not offered: neither as what was meant nor in the list of what there is.
#[test]
fn variants_that_are_gone_are_not_suggested() {
    for (fields, help) in [
        ("slc: (culling: Clusterd)", "known here: `Tiled`, `None`"),
        ("slc: (bounds: EnclosingSpere)", "known here: `Ellipsoid`, `CentredSphere`"),
    ] {
        let text = format!(r#"Scene(entities: [(name: "A", {fields})])"#);
        let error = Folder::new(&[("a.scene.ron", &text)]).load("a.scene.ron").err().unwrap();
        assert_eq!(error.help.as_deref(), Some(help), "{error}");
    }
}
