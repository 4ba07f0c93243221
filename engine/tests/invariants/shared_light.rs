//! Images that take the light that another one with a shifted pixel grid has gathered: no rays for their own, the same light,
//! smooth edges, and bits that do not depend on what was drawn before.

use crate::support::{Stage, gpu};
use glam::{Affine3A, Vec3};
use lightwell::assets::{Material, Shape};
use lightwell::gpu::{Gpu, read_buffer};
use lightwell::graph::{FrameReport, PassState};
use lightwell::measure::{Comparison, Image, compare};
use lightwell::render::{GiMethod, Layer, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Quality};

const EDGE: u32 = 64;
const GATHERED_AT: [f32; 2] = [0.0; 2];

/// A room with a block and a rod that is about half as wide as a pixel.
fn room() -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 0.6, 1.7), Vec3::new(-1.0, -1.0, -1.2), EDGE);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.55, 0.4));
    let block = Shape::Box { size: [0.8, 1.2, 0.8] };
    stage.add(block, Vec3::new(0.8, 0.2, 0.2), Affine3A::from_translation(Vec3::new(-0.5, -1.4, -0.4)));
    let rod = Shape::Box { size: [0.03, 3.9, 0.03] };
    stage.add(rod, Vec3::new(0.1, 0.2, 0.9), Affine3A::from_translation(Vec3::new(0.9, 0.0, -0.6)));
    stage.light(LightShape::Point, Vec3::splat(2.0), Vec3::new(0.3, 1.2, -0.2), Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, Clpv { quality: Quality::Ultra, ..Default::default() });
    stage
}

fn shifts() -> impl Iterator<Item = [f32; 2]> {
    (0..16).map(|index| [(index % 4) as f32 / 4.0 - 0.375, (index / 4) as f32 / 4.0 - 0.375])
}

fn draw(
    gpu: &Gpu,
    renderer: &mut Renderer,
    stage: &mut Stage,
    jitter: [f32; 2],
    gathered_at: Option<[f32; 2]>,
) -> (Image, FrameReport) {
    stage.view.jitter = jitter;
    let settings = RenderSettings { only: Layer::Indirect, display: false, gathered_at, ..Default::default() };
    let (image, report) = stage.render_with(gpu, renderer, &settings);
    let image = Image::from_rgba(image.width, image.height, &image.rgba).expect("a whole image");
    (image, report)
}

fn mean_of(gpu: &Gpu, stage: &mut Stage, gathered_at: Option<[f32; 2]>) -> Image {
    let mut renderer = Renderer::new(gpu);
    let mut sum = vec![[0.0; 3]; (EDGE * EDGE) as usize];
    for jitter in shifts() {
        let (image, _) = draw(gpu, &mut renderer, stage, jitter, gathered_at);
        for (sum, value) in sum.as_flattened_mut().iter_mut().zip(image.values()) {
            *sum += value / 16.0;
        }
    }
    Image::from_pixels(EDGE, EDGE, sum).expect("a whole image")
}

fn difference(image: &Image, expected: &Image) -> Comparison {
    compare(image, expected).expect("images of one size")
}

#[test]
fn only_the_first_of_a_row_casts_rays() {
    let gpu = gpu();
    let (mut stage, mut renderer) = (room(), Renderer::new(&gpu));
    let (_, first) = draw(&gpu, &mut renderer, &mut stage, [0.25, -0.25], Some(GATHERED_AT));
    assert_eq!(first.pass("gather").expect("the pass").state, PassState::Ran);
    let (_, second) = draw(&gpu, &mut renderer, &mut stage, [-0.4, 0.1], Some(GATHERED_AT));
    assert_eq!(second.pass("gather filter, vertical").expect("the pass").state, PassState::Cached);
    let rays: u64 = second.passes.iter().map(|pass| pass.counts.rays).sum();
    assert_eq!(rays, 0, "rays of the second image");
    assert_eq!(second.pass("gather shift").expect("the pass").state, PassState::Ran);
}

#[test]
fn bits_do_not_depend_on_what_was_drawn_before() {
    let gpu = gpu();
    let (mut stage, mut renderer) = (room(), Renderer::new(&gpu));
    for jitter in shifts().take(3) {
        draw(&gpu, &mut renderer, &mut stage, jitter, Some(GATHERED_AT));
    }
    let (again, _) = draw(&gpu, &mut renderer, &mut stage, [0.3, 0.2], Some(GATHERED_AT));
    let (fresh, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, [0.3, 0.2], Some(GATHERED_AT));
    assert_eq!(again.first_bit_difference(&fresh), None);
}

#[test]
fn an_image_that_gathers_for_itself_keeps_its_light() {
    let gpu = gpu();
    let mut stage = room();
    let (shared, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, Some(GATHERED_AT));
    let (own, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, None);
    let error = difference(&shared, &own).nrmse;
    assert!(error < 0.02, "{error}");
}

#[test]
fn the_mean_over_shifts_is_as_if_each_had_gathered() {
    let gpu = gpu();
    let mut stage = room();
    let own = mean_of(&gpu, &mut stage, None);
    let shared = mean_of(&gpu, &mut stage, Some(GATHERED_AT));
    let (single, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, None);
    let (of_shared, of_single) = (difference(&shared, &own).nrmse, difference(&single, &own).nrmse);
    let bias = difference(&shared, &own).bias;
    eprintln!("error {of_shared:.4}, of a single image {of_single:.4}, bias {bias:.4}");
    assert!(of_shared < 0.35 * of_single, "{of_shared} against {of_single}");
    assert!(bias.abs() < 0.01, "bias {bias}");
}

