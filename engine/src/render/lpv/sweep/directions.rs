//! The directions that light is swept along: full octahedral orbits, so that mirrored and turned scenes give mirrored
//! and turned light.

use crate::assets::SkyMap;
use crate::world::Quality;
use glam::{DVec3, Vec3};

/// Generators x > y > z > 0 with the weight of each of their 48 images, as a part of the whole sphere. Exact for
/// polynomials of degree 11.
const DEGREE_ELEVEN: [([f64; 3], f64); 3] = [
    ([0.947_903_13, 0.281_350_67, 0.149_403_65], 0.008_077_580),
    ([0.783_469_78, 0.604_515_10, 0.144_002_06], 0.006_685_621),
    ([0.743_305_46, 0.535_708_73, 0.400_640_93], 0.006_070_133),
];
/// Of degree 7.
const DEGREE_SEVEN: [([f64; 3], f64); 2] = [
    ([0.934_152_88, 0.328_333_27, 0.139_841_57], 0.009_270_913),
    ([0.764_934_09, 0.578_628_23, 0.282_955_93], 0.011_562_421),
];

/// Directions in the order that the shader takes them: by dominant axis, by sense along it, by quadrant.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    /// Unit direction and weight [sr].
    pub values: Vec<[f32; 4]>,
    /// Directions of one quadrant of one sense of one axis.
    pub quarter: u32,
}

impl Directions {
    /// The set for light that comes straight from the lights. Where they light a small part of the scene, few directions
    /// would show as rays (Lathrop 1968, "Ray effects in discrete ordinates equations").
    pub fn of(quality: Quality) -> Self {
        match quality {
            Quality::Low => Self::from_orbits(&DEGREE_SEVEN),
            Quality::Medium => Self::from_orbits(&subdivided(2)),
            Quality::High => Self::from_orbits(&subdivided(3)),
            Quality::Ultra => Self::from_orbits(&subdivided(4)),
        }
    }

    /// The set for all further bounces. Their light comes from all over the scene, so that few directions tell all.
    pub fn of_further_bounces(quality: Quality) -> Self {
        match quality {
            Quality::Low | Quality::Medium => Self::from_orbits(&DEGREE_SEVEN),
            Quality::High | Quality::Ultra => Self::from_orbits(&DEGREE_ELEVEN),
        }
    }

    fn from_orbits(orbits: &[([f64; 3], f64)]) -> Self {
        let mut values = Vec::with_capacity(48 * orbits.len());
        for axis in 0..3 {
            for sense in [1.0, -1.0] {
                for quadrant in 0..4 {
                    let signs = [quadrant & 1, quadrant >> 1].map(|negative| if negative == 1 { -1.0 } else { 1.0 });
                    for (generator, weight) in orbits {
                        for across in [[1, 2], [2, 1]] {
                            let mut d = [0.0; 3];
                            d[axis] = sense * generator[0];
                            d[(axis + 1) % 3] = signs[0] * generator[across[0]];
                            d[(axis + 2) % 3] = signs[1] * generator[across[1]];
                            let direction = Vec3::from(d.map(|c| c as f32));
                            let weight = 4.0 * std::f64::consts::PI * weight;
                            values.push([direction.x, direction.y, direction.z, weight as f32]);
                        }
                    }
                }
            }
        }
        Self { values, quarter: 2 * orbits.len() as u32 }
    }

    /// Radiance that enters along each direction from a sky: the mean of the part that lies nearest to where the light
    /// comes from [W/(m² sr)].
    pub fn sky(&self, map: &SkyMap) -> Vec<[f32; 4]> {
        let origins: Vec<Vec3> = self.values.iter().map(|&[x, y, z, _]| -Vec3::new(x, y, z)).collect();
        map.around(&origins).into_iter().map(|radiance| radiance.extend(0.0).to_array()).collect()
    }

    /// Directions of one sense of one axis.
    pub fn group(&self) -> u32 {
        4 * self.quarter
    }
}

/// The triangle x > y > z > 0 of the sphere, a 48th of it, in k² parts: their centroids and areas.
fn subdivided(parts: u32) -> Vec<([f64; 3], f64)> {
    let corners = [DVec3::X, DVec3::new(1.0, 1.0, 0.0).normalize(), DVec3::ONE.normalize()];
    let k = f64::from(parts);
    let at = |i: u32, j: u32| {
        let (b, c) = (f64::from(i) / k, f64::from(j) / k);
        (corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c).normalize()
    };
    let mut orbits = Vec::new();
    for i in 0..parts {
        for j in 0..parts - i {
            let mut add = |triangle: [DVec3; 3]| {
                let center = (triangle[0] + triangle[1] + triangle[2]).normalize();
                orbits.push((center.to_array(), solid_angle(triangle) / (4.0 * std::f64::consts::PI)));
            };
            add([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 1 < parts {
                add([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    orbits
}

/// Solid angle of a spherical triangle (Van Oosterom and Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let volume = a.dot(b.cross(c)).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::PI;

    fn all() -> [(&'static str, Directions, f64); 5] {
        [
            ("degree 7", Directions::from_orbits(&DEGREE_SEVEN), 1e-5),
            ("degree 11", Directions::from_orbits(&DEGREE_ELEVEN), 1e-5),
            ("192", Directions::of(Quality::Medium), 0.02),
            ("432", Directions::of(Quality::High), 0.01),
            ("768", Directions::of(Quality::Ultra), 0.006),
        ]
    }

    fn integral(set: &Directions, f: impl Fn(DVec3) -> f64) -> f64 {
        set.values.iter().map(|v| f64::from(v[3]) * f(Vec3::new(v[0], v[1], v[2]).as_dvec3())).sum()
    }

    #[test]
    fn low_moments_are_those_of_the_sphere() {
        for (name, set, error) in all() {
            for (f, exact) in [
                ((|_| 1.0) as fn(DVec3) -> f64, 4.0 * PI),
                (|d| d.x * d.x, 4.0 * PI / 3.0),
                (|d| d.x, 0.0),
                (|d| d.x.powi(4), 4.0 * PI / 5.0),
                (|d| (d.x * d.y).powi(2), 4.0 * PI / 15.0),
                (|d| d.x.powi(6), 4.0 * PI / 7.0),
            ] {
                let value = integral(&set, f);
                assert!((value - exact).abs() <= error * exact.max(1.0), "{name}: {value} for {exact}");
            }
        }
    }

    #[test]
    fn the_parts_of_the_triangle_fill_it() {
        for parts in 1..6 {
            let sum: f64 = subdivided(parts).iter().map(|(_, weight)| weight).sum();
            assert!((48.0 * sum - 1.0).abs() < 1e-12, "{parts}: {sum}");
        }
    }

    #[test]
    fn a_wall_of_any_direction_gets_and_sends_what_it_should() {
        for (name, set, _) in all() {
            for n in [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE, DVec3::new(0.3, -0.8, 0.5)] {
                let half = integral(&set, |d| d.dot(n.normalize()).max(0.0));
                assert!((half / PI - 1.0).abs() < 0.02, "{name}, {n}: {half}");
            }
        }
    }
}
