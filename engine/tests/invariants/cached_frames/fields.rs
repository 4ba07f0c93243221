//! Values for each field of the components that a frame depends on, in the text of scene files.

use lightwell::world::fields::ron_options;
use lightwell::world::fields::text::replace;
use lightwell::world::{
    Camera, Clpv, Fog, InstantRadiosity, Lens, Light, Particles, SceneSettings, StochasticLightCulling,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// A field as `component.field`, and its values. The first is that of the world before it is edited, or near it.
pub type Field = (&'static str, &'static [&'static str]);

/// Settings of cascaded light propagation volumes.
pub const CLPV: [Field; 26] = [
    ("clpv.transport", &["Sweep", "Diffusion"]),
    ("clpv.bounces", &["Converged", "Count(1)", "Count(2)"]),
    ("clpv.quality", &["Low", "Medium"]),
    ("clpv.placement", &["Fixed", "Camera(ahead: 0.5)", "Camera(ahead: 0.0)"]),
    ("clpv.gather_rays", &["Count(2)", "Count(0)", "Count(1)", "Paths(1)", "Auto"]),
    ("clpv.gather_points", &["Count(1)", "Count(0)", "Count(2)", "Auto"]),
    ("clpv.mirror_rays", &["Auto", "Count(0)", "Count(2)"]),
    ("clpv.gather_filter", &["8", "0", "3"]),
    ("clpv.vary_directions", &["false", "true"]),
    ("clpv.precision", &["Single", "Half"]),
    ("clpv.cascades", &["1", "2", "3"]),
    ("clpv.cells", &["(8, 8, 8)", "(6, 9, 7)"]),
    ("clpv.cell_size", &["Meters(0.6)", "Meters(0.45)", "Auto"]),
    ("clpv.steps", &["6", "0", "9"]),
    ("clpv.occlusion", &["true", "false"]),
    ("clpv.bounce", &["true", "false"]),
    ("clpv.blocker_scale", &["1.3333334", "1.0"]),
    ("clpv.camera_blockers", &["false", "true"]),
    ("clpv.gain", &["0.6666667", "1.0"]),
    ("clpv.border_fade", &["2.0", "0.0", "1.0"]),
    ("clpv.outside_fade", &["0.0", "2.0"]),
    ("clpv.formulas", &["Corrected", "Printed"]),
    ("clpv.gradient_damping", &["0.0", "2.0"]),
    ("clpv.gloss_march", &["Off", "InverseDistance", "InverseSquare"]),
    ("clpv.ambient_occlusion", &["0.0", "0.5", "0.2"]),
    ("clpv.rsm_samples", &["0", "200"]),
];

/// Settings of instant radiosity.
pub const VPL: [Field; 21] = [
    ("vpl.particles", &["16", "9", "1"]),
    ("vpl.candidates", &["1", "8"]),
    ("vpl.schedule", &["Report", "Keller"]),
    ("vpl.bounce", &["Diffuse", "Mirror"]),
    ("vpl.bounces", &["Converged", "Count(1)", "Count(0)"]),
    ("vpl.shading", &["Physical", "AsPublished"]),
    ("vpl.accumulation", &["Batched", "ByTheLetter"]),
    ("vpl.visibility", &["ShadowRays", "None"]),
    ("vpl.placement", &["Particles", "Rsm"]),
    ("vpl.view_driven", &["true", "false"]),
    ("vpl.near_bound", &["1.0", "0.0", "2.0"]),
    ("vpl.near_rays", &["4", "0", "1"]),
    ("vpl.near_filter", &["8", "0", "3"]),
    ("vpl.sequence", &["LowDiscrepancy", "Random"]),
    ("vpl.seed", &["0", "1"]),
    ("vpl.casts", &["Hierarchy", "BruteForce", "Bounds"]),
    ("vpl.shadow_lookup", &["Texels", "AsPublished"]),
    ("vpl.shadow_bias", &["1.0", "0.1"]),
    ("vpl.shadow_slope_bias", &["16.0", "1.0"]),
    ("vpl.shadow_samples", &["4", "1"]),
    ("vpl.shadow_offset", &["1.5", "0.3"]),
];

/// Settings of stochastic light culling.
pub const SLC: [Field; 11] = [
    ("slc.rsm_size", &["16", "8"]),
    ("slc.delta", &["Relative(3e-4)", "Relative(1e-2)", "Absolute(1e-3)"]),
    ("slc.bounds", &["Ellipsoid", "CentredSphere", "EnclosingSphere"]),
    ("slc.culling", &["Tiled", "Clustered", "Splatting", "None"]),
    ("slc.lobes", &["Both", "Diffuse", "Specular"]),
    ("slc.interleave", &["8", "4"]),
    ("slc.filter_radius", &["8", "0", "3"]),
    ("slc.visibility", &["None", "ShadowRays"]),
    ("slc.chances", &["Even", "Independent"]),
    ("slc.seed", &["0", "1"]),
    ("slc.show", &["Light", "Candidates", "FalsePositives"]),
];

/// Fields of a light.
pub const LIGHT: [Field; 8] = [
    (
        "light.kind",
        &[
            "Point",
            "Directional",
            "Spot(inner: 20.0, outer: 50.0)",
            "Sun(angle: 5.0)",
            "Sphere(radius: 0.2)",
            "Disc(radius: 0.3)",
            "Rectangle(width: 0.5, height: 0.3)",
            "Tube(length: 0.6, radius: 0.05)",
        ],
    ),
    ("light.color", &["(1.0, 1.0, 1.0)", "(0.2, 0.9, 0.5)", "(0.0, 0.0, 0.0)"]),
    ("light.intensity", &["3.0", "0.0", "6.0"]),
    ("light.range", &["None", "1.5", "0.7"]),
    ("light.casts_shadow", &["true", "false"]),
    ("light.indirect", &["true", "false"]),
    ("light.shadow_size", &["64", "32"]),
    ("light.rsm_size", &["16", "8"]),
];

/// Fields of the camera.
pub const CAMERA: [Field; 5] = [
    ("camera.projection", &["Perspective", "Orthographic(height: 2.0)"]),
    ("camera.fov", &["70.0", "40.0"]),
    ("camera.near", &["0.1", "0.2"]),
    ("camera.far", &["None", "3.0"]),
    ("camera.primary", &["true", "false"]),
];

/// Fields of the camera's lens.
pub const LENS: [Field; 8] = [
    ("lens.exposure", &["Scene", "Automatic", "Photographic(f_number: 2.0, shutter: 0.02, iso: 400.0)"]),
    ("lens.tone_map", &["Neutral", "AgX", "Reinhard"]),
    ("lens.depth_of_field", &["None", "(focus: 1.5, f_number: 0.2)", "(focus: 3.0, f_number: 0.2)"]),
    ("lens.bloom", &["None", "(scatter: 0.3)", "(scatter: 0.3, radius: 0.6)"]),
    ("lens.grading", &["None", "\"swapped\"", "\"dark\""]),
    ("lens.vignette", &["0.0", "0.5"]),
    ("lens.sharpening", &["0.0", "0.5"]),
    ("lens.grain", &["0.0", "0.1"]),
];

/// Fields of fog.
pub const FOG: [Field; 5] = [
    ("fog.shape", &["Everywhere", "Sphere(radius: 0.8)", "Box(size: (1.5, 1.0, 0.5))"]),
    ("fog.extinction", &["0.3", "0.0", "2.0"]),
    ("fog.albedo", &["(1.0, 1.0, 1.0)", "(0.9, 0.5, 0.2)", "(0.0, 0.0, 0.0)"]),
    ("fog.anisotropy", &["0.0", "0.7", "-0.4"]),
    ("fog.falloff", &["0.0", "2.0"]),
];

/// Fields of particles.
pub const PARTICLES: [Field; 13] = [
    ("particles.rate", &["20.0", "0.0", "7.3"]),
    ("particles.life", &["1.0", "0.5"]),
    ("particles.source", &["(0.3, 0.3, 0.3)", "(0.1, 0.5, 0.1)"]),
    ("particles.velocity", &["(0.0, 1.0, 0.0)", "(0.5, 0.5, 0.0)"]),
    ("particles.spread", &["30.0", "0.0"]),
    ("particles.speed_variation", &["0.5", "0.0"]),
    ("particles.gravity", &["(0.0, -1.0, 0.0)", "(0.0, 0.0, 0.0)"]),
    ("particles.radius", &["0.03", "0.06"]),
    ("particles.end_radius", &["0.01", "0.03"]),
    ("particles.color", &["(1.0, 1.0, 1.0)", "(0.1, 0.2, 1.0)"]),
    ("particles.end_color", &["(1.0, 0.2, 0.1)", "(1.0, 1.0, 1.0)"]),
    ("particles.radiance", &["40.0", "0.0", "80.0"]),
    ("particles.seed", &["0", "5"]),
];

/// Settings of the scene that its frames depend on.
pub const SCENE: [Field; 4] = [
    ("scene.sky", &["(0.0, 0.0, 0.0)", "(0.2, 0.2, 0.2)", "(0.1, 0.2, 0.4)"]),
    ("scene.sky_light", &["true", "false"]),
    ("scene.exposure", &["0.0", "1.0"]),
    ("scene.auto_exposure", &["false", "true"]),
];

/// Settings of the scene that are edited elsewhere, or that no frame depends on.
const OTHER_SCENE_FIELDS: [&str; 4] = ["environment", "move_speed", "duration", "frame_rate"];
/// Fields of the camera that have a separate table.
const OTHER_CAMERA_FIELDS: [&str; 1] = ["lens"];

/// The component with one field replaced.
pub fn with_field<C: Serialize + DeserializeOwned>(component: &C, field: &str, value: &str) -> C {
    let text = ron_options().to_string(component).expect("components are written");
    // A field that is not written has its default.
    let text = replace(&text, &[field], value).unwrap_or_else(|_| text.replacen('(', &format!("({field}:{value},"), 1));
    ron_options().from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Names of the fields of a structure, from its debug form.
pub fn names(structure: &impl Debug) -> Vec<String> {
    let text = format!("{structure:#?}");
    let fields = text.lines().filter_map(|line| line.strip_prefix("    ")).filter(|line| !line.starts_with(' '));
    fields.filter_map(|line| line.split_once(": ")).map(|(name, _)| name.to_owned()).collect()
}

/// Asserts that the table has all fields of the component, each with values that differ and that are read.
fn assert_complete<C>(table: &[Field], component: &C, elsewhere: &[&str])
where
    C: Serialize + DeserializeOwned + PartialEq + Debug,
{
    let expected: Vec<String> =
        names(component).into_iter().filter(|name| !elsewhere.contains(&name.as_str())).collect();
    let listed: Vec<&str> = table.iter().filter_map(|(path, _)| path.split_once('.')).map(|(_, f)| f).collect();
    assert_eq!(listed, expected, "each field of a component has values that random edits choose from");
    for (path, values) in table {
        let (_, field) = path.split_once('.').expect("a component and a field");
        let edited: Vec<C> = values.iter().map(|value| with_field(component, field, value)).collect();
        assert!(edited.len() > 1, "{path} has one value");
        for (index, one) in edited.iter().enumerate() {
            assert!(!edited[index + 1..].contains(one), "{path} has a value twice");
            assert_eq!(with_field(one, field, values[0]), edited[0], "{path}: the value comes back");
        }
    }
}

#[test]
fn every_field_of_every_component_is_edited() {
    assert_complete(&CLPV, &Clpv::default(), &[]);
    assert_complete(&VPL, &InstantRadiosity::default(), &[]);
    assert_complete(&SLC, &StochasticLightCulling::default(), &[]);
    assert_complete(&LIGHT, &Light::default(), &[]);
    assert_complete(&CAMERA, &Camera::default(), &OTHER_CAMERA_FIELDS);
    assert_complete(&LENS, &Lens::default(), &[]);
    assert_complete(&FOG, &Fog::default(), &[]);
    assert_complete(&PARTICLES, &Particles::default(), &[]);
    assert_complete(&SCENE, &SceneSettings::default(), &OTHER_SCENE_FIELDS);
}
