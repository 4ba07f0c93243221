//! Indirect light of the sweep transport against images of an independent renderer. They lie in the folder that
//! `LIGHTWELL_REFERENCE` names; without it the tests say so and pass.
//!
//! The bounds stand a little above what was measured. Most of the error lies within two cells of the edges where
//! surfaces meet, and in the rays that few directions make of a small lit spot.

use lightwell::measure::{Image, compare, read_image};
use lightwell::render::{Layer, RenderSettings};
use lightwell::world::{Bounces, GatherRays, Quality};
use lightwell_needs::needs;
use lightwell_tests::{Stage, folder_from_env};

const EDGE: u32 = 256;

/// Mean of two by two pixels.
fn halved(image: &Image) -> Image {
    let [width, height] = image.size().map(|edge| edge / 2);
    let mut half = Image::filled(width, height, [0.0; 3]);
    for y in 0..2 * height {
        for x in 0..2 * width {
            let from = image.pixels()[(y * 2 * width + x) as usize];
            let to = &mut half.pixels_mut()[(y / 2 * width + x / 2) as usize];
            (0..3).for_each(|channel| to[channel] += 0.25 * from[channel]);
        }
    }
    half
}

struct Case {
    scene: &'static str,
    bounces: Bounces,
    quality: Quality,
    rays: GatherRays,
}

/// Most nrmse and bias.
fn check(Case { scene, bounces, quality, rays }: Case, most: (f64, f64)) {
    let folder = folder_from_env("LIGHTWELL_REFERENCE");
    let folder = folder.join(scene);
    let name = if bounces == Bounces::Converged { "indirect_inf.exr" } else { "indirect_k1.exr" };
    let reference = halved(&read_image(&folder.join(name)).unwrap_or_else(|error| panic!("{error}")));
    assert_eq!(reference.size(), [EDGE; 2]);
    let mut stage = Stage::open(&folder.join("scene.glb"), None, [EDGE; 2]);
    let clpv = &mut stage.scene.clpv.as_mut().expect("a model gets a light volume").settings;
    (clpv.bounces, clpv.quality, clpv.gather_rays) = (bounces, quality, rays);
    let settings = RenderSettings { only: Layer::Indirect, display: false, ..RenderSettings::default() };
    let image = stage.averaged(&settings, 4);
    let comparison = compare(&image, &reference).unwrap_or_else(|error| panic!("{error}"));
    let (nrmse, bias) = (comparison.nrmse, comparison.bias);
    eprintln!("{scene}, {bounces:?}, {quality:?}, {rays:?}: nrmse {nrmse:.4}, bias {bias:.4}");
    assert!(nrmse < most.0 && bias.abs() < most.1, "{scene}, {quality:?}, {rays:?}: nrmse {nrmse:.4}, bias {bias:.4}");
}

/// The volumes alone, of high quality.
fn looked_up(scene: &'static str, bounces: Bounces, most: (f64, f64)) {
    check(Case { scene, bounces, quality: Quality::High, rays: GatherRays::Count(0) }, most);
}

/// A quality as it is.
fn of_quality(scene: &'static str, bounces: Bounces, quality: Quality, most: (f64, f64)) {
    check(Case { scene, bounces, quality, rays: GatherRays::Auto }, most);
}

#[needs("LIGHTWELL_REFERENCE")]
fn one_bounce_in_the_cornell_box() {
    looked_up("cornell", Bounces::Count(1), (0.1, 0.03));
    of_quality("cornell", Bounces::Count(1), Quality::High, (0.08, 0.01));
}

#[needs("LIGHTWELL_REFERENCE")]
fn all_bounces_in_the_cornell_box() {
    looked_up("cornell", Bounces::Converged, (0.07, 0.03));
    of_quality("cornell", Bounces::Converged, Quality::Medium, (0.06, 0.015));
    of_quality("cornell", Bounces::Converged, Quality::High, (0.05, 0.015));
}

#[needs("LIGHTWELL_REFERENCE")]
fn one_bounce_among_the_cubes() {
    looked_up("bleeding_diffuse", Bounces::Count(1), (0.17, 0.05));
    of_quality("bleeding_diffuse", Bounces::Count(1), Quality::High, (0.075, 0.01));
}

#[needs("LIGHTWELL_REFERENCE")]
fn all_bounces_among_the_cubes() {
    looked_up("bleeding_diffuse", Bounces::Converged, (0.185, 0.045));
    of_quality("bleeding_diffuse", Bounces::Converged, Quality::Medium, (0.085, 0.01));
    of_quality("bleeding_diffuse", Bounces::Converged, Quality::High, (0.075, 0.01));
}
