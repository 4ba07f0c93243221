//! Debug views: they show, they hide behind surfaces, and they never touch the radiance.

#![allow(clippy::unwrap_used)]

use crate::support::{Stage, gpu};
use glam::{Affine3A, Quat, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::{Gpu, read_texture};
use lightwell::graph::{FrameReport, PassState};
use lightwell::render::debug::{DebugSettings, DebugView, Line, ShownTarget};
use lightwell::render::reference::TraceSettings;
use lightwell::render::{Beside, GiMethod, ReferenceSettings, RenderSettings, Renderer, Shown};
use lightwell::scene::LightShape;
use lightwell::world::{Clpv, Transport};
use std::collections::BTreeSet;

const EDGE: u32 = 64;

/// A room with a ball and a lamp, seen from its middle.
fn stage(transport: Transport) -> Stage {
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 1.8), Vec3::ZERO, EDGE);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.6, 0.5, 0.4));
    let ball = Shape::Sphere { radius: 0.5, segments: 16, rings: 8 };
    stage.add(ball, Vec3::splat(0.8), Affine3A::from_translation(Vec3::new(0.0, -0.5, -0.5)));
    stage.light(LightShape::Point, Vec3::splat(4.0), Vec3::new(0.4, 1.0, 0.0), Vec3::NEG_Y).range = Some(2.6);
    stage.clpv(Vec3::ZERO, Clpv { cells: [8; 3], cascades: 2, transport, ..Default::default() });
    stage
}

struct Drawn {
    bytes: Vec<u8>,
    radiance: Vec<[f32; 4]>,
    report: FrameReport,
}

impl Drawn {
    fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let at = 4 * (x + y * EDGE) as usize;
        [self.bytes[at], self.bytes[at + 1], self.bytes[at + 2]]
    }

    fn ran(&self, name: &str) -> bool {
        self.report.pass(name).is_some_and(|pass| pass.state == PassState::Ran)
    }
}

fn draw(gpu: &Gpu, renderer: &mut Renderer, stage: &Stage, settings: RenderSettings) -> Drawn {
    let (image, report) = stage.render_with(gpu, renderer, &settings);
    let bytes = read_texture(gpu, renderer.display().unwrap(), 0, 0).unwrap();
    Drawn { bytes, radiance: image.rgba, report }
}

fn differing(a: &Drawn, b: &Drawn) -> usize {
    a.bytes.chunks(4).zip(b.bytes.chunks(4)).filter(|(a, b)| a != b).count()
}

fn settings(gi: GiMethod, debug: DebugSettings) -> RenderSettings {
    RenderSettings { gi, debug, ..Default::default() }
}

fn views(views: &[DebugView]) -> DebugSettings {
    DebugSettings { views: views.iter().copied().collect(), bvh_level: 3, ..Default::default() }
}

#[test]
fn an_outline_surrounds_what_is_selected() {
    let gpu = gpu();
    let stage = stage(Transport::Sweep);
    let mut renderer = Renderer::new(&gpu);
    let ball = stage.scene.primitives.last().unwrap().id.0 as u32;
    let select = |ids: &[u32]| DebugSettings { outlined: ids.to_vec(), ..Default::default() };
    let plain = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, select(&[])));
    assert!(!plain.ran("outline") && !plain.ran("selection"));
    let nobody = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, select(&[ball + 1000])));
    assert_eq!(differing(&plain, &nobody), 0, "nobody that is seen is selected");
    let outlined = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, select(&[3, ball])));
    assert!(outlined.ran("outline"));
    assert_eq!(plain.radiance, outlined.radiance);
    let orange = |drawn: &Drawn, x, y| {
        let [r, g, b] = drawn.pixel(x, y);
        r > 230 && g > 120 && b < 80
    };
    let marked: Vec<[u32; 2]> =
        (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| [x, y])).filter(|&[x, y]| orange(&outlined, x, y)).collect();
    // The ball is seen as a disc of about 14 pixels: two pixels around it are some 90.
    assert!((40..200).contains(&marked.len()), "{}", marked.len());
    let object = read_texture(&gpu, renderer.target("gbuffer object").unwrap(), 0, 0).unwrap();
    for [x, y] in marked {
        let at = 8 * (x + y * EDGE) as usize;
        let id = u32::from_le_bytes(object[at..at + 4].try_into().unwrap());
        assert_ne!(id, ball, "the outline covers nothing of the ball itself");
    }
    let again = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, select(&[])));
    assert_eq!(differing(&plain, &again), 0, "nothing is left of it");
}

