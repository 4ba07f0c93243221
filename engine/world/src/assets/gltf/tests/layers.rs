//! Clear coats, sheen, anisotropy, films and dispersion.

use super::*;
use crate::assets::{Anisotropy, Clearcoat, Iridescence, Material, Sheen};
use glam::Affine2;

/// A square with a material of these extensions, and one texture.
fn square(extensions: &str) -> String {
    let mut bytes = square_bytes();
    let picture = png(3, 2);
    bytes.extend(&picture);
    let views =
        VIEWS.replace("12}]", &format!("12}},{{\"buffer\":0,\"byteOffset\":92,\"byteLength\":{}}}]", picture.len()));
    let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
    let rest = format!(
        r#""extensionsUsed":["KHR_materials_clearcoat"],"extensionsRequired":["KHR_materials_clearcoat"],
        "images":[{{"bufferView":3,"mimeType":"image/png"}}],"textures":[{{"source":0}}],
        "materials":[{{"name":"m","extensions":{{{extensions}}}}}],"nodes":[{{"mesh":0}}]"#
    );
    document(&bytes, &[&views, ACCESSORS, &mesh, &rest])
}

fn material(extensions: &str) -> (Arc<Material>, Vec<String>) {
    let model = load(&square(extensions)).unwrap();
    (model.nodes[0].primitives[0].1.clone(), model.warnings)
}

#[test]
fn layers_are_read_with_their_textures() {
    let (coated, warnings) = material(
        r#""KHR_materials_clearcoat":{"clearcoatFactor":0.75,"clearcoatRoughnessFactor":0.25,"clearcoatTexture":{"index":0},
        "clearcoatRoughnessTexture":{"index":0,"texCoord":1},"clearcoatNormalTexture":{"index":0,"scale":0.5,
        "extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"scale":[2,4]}}}}"#,
    );
    let is_missed = |warning: &String| warning.contains("needs TEXCOORD_1, which is missing; TEXCOORD_0 is taken");
    assert!(warnings.len() == 1 && is_missed(&warnings[0]), "{warnings:?}");
    assert_eq!(coated.clearcoat, Clearcoat { factor: 0.75, roughness: 0.25, normal_scale: 0.5 });
    assert!(coated.clearcoat_texture.is_some() && coated.clearcoat_normal_texture.is_some());
    assert_eq!((coated.uv.clearcoat.set, coated.uv.clearcoat_roughness.set), (0, 1));
    let moved = Affine2::from_scale_angle_translation([2.0, 4.0].into(), 0.0, [0.5, 0.25].into());
    assert_eq!(coated.uv.clearcoat_normal.transform, moved);
    assert!(coated.has_layers() && !coated.is_plain());

    let (velvet, _) = material(
        r#""KHR_materials_sheen":{"sheenColorFactor":[0.5,0.25,1],"sheenRoughnessFactor":0.5,"sheenColorTexture":{"index":0},
        "sheenRoughnessTexture":{"index":0}}"#,
    );
    assert_eq!(velvet.sheen, Sheen { color: Vec3::new(0.5, 0.25, 1.0), roughness: 0.5 });
    assert!(velvet.sheen_color_texture.as_ref().unwrap().srgb);
    assert!(!velvet.sheen_roughness_texture.as_ref().unwrap().srgb);

    let (brushed, _) = material(
        r#""KHR_materials_anisotropy":{"anisotropyStrength":0.5,"anisotropyRotation":1.5,"anisotropyTexture":{"index":0}}"#,
    );
    assert_eq!(brushed.anisotropy, Anisotropy { strength: 0.5, rotation: 1.5 });
    assert!(!brushed.anisotropy_texture.as_ref().unwrap().srgb);

    let (film, _) = material(
        r#""KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceIor":1.5,"iridescenceThicknessMaximum":800,
        "iridescenceTexture":{"index":0},"iridescenceThicknessTexture":{"index":0}}"#,
    );
    assert_eq!(film.iridescence, Iridescence { factor: 1.0, ior: 1.5, least_thickness: 100.0, thickness: 800.0 });
    assert!(film.iridescence_texture.is_some() && film.iridescence_thickness_texture.is_some());

    let (prism, _) = material(r#""KHR_materials_dispersion":{"dispersion":0.5}"#);
    assert_eq!(prism.dispersion, 0.5);
}

#[test]
fn layers_are_none_where_nothing_is_said() {
    let (plain, _) =
        material(r#""KHR_materials_clearcoat":{},"KHR_materials_sheen":{},"KHR_materials_iridescence":{}"#);
    let none = Material::new("none");
    assert_eq!((plain.clearcoat, plain.sheen), (none.clearcoat, none.sheen));
    assert_eq!((plain.anisotropy, plain.iridescence, plain.dispersion), (none.anisotropy, none.iridescence, 0.0));
    assert!(!plain.has_layers());
    let (unlit, _) = material(
        r#""KHR_materials_unlit":{},"KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatTexture":{"index":0}}"#,
    );
    assert!(!unlit.has_layers() && unlit.clearcoat_texture.is_none() && unlit.unlit);
}

#[test]
fn layers_out_of_range_are_brought_back() {
    let (m, warnings) = material(
        r#""KHR_materials_clearcoat":{"clearcoatFactor":7,"clearcoatRoughnessFactor":-1},
        "KHR_materials_sheen":{"sheenColorFactor":[1e99,0.5,-3]},"KHR_materials_iridescence":{"iridescenceIor":0.2}"#,
    );
    assert_eq!((m.clearcoat.factor, m.clearcoat.roughness), (1.0, 0.0));
    assert_eq!((m.sheen.color, m.iridescence.ior), (Vec3::new(1.0, 0.5, 0.0), 1.0));
    assert!(warnings.iter().any(|warning| warning.contains("out of range")), "{warnings:?}");
}

#[test]
fn textures_of_layers_that_are_not_there_are_ignored() {
    for texture in [r#"{"index":3}"#, "{}", r#"{"index":-1}"#] {
        let extension = format!(r#""KHR_materials_sheen":{{"sheenColorTexture":{texture}}}"#);
        let model = load(&square(&extension)).unwrap();
        let words = ["material 0", "KHR_materials_sheen", "sheenColorTexture", "ignored"];
        assert!(words.iter().all(|word| model.faults[0].contains(word)), "{:?}", model.faults);
    }
}

/// A mesh without tangents gets some where highlights are stretched.
#[test]
fn stretched_highlights_have_tangents() {
    let tangents = |extensions: &str| {
        let model = load(&square(extensions)).unwrap();
        model.nodes[0].primitives[0].0.vertices.iter().map(|vertex| vertex.tangent).collect::<Vec<_>>()
    };
    for tangent in tangents(r#""KHR_materials_anisotropy":{"anisotropyStrength":0.5}"#) {
        // Along u, which runs along x.
        assert!((tangent[0] - 1.0).abs() < 1e-4 && tangent[3].abs() == 1.0, "{tangent:?}");
    }
}
