//! Images of textures, and how they are sampled.

use super::*;

#[test]
fn images_of_extensions_come_before_plain_ones() {
    let ktx2 = include_bytes!("../../../../../tests/data/gradient_uastc.ktx2");
    let webp = include_bytes!("../../../../../tests/data/gradient.webp");
    for (name, kind, image) in [("KHR_texture_basisu", "ktx2", &ktx2[..]), ("EXT_texture_webp", "webp", &webp[..])] {
        let mut bytes = square_bytes();
        bytes.extend(image);
        let views =
            VIEWS.replace("12}]", &format!("12}},{{\"buffer\":0,\"byteOffset\":92,\"byteLength\":{}}}]", image.len()));
        let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
        let of = |plain: &str| {
            let rest = format!(
                r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],"images":[{{"bufferView":3,"mimeType":"image/{kind}"}},
                {{"uri":"missing.png"}}],"textures":[{{{plain}"extensions":{{"{name}":{{"source":0}}}}}}],
                "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],"nodes":[{{"mesh":0}}]"#
            );
            load(&document(&bytes, &[&views, ACCESSORS, &mesh, &rest])).unwrap()
        };
        for model in [of(""), of("\"source\":1,")] {
            let texture = model.nodes[0].primitives[0].1.base_color_texture.clone().unwrap();
            assert_eq!((texture.width, texture.height, texture.srgb), (20, 12, true), "{name}");
            assert_eq!((model.warnings.len(), texture.rgba.len()), (0, 960), "{name}: {:?}", model.warnings);
        }
    }
}

#[test]
fn sixteen_bit_images_become_eight_and_bombs_are_refused() {
    let mut out = std::io::Cursor::new(Vec::new());
    let deep = image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(2, 1, image::Luma([0x8080u16]));
    image::DynamicImage::ImageLuma16(deep).write_to(&mut out, image::ImageFormat::Png).unwrap();
    let pixels =
        crate::assets::image::decode(Path::new("x.png"), "image", out.get_ref(), &crate::assets::Meter::default())
            .unwrap();
    assert_eq!(pixels.rgba, [128, 128, 128, 255, 128, 128, 128, 255]);
    let wide = png(16385, 1);
    let message = crate::assets::image::decode(Path::new("x.png"), "image", &wide, &crate::assets::Meter::default())
        .unwrap_err()
        .to_string();
    assert!(message.contains("x.png"), "{message}");
}

#[test]
fn samplers_say_how_textures_are_minified() {
    let mut bytes = square_bytes();
    let picture = png(3, 2);
    bytes.extend(&picture);
    let views =
        VIEWS.replace("12}]", &format!("12}},{{\"buffer\":0,\"byteOffset\":92,\"byteLength\":{}}}]", picture.len()));
    let mesh = MESH.replace("\"indices\"", "\"material\":0,\"indices\"");
    let of = |sampler: &str| {
        let rest = format!(
            r#""images":[{{"bufferView":3,"mimeType":"image/png"}}],"samplers":[{{{sampler}}}],
            "textures":[{{"source":0,"sampler":0}},{{"source":0}}],"nodes":[{{"mesh":0}}],
            "materials":[{{"emissiveTexture":{{"index":1}},"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]"#
        );
        let model = load(&document(&bytes, &[&views, ACCESSORS, &mesh, &rest])).unwrap();
        let material = model.nodes[0].primitives[0].1.clone();
        let [base, plain] = [&material.base_color_texture, &material.emissive_texture].map(|t| t.clone().unwrap());
        assert_eq!((plain.sampling, &plain.rgba), (Sampling::default(), &base.rgba), "one image, two samplers");
        base.sampling
    };
    for (filter, nearest, levels) in [
        (9728, true, Levels::Full),
        (9729, false, Levels::Full),
        (9984, true, Levels::Nearest),
        (9985, false, Levels::Nearest),
        (9986, true, Levels::Blended),
        (9987, false, Levels::Blended),
    ] {
        let minification = Some(Minification { nearest, levels });
        assert_eq!(of(&format!("\"minFilter\":{filter}")), Sampling { minification, ..Sampling::default() });
    }
    // What a file leaves open follows the other filter.
    let open = |nearest| Sampling { nearest, ..Sampling::default() };
    assert_eq!(of("\"magFilter\":9728"), open(true));
    assert_eq!(open(true).minified(), Minification { nearest: true, levels: Levels::Nearest });
    assert_eq!(open(false).minified(), Minification { nearest: false, levels: Levels::Blended });
}
