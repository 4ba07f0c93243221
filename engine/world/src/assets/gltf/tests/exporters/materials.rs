//! Materials, textures and images.

use super::*;

const BASE: &str = "/materials/0/pbrMetallicRoughness/";

#[test]
fn materials() {
    let base = |name: &str| -> &'static str { Box::leak(format!("{BASE}{name}").into_boxed_str()) };
    check(vec![
        (
            "a mode in another case",
            vec![Set("/materials/0/alphaMode", "\"mask\"")],
            Mended(&[], &["material 0", "MASK"]),
        ),
        ("both sides as a number", vec![Set("/materials/0/doubleSided", "1")], Mended(&[], &["material 0", "true"])),
        (
            "both sides as a text",
            vec![Set("/materials/0/doubleSided", "\"true\"")],
            Mended(&[], &["material 0", "true"]),
        ),
        (
            "a colour without alpha",
            vec![Set(base("baseColorFactor"), "[0.5, 0.25, 1]")],
            Mended(&[], &["material 0", "no alpha"]),
        ),
        (
            "emission with alpha",
            vec![Set("/materials/0/emissiveFactor", "[0, 0.5, 1, 1]")],
            Mended(&[], &["material 0", "4 numbers"]),
        ),
        (
            "emission above one",
            vec![Set("/materials/0/emissiveFactor", "[0, 5, 10]")],
            Read(&[Set("/materials/0/emissiveFactor", "[0, 5, 10]")]),
        ),
        (
            "a factor above one",
            vec![Set(base("metallicFactor"), "7")],
            Mended(&[Set("/materials/0/pbrMetallicRoughness/metallicFactor", "1")], &["material \"paint\"", "clamped"]),
        ),
        ("a factor that is null", vec![Set(base("roughnessFactor"), "null")], Read(&[])),
        (
            "a cutoff of another mode",
            vec![Set("/materials/0/alphaMode", "\"OPAQUE\""), Set("/materials/0/alphaCutoff", "0.7")],
            Read(&[Set("/materials/0/alphaMode", "null")]),
        ),
        (
            "a material of -1",
            vec![Set("/meshes/0/primitives/0/material", "-1")],
            Mended(&[Set("/meshes/0/primitives/0/material", "null")], &["none"]),
        ),
        ("extras of textures", vec![Set(base("baseColorTexture/extras"), "[1]")], Read(&[])),
    ]);
}

