//! Indirect light averaged over frames: noise that goes, light that is followed, cameras that move, and rest.

use crate::support::{Stage, error, gpu, left_of};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, ImageF32, read_buffer, read_texture_f32};
use lightwell::graph::{FrameReport, PassState};
use lightwell::measure::Image;
use lightwell::render::reference::{PathTracer, TraceSettings};
use lightwell::render::{GiMethod, Layer, MOST_FRAMES, RenderSettings, Renderer};
use lightwell::scene::LightShape;
use lightwell::world::{Bounces, Clpv, Delta, GatherRays, Quality, StochasticLightCulling};

fn settings(average: bool) -> RenderSettings {
    RenderSettings { only: Layer::Indirect, display: false, average, ..Default::default() }
}

fn clpv(rays: u32) -> Clpv {
    Clpv {
        bounces: Bounces::Count(1),
        quality: Quality::Low,
        gather_rays: GatherRays::Count(rays),
        gather_filter: 0,
        ..Default::default()
    }
}

/// A lamp in a closed room of 4 m.
fn room(settings: Clpv, lamp: Vec3) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 48);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    stage.light(LightShape::Point, Vec3::splat(2.0), lamp, Vec3::NEG_Y);
    stage.clpv(Vec3::ZERO, settings);
    stage
}

const LAMP: Vec3 = Vec3::new(0.3, 0.6, -0.2);

fn traced(gpu: &Gpu, stage: &Stage, bounces: Option<u32>) -> Image {
    let mut tracer = PathTracer::new(gpu);
    let settings = TraceSettings { bounces, seed: 3 };
    tracer.begin(gpu, &stage.scene, &stage.view, &settings).expect("a scene that can be traced");
    tracer.advance(gpu, 256).expect("a device");
    tracer.estimate(gpu).expect("an image").indirect()
}

/// The last of so many frames.
fn frames(gpu: &Gpu, renderer: &mut Renderer, stage: &Stage, count: u32) -> (ImageF32, FrameReport) {
    let mut drawn = stage.render_with(gpu, renderer, &settings(true));
    for _ in 1..count {
        drawn = stage.render_with(gpu, renderer, &settings(true));
    }
    drawn
}

fn bits(image: &ImageF32) -> Vec<[u32; 4]> {
    image.rgba.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
fn a_view_that_rests_loses_its_noise_and_comes_to_rest() {
    let gpu = gpu();
    let stage = room(clpv(1), LAMP);
    let truth = traced(&gpu, &stage, Some(1));
    let mut renderer = Renderer::new(&gpu);
    let (first, _) = frames(&gpu, &mut renderer, &stage, 1);
    assert!(renderer.is_settling());
    let mut count = 1;
    let mut last = first.clone();
    while renderer.is_settling() {
        last = frames(&gpu, &mut renderer, &stage, 1).0;
        count += 1;
        assert!(count <= 2 * MOST_FRAMES, "no rest after {count} frames");
    }
    assert!(count >= MOST_FRAMES, "{count} frames");
    let ((noisy, _), (rested, bias)) = (error(&first, &truth), error(&last, &truth));
    assert!(rested < 0.2 * noisy && bias.abs() < 0.02, "{noisy} became {rested}, bias {bias}");
    let (again, report) = frames(&gpu, &mut renderer, &stage, 1);
    assert_eq!(bits(&again), bits(&last), "an image at rest changes");
    let ran: Vec<_> = report.passes.iter().filter(|pass| pass.state == PassState::Ran).map(|pass| &pass.name).collect();
    assert!(ran.is_empty(), "at rest there run {ran:?}");
}

/// Median over the image of how far a pixel is from the mean of its four neighbours, over that mean.
fn grain(image: &ImageF32) -> f32 {
    let at = |x: u32, y: u32| image.rgba[(x + y * image.width) as usize][1];
    let mut grain = Vec::new();
    for y in 1..image.height - 1 {
        for x in 1..image.width - 1 {
            let around = 0.25 * (at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1));
            grain.push((at(x, y) - around).abs() / around.max(1e-6));
        }
    }
    grain.sort_by(f32::total_cmp);
    grain[grain.len() / 2]
}

/// The filter narrows with the rays that the mean holds, and not so fast that the image gets noisier.
#[test]
fn a_view_that_rests_gets_smoother_with_every_doubling_of_frames() {
    let gpu = gpu();
    let stage = room(Clpv::default(), LAMP);
    let mut renderer = Renderer::new(&gpu);
    let mut grains = Vec::new();
    let mut count = 0;
    for wanted in [2, 4, 8, 16, 32, 64] {
        let (shown, _) = frames(&gpu, &mut renderer, &stage, wanted - count);
        count = wanted;
        let mean =
            read_texture_f32(&gpu, renderer.target("averaged indirect radiance").expect("a mean")).expect("readable");
        assert!(
            grain(&shown) < 0.95 * grain(&mean),
            "{count} frames: the filter leaves {} of {}",
            grain(&shown),
            grain(&mean)
        );
        grains.push(grain(&mean));
    }
    let falls = grains.windows(2).all(|pair| pair[1] < 1.1 * pair[0]);
    assert!(falls && grains[5] < 0.85 * grains[0], "grain after 2 to 64 frames: {grains:?}");
}

