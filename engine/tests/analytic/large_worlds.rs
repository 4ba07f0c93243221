//! Shadows of small things in worlds of any size, and of spots whose cone nears a half space: each pixel of a floor is lit or
//! not, as a ray on the host says.

use crate::support::{Stage, gpu, rgb};
use glam::{Affine3A, Vec3};
use lightwell::assets::Shape;
use lightwell::gpu::Gpu;
use lightwell::render::{GiMethod, Layer};
use lightwell::scene::LightShape;
use lightwell::world::Clpv;
use std::f32::consts::PI;

const EDGE: u32 = 96;

/// A box on the floor, by its centre and half extent.
#[derive(Clone, Copy)]
struct Thing {
    center: Vec3,
    half: Vec3,
}

impl Thing {
    /// Whether a ray from a point meets it before a distance.
    fn blocks(&self, from: Vec3, direction: Vec3, distance: f32) -> bool {
        let a = (self.center - self.half - from) / direction;
        let b = (self.center + self.half - from) / direction;
        a.min(b).max_element().max(0.0) < a.max(b).min_element().min(distance)
    }
}

/// A stage, the things on its floor, and the floor's extent \[m\].
struct Subject {
    stage: Stage,
    things: Vec<Thing>,
    world: f32,
}

/// Things of the size of `scale` \[m\] on a floor that the camera looks at from near by, and one at the end of a world of the
/// given extent.
fn subject(scale: f32, world: f32) -> Subject {
    let mut stage = Stage::new(Vec3::new(0.0, 3.2, 2.6) * scale, Vec3::ZERO, EDGE);
    let floor = Shape::Plane { size: [world, world], subdivisions: [1, 1] };
    stage.add(floor, Vec3::ONE, Affine3A::IDENTITY);
    let at_the_end = Vec3::new(0.5 * world / scale, 0.5, 0.0);
    let things = [
        (Vec3::new(-1.3, 0.5, 0.2), 0.5),
        (Vec3::new(0.9, 0.25, -0.8), 0.25),
        (Vec3::new(1.7, 1.5, 1.1), 0.3),
        (at_the_end, 0.5),
    ];
    let things = things.map(|(center, half)| Thing { center: center * scale, half: Vec3::splat(half * scale) });
    for thing in things {
        let size = (2.0 * thing.half).to_array();
        stage.add(Shape::Box { size }, Vec3::splat(0.5), Affine3A::from_translation(thing.center));
    }
    Subject { stage, things: things.to_vec(), world }
}

