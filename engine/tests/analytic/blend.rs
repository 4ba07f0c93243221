//! Blended surfaces: against the formula of blending, against the path tracer, and in the report.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::{AlphaMode, Material, Shape};
use lightwell::gpu::Gpu;
use lightwell::graph::PassState;
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{CellSize, Clpv};
use std::f32::consts::PI;

const EDGE: u32 = 32;
const BACKGROUND: Vec3 = Vec3::new(0.7, 0.2, 0.1);

/// A camera at z = 3 that looks at the origin, where an even wall shines behind.
fn stage() -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, EDGE);
    let wall = Material { emissive: BACKGROUND, ..Material::diffuse("wall", Vec3::ZERO) };
    stage.add_material(Shape::Box { size: [20.0, 20.0, 0.1] }, wall, Affine3A::from_translation(Vec3::NEG_Z * 2.0));
    stage
}

fn glass(albedo: Vec3, emissive: Vec3, alpha: f32) -> Material {
    let diffuse = Material::diffuse("glass", albedo);
    Material { base_color: albedo.extend(alpha), emissive, alpha_mode: AlphaMode::Blend, ..diffuse }
}

/// A square that faces +z.
fn pane(stage: &mut Stage, material: Material, z: f32, edge: f32) {
    let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    let at = Affine3A::from_rotation_translation(turn, Vec3::Z * z);
    stage.add_material(Shape::Plane { size: [edge; 2], subdivisions: [1; 2] }, material, at);
}

fn middle(gpu: &Gpu, stage: &Stage, layer: Layer) -> Vec3 {
    rgb(&stage.render(gpu, GiMethod::NONE, layer), EDGE / 2, EDGE / 2)
}

fn assert_close(found: Vec3, expected: Vec3) {
    let error = (found - expected).abs().max_element() / expected.abs().max_element();
    assert!(error < 1e-4, "{found}, expected {expected}");
}

#[test]
fn a_pane_that_shines_is_blended_by_its_alpha() {
    let gpu = gpu();
    let shine = Vec3::new(0.1, 0.5, 2.0);
    for alpha in [0.0, 0.25, 0.7, 1.0] {
        let mut stage = stage();
        pane(&mut stage, glass(Vec3::ZERO, shine, alpha), 0.0, 2.0);
        let expected = alpha * shine + (1.0 - alpha) * BACKGROUND;
        assert_close(middle(&gpu, &stage, Layer::Total), expected);
        let image = stage.render(&gpu, GiMethod::NONE, Layer::Total);
        assert_close(rgb(&image, 0, 0), BACKGROUND);
    }
}

#[test]
fn a_pane_is_lit_and_shadowed() {
    let gpu = gpu();
    let (albedo, alpha, e) = (Vec3::new(0.9, 0.6, 0.3), 0.4, 5.0);
    let toward = Vec3::new(0.0, 0.6, 0.8);
    for shadowed in [false, true] {
        let mut stage = stage();
        pane(&mut stage, glass(albedo, Vec3::ZERO, alpha), 0.0, 2.0);
        stage.light(LightShape::Directional, Vec3::splat(e), Vec3::ZERO, -toward);
        if shadowed {
            let at = Affine3A::from_translation(3.0 * toward);
            stage.add(Shape::Box { size: [0.8, 0.3, 0.3] }, Vec3::ONE, at);
        }
        let lit = if shadowed { Vec3::ZERO } else { albedo / PI * e * toward.z };
        assert_close(middle(&gpu, &stage, Layer::Direct), alpha * lit + (1.0 - alpha) * BACKGROUND);
    }
}

#[test]
fn more_lights_than_one_draw_holds() {
    let gpu = gpu();
    let (albedo, alpha) = (Vec3::splat(0.8), 0.5);
    let mut stage = stage();
    pane(&mut stage, glass(albedo, Vec3::ZERO, alpha), 0.0, 2.0);
    for i in 0..9 {
        stage.light(LightShape::Directional, Vec3::splat(0.1 + i as f32), Vec3::ZERO, Vec3::NEG_Z);
    }
    let lit = albedo / PI * (0..9).map(|i| 0.1 + i as f32).sum::<f32>();
    assert_close(middle(&gpu, &stage, Layer::Direct), alpha * lit + (1.0 - alpha) * BACKGROUND);
}