#[test]
fn what_is_thinner_than_a_pixel_has_light() {
    let gpu = gpu();
    let mut stage = room();
    let (own, shared) = (mean_of(&gpu, &mut stage, None), mean_of(&gpu, &mut stage, Some(GATHERED_AT)));
    let is_rod = |pixel: &[f32; 3]| pixel[2] > 0.75 * pixel[0];
    let pairs = own.pixels().iter().zip(shared.pixels()).filter(|(own, _)| is_rod(own));
    let (mut of_own, mut of_shared, mut count) = (0.0, 0.0, 0);
    pairs.for_each(|(own, shared)| (of_own, of_shared, count) = (of_own + own[2], of_shared + shared[2], count + 1));
    let ratio = of_shared / of_own;
    assert!(count > 8 && (0.95..1.05).contains(&ratio), "{ratio} over {count} pixels");
}

#[test]
fn methods_that_do_not_gather_draw_what_they_drew() {
    let gpu = gpu();
    let mut stage = room();
    stage.scene.clpv.as_mut().expect("volumes").settings.transport = lightwell::world::Transport::Diffusion;
    let mut image = |gathered_at| draw(&gpu, &mut Renderer::new(&gpu), &mut stage, [0.2, 0.1], gathered_at).0;
    assert_eq!(image(Some(GATHERED_AT)).first_bit_difference(&image(None)), None);
    let settings = RenderSettings::default();
    let mut renderer = Renderer::new(&gpu);
    draw(&gpu, &mut renderer, &mut stage, GATHERED_AT, None);
    assert!(!renderer.shares_light(&stage.scene, &settings));
    assert!(renderer.shares_light(&room().scene, &settings));
    assert!(!renderer.shares_light(&room().scene, &RenderSettings { gi: GiMethod::NONE, ..settings }));
}

/// A surface of a single pixel has no lit pixel beside it.
#[test]
fn what_stands_alone_before_the_sky_has_light() {
    let gpu = gpu();
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 33);
    stage.add(Shape::Box { size: [1.0; 3] }, Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(0.0, 0.0, -20.0)));
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::new(0.0, 0.0, -20.0), Clpv { quality: Quality::Medium, ..Default::default() });
    let mut light = |gathered_at| {
        let (image, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, gathered_at);
        image.pixel(16, 16)[1]
    };
    let (own, shared) = (light(None), light(Some(GATHERED_AT)));
    assert!(own > 0.1 && (shared / own - 1.0).abs() < 0.05, "{shared} of {own}");
}

/// Rough metal before the walls of a room: it has specular light alone.
#[test]
fn rough_metal_has_light() {
    let gpu = gpu();
    let mut stage = room();
    let metal = Material { metallic: 1.0, roughness: 0.7, ..Material::diffuse("metal", Vec3::splat(0.8)) };
    let cube = Shape::Box { size: [0.8; 3] };
    stage.add_material(cube, metal, Affine3A::from_translation(Vec3::new(0.4, -0.6, 0.2)));
    let (own, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, None);
    let (shared, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, Some(GATHERED_AT));
    let error = difference(&shared, &own).nrmse;
    assert!(error < 0.02, "{error}");
}

/// A plate outside of a dark cave, narrower than a pixel.
fn plate_before_a_cave() -> Stage {
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 33);
    let cave = Vec3::new(0.0, 0.0, -35.0);
    stage.add(Shape::Box { size: [60.0, 60.0, 1.0] }, Vec3::splat(0.5), Affine3A::from_translation(cave));
    for side in [-1.0, 1.0] {
        let sides = [
            (Vec3::new(0.0, 8.0 * side, -28.0), [60.0, 1.0, 15.0]),
            (Vec3::new(8.0 * side, 0.0, -28.0), [1.0, 60.0, 15.0]),
        ];
        for (center, size) in sides {
            stage.add(Shape::Box { size }, Vec3::splat(0.05), Affine3A::from_translation(center));
        }
    }
    let plate = Shape::Box { size: [0.6, 0.6, 0.1] };
    stage.add(plate, Vec3::splat(0.5), Affine3A::from_translation(Vec3::new(0.0, 0.0, -18.0)));
    stage.scene.sky = Vec3::ONE;
    stage.clpv(cave, Clpv { quality: Quality::Ultra, ..Default::default() });
    stage
}

/// Number of the pixels that had rays of their own in the last frame.
fn strays(gpu: &Gpu, renderer: &Renderer) -> u32 {
    let counts = renderer.buffer("number of pixels that are left out").expect("the queue");
    read_buffer::<u32>(gpu, counts).expect("readable")[0]
}

#[test]
fn what_no_gathered_pixel_shows_has_rays_of_its_own() {
    let gpu = gpu();
    let mut stage = plate_before_a_cave();
    let beside = [0.5, 0.5];
    let mut renderer = Renderer::new(&gpu);
    let (shared, _) = draw(&gpu, &mut renderer, &mut stage, GATHERED_AT, Some(beside));
    assert_eq!(strays(&gpu, &renderer), 1);
    let (own, _) = draw(&gpu, &mut Renderer::new(&gpu), &mut stage, GATHERED_AT, None);
    let (there, expected, behind) = (shared.pixel(16, 16)[1], own.pixel(16, 16)[1], own.pixel(14, 16)[1]);
    assert!(expected > 1.5 * behind, "the plate has {expected}, what is behind it {behind}");
    assert!((there / expected - 1.0).abs() < 0.02, "{there} in place of {expected}");
}

#[test]
fn where_all_is_gathered_no_rays_are_cast() {
    let gpu = gpu();
    let mut stage = plate_before_a_cave();
    let mut renderer = Renderer::new(&gpu);
    draw(&gpu, &mut renderer, &mut stage, GATHERED_AT, Some(GATHERED_AT));
    assert_eq!(strays(&gpu, &renderer), 0);
}
