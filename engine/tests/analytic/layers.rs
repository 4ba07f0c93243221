//! Layers of surfaces: clear coats, sheen, films and stretched highlights against the formulas that they stand for, in even light,
//! and rooms with them against the path tracer.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Anisotropy, Clearcoat, Iridescence, Material, Shape, Sheen};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::PassState;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};
use std::f32::consts::PI;

const EDGE: u32 = 32;
const PIXELS: [(u32, u32); 5] = [(16, 16), (4, 16), (20, 6), (9, 25), (28, 30)];

fn trace(gpu: &Gpu, stage: &Stage, samples: u32, bounces: Option<u32>) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}")).total()
}

fn color_at(image: &Image, x: u32, y: u32) -> Vec3 {
    Vec3::from_slice(&image.pixels()[(x + EDGE * y) as usize][..3])
}

/// A floor of a material, seen from a height of 2 m, and light from far.
fn floor(material: Material, direction: Vec3) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 1.0), Vec3::new(0.0, 0.0, -0.5), EDGE);
    stage.add_material(Shape::Plane { size: [60.0; 2], subdivisions: [1; 2] }, material, Affine3A::IDENTITY);
    stage.light(LightShape::Directional, Vec3::splat(2.0), Vec3::ZERO, direction);
    stage
}

/// A floor of a material in even light of 1 W/(m² sr) from the whole sky.
fn floor_in_even_light(material: Material) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 2.0, 1.0), Vec3::new(0.0, 0.0, -0.5), EDGE);
    stage.add_material(Shape::Plane { size: [24.0; 2], subdivisions: [1; 2] }, material, Affine3A::IDENTITY);
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Clpv::default() });
    stage
}

fn black(name: &str) -> Material {
    Material::diffuse(name, Vec3::ZERO)
}

// ---- The formulas, in their own words ----

fn schlick(cosine: f32) -> f32 {
    0.04 + 0.96 * (1.0 - cosine).powi(5)
}

/// GGX with Smith's height-correlated masking, for α along x and z of a floor (Heitz 2014, eq. 85 and 99).
fn ggx(v: Vec3, l: Vec3, [x, z]: [f32; 2]) -> f32 {
    let h = (v + l).normalize();
    let d = 1.0 / (PI * x * z * ((h.x / x).powi(2) + (h.z / z).powi(2) + h.y * h.y).powi(2));
    let lambda = |w: Vec3| 0.5 * ((1.0 + ((x * w.x).powi(2) + (z * w.z).powi(2)) / (w.y * w.y)).sqrt() - 1.0);
    d / ((1.0 + lambda(v) + lambda(l)) * 4.0 * v.y * l.y)
}

/// The lobe of sheen (Estevez and Kulla 2017, eq. 2 to 4), in f64.
fn sheen(v: Vec3, l: Vec3, roughness: f32) -> f32 {
    let alpha = f64::from(roughness).powi(2);
    let h = (v + l).normalize();
    let sine = (1.0 - f64::from(h.y).powi(2)).max(0.0).sqrt();
    let d = (2.0 + 1.0 / alpha) * sine.powf(1.0 / alpha) / (2.0 * std::f64::consts::PI);
    let (smooth, rough) =
        ([25.3245, 3.32435, 0.16801, -1.27393, -4.85967], [21.5473, 3.82987, 0.19823, -1.97760, -4.32054]);
    let weight = (1.0 - alpha).powi(2);
    let p: [f64; 5] = std::array::from_fn(|i| weight * smooth[i] + (1.0 - weight) * rough[i]);
    let fit = |x: f64| p[0] / (1.0 + p[1] * x.powf(p[2])) + p[3] * x + p[4];
    let lambda = |x: f64| if x < 0.5 { fit(x).exp() } else { (2.0 * fit(0.5) - fit(1.0 - x)).exp() };
    let (nv, nl) = (f64::from(v.y), f64::from(l.y));
    (d / ((1.0 + lambda(nv) + lambda(nl)) * 4.0 * nv * nl)) as f32
}

