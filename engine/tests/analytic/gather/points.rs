//! Points of lit surfaces, drawn from reflective shadow maps, beside the rays.

use super::*;

/// A room that is lit by what a narrow beam leaves on one wall.
fn beam(settings: Clpv) -> Stage {
    let mut stage = Stage::new(Vec3::new(1.6, 1.0, 1.5), Vec3::new(-1.0, -0.8, -1.2), 48);
    stage.add_room(Vec3::splat(-2.0), Vec3::splat(4.0), Vec3::new(0.7, 0.5, 0.3));
    let small = Shape::Box { size: [0.5, 0.9, 0.5] };
    stage.add(small, Vec3::splat(0.6), Affine3A::from_translation(Vec3::new(-0.9, -1.5, -0.8)));
    let spot = LightShape::Spot { inner: 0.25, outer: 0.3 };
    stage.light(spot, Vec3::splat(60.0), Vec3::new(0.3, 0.6, 0.4), Vec3::new(0.6, 0.2, 1.0).normalize());
    stage.clpv(Vec3::ZERO, Clpv { gather_filter: 0, ..settings });
    stage
}

/// Rays seldom meet a small bright patch; the points that are drawn from the lamp's map all lie in it.
#[test]
fn points_of_lit_surfaces_bring_the_same_light_with_less_noise() {
    let gpu = gpu();
    let with = |rays, points| {
        let [gather_rays, gather_points] = [rays, points].map(GatherRays::Count);
        beam(Clpv { gather_rays, gather_points, ..settings(Bounces::Count(1)) })
    };
    let best = averaged(&gpu, with(8, 16));
    let expected = Image::from_rgba(best.width, best.height, &best.rgba).expect("an image");
    let (noise, _) = error(&averaged(&gpu, with(2, 0)), &expected);
    let (nrmse, bias) = error(&averaged(&gpu, with(2, 2)), &expected);
    assert!(nrmse < 0.4 * noise && bias.abs() < 0.01, "with points {nrmse}, bias {bias}, without {noise}");
    // The tracer's noise is that of rays alone.
    let (_, bias) = error(&averaged(&gpu, with(2, 2)), &traced(&gpu, &with(2, 2), 1));
    assert!(bias.abs() < 0.015, "bias {bias}");
}

/// Near the patch, on what mirrors and from what mirrors, the weights of both ways add up to one.
#[test]
fn points_and_rays_share_the_light_of_glossy_surfaces_and_corners() {
    let gpu = gpu();
    let with = |points| {
        let mut stage = beam(Clpv { gather_points: GatherRays::Count(points), ..settings(Bounces::Count(1)) });
        let gloss = Material { roughness: 0.35, specular: 1.0, ..Material::diffuse("gloss", Vec3::splat(0.4)) };
        let metal =
            Material { metallic: 1.0, roughness: 0.5, specular: 1.0, ..Material::diffuse("metal", Vec3::splat(0.8)) };
        let at = |x: f32, y: f32, z: f32| Affine3A::from_translation(Vec3::new(x, y, z));
        stage.add_material(Shape::Box { size: [3.9, 0.1, 3.9] }, gloss, at(0.0, -1.95, 0.0));
        stage.add_material(Shape::Sphere { radius: 0.5, segments: 64, rings: 32 }, metal, at(-0.4, -1.2, 0.6));
        // Into the corner between the floor and the wall.
        stage.scene.lights[0].direction = Vec3::new(-0.6, -2.3, -2.4).normalize();
        stage.scene.lights[0].position = Vec3::new(-0.2, 0.4, 0.4);
        stage
    };
    let expected = traced(&gpu, &with(0), 1);
    let [(noise, alone), (nrmse, both)] = [0, 4].map(|points| error(&averaged(&gpu, with(points)), &expected));
    assert!(nrmse < noise && (both - alone).abs() < 0.02, "nrmse {noise}, {nrmse}; bias {alone}, {both}");
}

/// A map shows the first surface in a light's way, and a light without shadows lights those behind it too.
#[test]
fn light_without_shadows_is_left_to_the_rays() {
    let gpu = gpu();
    let mut stage = room(settings(Bounces::Count(1)));
    stage.scene.lights[0].casts_shadow = false;
    let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
    assert!(report.ran("gather") && !report.ran("RSM samples"), "{report}");
    stage.light(LightShape::Point, Vec3::splat(1.0), Vec3::new(-1.2, 1.2, 1.0), Vec3::NEG_Y);
    let both = traced(&gpu, &stage, 1);
    let (_, report) = stage.render_with(&gpu, &mut Renderer::new(&gpu), &RenderSettings::default());
    assert!(report.ran("RSM samples"), "{report}");
    let (_, bias) = error(&averaged(&gpu, stage), &both);
    assert!(bias.abs() < 0.01, "bias {bias}");
}
