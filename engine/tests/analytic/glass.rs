//! Glass: what passes it, straight and refracted, what it absorbs, the light behind it, and rooms with it against the path tracer.

use crate::support::{Stage, error, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{Attenuation, Material, Shape};
use lightwell::gpu::{Gpu, ImageF32};
use lightwell::graph::PassState;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};
use std::f32::consts::PI;

const EDGE: u32 = 32;

/// A traced image, all bounces.
fn trace(gpu: &Gpu, stage: &Stage, samples: u32, layer: Layer) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces: None, seed: 1 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).unwrap_or_else(|error| panic!("{error}"));
    tracer.advance(gpu, samples).unwrap_or_else(|error| panic!("{error}"));
    let estimate = tracer.estimate(gpu).unwrap_or_else(|error| panic!("{error}"));
    match layer {
        Layer::Direct => estimate.direct(),
        _ => estimate.total(),
    }
}

fn image_of(image: &ImageF32) -> Image {
    Image::from_rgba(image.width, image.height, &image.rgba).expect("an image")
}

fn color_at(image: &Image, x: u32, y: u32) -> Vec3 {
    Vec3::from_slice(&image.pixels()[(x + EDGE * y) as usize][..3])
}

/// A wall that shines with a radiance at z = −2, seen from z = 3.
fn before_wall(radiance: Vec3) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, EDGE);
    let wall = Material { emissive: radiance, ..Material::diffuse("wall", Vec3::ZERO) };
    stage.add_material(facing_plane(60.0), wall, facing(-2.0));
    stage
}

fn facing_plane(edge: f32) -> Shape {
    Shape::Plane { size: [edge; 2], subdivisions: [1; 2] }
}

/// The place of a plane at a height z that faces +z.
fn facing(z: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_arc(Vec3::Y, Vec3::Z), Vec3::Z * z)
}

/// Clear glass, without reflection where the index of refraction is 1.
fn clear(color: Vec3, ior: f32, volume: Option<Attenuation>) -> Material {
    Material { base_color: color.extend(1.0), roughness: 0.0, transmission: 1.0, ior, volume, ..Material::new("glass") }
}

/// Schlick's term of an index of refraction.
fn fresnel(ior: f32, cosine: f32) -> f32 {
    let f = ((ior - 1.0) / (ior + 1.0)).powi(2);
    f + (1.0 - f) * (1.0 - cosine).powi(5)
}

/// Frames and traced images within that part of the expected radiance, at some pixels.
fn assert_both(gpu: &Gpu, stage: &Stage, tolerance: f32, expected: impl Fn(Vec3) -> Vec3) {
    let drawn = stage.render(gpu, GiMethod::NONE, Layer::Total);
    let traced = trace(gpu, stage, 256, Layer::Total);
    for (x, y) in [(16, 16), (4, 16), (20, 6), (9, 25)] {
        let wanted = expected(stage.ray(x, y));
        for (what, found) in [("drawn", rgb(&drawn, x, y)), ("traced", color_at(&traced, x, y))] {
            let off = (found - wanted).abs().max_element() / wanted.max_element();
            assert!(off < tolerance, "{what} at {x}, {y}: {found}, expected {wanted}");
        }
    }
}

/// A thin wall lets pass what Fresnel's term leaves, times its colour and its transmission (KHR_materials_transmission).
#[test]
fn a_thin_wall_colours_what_lies_behind_it() {
    let gpu = gpu();
    let color = Vec3::new(0.9, 0.4, 0.1);
    for transmission in [1.0, 0.6] {
        let mut stage = before_wall(Vec3::new(1.0, 2.0, 4.0));
        let pane = Material { transmission, double_sided: true, ..clear(color, 1.5, None) };
        stage.add_material(facing_plane(30.0), pane, facing(0.0));
        let left = |ray: Vec3| transmission * (1.0 - fresnel(1.5, -ray.z));
        // The tracer chooses between ways by chance.
        assert_both(&gpu, &stage, 0.02, |ray| left(ray) * color * Vec3::new(1.0, 2.0, 4.0));
    }
}