/// What white sheen reflects of even light, by the mean over the hemisphere.
fn sheen_albedo(cosine: f32, roughness: f32) -> f32 {
    const STEPS: u32 = 240;
    let v = Vec3::new((1.0 - cosine * cosine).sqrt(), cosine, 0.0);
    let mut sum = 0.0;
    for i in 0..STEPS {
        let y = (i as f32 + 0.5) / STEPS as f32;
        let radius = (1.0 - y * y).sqrt();
        for j in 0..STEPS {
            let angle = PI * (j as f32 + 0.5) / STEPS as f32;
            sum += y * sheen(v, Vec3::new(radius * angle.cos(), y, radius * angle.sin()), roughness);
        }
    }
    2.0 * PI * sum / (STEPS * STEPS) as f32
}

/// Frames and traced images within that part of the expected radiance.
fn assert_both(gpu: &Gpu, stage: &Stage, tolerance: f32, expected: impl Fn(Vec3) -> Vec3) {
    let drawn = stage.render(gpu, GiMethod::NONE, Layer::Total);
    let traced = trace(gpu, stage, 64, Some(0));
    let brightest = PIXELS.iter().map(|&(x, y)| expected(stage.ray(x, y)).max_element()).fold(0.0, f32::max);
    for (x, y) in PIXELS {
        let wanted = expected(stage.ray(x, y));
        for (what, found) in [("drawn", rgb(&drawn, x, y)), ("traced", color_at(&traced, x, y))] {
            let off = (found - wanted).abs().max_element() / brightest;
            assert!(off < tolerance, "{what} at {x}, {y}: {found}, expected {wanted}");
        }
    }
}

/// Without a base there is the lobe of the coat alone, by the angle of the view (KHR_materials_clearcoat).
#[test]
fn a_coat_reflects_a_light_by_its_lobe() {
    let gpu = gpu();
    let direction = Vec3::new(0.3, -1.0, -0.6).normalize();
    for (factor, roughness) in [(1.0, 0.5), (0.6, 0.8)] {
        let clearcoat = Clearcoat { factor, roughness, ..Default::default() };
        let stage = floor(Material { clearcoat, ..black("coated") }, direction);
        assert_both(&gpu, &stage, 0.02, |ray| {
            let (v, l, alpha) = (-ray, -direction, roughness * roughness);
            Vec3::splat(2.0 * factor * schlick(v.y) * ggx(v, l, [alpha; 2]) * l.y)
        });
    }
}

/// What the coat reflects it takes from the base and from its emission.
#[test]
fn a_coat_takes_from_what_lies_below_what_it_reflects() {
    let gpu = gpu();
    // Its highlight is out of view.
    let direction = Vec3::new(0.0, -0.2, 1.0).normalize();
    let albedo = Vec3::new(0.8, 0.5, 0.2);
    let clearcoat = Clearcoat { factor: 0.7, roughness: 0.0, ..Default::default() };
    let base = Material { emissive: Vec3::new(0.1, 0.2, 0.3), ..Material::diffuse("coated", albedo) };
    let stage = floor(Material { clearcoat, ..base }, direction);
    assert_both(&gpu, &stage, 0.01, |ray| {
        let left = 1.0 - 0.7 * schlick(-ray.y);
        left * (2.0 * albedo / PI * -direction.y + Vec3::new(0.1, 0.2, 0.3))
    });
}

/// The traced lobe of sheen is that of its authors.
#[test]
fn sheen_reflects_a_light_by_its_lobe() {
    let gpu = gpu();
    let direction = Vec3::new(0.2, -0.5, 0.8).normalize();
    for roughness in [0.35, 0.7, 1.0] {
        let color = Vec3::new(0.9, 0.6, 0.3);
        let stage = floor(Material { sheen: Sheen { color, roughness }, ..black("cloth") }, direction);
        let traced = trace(&gpu, &stage, 64, Some(0));
        let lit = |x, y| 2.0 * color * sheen(-stage.ray(x, y), -direction, roughness) * -direction.y;
        let brightest = PIXELS.iter().map(|&(x, y)| lit(x, y).max_element()).fold(0.0, f32::max);
        for (x, y) in PIXELS {
            let wanted = lit(x, y);
            let found = color_at(&traced, x, y);
            let off = (found - wanted).abs().max_element() / brightest;
            assert!(off < 0.01, "roughness {roughness} at {x}, {y}: {found}, expected {wanted}");
        }
    }
}