#[test]
fn lines_of_a_game_are_dim_behind_surfaces_unless_on_top() {
    let gpu = gpu();
    let stage = stage(Transport::Sweep);
    let mut renderer = Renderer::new(&gpu);
    // Along the horizon of the image, before the ball or behind the wall.
    let line = |z: f32| Line::new(Vec3::new(-1.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, 0.0));
    let mut green = |lines: &[Line]| {
        let debug = DebugSettings { lines: lines.to_vec(), ..Default::default() };
        let drawn = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, debug));
        let [r, g, b] = drawn.pixel(EDGE / 2, EDGE / 2).map(i32::from);
        (g - (r + b) / 2, drawn.radiance)
    };
    let (plain, radiance) = green(&[]);
    let (before, shown) = green(&[line(0.5)]);
    let (behind, _) = green(&[line(-2.5)]);
    let (on_top, _) = green(&[line(-2.5).on_top()]);
    assert_eq!(radiance, shown, "light does not see it");
    assert!(before > plain + 60 && on_top > plain + 60, "{plain} {before} {on_top}");
    assert!(behind < plain + (on_top - plain) / 2 && behind > plain, "dim: {plain} {behind} {on_top}");
}

fn shown(targets: &[&str]) -> DebugSettings {
    let targets = targets.iter().map(|text| text.parse::<ShownTarget>().unwrap()).collect();
    DebugSettings { targets, ..Default::default() }
}

#[test]
fn targets_are_laid_side_by_side() {
    let gpu = gpu();
    let stage = stage(Transport::Sweep);
    let mut renderer = Renderer::new(&gpu);
    let plain = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, shown(&[])));
    let two =
        draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, shown(&["radiance=0..1", "gbuffer depth.r=0..1"])));
    assert!(two.ran("debug targets"));
    assert_eq!(plain.radiance, two.radiance, "light does not see them");
    // Tiles of 16 pixels, 4 apart, from the lower left: all else is as it was.
    let is_tile = |x: u32, y: u32| (43..61).contains(&y) && (3..41).contains(&x);
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))).filter(|&(x, y)| !is_tile(x, y)) {
        assert_eq!(plain.pixel(x, y), two.pixel(x, y), "{x} {y}");
    }
    let expected = |x: u32, y: u32| {
        let texel = plain.radiance[(4 * (x % 20 - 4) + 2 + (4 * (y - 44) + 2) * EDGE) as usize];
        texel.map(|value| (255.0 * value.clamp(0.0, 1.0)).round() as i32)
    };
    for (x, y) in (44..60).flat_map(|y| (4..20).map(move |x| (x, y))) {
        let (found, expected) = (two.pixel(x, y), expected(x, y));
        let near = (0..3).all(|channel| (i32::from(found[channel]) - expected[channel]).abs() <= 1);
        assert!(near, "{x} {y}: {found:?} {expected:?}");
    }
    assert!(
        (24..40).all(|x| {
            let [r, g, b] = two.pixel(x, 50);
            r == g && g == b
        }),
        "depth is grey"
    );
    // The range is found: the brightest is white, the darkest black.
    let measured = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, shown(&["gbuffer depth.r"])));
    let tile: Vec<u8> =
        (44..60).flat_map(|y| (4..20).map(move |x| (x, y))).map(|(x, y)| measured.pixel(x, y)[0]).collect();
    assert!(tile.iter().any(|value| *value > 200) && tile.iter().any(|value| *value < 60), "{tile:?}");
}

#[test]
fn targets_of_every_kind_can_be_shown_and_others_are_told() {
    let gpu = gpu();
    let stage = stage(Transport::Diffusion);
    let mut renderer = Renderer::new(&gpu);
    let plain = draw(&gpu, &mut renderer, &stage, settings(GiMethod::CLPV, shown(&[])));
    let names: Vec<String> = plain
        .report
        .resources
        .iter()
        .filter(|resource| matches!(resource.desc, lightwell::graph::ResourceDesc::Texture(_)))
        .map(|resource| format!("{}@99/99", resource.name))
        .filter(|name| !name.starts_with("display"))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).chain(["nothing of this name"]).collect();
    assert!(names.len() > 12, "{names:?}");
    let all = draw(&gpu, &mut renderer, &stage, settings(GiMethod::CLPV, shown(&names)));
    assert!(all.ran("debug targets"));
    assert_eq!(plain.radiance, all.radiance);
    let told: Vec<&String> = all.report.warnings.iter().filter(|text| text.contains("is not shown")).collect();
    assert!(told.iter().any(|text| text.contains("`nothing of this name`")), "{told:?}");
}

