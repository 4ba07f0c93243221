//! Materials of the things that are edited, and images of their sky.

use super::fields::names;
use glam::{Affine2, Vec2, Vec3, Vec4};
use lightwell::assets::{
    AlphaMode, Anisotropy, AssetId, Attenuation, Clearcoat, Iridescence, Material, Sampling, Sheen, SkyMap, Texture,
    UvMap, UvMaps,
};
use lightwell::world::{Environment, EnvironmentImage};
use std::sync::Arc;

/// Materials without textures.
pub const PLAIN: usize = 11;
/// States of each texture: an image, another image, and the first one placed in another way.
pub const STATES: usize = 3;
/// Images of the sky.
pub const SKY_IMAGES: usize = 4;

/// Puts a texture on a material, with a factor that makes it count.
type PutTexture = fn(&mut Material, Arc<Texture>);

/// All textures that a material can have.
pub const TEXTURES: [(&str, PutTexture); 15] = [
    ("base_color_texture", |m, texture| {
        m.alpha_mode = AlphaMode::Mask(0.5);
        m.base_color_texture = Some(texture);
    }),
    ("metallic_roughness_texture", |m, texture| {
        m.metallic = 1.0;
        m.metallic_roughness_texture = Some(texture);
    }),
    ("normal_texture", |m, texture| m.normal_texture = Some(texture)),
    ("emissive_texture", |m, texture| {
        m.emissive = Vec3::splat(1.5);
        m.emissive_texture = Some(texture);
    }),
    ("specular_texture", |m, texture| m.specular_texture = Some(texture)),
    ("specular_color_texture", |m, texture| m.specular_color_texture = Some(texture)),
    ("transmission_texture", |m, texture| {
        m.transmission = 0.9;
        m.transmission_texture = Some(texture);
    }),
    ("clearcoat_texture", |m, texture| {
        m.clearcoat.factor = 0.8;
        m.clearcoat_texture = Some(texture);
    }),
    ("clearcoat_roughness_texture", |m, texture| {
        m.clearcoat = Clearcoat { factor: 0.8, roughness: 0.6, ..Clearcoat::default() };
        m.clearcoat_roughness_texture = Some(texture);
    }),
    ("clearcoat_normal_texture", |m, texture| {
        m.clearcoat.factor = 0.8;
        m.clearcoat_normal_texture = Some(texture);
    }),
    ("sheen_color_texture", |m, texture| {
        m.sheen = Sheen { color: Vec3::ONE, roughness: 0.5 };
        m.sheen_color_texture = Some(texture);
    }),
    ("sheen_roughness_texture", |m, texture| {
        m.sheen = Sheen { color: Vec3::splat(0.6), roughness: 1.0 };
        m.sheen_roughness_texture = Some(texture);
    }),
    ("anisotropy_texture", |m, texture| {
        m.anisotropy.strength = 0.8;
        m.anisotropy_texture = Some(texture);
    }),
    ("iridescence_texture", |m, texture| {
        m.iridescence.factor = 0.9;
        m.iridescence_texture = Some(texture);
    }),
    ("iridescence_thickness_texture", |m, texture| {
        m.iridescence.factor = 0.9;
        m.iridescence_thickness_texture = Some(texture);
    }),
];

/// A solid body of glass.
fn glass_body(color: Vec3, roughness: f32) -> Material {
    let volume = Some(Attenuation { color, distance: 0.5 });
    Material { transmission: 1.0, roughness, volume, ..Material::new("body") }
}