/// In even light sheen reflects the integral of its lobe, and the base what that leaves: in frames as in traced images.
#[test]
fn sheen_and_base_share_even_light() {
    let gpu = gpu();
    for (roughness, albedo) in [(0.3, 0.0), (0.6, 0.5), (1.0, 0.5)] {
        let color = Vec3::new(0.9, 0.6, 0.3);
        let cloth = Material { sheen: Sheen { color, roughness }, ..Material::diffuse("cloth", Vec3::splat(albedo)) };
        let stage = floor_in_even_light(cloth);
        let traced = trace(&gpu, &stage, 2048, None);
        let drawn = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
        for (x, y) in PIXELS {
            let cosine = -stage.ray(x, y).y;
            let reflected = sheen_albedo(cosine, roughness);
            let wanted = color * reflected + Vec3::splat(albedo * (1.0 - 0.9 * reflected));
            for (what, found) in [("drawn", rgb(&drawn, x, y)), ("traced", color_at(&traced, x, y))] {
                let off = (found - wanted).abs().max_element();
                assert!(off < 0.02, "{what}, roughness {roughness} at {x}, {y}: {found}, expected {wanted}");
            }
        }
    }
}

/// A stretched highlight is GGX with two α, turned as the material says.
#[test]
fn a_stretched_highlight_has_two_widths() {
    let gpu = gpu();
    let direction = Vec3::new(0.3, -1.0, -0.6).normalize();
    let (roughness, strength) = (0.5_f32, 0.6_f32);
    let alpha = roughness * roughness;
    let along = alpha + (1.0 - alpha) * strength * strength;
    for (rotation, widths) in [(0.0, [along, alpha]), (0.5 * PI, [alpha, along])] {
        let metal = Material {
            metallic: 1.0,
            roughness,
            anisotropy: Anisotropy { strength, rotation },
            ..Material::new("brushed")
        };
        let stage = floor(metal, direction);
        let traced = trace(&gpu, &stage, 64, Some(0));
        for (x, y) in PIXELS {
            let (v, l) = (-stage.ray(x, y), -direction);
            let wanted = 2.0 * ggx(v, l, widths) * l.y;
            let found = color_at(&traced, x, y).x;
            assert!((found - wanted).abs() < 0.05 * wanted, "turn {rotation} at {x}, {y}: {found}, expected {wanted}");
        }
    }
}

/// A film so thick that its waves are out of step adds up what it reflects once, twice and so on, like a pane of glass.
#[test]
fn a_thick_film_is_a_pane() {
    let gpu = gpu();
    let iridescence = Iridescence { factor: 1.0, ior: 1.6, least_thickness: 0.0, thickness: 9e4 };
    // A mirror of metal: what it shows of an even sky is its reflectance.
    let metal = Material {
        base_color: Vec3::splat(0.3).extend(1.0),
        metallic: 1.0,
        roughness: 0.0,
        iridescence,
        ..Material::new("film")
    };
    let stage = floor_in_even_light(metal);
    let traced = trace(&gpu, &stage, 64, None);
    let drawn = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
    for (x, y) in PIXELS {
        let cosine = -stage.ray(x, y).y;
        let within = (1.0 - (1.0 - cosine * cosine) / (1.6 * 1.6)).sqrt();
        let index = (1.0 + 0.3_f32.sqrt()) / (1.0 - 0.3_f32.sqrt());
        let of = |f: f32, cosine: f32| f + (1.0 - f) * (1.0 - cosine).powi(5);
        let upper = of((0.6_f32 / 2.6).powi(2), cosine);
        let lower = of(((index - 1.6) / (index + 1.6)).powi(2), within);
        let wanted = upper + (1.0 - upper).powi(2) * lower / (1.0 - upper * lower);
        for (what, found) in [("drawn", rgb(&drawn, x, y)), ("traced", color_at(&traced, x, y))] {
            assert!((found - wanted).abs().max_element() < 0.02, "{what} at {x}, {y}: {found}, expected {wanted}");
        }
    }
}