/// Remaining noise is filtered as far as its variance goes, and the mean that later frames continue stays unfiltered.
#[test]
fn noise_that_is_left_in_a_mean_is_filtered() {
    let gpu = gpu();
    let means = |quality, count| {
        let stage = room(Clpv { quality, gather_filter: 0, ..Default::default() }, LAMP);
        let mut renderer = Renderer::new(&gpu);
        let (filtered, _) = frames(&gpu, &mut renderer, &stage, count);
        let mean = renderer.target("averaged indirect radiance").expect("frames are averaged");
        (read_texture_f32(&gpu, mean).expect("readable"), filtered)
    };
    let (converged, _) = means(Quality::High, MOST_FRAMES);
    let pixels = converged.rgba.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let truth = Image::from_pixels(converged.width, converged.height, pixels).expect("all pixels");
    for count in [16, 64] {
        let (mean, filtered) = means(Quality::Medium, count);
        let ((noisy, _), (left, bias)) = (error(&mean, &truth), error(&filtered, &truth));
        println!("{count} frames: {noisy:.4} becomes {left:.4}, bias {bias:.4}");
        assert!(left < 0.9 * noisy && bias.abs() < 0.01, "{count} frames: {noisy} becomes {left}, bias {bias}");
    }
}

#[test]
fn light_that_moves_is_followed_within_eight_frames() {
    let gpu = gpu();
    let place = Vec3::new(-1.2, -1.0, 1.0);
    let (stage, mut moved) = (room(clpv(8), LAMP), room(clpv(8), place));
    moved.scene.revisions.lights += 1;
    moved.scene.lights[0].revision += 1;
    let (before, after) = (traced(&gpu, &stage, Some(1)), traced(&gpu, &moved, Some(1)));
    let mut renderer = Renderer::new(&gpu);
    frames(&gpu, &mut renderer, &stage, 30);
    let (first, _) = frames(&gpu, &mut renderer, &moved, 1);
    let (eighth, _) = frames(&gpu, &mut renderer, &moved, 7);
    let (first, eighth) = (left_of(&before, &after, &first), left_of(&before, &after, &eighth));
    assert!((0.5..0.9).contains(&first), "after a frame {first} is left: frames are not averaged");
    assert!(eighth.abs() < 0.1, "after eight frames {eighth} is left");
    let (rested, _) = frames(&gpu, &mut renderer, &moved, 2 * MOST_FRAMES);
    let (_, bias) = error(&rested, &after);
    assert!(left_of(&before, &after, &rested).abs() < 0.02 && bias.abs() < 0.02, "at rest, bias {bias}");
}

#[test]
fn a_camera_that_moves_takes_light_along() {
    let gpu = gpu();
    let mut stage = room(clpv(1), LAMP);
    let mut renderer = Renderer::new(&gpu);
    frames(&gpu, &mut renderer, &stage, 40);
    // A step aside and a turn: parts of the image were not seen before.
    let camera = &mut stage.view.camera.world_from_view;
    camera.translation += glam::Vec3A::new(0.1, 0.05, -0.1);
    camera.matrix3 = glam::Mat3A::from_quat(Quat::from_rotation_y(0.1)) * camera.matrix3;
    let truth = traced(&gpu, &stage, Some(1));
    let (moved, _) = frames(&gpu, &mut renderer, &stage, 1);
    let (alone, _) = frames(&gpu, &mut Renderer::new(&gpu), &stage, 1);
    let ((kept, bias), (noisy, _)) = (error(&moved, &truth), error(&alone, &truth));
    assert!(kept < 0.6 * noisy && bias.abs() < 0.05, "error {kept} with frames before, {noisy} without; bias {bias}");
}

