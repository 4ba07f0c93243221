//! Savings of light culling: all virtual lights against those that are accepted, and spheroids against spheres, in turns in
//! one run. Run with `--nocapture` for the figures.

use lightwell::assets::Material;
use lightwell::render::slc::{ACCEPTED, TESTED};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::world::{LightBounds, LightCulling, StochasticLightCulling};
use lightwell_tests::{Stage, root};
use std::sync::Arc;

const ROUNDS: u32 = 1;

/// Least time of culling and shading [ms], and lights tested and accepted a pixel.
#[derive(Clone, Copy, Debug)]
struct Cost {
    ms: f64,
    tested: f64,
    accepted: f64,
}

fn draw(stage: &mut Stage, settings: &StochasticLightCulling, jitter: f32) -> Cost {
    stage.scene.slc = Some(settings.clone());
    let frame = RenderSettings {
        gi: GiMethod::SLC,
        only: Layer::Indirect,
        display: false,
        no_cache: true,
        ..Default::default()
    };
    let report = stage.draw(&frame, [jitter, 0.0]);
    let stages = ["slc error bound", "slc ranges", "slc cull", "slc shade"];
    let passes = report.passes.iter().filter(|pass| stages.contains(&pass.name.as_str()));
    let [tested, accepted] = [TESTED, ACCEPTED].map(|name| stage.mean_alpha(name));
    Cost { ms: passes.filter_map(|pass| pass.gpu_ms).sum(), tested, accepted }
}

/// All settings in turns.
fn costs<const N: usize>(stage: &mut Stage, settings: [StochasticLightCulling; N]) -> [Cost; N] {
    let mut best = settings.each_ref().map(|one| draw(stage, one, 0.25));
    for round in 0..ROUNDS {
        for (best, one) in best.iter_mut().zip(&settings) {
            best.ms = best.ms.min(draw(stage, one, 0.1 * round as f32).ms);
        }
    }
    best
}

fn mean(stage: &mut Stage, settings: &StochasticLightCulling) -> f64 {
    draw(stage, settings, 0.0);
    let image = stage.radiance();
    image.pixels().iter().map(|p| f64::from(p[0] + p[1] + p[2])).sum::<f64>() / image.pixels().len() as f64
}

#[test]
fn culling_beats_the_sum_over_all_lights_at_the_same_mean() {
    // As large as a tile of 128 × 128 pixels deserves.
    let mut stage = Stage::open(&root().join("scenes/cornell.scene.ron"), None, [512; 2]);
    let culled = StochasticLightCulling::default();
    let all = StochasticLightCulling { culling: LightCulling::None, ..culled.clone() };
    let [fast, slow] = costs(&mut stage, [culled.clone(), all.clone()]);
    let [found, truth] = [&culled, &all].map(|settings| mean(&mut stage, settings));
    eprintln!(
        "cornell: {:.0} of {:.0} lights a pixel tested, {:.0} accepted; {:.0} ms against {:.0} ms: {:.1} times; mean {:+.2} %",
        fast.tested,
        slow.tested,
        fast.accepted,
        fast.ms,
        slow.ms,
        slow.ms / fast.ms,
        100.0 * (found / truth - 1.0)
    );
    assert!((found / truth - 1.0).abs() < 0.02, "mean {found}, of all lights {truth}");
    assert!(slow.tested > 10.0 * fast.tested, "{fast:?} {slow:?}");
    assert!(slow.ms > 5.0 * fast.ms, "{fast:?} {slow:?}");
}

#[test]
fn spheroids_beat_centred_spheres_on_glossy_surfaces() {
    let mut stage = Stage::open(&root().join("scenes/glossy_ring.scene.ron"), None, [256; 2]);
    // GGX α = 0.1 everywhere.
    let gold = Material::diffuse("gold", glam::Vec3::new(1.0, 0.77, 0.34));
    let gold = Arc::new(Material { metallic: 1.0, roughness: 0.1_f32.sqrt(), specular: 1.0, ..gold });
    stage.scene.primitives.iter_mut().for_each(|primitive| primitive.material = Arc::clone(&gold));
    let spheroids = StochasticLightCulling::default();
    let spheres = StochasticLightCulling { bounds: LightBounds::CentredSphere, ..spheroids.clone() };
    let [few, many] = costs(&mut stage, [spheroids, spheres]);
    let vain = |cost: &Cost| cost.tested - cost.accepted;
    eprintln!(
        "α = 0.1: spheroids {:.0} tested, {:.0} ms; centred spheres {:.0} tested, {:.0} ms: {:.1} times; {:.0} % fewer in vain",
        few.tested,
        few.ms,
        many.tested,
        many.ms,
        many.ms / few.ms,
        100.0 * (1.0 - vain(&few) / vain(&many))
    );
    assert!(vain(&few) < 0.5 * vain(&many), "{few:?} {many:?}");
    assert!(many.ms > 1.5 * few.ms, "{few:?} {many:?}");
}
