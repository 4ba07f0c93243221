//! The sky against what is known of it, and against all orders of scattering by random paths.
#![allow(clippy::unwrap_used)]

use super::*;

const CLEAR: Atmosphere = Atmosphere { haze: 1.0, ground: Vec3::splat(0.3), altitude: 0.0 };

fn mean(color: DVec3) -> f64 {
    color.element_sum() / 3.0
}

/// Random numbers in [0, 1) (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let across = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(across * angle.cos(), z, across * angle.sin())
    }
}

/// Radiance of the green channel from a direction by random paths with delta tracking (Woodcock et al. 1965): all orders of
/// scattering, and all bounces of the ground.
fn by_paths(tables: &AtmosphereTables, direction: DVec3, sun: DVec3, paths: u32) -> f64 {
    const GREEN: usize = 1;
    let air_at = |place: DVec3| tables.atmosphere.air((place.length() - GROUND).max(0.0));
    let densest = tables.atmosphere.air(0.0).extinction[GREEN] + OZONE[GREEN];
    let start = DVec3::new(0.0, tables.atmosphere.radius(), 0.0);
    let ground = f64::from(tables.atmosphere.ground[GREEN]);
    let sun_at = |place: DVec3| tables.to_sun(place.length().max(GROUND), place.normalize().dot(sun))[GREEN];
    let mut random = Random(7);
    let mut sum = 0.0;
    for _ in 0..paths {
        let (mut place, mut toward, mut weight) = (start, direction, 1.0);
        loop {
            let (radius, up) = (place.length(), place.normalize().dot(toward));
            let to_ground = distance_to(GROUND, radius, up).filter(|way| *way > 1e-6 || up < 0.0);
            let end = to_ground.or(distance_to(TOP, radius, up)).unwrap_or(0.0);
            let way = -(1.0 - random.next()).ln() / densest;
            if way >= end {
                if to_ground.is_none() {
                    break;
                }
                place = (place + toward * end).normalize() * (GROUND + 1e-6);
                let normal = place.normalize();
                weight *= ground;
                sum += weight / PI * normal.dot(sun).max(0.0) * sun_at(place);
                toward = (normal + random.direction() * 0.999_999).normalize();
                continue;
            }
            place += toward * way;
            let air = air_at(place);
            let scattering = air.rayleigh[GREEN] + air.mie;
            if random.next() >= air.extinction[GREEN] / densest {
                continue;
            }
            weight *= scattering / air.extinction[GREEN];
            let phase =
                |cosine: f64| (air.rayleigh[GREEN] * rayleigh_phase(cosine) + air.mie * mie_phase(cosine)) / scattering;
            sum += weight * phase(toward.dot(sun)) * sun_at(place);
            // Paths go on evenly to all sides, weighted by the phase function.
            let next = random.direction();
            weight *= phase(toward.dot(next)) * 4.0 * PI;
            toward = next;
            let survival = weight.min(1.0);
            if random.next() >= survival {
                break;
            }
            weight /= survival;
        }
    }
    sum / f64::from(paths)
}

#[test]
fn the_sky_is_that_of_random_paths() {
    let tables = AtmosphereTables::new(CLEAR);
    for elevation in [60f64, 15.0, 3.0] {
        let sine = elevation.to_radians().sin();
        let sun = DVec3::new(0.0, sine, -(1.0 - sine * sine).sqrt());
        for up in [0.95f64, 0.5, 0.1] {
            let direction = DVec3::new((1.0 - up * up).sqrt(), up, 0.0);
            let sight = Sight { radius: tables.atmosphere.radius(), up, sun_up: sine, toward_sun: direction.dot(sun) };
            let end = distance_to(TOP, sight.radius, up).unwrap();
            let found = tables.along(sight, end, STEPS, true).light.y;
            let truth = by_paths(&tables, direction, sun, 60_000);
            let error = found / truth - 1.0;
            println!("sun {elevation}°, up {up}: {found:.4} of {truth:.4}, {:+.1} %", 100.0 * error);
            assert!(error.abs() < 0.12, "sun {elevation}°, up {up}: {found:.4} and not {truth:.4}");
        }
    }
}

