//! Costs of virtual lights: casts through the hierarchy against brute force on Sponza, and one pass for all lights
//! against one pass a light. Run with `--nocapture` for the figures. The first needs Sponza (`LIGHTWELL_MODELS`).

use lightwell::bvh::Ray;
use lightwell::render::vpl::{Caster, IntersectionCounts, virtual_lights};
use lightwell::render::{GiMethod, Layer, RenderSettings};
use lightwell::scene::SceneBvh;
use lightwell::world::{Accumulation, InstantRadiosity, ParticleCasts, VirtualVisibility};
use lightwell_needs::needs;
use lightwell_tests::{Stage, folder_from_env, root};
use lightwell_tools::bench::plot::{Curve, sweep};
use std::time::Instant;

/// Seconds a ray and tests of all rays.
fn cast(caster: &Caster, rays: &[Ray]) -> (f64, IntersectionCounts) {
    let mut counts = IntersectionCounts::default();
    let start = Instant::now();
    let hits = rays.iter().filter(|ray| caster.cast(ray, &mut counts).is_some()).count();
    assert!(hits * 2 > rays.len(), "most rays meet the building");
    (start.elapsed().as_secs_f64() / rays.len() as f64, counts)
}

#[needs("LIGHTWELL_MODELS")]
fn the_hierarchy_beats_brute_force_on_sponza() {
    let models = folder_from_env("LIGHTWELL_MODELS");
    let stage = Stage::open(&root().join("scenes/sponza.scene.ron"), Some(models), [16; 2]);
    let bvh = SceneBvh::new(&stage.scene);
    let eye = glam::Vec3::from(stage.camera().world_from_view.translation);
    let ray = |i: u32| {
        let part = |prime: f32| (i as f32 * prime).fract() * 2.0 - 1.0;
        Ray::new(eye, glam::Vec3::new(part(0.618_034), part(0.754_878), part(0.569_841)).normalize())
    };
    let rays: Vec<Ray> = (1..20_000).map(ray).collect();
    let (hierarchy, tests) = cast(&Caster::new(&stage.scene, &bvh, ParticleCasts::Hierarchy), &rays);
    let (brute, all) = cast(&Caster::new(&stage.scene, &bvh, ParticleCasts::BruteForce), &rays[..40]);
    let each = |counts: IntersectionCounts| counts.tests() as f64 / counts.rays as f64;
    eprintln!(
        "Sponza, a ray: hierarchy {:.2} us and {:.0} tests, brute force {:.0} us and {:.0} tests: {:.0} times the time, {:.0} times the tests",
        1e6 * hierarchy,
        each(tests),
        1e6 * brute,
        each(all),
        brute / hierarchy,
        each(all) / each(tests)
    );
    assert!(each(all) > 500.0 * each(tests));
}

/// Writes the tests of simulations over the number of particles, if `LIGHTWELL_PLOTS` names a folder.
fn plot(scene: &str, title: &str, rows: &[[f64; 4]]) {
    let Some(folder) = std::env::var_os("LIGHTWELL_PLOTS").map(std::path::PathBuf::from) else { return };
    let curve = |label, column: usize| Curve { label, points: rows.iter().map(|row| (row[0], row[column])).collect() };
    let curves =
        [curve("B·N/(1−ρ)", 1), curve("objects, one by one", 2), curve("boxes and triangles of the hierarchy", 3)];
    sweep(&folder.join(format!("casts_{scene}.png")), title, &curves, "particles N")
        .unwrap_or_else(|e| panic!("{e:#}"));
}

/// Object by object a simulation takes B·N/(1−ρ) tests, where no particle is lost; through the hierarchy a ray takes
/// about as many tests whatever N.
#[test]
fn tests_of_a_simulation_follow_the_report() {
    for scene in ["cornell", "glasshouse"] {
        follow_the_report(scene);
    }
}

fn follow_the_report(scene: &str) {
    let mut stage = Stage::open(&root().join(format!("scenes/{scene}.scene.ron")), None, [16; 2]);
    // The sky's particles come from all around, and many of them miss.
    (stage.scene.sky, stage.scene.sky_map) = (glam::Vec3::ZERO, None);
    let settings = RenderSettings { gi: GiMethod::VPL, only: Layer::Indirect, display: false, ..Default::default() };
    let objects = stage.scene.primitives.iter().filter(|primitive| primitive.casts_shadow).count() as f64;
    let mut rows = Vec::new();
    eprintln!(
        "{scene}, {objects} objects\n     N    B·N/(1−ρ)   objects one by one   boxes and triangles of the hierarchy"
    );
    for particles in [64, 256, 1024, 4096] {
        let [brute, hierarchy] = [ParticleCasts::BruteForce, ParticleCasts::Hierarchy].map(|casts| {
            stage.scene.vpl = Some(InstantRadiosity { particles, casts, candidates: 1, ..Default::default() });
            stage.draw(&settings, [0.0; 2]);
            let shot = virtual_lights(stage.renderer().methods()).expect("they were asked for").particles();
            (shot.casts, shot.reflectance)
        });
        let predicted = objects * f64::from(particles) / (1.0 - brute.1);
        let (found, tree) = (brute.0.objects as f64, hierarchy.0);
        eprintln!("{particles:>6} {predicted:>12.0} {found:>20.0} {:>20} and {}", tree.boxes, tree.triangles);
        rows.push([f64::from(particles), predicted, found, (tree.boxes + tree.triangles) as f64]);
        // Particles that leave by the open side, or meet black, go no further.
        assert!((0.5..1.02).contains(&(found / predicted)), "{found} tests, {predicted} by the formula");
    }
    plot(scene, &format!("Intersection tests of a simulation: {scene}, {objects} objects"), &rows);
}

#[test]
fn one_pass_beats_a_pass_for_every_light() {
    let mut stage = Stage::open(&root().join("scenes/cornell.scene.ron"), None, [64; 2]);
    let settings = RenderSettings { gi: GiMethod::VPL, only: Layer::Indirect, display: false, ..Default::default() };
    for particles in [64, 256, 1024] {
        let times = [Accumulation::Batched, Accumulation::ByTheLetter].map(|accumulation| {
            let visibility = VirtualVisibility::None;
            let vpl = InstantRadiosity {
                particles,
                candidates: 1,
                accumulation,
                visibility,
                view_driven: false,
                ..Default::default()
            };
            // One reflection alone: as many lights as particles that hit.
            stage.scene.vpl = Some(InstantRadiosity { bounces: lightwell::world::Bounces::Count(1), ..vpl });
            stage.draw(&settings, [0.0; 2]);
            // Another sub-pixel shift makes the frame anew, and leaves the particles.
            let start = Instant::now();
            let report = stage.draw(&settings, [0.25, 0.0]);
            let _ = stage.radiance();
            (start.elapsed().as_secs_f64() * 1e3, report.total().draws)
        });
        let [(batched, _), (letter, draws)] = times;
        eprintln!(
            "M = {particles}: one pass {batched:.1} ms, by the letter {letter:.1} ms in {draws} draws: {:.1} times",
            letter / batched
        );
        assert!(draws > u64::from(particles), "{draws} draws");
    }
}