#[test]
fn frames_that_are_not_averaged_know_nothing_of_others() {
    let gpu = gpu();
    let mut stage = room(clpv(2), LAMP);
    let (fresh, _) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &settings(false));
    let mut renderer = Renderer::new(&gpu);
    let (averaged, _) = frames(&gpu, &mut renderer, &stage, 5);
    assert_ne!(bits(&averaged), bits(&fresh));
    let (alone, _) = stage.render_with(&gpu, &mut renderer, &settings(false));
    assert_eq!(bits(&alone), bits(&fresh), "a frame that stands for itself has something of those before");
    assert!(!renderer.is_settling());
    // A layer without indirect light gets no better, however often it is drawn.
    frames(&gpu, &mut renderer, &stage, 3);
    let direct = RenderSettings { only: Layer::Direct, ..settings(true) };
    stage.render_with(&gpu, &mut renderer, &direct);
    assert!(!renderer.is_settling());
    stage.render_with(&gpu, &mut renderer, &settings(false));
    // The first of a new row knows nothing of the last one's either, nor does one of another size.
    let (first, _) = frames(&gpu, &mut renderer, &stage, 1);
    assert_eq!(bits(&first), bits(&frames(&gpu, &mut Renderer::new(&gpu), &stage, 1).0));
    stage.view.size = [31, 17];
    let (other, _) = frames(&gpu, &mut renderer, &stage, 1);
    assert_eq!(bits(&other), bits(&frames(&gpu, &mut Renderer::new(&gpu), &stage, 1).0));
}

#[test]
fn virtual_lights_by_chance_are_averaged_too() {
    let gpu = gpu();
    let mut stage = room(Clpv::default(), LAMP);
    let coarse = StochasticLightCulling { delta: Delta::Relative(0.03), filter_radius: 0, ..Default::default() };
    stage.scene.slc = Some(coarse);
    let truth = traced(&gpu, &stage, Some(1));
    let mut renderer = Renderer::new(&gpu);
    let slc = RenderSettings { gi: GiMethod::SLC, ..settings(true) };
    let (first, _) = stage.render_with(&gpu, &mut renderer, &slc);
    let mut last = first.clone();
    for _ in 0..24 {
        last = stage.render_with(&gpu, &mut renderer, &slc).0;
    }
    let ((noisy, _), (rested, _)) = (error(&first, &truth), error(&last, &truth));
    assert!(rested < 0.5 * noisy, "{noisy} became {rested}");
}

/// A small bright patch in a dark room: along few directions its light makes rays.
#[test]
fn directions_that_change_leave_no_rays() {
    let gpu = gpu();
    let mut found = [0.0; 2];
    for (vary_directions, found) in [false, true].into_iter().zip(&mut found) {
        let volumes = Clpv { vary_directions, bounces: Bounces::Count(1), ..clpv(0) };
        let mut stage = room(volumes, LAMP);
        stage.scene.lights[0].shape = LightShape::Spot { inner: 0.1, outer: 0.2 };
        let truth = traced(&gpu, &stage, Some(1));
        let mut renderer = Renderer::new(&gpu);
        let (image, report) = frames(&gpu, &mut renderer, &stage, 48);
        let averages = report.passes.iter().any(|pass| pass.name == "average" && pass.state == PassState::Ran);
        assert_eq!(averages, vary_directions, "averaged is what changes from frame to frame");
        *found = error(&image, &truth).0;
    }
    assert!(found[1] < 0.8 * found[0], "error {found:?} with one set of directions and with many");
}

/// Plates of less than a pixel before a wall, five pixels apart.
fn plates() -> Stage {
    let mut stage = Stage::new(Vec3::ZERO, Vec3::NEG_Z, 33);
    let wall = Shape::Box { size: [90.0, 90.0, 1.0] };
    stage.add(wall, Vec3::splat(0.1), Affine3A::from_translation(Vec3::new(0.0, 0.0, -30.0)));
    for pixel in plate_pixels() {
        let plate = Shape::Box { size: [0.6, 0.6, 0.1] };
        let [x, y] = pixel.map(|at| (at as f32 - 16.0) * 36.0 / 33.0);
        stage.add(plate, Vec3::splat(0.5), Affine3A::from_translation(Vec3::new(x, -y, -18.0)));
    }
    stage.light(LightShape::Point, Vec3::splat(200.0), Vec3::new(0.0, 3.0, -2.0), Vec3::NEG_Z);
    stage.scene.sky = Vec3::ONE;
    stage.clpv(Vec3::new(0.0, 0.0, -18.0), Clpv { quality: Quality::Medium, ..Default::default() });
    stage
}

fn plate_pixels() -> impl Iterator<Item = [u32; 2]> {
    (0..25).map(|index| [4 + 5 * (index % 5), 4 + 5 * (index / 5)])
}

/// Of each four pixels a frame gathers at one; what none of those around a pixel shows has rays in every frame.
#[test]
fn a_sparse_frame_casts_rays_for_what_its_neighbours_do_not_show() {
    let gpu = gpu();
    let stage = plates();
    let mut renderer = Renderer::new(&gpu);
    let mut counts = Vec::new();
    for _ in 0..5 {
        frames(&gpu, &mut renderer, &stage, 1);
        let count = renderer.buffer("number of pixels that are left out");
        counts.push(count.map_or(0, |count| read_buffer::<u32>(&gpu, count).expect("readable")[0]));
    }
    // The first frame gathers everywhere. In four others each pixel is gathered at once.
    assert_eq!((counts[0], counts[1..].iter().sum::<u32>()), (0, 75), "{counts:?}");
}