#[test]
fn light_through_the_zenith_has_the_depth_of_the_layers() {
    let tables = AtmosphereTables::new(Atmosphere { haze: 0.0, ..CLEAR });
    // ∫ e^{−h/H} dh = H up to the top of the air; the ozone's tent has half its width's area.
    let depth = RAYLEIGH * RAYLEIGH_HEIGHT * (1.0 - (-100.0f64 / RAYLEIGH_HEIGHT).exp()) + OZONE * OZONE_HALF;
    let found = tables.to_top(GROUND + 1e-3, 1.0);
    let wanted = (-depth).map(f64::exp);
    assert!((found - wanted).abs().max_element() < 2e-3, "{found} and not {wanted}");
}

#[test]
fn the_low_sun_is_red_and_the_night_is_dark() {
    let tables = AtmosphereTables::new(CLEAR);
    let at = |degrees: f32| tables.sunlight(degrees.to_radians().sin());
    assert!(at(80.0).min_element() > 0.7 && at(80.0).max_element() < 1.0, "{}", at(80.0));
    let low = at(2.0);
    assert!(low.x > 2.0 * low.y && low.y > 2.0 * low.z, "{low}");
    assert_eq!(at(-2.0), Vec3::ZERO);
    let brightness = |degrees: f32| tables.sky(degrees.to_radians().sin()).mean().element_sum();
    let (noon, dusk, night) = (brightness(60.0), brightness(-4.0), brightness(-18.0));
    assert!(noon > 50.0 * dusk && dusk > 20.0 * night && night >= 0.0, "{noon} {dusk} {night}");
}

#[test]
fn the_zenith_is_blue_and_haze_whitens_the_horizon() {
    let sky = AtmosphereTables::new(CLEAR).sky(0.7);
    let texel = |sky: &SkyMap, column: u32, row: u32| sky.texels[(row * sky.width + column) as usize];
    let zenith = texel(&sky, 0, 2);
    assert!(zenith.z > 1.5 * zenith.y && zenith.y > zenith.x, "{zenith}");
    let hazy = AtmosphereTables::new(Atmosphere { haze: 10.0, ..CLEAR }).sky(0.7);
    let saturation = |color: Vec3| color.z / color.x;
    assert!(saturation(texel(&hazy, 10, 120)) < saturation(texel(&sky, 10, 120)));
}

/// Nothing that is sent in is lost but to ozone and ground, and nothing is won: what comes down is at most what the sun sends.
#[test]
fn no_energy_comes_out_of_nothing() {
    for (haze, ground) in [(0.0, 0.0), (1.0, 1.0), (100.0, 1.0)] {
        let tables = AtmosphereTables::new(Atmosphere { haze, ground: Vec3::splat(ground), altitude: 0.0 });
        for sine in [1.0f32, 0.3] {
            let sky = tables.sky(sine);
            let down = sky.irradiance(Vec3::Y) + tables.sunlight(sine) * sine;
            let up = sky.irradiance(Vec3::NEG_Y);
            // What stays is what comes down and does not go up again.
            assert!((down - up).max_element() <= sine * 1.05, "haze {haze}, ground {ground}: {down} down, {up} up");
            assert!(sky.texels.iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
        }
    }
}

#[test]
fn any_place_and_sun_is_finite() {
    for altitude in [0.0, 1e3, MAX_ALTITUDE] {
        let tables = AtmosphereTables::new(Atmosphere { haze: 3.0, ground: Vec3::ONE, altitude });
        for sine in [-1.0, -0.01, 0.0, 1e-3, 1.0] {
            assert!(tables.sunlight(sine).is_finite());
            assert!(tables.sky(sine).texels.iter().all(|texel| texel.is_finite()), "{altitude} m, {sine}");
        }
    }
    assert!(mean(AtmosphereTables::new(CLEAR).further(GROUND, 0.5)) > 0.0);
}