/// A body whose inside refracts nothing absorbs by the way through it (Beer, Lambert), and its surface colours twice.
#[test]
fn a_body_absorbs_by_the_way_through_it() {
    let gpu = gpu();
    let mut stage = before_wall(Vec3::ONE);
    let inside = Attenuation { color: Vec3::new(0.8, 0.3, 0.05), distance: 0.7 };
    let color = Vec3::new(1.0, 0.9, 0.8);
    let slab = Shape::Box { size: [30.0, 30.0, 0.5] };
    stage.add_material(slab, clear(color, 1.0, Some(inside)), Affine3A::from_translation(Vec3::Z * 0.4));
    assert_both(&gpu, &stage, 0.02, |ray| color * color * (-inside.absorption() * (0.5 / -ray.z)).exp());
    let share = (-inside.absorption() * 0.7).exp();
    assert!((share - inside.color).abs().max_element() < 1e-5, "{share}");
}

/// A turned slab moves what lies behind it, by Snell's law: where the border between dark and bright shows.
#[test]
fn a_slab_refracts_by_snells_law() {
    let gpu = gpu();
    for ior in [1.33_f32, 1.8] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, EDGE);
        for (side, emissive) in [(-1.0, Vec3::ONE), (1.0, Vec3::splat(0.01))] {
            let material = Material { emissive, ..Material::diffuse("half", Vec3::ZERO) };
            let place = Affine3A::from_translation(Vec3::X * (15.0 * side)) * facing(-1.0);
            stage.add_material(facing_plane(30.0), material, place);
        }
        let (turn, thickness) = (Quat::from_rotation_y(0.7), 0.8);
        let slab = Shape::Box { size: [20.0, 20.0, thickness] };
        let place = Affine3A::from_rotation_translation(turn, Vec3::Z * 1.2);
        stage.add_material(slab, clear(Vec3::ONE, ior, Some(Attenuation::NONE)), place);
        let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        let traced = trace(&gpu, &stage, 64, Layer::Total);
        let mut compared = 0;
        for x in 2..EDGE - 2 {
            let ray = stage.ray(x, 16);
            // Within a slab light goes by n·sin θ' = sin θ, and leaves it as it came.
            let n = turn * Vec3::Z;
            let cosine = -ray.dot(n);
            let inner = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
            let inside = ray / ior + n * (cosine / ior - inner);
            let moved = inside * (thickness / inner) - ray * (thickness / cosine);
            let at = stage.view.eye() + moved + ray * (-4.0 - moved.z) / ray.z;
            let pixel = 8.0 / EDGE as f32;
            if at.x.abs() < 1.5 * pixel || cosine < 0.3 {
                continue;
            }
            compared += 1;
            let is_bright = at.x < 0.0;
            for (what, found) in [("drawn", rgb(&drawn, x, 16)), ("traced", color_at(&traced, x, 16))] {
                assert_eq!(found.x > 0.4, is_bright, "{what}, index {ior}, column {x}: {found}, from {at}");
            }
        }
        assert!(compared > 12, "{compared} columns");
    }
}