#[test]
fn the_back_of_a_pane_shows_if_it_is_double_sided() {
    let gpu = gpu();
    let (albedo, alpha, e) = (Vec3::new(0.2, 0.9, 0.4), 0.4, 3.0);
    for double_sided in [false, true] {
        let mut stage = Stage::new(Vec3::new(0.0, 0.0, -1.5), Vec3::ZERO, EDGE);
        let wall = Material { emissive: BACKGROUND, ..Material::diffuse("wall", Vec3::ZERO) };
        stage.add_material(Shape::Box { size: [20.0, 20.0, 0.1] }, wall, Affine3A::from_translation(Vec3::Z * 2.0));
        pane(&mut stage, Material { double_sided, ..glass(albedo, Vec3::ZERO, alpha) }, 0.0, 2.0);
        stage.light(LightShape::Directional, Vec3::splat(e), Vec3::ZERO, Vec3::Z);
        let expected = if double_sided { alpha * albedo / PI * e + (1.0 - alpha) * BACKGROUND } else { BACKGROUND };
        assert_close(middle(&gpu, &stage, Layer::Direct), expected);
    }
}

/// Whatever the order of the scene's arrays.
#[test]
fn three_panes_from_the_farthest_to_the_nearest() {
    let gpu = gpu();
    let panes = [(-1.0, Vec3::X, 0.5), (0.0, Vec3::Y, 0.3), (1.0, Vec3::Z, 0.6)];
    let expected = panes.iter().fold(BACKGROUND, |behind, &(_, shine, alpha)| alpha * shine + (1.0 - alpha) * behind);
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 2, 1]] {
        let mut stage = stage();
        for (z, shine, alpha) in order.map(|i| panes[i]) {
            pane(&mut stage, glass(Vec3::ZERO, shine, alpha), z, 2.0);
        }
        assert_close(middle(&gpu, &stage, Layer::Total), expected);
    }
}

#[test]
fn an_opaque_surface_hides_what_is_blended_behind_it() {
    let gpu = gpu();
    let mut stage = stage();
    pane(&mut stage, glass(Vec3::ZERO, Vec3::ONE, 0.5), -1.0, 4.0);
    let opaque = Material { emissive: Vec3::Y, ..Material::diffuse("opaque", Vec3::ZERO) };
    pane(&mut stage, opaque, 0.0, 1.0);
    assert_close(middle(&gpu, &stage, Layer::Total), Vec3::Y);
    assert_close(rgb(&stage.render(&gpu, GiMethod::NONE, Layer::Total), 10, EDGE / 2), 0.5 * (Vec3::ONE + BACKGROUND));
}

#[test]
fn the_report_says_when_there_is_nothing_to_blend() {
    let gpu = gpu();
    let state = |stage: &Stage, only: Layer| {
        let settings = RenderSettings { gi: GiMethod::NONE, only, ..Default::default() };
        let mut renderer = Renderer::new(&gpu);
        let (_, report) = stage.render_with(&gpu, &mut renderer, &settings);
        let (_, again) = stage.render_with(&gpu, &mut renderer, &settings);
        let find = |report: &lightwell::graph::FrameReport| {
            let pass = report.passes.iter().find(|pass| pass.name == "blend").expect("named in the report");
            (pass.state.clone(), pass.counts.draws)
        };
        (find(&report), find(&again))
    };
    let without = stage();
    let skipped = |why: &str| PassState::Skipped(why.into());
    assert_eq!(state(&without, Layer::Total).0.0, skipped("no blended surface is in view"));
    let mut behind = stage();
    pane(&mut behind, glass(Vec3::ZERO, Vec3::ONE, 0.5), 5.0, 1.0);
    assert_eq!(state(&behind, Layer::Total).0.0, skipped("no blended surface is in view"));
    let mut with = stage();
    pane(&mut with, glass(Vec3::ZERO, Vec3::ONE, 0.5), 0.0, 1.0);
    let ((first, draws), (second, _)) = state(&with, Layer::Total);
    assert_eq!((first, draws, second), (PassState::Ran, 1, PassState::Cached));
    assert_eq!(state(&with, Layer::Albedo).0.0, skipped("the layer that is shown holds no blended surfaces"));
}

