//! Variants that were gone for a time: files that say them load as what their names say.

use super::*;
use crate::world::{InstantRadiosity, LightBounds, LightCulling, ParticleCasts, StochasticLightCulling};

#[test]
fn variants_that_came_back_are_what_their_names_say() {
    let text = r#"Scene(entities: [(name: "A", slc: (culling: Splatting, bounds: EnclosingSphere)),
        (name: "B", slc: (culling: Clustered, bounds: CentredSphere)), (name: "C", vpl: (casts: Bounds))])"#;
    let world = Folder::new(&[("a.scene.ron", text)]).load("a.scene.ron").unwrap();
    let found = ["A", "B"].map(|name| {
        let slc = world.ecs.get::<StochasticLightCulling>(at(&world, name).unwrap()).unwrap();
        (slc.culling, slc.bounds)
    });
    let a = (LightCulling::Splatting, LightBounds::EnclosingSphere);
    assert_eq!(found, [a, (LightCulling::Clustered, LightBounds::CentredSphere)]);
    let casts = world.ecs.get::<InstantRadiosity>(at(&world, "C").unwrap()).unwrap().casts;
    assert_eq!(casts, ParticleCasts::Bounds);
}