#[test]
fn every_view_shows_and_leaves_the_radiance_alone() {
    let gpu = gpu();
    let methods = [
        (GiMethod::CLPV, Transport::Sweep),
        (GiMethod::CLPV, Transport::Diffusion),
        (GiMethod::VPL, Transport::Sweep),
        (GiMethod::SLC, Transport::Sweep),
    ];
    let mut shown = BTreeSet::new();
    for (gi, transport) in methods {
        let mut stage = stage(transport);
        let mut second = stage.view.camera.clone();
        second.world_from_view = Affine3A::from_translation(Vec3::new(0.5, 0.5, 0.5));
        stage.scene.cameras = vec![stage.view.camera.clone(), second];
        let mut renderer = Renderer::new(&gpu);
        let plain = draw(&gpu, &mut renderer, &stage, settings(gi, DebugSettings::default()));
        for view in DebugView::ALL {
            let drawn = draw(&gpu, &mut renderer, &stage, settings(gi, views(&[view])));
            assert_eq!(plain.radiance, drawn.radiance, "{view}");
            let pass = drawn.report.pass(&format!("debug {view}"));
            let skipped = pass.is_some_and(|pass| matches!(pass.state, PassState::Skipped(_)));
            let by_light = matches!(view, DebugView::Light | DebugView::Blockers | DebugView::Voxels);
            let makes_none = (by_light && gi != GiMethod::CLPV)
                || view == DebugView::VirtualLights && !matches!(gi, GiMethod::VPL | GiMethod::SLC);
            assert_eq!(skipped, makes_none, "{view} with {gi:?}");
            let count = differing(&plain, &drawn);
            println!("{view} with {gi:?} and {transport:?}: {count} pixels");
            assert_eq!(count > 10, !makes_none, "{view} with {gi:?} changes {count} pixels");
            if !makes_none {
                shown.insert(view);
            }
        }
    }
    assert_eq!(shown.len(), DebugView::ALL.len());
}

#[test]
fn lines_are_dim_behind_surfaces() {
    let gpu = gpu();
    // The sphere of a light's range, half before a wall and half behind it.
    let mut stage = Stage::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, EDGE);
    let turn = Affine3A::from_quat(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
    stage.add(Shape::Plane { size: [9.0, 9.0], subdivisions: [1, 1] }, Vec3::ZERO, turn);
    let light = |stage: &mut Stage, z: f32| {
        stage.scene.lights.clear();
        stage.light(LightShape::Point, Vec3::ONE, Vec3::new(0.0, 0.0, z), Vec3::NEG_Y).range = Some(0.8);
        let drawn = draw(&gpu, &mut Renderer::new(&gpu), stage, settings(GiMethod::NONE, views(&[DebugView::Lights])));
        drawn.bytes.chunks(4).map(|p| u32::from(p[2])).max().unwrap()
    };
    let (before, behind) = (light(&mut stage, 1.2), light(&mut stage, -1.2));
    assert!(before > 200 && (10..140).contains(&behind), "{before} before, {behind} behind");
}

#[test]
fn the_reference_is_traced_beside_what_is_drawn() {
    let gpu = gpu();
    let mut stage = stage(Transport::Sweep);
    stage.scene.clpv = None;
    let mut renderer = Renderer::new(&gpu);
    let plain = draw(&gpu, &mut renderer, &stage, settings(GiMethod::NONE, DebugSettings::default()));
    let beside = |shown| {
        let trace = TraceSettings { bounces: None, seed: 1 };
        let reference = ReferenceSettings { trace, samples: 64, samples_a_frame: 16 };
        RenderSettings { gi: GiMethod::NONE, beside: Some(Beside { reference, shown }), ..Default::default() }
    };
    for frame in 1..=5 {
        let half = draw(&gpu, &mut renderer, &stage, beside(Shown::Wipe(0.5)));
        assert_eq!(renderer.tracer().unwrap().samples(), (16 * frame).min(64));
        assert_eq!(plain.radiance, half.radiance);
        for y in 0..EDGE {
            for x in 0..EDGE / 2 {
                assert_eq!(plain.pixel(x, y), half.pixel(x, y), "left of the wipe is what was drawn");
            }
        }
    }
    let alone = draw(&gpu, &mut renderer, &stage, beside(Shown::Wipe(0.0)));
    let sum = |drawn: &Drawn| drawn.bytes.iter().map(|b| u64::from(*b)).sum::<u64>();
    assert!(sum(&alone) > sum(&plain) + 100_000, "all bounces are brighter than direct light");
    let difference = draw(&gpu, &mut renderer, &stage, beside(Shown::Difference(0.05)));
    let mut blue = 0;
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        let [r, _, b] = difference.pixel(x, y);
        blue += u32::from(b > r);
    }
    // All indirect light is missing.
    assert!(blue > EDGE * EDGE * 9 / 10, "{blue}");
}