/// Glass with dispersion refracts each colour by an index of its own (KHR_materials_dispersion: Abbe's number is 20 over it).
#[test]
fn a_slab_with_dispersion_parts_colours() {
    const FINE: u32 = 128;
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, FINE);
    for (side, emissive) in [(-1.0, Vec3::ONE), (1.0, Vec3::splat(0.01))] {
        let material = Material { emissive, ..Material::diffuse("half", Vec3::ZERO) };
        let place = Affine3A::from_translation(Vec3::X * (15.0 * side)) * facing(-1.0);
        stage.add_material(facing_plane(30.0), material, place);
    }
    let (turn, thickness, dispersion) = (Quat::from_rotation_y(0.9), 1.2, 32.0);
    let slab = Shape::Box { size: [20.0, 20.0, thickness] };
    let place = Affine3A::from_rotation_translation(turn, Vec3::Z * 0.8);
    stage.add_material(slab, Material { dispersion, ..clear(Vec3::ONE, 1.5, Some(Attenuation::NONE)) }, place);
    let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Total);
    let traced = trace(&gpu, &stage, 256, Layer::Total);
    let traced_at = |x: u32| Vec3::from_slice(&traced.pixels()[(x + FINE * FINE / 2) as usize][..3]);
    let (mut compared, mut parted) = (0, 0);
    for x in 2..FINE - 2 {
        let ray = stage.ray(x, FINE / 2);
        let n = turn * Vec3::Z;
        let cosine = -ray.dot(n);
        // (n_F − n_C)/2 = (n − 1)/(2·V) with V = 20/dispersion, around the index itself.
        let places = [-1.0, 0.0, 1.0].map(|color| {
            let ior = 1.5 + color * 0.5 * 0.5 / (20.0 / dispersion);
            let inner = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
            let inside = ray / ior + n * (cosine / ior - inner);
            let moved = inside * (thickness / inner) - ray * (thickness / cosine);
            stage.view.eye() + moved + ray * (-4.0 - moved.z) / ray.z
        });
        let pixel = 8.0 / FINE as f32;
        if cosine < 0.3 || places.iter().any(|at| at.x.abs() < 1.0 * pixel) {
            continue;
        }
        compared += 1;
        parted += u32::from(places.iter().any(|at| at.x < 0.0) && places.iter().any(|at| at.x > 0.0));
        for (what, found) in [("drawn", rgb(&drawn, x, FINE / 2)), ("traced", traced_at(x))] {
            for (channel, at) in places.iter().enumerate() {
                assert_eq!(found[channel] > 0.4, at.x < 0.0, "{what}, column {x}, {channel}: {found}, from {at}");
            }
        }
    }
    assert!(compared > 8 && parted > 0, "{compared} columns, of which {parted} are parted");
}

/// In even light from everywhere a body that absorbs nothing is not to be seen: what it reflects and what passes are all of it.
#[test]
fn clear_bodies_vanish_in_a_furnace() {
    let gpu = gpu();
    for (roughness, tracer_bound, frame_bound) in [(0.0, 0.01, 0.02), (0.4, 0.06, 0.08)] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, EDGE);
        stage.scene.sky = Vec3::ONE;
        let glass = Material { roughness, ..clear(Vec3::ONE, 1.5, Some(Attenuation::NONE)) };
        let ball = Shape::Sphere { radius: 1.0, segments: 128, rings: 64 };
        stage.add_material(ball, glass, Affine3A::IDENTITY);
        let traced = trace(&gpu, &stage, 256, Layer::Total);
        let drawn = image_of(&stage.render(&gpu, GiMethod::NONE, Layer::Total));
        for (what, image, bound) in [("traced", &traced, tracer_bound), ("drawn", &drawn, frame_bound)] {
            let lit: Vec<f32> = image.pixels().iter().map(|pixel| pixel[0]).collect();
            let mean = lit.iter().sum::<f32>() / lit.len() as f32;
            let brightest = lit.iter().copied().fold(0.0, f32::max);
            println!("{what}, roughness {roughness}: mean {mean:.4}, brightest {brightest:.4}");
            assert!((mean - 1.0).abs() < bound, "{what}, roughness {roughness}: mean {mean}");
            assert!(what == "traced" || brightest < 1.001, "{what}: light out of nothing, {brightest}");
        }
    }
}