/// Films of the waves' own size have colours, and none reflects more than arrives.
#[test]
fn thin_films_have_colours() {
    let gpu = gpu();
    let mut spread = 0.0_f32;
    for thickness in [0.0, 150.0, 250.0, 380.0, 520.0] {
        let iridescence = Iridescence { factor: 1.0, ior: 1.8, least_thickness: 0.0, thickness };
        let metal = Material {
            metallic: 1.0,
            roughness: 0.0,
            iridescence,
            base_color: Vec3::splat(0.5).extend(1.0),
            ..Material::new("film")
        };
        let stage = floor_in_even_light(metal);
        let traced = trace(&gpu, &stage, 64, None);
        for (x, y) in PIXELS {
            let found = color_at(&traced, x, y);
            assert!(found.max_element() <= 1.001 && found.min_element() >= 0.0, "{thickness} nm: {found}");
            if thickness == 0.0 {
                let bare = 0.5 + 0.5 * (1.0 + stage.ray(x, y).y).powi(5);
                assert!((found - bare).abs().max_element() < 0.01, "without a film: {found}, expected {bare}");
            }
            spread = spread.max(found.max_element() - found.min_element());
        }
    }
    assert!(spread > 0.2, "the films differ by {spread} among the channels");
}

/// In even light no stack of layers reflects more than arrives, whatever it is of.
#[test]
fn no_layer_makes_light() {
    let gpu = gpu();
    let coat = |roughness| Clearcoat { factor: 1.0, roughness, ..Default::default() };
    let all = Material {
        clearcoat: coat(0.3),
        sheen: Sheen { color: Vec3::ONE, roughness: 0.0 },
        anisotropy: Anisotropy { strength: 0.8, rotation: 1.0 },
        iridescence: Iridescence { factor: 1.0, ..Default::default() },
        roughness: 0.4,
        ..Material::new("all of them")
    };
    let stacks = [
        Material { clearcoat: coat(0.0), ..Material::new("smooth coat") },
        Material { metallic: 1.0, ..Material::new("rough metal") },
        Material { clearcoat: coat(1.0), metallic: 1.0, ..Material::new("rough coat on metal") },
        Material { sheen: Sheen { color: Vec3::ONE, roughness: 0.0 }, ..Material::new("velvet") },
        Material { sheen: Sheen { color: Vec3::ONE, roughness: 1.0 }, ..Material::new("wool") },
        Material { metallic: 1.0, ..all.clone() },
        all,
    ];
    for material in stacks {
        let name = material.name.clone();
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 1.5), Vec3::ZERO, EDGE);
        let ball = Shape::Sphere { radius: 1.0, segments: 48, rings: 24 };
        stage.add_material(ball, Material { id: lightwell::assets::AssetId::fresh(), ..material }, Affine3A::IDENTITY);
        stage.scene.sky = Vec3::ONE;
        stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Clpv::default() });
        let traced = trace(&gpu, &stage, 512, None);
        let drawn = stage.render(&gpu, GiMethod::CLPV, Layer::Total);
        let (mut least, mut sum) = (1.0_f32, Vec3::ZERO);
        for y in 0..EDGE {
            for x in 0..EDGE {
                let (a, b) = (color_at(&traced, x, y), rgb(&drawn, x, y));
                least = least.min(a.min_element());
                sum += b;
                // The tracer chooses between lobes by chance.
                assert!(a.max_element() < 1.1 && b.max_element() < 1.15, "{name} at {x}, {y}: traced {a}, drawn {b}");
            }
        }
        let mean = (sum / (EDGE * EDGE) as f32).max_element();
        // A smooth coat on white returns all of it, and more by what numbers are rounded by.
        assert!(mean < 1.0001, "{name}: {mean} of the light in the mean");
        assert!(least > 0.3, "{name}: {least} of the light at least");
    }
}

/// The mean of several drawn images of a room, with shifted pixels.
fn drawn_mean(gpu: &Gpu, stage: &mut Stage) -> ImageF32 {
    const IMAGES: u32 = 8;
    let [width, height] = stage.view.size;
    let mut sum = vec![[0.0_f32; 4]; (width * height) as usize];
    let mut renderer = Renderer::new(gpu);
    for number in 0..IMAGES {
        stage.view.jitter = [number as f32 / IMAGES as f32 - 0.5, (number * 3 % IMAGES) as f32 / IMAGES as f32 - 0.5];
        let settings = RenderSettings { gi: GiMethod::CLPV, images: IMAGES, ..Default::default() };
        let (image, _) = stage.render_with(gpu, &mut renderer, &settings);
        for (sum, pixel) in sum.iter_mut().zip(&image.rgba) {
            (0..4).for_each(|channel| sum[channel] += pixel[channel] / IMAGES as f32);
        }
    }
    stage.view.jitter = [0.0; 2];
    ImageF32 { width, height, rgba: sum }
}