/// A room with a lit floor and two panes before its wall.
fn room(albedo: f32) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 1.0, 1.8), Vec3::new(0.0, 1.0, 0.0), EDGE);
    stage.add_room(Vec3::new(-2.0, 0.0, -2.0), Vec3::new(4.0, 3.0, 4.0), Vec3::splat(albedo));
    for (x, color, alpha) in [(-0.7, Vec3::new(0.9, 0.3, 0.2), 0.3), (0.7, Vec3::new(0.2, 0.4, 0.9), 0.45)] {
        let turn = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        let at = Affine3A::from_rotation_translation(turn, Vec3::new(x, 1.2, 0.0));
        let material = Material { double_sided: true, ..glass(color, Vec3::ZERO, alpha) };
        stage.add_material(Shape::Plane { size: [0.9; 2], subdivisions: [1; 2] }, material, at);
    }
    stage.light(LightShape::Point, Vec3::splat(6.0), Vec3::new(0.0, 2.5, 1.0), Vec3::NEG_Y);
    stage.clpv(Vec3::new(0.0, 1.5, 0.0), Clpv { cells: [24; 3], cell_size: CellSize::Meters(0.2), ..Clpv::default() });
    stage
}

fn image(stage: &Stage, gpu: &Gpu, gi: GiMethod, layer: Layer) -> Image {
    let image = stage.render(gpu, gi, layer);
    Image::from_rgba(image.width, image.height, &image.rgba).expect("an image")
}

/// Mean radiance of a block of pixels.
fn mean(image: &Image, x: u32, y: u32) -> Vec3 {
    let pixels = image.pixels();
    let block = (0..6).flat_map(|j| (0..6).map(move |i| (x + i) + (y + j) * EDGE));
    block.map(|index| Vec3::from(pixels[index as usize])).sum::<Vec3>() / 36.0
}

/// Direct light is right but for the shadows of the panes, which are less than half opaque and cast none when drawn;
/// indirect light as well as that of the sweep is.
#[test]
fn drawn_as_traced() {
    let gpu = gpu();
    let stage = room(0.6);
    let mut tracer = PathTracer::new(&gpu);
    tracer.begin(&gpu, &stage.scene, &stage.view, &TraceSettings { bounces: None, seed: 5 }).expect("traceable");
    tracer.advance(&gpu, 256).expect("samples");
    let traced = tracer.estimate(&gpu).expect("an image");
    let drawn = [Layer::Direct, Layer::Indirect].map(|layer| image(&stage, &gpu, GiMethod::CLPV, layer));
    for (x, pane) in [(6, "left"), (20, "right")] {
        for (drawn, traced, most) in [(&drawn[0], traced.direct(), 0.06), (&drawn[1], traced.indirect(), 0.15)] {
            let (found, expected) = (mean(drawn, x, 10), mean(&traced, x, 10));
            let error = (found - expected).abs().max_element() / expected.max_element();
            println!("{pane}: {found}, traced {expected}, error {error:.3}");
            assert!(error < most, "{pane}: {found}, traced {expected}");
        }
    }
}

/// Every method lends its light to blended surfaces. Light culling has one of the many bounces.
#[test]
fn all_methods_light_panes() {
    let gpu = gpu();
    let stage = room(0.6);
    let expected = mean(&image(&stage, &gpu, GiMethod::CLPV, Layer::Indirect), 6, 10).x;
    let mut propagated = room(0.6);
    if let Some(clpv) = &mut propagated.scene.clpv {
        clpv.settings.transport = lightwell::world::Transport::Diffusion;
    }
    let cases = [(&stage, GiMethod::VPL, 0.5), (&stage, GiMethod::SLC, 0.2), (&propagated, GiMethod::CLPV, 0.1)];
    for (stage, gi, least) in cases {
        let panes = image(stage, &gpu, gi, Layer::Indirect);
        let mut walls = room(0.6);
        walls.scene.clpv = stage.scene.clpv.clone();
        walls.scene.primitives.truncate(6);
        let walls = image(&walls, &gpu, gi, Layer::Indirect);
        // What the pane itself adds to the 70 % of the wall behind.
        let added = |x| mean(&panes, x, 10).x - 0.7 * mean(&walls, x, 10).x;
        let (found, shares) = (mean(&panes, 6, 10).x, added(6) / mean(&panes, 6, 10).x);
        println!("{gi:?}: {found}, swept {expected}, of the pane itself {shares}");
        assert!(found > least * expected && found < 1.5 * expected, "{gi:?}: {found}, swept {expected}");
        assert!(shares > 0.1 && shares < 0.7, "{gi:?}: the pane adds {shares}");
    }
}