/// Shadows of glass have its colour: a floor under a pane, and under a body, against the formula.
#[test]
fn shadows_of_glass_have_its_colour() {
    let gpu = gpu();
    let (color, albedo, irradiance) = (Vec3::new(0.9, 0.5, 0.2), 0.6, 3.0);
    let inside = Attenuation { color: Vec3::new(0.4, 0.7, 0.9), distance: 0.5 };
    let toward = Vec3::new(0.4, 1.0, 0.2).normalize();
    let left = 1.0 - fresnel(1.5, toward.y);
    let pane = left * color;
    let body = left * left * color * color * (-inside.absorption() * (0.3 / toward.y)).exp();
    for (what, shape, volume, expected) in [
        ("a pane", Shape::Plane { size: [40.0; 2], subdivisions: [1; 2] }, None, pane),
        ("a body", Shape::Box { size: [40.0, 0.3, 40.0] }, Some(inside), body),
    ] {
        for kind in [LightShape::Directional, LightShape::Point, LightShape::Sphere { radius: 0.5 }] {
            let mut stage = Stage::new(Vec3::new(0.0, 1.0, 2.0), Vec3::ZERO, EDGE);
            stage.add(
                Shape::Box { size: [60.0, 0.2, 60.0] },
                Vec3::splat(albedo),
                Affine3A::from_translation(-0.1 * Vec3::Y),
            );
            stage.add_material(shape.clone(), clear(color, 1.5, volume), Affine3A::from_translation(Vec3::Y * 3.0));
            let far = 4000.0;
            let intensity = if kind != LightShape::Directional { irradiance * far * far } else { irradiance };
            stage.light(kind, Vec3::splat(intensity), toward * far, -toward);
            let expected = expected * (albedo * irradiance * toward.y / PI);
            let drawn = stage.render(&gpu, GiMethod::NONE, Layer::Direct);
            let traced = trace(&gpu, &stage, 16, Layer::Direct);
            for (how, found) in [("drawn", rgb(&drawn, 16, 24)), ("traced", color_at(&traced, 16, 24))] {
                let off = (found - expected).abs().max_element() / expected.max_element();
                assert!(off < 5e-3, "{what} and {kind:?}, {how}: {found}, expected {expected}");
            }
        }
    }
}

/// A room that is lit through coloured panes alone, a frosted one and a body in it: light that bounces, against the path tracer.
#[test]
fn a_room_is_lit_through_glass() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 1.85), Vec3::new(0.0, 0.9, 0.0), 64);
    stage.add_room(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(4.0, 2.0, 4.0), Vec3::new(0.7, 0.65, 0.6));
    // A wall of two panes between the lamp and the rest.
    for (x, color) in [(-1.0, Vec3::new(0.9, 0.2, 0.05)), (1.0, Vec3::new(0.9, 0.4, 0.05))] {
        let pane = Material { double_sided: true, ..clear(color, 1.5, None) };
        let place =
            Affine3A::from_rotation_translation(Quat::from_rotation_arc(Vec3::Y, Vec3::Z), Vec3::new(x, 1.0, -1.0));
        stage.add_material(Shape::Plane { size: [2.0; 2], subdivisions: [1; 2] }, pane, place);
    }
    let body = clear(Vec3::ONE, 1.5, Some(Attenuation { color: Vec3::new(0.5, 0.9, 0.6), distance: 0.3 }));
    let ball = Shape::Sphere { radius: 0.3, segments: 64, rings: 32 };
    stage.add_material(ball, body, Affine3A::from_translation(Vec3::new(0.4, 0.3, 0.3)));
    stage.light(LightShape::Point, Vec3::splat(6.0), Vec3::new(0.3, 1.4, -1.6), Vec3::NEG_Y);
    stage.clpv(Vec3::new(0.0, 1.0, 0.0), Clpv { quality: Quality::Medium, ..Clpv::default() });
    let mut sum = vec![[0.0_f32; 4]; 64 * 64];
    let mut renderer = Renderer::new(&gpu);
    const IMAGES: u32 = 8;
    for number in 0..IMAGES {
        stage.view.jitter = [number as f32 / IMAGES as f32 - 0.5, (number * 3 % IMAGES) as f32 / IMAGES as f32 - 0.5];
        let settings = RenderSettings { gi: GiMethod::CLPV, images: IMAGES, ..Default::default() };
        let (image, _) = stage.render_with(&gpu, &mut renderer, &settings);
        for (sum, pixel) in sum.iter_mut().zip(&image.rgba) {
            (0..4).for_each(|channel| sum[channel] += pixel[channel] / IMAGES as f32);
        }
    }
    stage.view.jitter = [0.0; 2];
    let drawn = ImageF32 { width: 64, height: 64, rgba: sum };
    let traced = trace(&gpu, &stage, 1024, Layer::Total);
    let (error, bias) = error(&drawn, &traced);
    let channels = [0, 1, 2].map(|channel| {
        let sum = |pixels: &mut dyn Iterator<Item = f32>| pixels.sum::<f32>();
        let found = sum(&mut drawn.rgba.iter().map(|pixel| pixel[channel]));
        found / sum(&mut traced.pixels().iter().map(|pixel| pixel[channel])) - 1.0
    });
    println!("a room lit through glass: nrmse {error:.4}, bias {bias:+.4}, by channel {channels:?}");
    // What glass reflects of light between surfaces is left out.
    assert!(error < 0.14 && (-0.08..0.01).contains(&bias), "nrmse {error}, bias {bias}");
    // Hardly any blue passes: patches of the wall that lie on both sides of a pane bring more.
    assert!(channels[2] < 0.25, "by channel {channels:?}");
}

