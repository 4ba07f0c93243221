//! Variants of earlier versions: files that say them load, and nothing suggests them.

use super::*;
use crate::world::{InstantRadiosity, LightBounds, LightCulling, ParticleCasts, StochasticLightCulling};

#[test]
fn variants_that_are_gone_load_as_those_that_stand_for_them() {
    let text = r#"Scene(entities: [(name: "A", vpl: (casts: Bounds))])"#;
    let world = Folder::new(&[("a.scene.ron", text)]).load("a.scene.ron").unwrap();
    let entity = at(&world, "A").unwrap();
    assert_eq!(world.ecs.get::<InstantRadiosity>(entity).unwrap().casts, ParticleCasts::Hierarchy);
}

/// Light culling's rivals were gone for a time, and files that named them loaded as `Tiled` and `CentredSphere`. They name
/// what they say again.
#[test]
fn rivals_of_light_culling_are_what_their_names_say() {
    let text = r#"Scene(entities: [(name: "A", slc: (culling: Splatting, bounds: EnclosingSphere)),
        (name: "B", slc: (culling: Clustered, bounds: CentredSphere))])"#;
    let world = Folder::new(&[("a.scene.ron", text)]).load("a.scene.ron").unwrap();
    let found = ["A", "B"].map(|name| {
        let slc = world.ecs.get::<StochasticLightCulling>(at(&world, name).unwrap()).unwrap();
        (slc.culling, slc.bounds)
    });
    let a = (LightCulling::Splatting, LightBounds::EnclosingSphere);
    assert_eq!(found, [a, (LightCulling::Clustered, LightBounds::CentredSphere)]);
}

/// They are read, and not offered: neither as what was meant nor in the list of what there is.
#[test]
fn variants_that_are_gone_are_not_suggested() {
    let text = r#"Scene(entities: [(name: "A", vpl: (casts: Bound))])"#;
    let error = Folder::new(&[("a.scene.ron", text)]).load("a.scene.ron").err().unwrap();
    assert_eq!(error.help.as_deref(), Some("known here: `Hierarchy`, `BruteForce`"), "{error}");
}