#[test]
fn textures() {
    const INFO: &str = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions";
    const TRANSFORM: &str = r#"{"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}"#;
    const DRAFT: &str = r#"{"EXT_texture_transform": {"offset": [0.5, 0], "scale": [2, 2]}}"#;
    const BOTH: &[Edit] = &[Set(INFO, TRANSFORM), Set("/materials/0/normalTexture/extensions", TRANSFORM)];
    check(vec![
        (
            "the draft of transforms",
            vec![Set(INFO, DRAFT)],
            Mended(&[Set(INFO, TRANSFORM)], &["EXT_texture_transform", "draft"]),
        ),
        (
            "a transform of the texture",
            vec![Set("/textures/0/extensions", TRANSFORM)],
            Mended(BOTH, &["texture 0", "moved"]),
        ),
        ("a transform of no numbers", vec![Set(INFO, r#"{"KHR_texture_transform": {}}"#)], Read(&[])),
        ("a sampler of -1", vec![Set("/textures/0/sampler", "-1")], Mended(&[], &["texture 0", "none"])),
        (
            "a sampler of no names",
            vec![Set("/samplers/0", r#"{"magFilter": 0, "wrapS": 0}"#)],
            Mended(&[], &["sampler 0"]),
        ),
        (
            "a texture of -1",
            vec![Set("/materials/0/normalTexture/index", "-1")],
            Mended(&[Set("/materials/0/normalTexture", "null")], &["normalTexture"]),
        ),
        ("a source that is not there", vec![Set("/textures/0/source", "5")], Warned(&["texture 0", "image 5"])),
    ]);
}

#[test]
fn images() {
    let jpeg = {
        let mut out = std::io::Cursor::new(Vec::new());
        let grey = image::GrayImage::from_pixel(3, 2, image::Luma([128]));
        grey.write_to(&mut out, image::ImageFormat::Jpeg).unwrap();
        out.into_inner()
    };
    let model = load_edited(&[Bytes(IMAGE, jpeg)]).unwrap();
    let texture = model.nodes[0].primitives[0].1.base_color_texture.clone().unwrap();
    assert!(model.faults.is_empty() && texture.rgba[0].abs_diff(128) < 2, "{:?}", model.faults);
    check(vec![
        ("no media type", vec![Set("/images/0/mimeType", "null")], Read(&[])),
        ("another media type", vec![Set("/images/0/mimeType", "\"image/jpeg\"")], Read(&[])),
        ("a media type that is none", vec![Set("/images/0/mimeType", "\"image/jpg\"")], Read(&[])),
        ("a media type that is a number", vec![Set("/images/0/mimeType", "5")], Mended(&[], &["image 0"])),
        (
            "a file that is not there, and a view",
            vec![Set("/images/0/uri", "\"gone.png\"")],
            Mended(&[], &["gone.png", "buffer view is read"]),
        ),
        (
            "an empty name of a file, and a view",
            vec![Set("/images/0/uri", "\"\"")],
            Mended(&[], &["image 0", "buffer view is read"]),
        ),
        ("an image of no bytes", vec![Bytes(IMAGE, Vec::new())], Warned(&["image 0", "empty"])),
        ("an image that ends early", vec![Bytes(IMAGE, png(3, 2)[..50].to_vec())], Warned(&["image 0", "decoded"])),
        (
            "an image of another kind",
            vec![Bytes(IMAGE, b"DDS |\0\0\0".to_vec())],
            Warned(&["image 0", "not supported"]),
        ),
        ("a view of an image with a stride", vec![Set("/bufferViews/14/byteStride", "4")], Read(&[])),
    ]);
}

/// `KHR_materials_pbrSpecularGlossiness`, as its specification gives it, is a dielectric of that reflectance.
#[test]
fn specular_and_gloss() {
    let load_one = |fields: &str| {
        let extension = format!(r#"{{"KHR_materials_pbrSpecularGlossiness": {{{fields}}}}}"#);
        let extension: &'static str = Box::leak(extension.into_boxed_str());
        let edits = [Set("/materials/0/extensions", extension), Set("/materials/0/pbrMetallicRoughness", "null")];
        let needs = Set("/extensionsRequired", r#"["KHR_materials_pbrSpecularGlossiness"]"#);
        let used = Set("/extensionsUsed", r#"["KHR_materials_pbrSpecularGlossiness"]"#);
        let model = load_edited(&[&edits[..], &[needs, used]].concat()).unwrap();
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        model.nodes[0].primitives[0].1.clone()
    };
    let gold = load_one(
        r#""diffuseFactor": [0.25, 0.5, 0, 0.75], "specularFactor": [1, 0.75, 0.25], "glossinessFactor": 0.75"#,
    );
    assert_eq!((gold.base_color.to_array(), gold.metallic, gold.roughness), ([0.25, 0.5, 0.0, 0.75], 0.0, 0.25));
    assert!((gold.dielectric_reflectance() * 0.04 - Vec3::new(1.0, 0.75, 0.25)).length() < 1e-6);
    assert_eq!((gold.specular, gold.alpha_mode, gold.double_sided), (1.0, AlphaMode::Mask(0.5), true));
    let usual = load_one("");
    assert_eq!((usual.base_color.to_array(), usual.roughness), ([1.0; 4], 0.0));
    assert!((usual.dielectric_reflectance() * 0.04 - Vec3::ONE).length() < 1e-6);

    let mapped = load_one(
        r#""diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 0, "extensions":
            {"KHR_texture_transform": {"scale": [2, 2]}}}, "glossinessFactor": 0.6"#,
    );
    let [base, specular, roughness] =
        [&mapped.base_color_texture, &mapped.specular_color_texture, &mapped.metallic_roughness_texture]
            .map(|texture| texture.clone().unwrap());
    assert!(Arc::ptr_eq(&base, &specular) && base.srgb && !roughness.srgb);
    // The image has an alpha of 1, so that gloss is the factor.
    assert_eq!((roughness.width, roughness.height, &roughness.rgba[..4]), (3, 2, &[0, 102, 0, 255][..]));
    assert_eq!((mapped.roughness, mapped.metallic), (1.0, 0.0));
    assert_eq!(
        (mapped.uv.specular_color, mapped.uv.metallic_roughness.transform.matrix2.x_axis.x),
        (mapped.uv.metallic_roughness, 2.0)
    );
}