/// Nothing is done for glass where there is none, nor again where nothing changed.
/// A frosted pane before stripes that shine.
fn frosted() -> Stage {
    let mut stage = before_wall(Vec3::splat(0.1));
    for x in [-3.0, -1.0, 1.0, 3.0] {
        let strip = Shape::Plane { size: [0.5, 20.0], subdivisions: [1; 2] };
        let shining = Material { emissive: Vec3::splat(4.0), ..Material::diffuse("strip", Vec3::ZERO) };
        stage.add_material(strip, shining, Affine3A::from_translation(Vec3::X * x) * facing(-1.9));
    }
    let frost = Material { roughness: 0.4, double_sided: true, ..clear(Vec3::ONE, 1.5, None) };
    stage.add_material(facing_plane(3.0), frost, facing(0.5));
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Medium, ..Default::default() });
    stage
}

#[test]
fn frosted_glass_is_quiet_and_as_bright_as_traced() {
    let gpu = gpu();
    let stage = frosted();
    let one = image_of(&stage.render(&gpu, GiMethod::CLPV, Layer::Total));
    let truth = trace(&gpu, &stage, 1024, Layer::Total);
    // Of the pane alone, which fills the middle.
    let pixels = (0..EDGE)
        .flat_map(|y| (0..EDGE).map(move |x| (x, y)))
        .filter(|&(x, y)| [x, y].iter().all(|&place| (8..24).contains(&place)));
    let pairs: Vec<_> = pixels.map(|(x, y)| (color_at(&one, x, y).x, color_at(&truth, x, y).x)).collect();
    let count = pairs.len() as f32;
    let mean = pairs.iter().map(|pair| pair.1).sum::<f32>() / count;
    let bias = pairs.iter().map(|pair| pair.0).sum::<f32>() / count / mean - 1.0;
    let off = (pairs.iter().map(|pair| (pair.0 - pair.1).powi(2)).sum::<f32>() / count).sqrt() / mean;
    println!("bias {bias}, off {off}");
    assert!(bias.abs() < 0.03 && off < 0.2, "bias {bias}, off {off}");
}

#[test]
fn without_glass_nothing_is_done_for_it() {
    let gpu = gpu();
    let states = |stage: &Stage| {
        let mut renderer = Renderer::new(&gpu);
        let settings = RenderSettings { gi: GiMethod::NONE, ..Default::default() };
        [(); 2].map(|()| {
            let (_, report) = stage.render_with(&gpu, &mut renderer, &settings);
            let found = ["glass", "glass depth", "compose opaque"].map(|name| {
                report.passes.iter().find(|pass| pass.name == name).map(|pass| pass.state == PassState::Ran)
            });
            found.map(|ran| ran.unwrap_or(false))
        })
    };
    let mut stage = before_wall(Vec3::ONE);
    assert_eq!(states(&stage), [[false; 3]; 2]);
    let pane = Material { double_sided: true, ..clear(Vec3::ONE, 1.5, None) };
    stage.add_material(facing_plane(1.0), pane, facing(0.0));
    assert_eq!(states(&stage), [[true; 3], [false; 3]]);
}