/// Share of the floor's pixels whose light is that of the other side of a shadow's border, away from borders.
fn wrong_pixels(
    gpu: &Gpu,
    Subject { stage, things, world }: &Subject,
    gi: GiMethod,
    lit: impl Fn(Vec3) -> (Vec3, f32, f32),
) -> f32 {
    let image = stage.render(gpu, gi, Layer::Direct);
    let eye = stage.view.eye();
    let expected = |x: f32, y: f32| {
        let ray = stage.ray_at(x, y);
        if ray.y >= -1e-3 || things.iter().any(|thing| thing.blocks(eye, ray, -eye.y / ray.y)) {
            return None;
        }
        let point = eye - ray * (eye.y / ray.y);
        if point.abs().max_element() > 0.5 * world {
            return None;
        }
        let (toward, distance, light) = lit(point);
        let start = point + Vec3::Y * (1e-4 * eye.y);
        let is_blocked = things.iter().any(|thing| thing.blocks(start, toward, distance));
        Some(if is_blocked { 0.0 } else { light })
    };
    let (mut wrong, mut all, mut shaded) = (0, 0, 0);
    for (x, y) in (0..EDGE).flat_map(|y| (0..EDGE).map(move |x| (x, y))) {
        let at = |dx: f32, dy: f32| expected(x as f32 + 0.5 + dx, y as f32 + 0.5 + dy);
        let Some(light) = at(0.0, 0.0) else { continue };
        let around =
            [(-0.7, 0.0), (0.7, 0.0), (0.0, -0.7), (0.0, 0.7), (-0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (0.5, -0.5)];
        let is_border = |other: Option<f32>| other.is_none_or(|other| (other > 0.0) != (light > 0.0));
        if around.into_iter().any(|(dx, dy)| is_border(at(dx, dy))) {
            continue;
        }
        all += 1;
        shaded += u32::from(light == 0.0);
        wrong += u32::from((rgb(&image, x, y).y - light).abs() > 0.02 * light.max(1e-3));
    }
    assert!(all > EDGE * EDGE / 3, "{all} pixels");
    assert!(shaded > all / 100, "{shaded} of {all} pixels lie in shadow");
    wrong as f32 / all as f32
}

#[test]
fn things_of_a_centimetre_cast_the_suns_shadow_in_worlds_of_any_size() {
    let gpu = gpu();
    let toward = Vec3::new(0.8, 0.6, -0.5).normalize();
    // The last number is how many pixels may be wrong: shadows begin up to 5e-7 of the world's size from what throws them.
    const EXACT: f32 = 2e-3;
    const ROUNDED: f32 = 0.04;
    let sizes = [
        (0.04, 1.0, EXACT),
        (0.01, 60.0, EXACT),
        (0.02, 1e4, ROUNDED),
        (1.0, 1e2, EXACT),
        (1.0, 2e4, EXACT),
        (1.0, 1e6, ROUNDED),
        (100.0, 1e6, EXACT),
    ];
    for (scale, world, most) in sizes {
        let mut subject = subject(scale, world);
        subject.stage.light(LightShape::Directional, Vec3::splat(3.0), Vec3::ZERO, -toward).shadow_size = 2048;
        let light = 3.0 / PI * toward.y;
        for gi in [GiMethod::NONE, GiMethod::CLPV] {
            subject.stage.clpv(Vec3::ZERO, Clpv::default());
            let wrong = wrong_pixels(&gpu, &subject, gi, |_| (toward, f32::MAX, light));
            assert!(wrong < most, "things of {scale} m in a world of {world} m, {gi:?}: {wrong} of the pixels");
        }
    }
}

#[test]
fn things_cast_the_shadow_of_a_point_light_kilometres_away() {
    let gpu = gpu();
    for (scale, distance) in [(1.0, 3e3), (0.02, 1e4)] {
        let position = Vec3::new(0.5, 0.9, 0.35).normalize() * distance;
        let mut subject = subject(scale, 20.0 * scale);
        subject.stage.light(LightShape::Point, Vec3::splat(3.0 * distance * distance), position, Vec3::NEG_Y);
        let lit = |point: Vec3| {
            let offset = position - point;
            (
                offset.normalize(),
                offset.length(),
                3.0 / PI * distance.powi(2) / offset.length_squared() * offset.normalize().y,
            )
        };
        let wrong = wrong_pixels(&gpu, &subject, GiMethod::NONE, lit);
        assert!(wrong < 5e-3, "{scale} m, a light {distance} m away: {wrong} of the pixels");
    }
}

#[test]
fn spots_up_to_a_half_space_cast_shadows_everywhere() {
    let gpu = gpu();
    let position = Vec3::new(0.2, 2.5, 0.3);
    for degrees in [40.0_f32, 60.0, 70.0, 80.0, 90.0] {
        let mut subject = subject(1.0, 12.0);
        let outer = degrees.to_radians();
        let inner = outer - 1e-3;
        let shape = LightShape::Spot { inner, outer };
        subject.stage.light(shape, Vec3::splat(15.0), position, Vec3::NEG_Y).shadow_size = 1024;
        let lit = |point: Vec3| {
            let offset = position - point;
            let toward = offset.normalize();
            let inside = f32::from(toward.y > inner.cos());
            (toward, offset.length(), 15.0 / PI * inside * toward.y / offset.length_squared())
        };
        for gi in [GiMethod::NONE, GiMethod::SLC] {
            let wrong = wrong_pixels(&gpu, &subject, gi, lit);
            assert!(wrong < 0.01, "{degrees}°, {gi:?}: {wrong} of the pixels");
        }
    }
}