/// A room with a ball and a box of a material, against the path tracer: each layer alone.
#[test]
fn rooms_with_layers_are_as_the_path_tracer_has_them() {
    let gpu = gpu();
    let coat = Clearcoat { factor: 1.0, roughness: 0.1, ..Default::default() };
    let red = Vec3::new(0.7, 0.1, 0.05);
    let cases = [
        (
            "coat",
            0.10,
            Material { clearcoat: coat, roughness: 0.6, base_color: red.extend(1.0), ..Material::new("paint") },
        ),
        (
            "rough coat",
            0.10,
            Material { clearcoat: Clearcoat { roughness: 0.6, ..coat }, ..Material::diffuse("paint", red) },
        ),
        (
            "sheen",
            0.10,
            Material {
                sheen: Sheen { color: Vec3::new(0.9, 0.7, 0.8), roughness: 0.5 },
                ..Material::diffuse("velvet", red)
            },
        ),
        (
            "film",
            0.12,
            Material {
                iridescence: Iridescence { factor: 1.0, ..Default::default() },
                metallic: 1.0,
                roughness: 0.3,
                ..Material::new("film")
            },
        ),
        (
            "anisotropy",
            0.25,
            Material {
                anisotropy: Anisotropy { strength: 0.7, rotation: 0.0 },
                metallic: 1.0,
                roughness: 0.3,
                ..Material::new("brushed")
            },
        ),
    ];
    for (name, most, material) in cases {
        let mut stage = Stage::new(Vec3::new(0.0, 1.0, 1.85), Vec3::new(0.0, 0.8, 0.0), 64);
        stage.add_room(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(4.0, 2.0, 4.0), Vec3::new(0.7, 0.65, 0.6));
        let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(-0.8, 0.4, -0.5));
        stage.add_material(Shape::Box { size: [0.8; 3] }, material.clone(), turned);
        let ball = Shape::Sphere { radius: 0.5, segments: 64, rings: 32 };
        stage.add_material(ball, material, Affine3A::from_translation(Vec3::new(0.7, 0.5, 0.2)));
        stage.light(LightShape::Point, Vec3::splat(4.0), Vec3::new(0.3, 1.8, 0.6), Vec3::NEG_Y);
        stage.clpv(Vec3::new(0.0, 1.0, 0.0), Clpv { quality: Quality::Medium, ..Clpv::default() });
        let drawn = drawn_mean(&gpu, &mut stage);
        let traced = trace(&gpu, &stage, 1024, None);
        let (error, bias) = error(&drawn, &traced);
        println!("a room with {name}: nrmse {error:.4}, bias {bias:+.4}");
        assert!(error < most && bias.abs() < 0.03, "{name}: nrmse {error}, bias {bias}");
    }
}

/// Nothing is done for coats where there is none in view, nor again where nothing changed.
#[test]
fn without_coats_nothing_is_done_for_them() {
    let gpu = gpu();
    let states = |stage: &Stage| {
        let mut renderer = Renderer::new(&gpu);
        let settings = RenderSettings { gi: GiMethod::CLPV, ..Default::default() };
        [(); 2].map(|()| {
            let (_, report) = stage.render_with(&gpu, &mut renderer, &settings);
            ["second lobe", "second lobe, direct", "second lobe, mirror"].map(|name| {
                let mut passes = report.passes.iter().filter(|pass| pass.name.starts_with(name));
                passes.any(|pass| pass.state == PassState::Ran)
            })
        })
    };
    let mut stage = floor(Material::new("bare"), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Low, ..Clpv::default() });
    assert_eq!(states(&stage), [[false; 3]; 2]);
    let clearcoat = Clearcoat { factor: 1.0, ..Default::default() };
    let ball = Shape::Sphere { radius: 0.3, segments: 16, rings: 8 };
    stage.add_material(ball, Material { clearcoat, ..Material::new("coated") }, Affine3A::IDENTITY);
    assert_eq!(states(&stage), [[true; 3], [false; 3]]);
}