/// Materials without textures.
pub fn plain() -> [Arc<Material>; PLAIN] {
    [
        Material::diffuse("white", Vec3::splat(0.7)),
        Material::diffuse("red", Vec3::new(0.7, 0.1, 0.1)),
        Material { roughness: 0.2, metallic: 0.8, ..Material::new("metal") },
        Material { emissive: Vec3::new(1.0, 2.0, 0.5), ..Material::new("lamp") },
        Material { alpha_mode: AlphaMode::Blend, base_color: Vec4::new(0.4, 0.7, 0.9, 0.5), ..Material::new("veil") },
        Material { transmission: 0.9, double_sided: true, roughness: 0.3, ..Material::new("pane") },
        glass_body(Vec3::new(0.9, 0.4, 0.2), 0.0),
        glass_body(Vec3::new(0.2, 0.4, 0.9), 0.0),
        Material {
            clearcoat: Clearcoat { factor: 0.8, roughness: 0.2, ..Default::default() },
            ..Material::new("paint")
        },
        Material {
            sheen: Sheen { color: Vec3::new(0.9, 0.5, 0.5), roughness: 0.5 },
            iridescence: Iridescence { factor: 0.5, ..Default::default() },
            ..Material::new("silk")
        },
        Material {
            anisotropy: Anisotropy { strength: 0.7, rotation: 0.4 },
            metallic: 1.0,
            roughness: 0.4,
            ..Material::new("brushed")
        },
    ]
    .map(|surface| Arc::new(Material { id: AssetId::fresh(), ..surface }))
}

/// An image of 4 × 4 texels whose channels differ from texel to texel.
fn image(seed: u8) -> Arc<Texture> {
    let rgba = (0..64_u8).map(|byte| byte.wrapping_mul(37).wrapping_add(seed).rotate_left(3)).collect();
    let (name, sampling) = (format!("image {seed}"), Sampling::default());
    Arc::new(Texture { id: AssetId::fresh(), name, width: 4, height: 4, rgba, srgb: false, sampling })
}

/// Materials with one texture each, in its states.
pub fn textured() -> Vec<[Arc<Material>; STATES]> {
    let images = [1, 77].map(image);
    let map = UvMap { set: 0, transform: Affine2::from_scale_angle_translation(Vec2::splat(2.0), 0.5, Vec2::X * 0.3) };
    let placed = UvMaps {
        base_color: map,
        metallic_roughness: map,
        normal: map,
        emissive: map,
        specular: map,
        specular_color: map,
        transmission: map,
        clearcoat: map,
        clearcoat_roughness: map,
        clearcoat_normal: map,
        sheen_color: map,
        sheen_roughness: map,
        anisotropy: map,
        iridescence: map,
        iridescence_thickness: map,
    };
    let made = |put: PutTexture, state: usize| {
        let mut material = Material { id: AssetId::fresh(), roughness: 0.4, ..Material::new("textured") };
        put(&mut material, images[state % 2].clone());
        material.uv = if state == 2 { placed } else { UvMaps::default() };
        Arc::new(material)
    };
    TEXTURES.iter().map(|(_, put)| std::array::from_fn(|state| made(*put, state))).collect()
}

/// An environment with an image of the sky, and the loaded image: two files, of which one is also turned and brightened.
pub fn sky_image(state: usize) -> (Environment, EnvironmentImage) {
    let (file, rotation, intensity) =
        [("first", 0.0, 1.0), ("first", 70.0, 1.0), ("first", 0.0, 2.0), ("second", 0.0, 1.0)][state];
    let mut map = SkyMap::gradient(Vec3::ONE, Vec3::ONE, Vec3::ONE);
    (map.width, map.height) = (4, 2);
    let brightness = |texel: usize| if file == "first" { texel % 5 } else { texel % 3 } as f32;
    map.texels = (0..8).map(|texel| Vec3::new(0.3, 0.2, 0.1) * brightness(texel) + 0.02).collect();
    let environment = |rotation, intensity| Environment::Image { file: file.to_owned(), rotation, intensity };
    let loaded = EnvironmentImage { environment: environment(0.0, 1.0), map: Arc::new(map) };
    (environment(rotation, intensity), loaded)
}

#[test]
fn every_texture_of_a_material_is_edited() {
    let of_material: Vec<String> =
        names(&Material::new("any")).into_iter().filter(|name| name.ends_with("_texture")).collect();
    assert_eq!(TEXTURES.map(|(name, _)| name).to_vec(), of_material);
    for ((name, _), states) in TEXTURES.iter().zip(textured()) {
        for material in states {
            let text = format!("{material:#?}");
            assert!(text.contains(&format!("    {name}: Some(")) && text.matches("_texture: Some(").count() == 1);
        }
    }
}
