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
    /// Which of the sets of that many it is; none: the fixed one.
    number: Option<u32>,
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

    /// Another set of as many directions for each number: each lies anywhere in its part of the sphere, so that over many
    /// sets light comes from everywhere.
    pub fn varied(&self, number: u32) -> Self {
        let parts = bisected(self.quarter / 2);
        let orbits = parts.into_iter().zip(0..).map(|(triangle, index)| {
            let weight = solid_angle(triangle) / (4.0 * std::f64::consts::PI);
            (point_within(triangle, low_discrepancy(number, index)).to_array(), weight)
        });
        Self { number: Some(number), ..Self::from_orbits(&orbits.collect::<Vec<_>>()) }
    }

    /// Of two sets with the same key light is the same.
    pub fn key(&self) -> (usize, Option<u32>) {
        (self.values.len(), self.number)
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
        Self { values, quarter: 2 * orbits.len() as u32, number: None }
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

/// The corners of the triangle x > y > z > 0 of the sphere, a 48th of it.
fn corners() -> [DVec3; 3] {
    [DVec3::X, DVec3::new(1.0, 1.0, 0.0).normalize(), DVec3::ONE.normalize()]
}

/// That triangle in k² parts: their centroids and areas.
fn subdivided(parts: u32) -> Vec<([f64; 3], f64)> {
    let corners = corners();
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

/// That triangle in so many parts: the largest is halved across its longest edge until there are.
fn bisected(parts: u32) -> Vec<[DVec3; 3]> {
    let mut triangles = vec![corners()];
    while triangles.len() < parts as usize {
        let area = |&(_, triangle): &(usize, &[DVec3; 3])| solid_angle(*triangle);
        let largest = triangles.iter().enumerate().max_by(|a, b| area(a).total_cmp(&area(b)));
        let [a, b, c] = triangles.remove(largest.map_or(0, |(index, _)| index));
        // The edge from the first to the second is the longest.
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let longest = turned.into_iter().min_by(|t, u| t[0].dot(t[1]).total_cmp(&u[0].dot(u[1])));
        let [a, b, c] = longest.unwrap_or([a, b, c]);
        let middle = (a + b).normalize();
        triangles.extend([[a, middle, c], [middle, b, c]]);
    }
    triangles
}

/// A point of a spherical triangle, evenly by two numbers of 0..1 (Arvo 1995, "Stratified sampling of spherical
/// triangles").
fn point_within([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    // The angle at a corner is that between the planes of its edges.
    let angle = |at: DVec3, to: DVec3, other: DVec3| at.cross(to).angle_between(at.cross(other));
    let alpha = angle(a, b, c);
    let area = u * solid_angle([a, b, c]);
    let (s, t) = (area - alpha).sin_cos();
    let across = t - alpha.cos();
    let along = s + alpha.sin() * a.dot(b);
    let q = ((along * t - across * s) * alpha.cos() - along) / ((along * s + across * t) * alpha.sin());
    let on_edge = q.clamp(-1.0, 1.0) * a + (1.0 - q * q).max(0.0).sqrt() * (c - a * a.dot(c)).normalize();
    let z = 1.0 - v * (1.0 - on_edge.dot(b));
    (z * b + (1.0 - z * z).max(0.0).sqrt() * (on_edge - b * b.dot(on_edge)).normalize_or_zero()).normalize()
}

/// The point of a row of evenly spread ones in the unit square (Roberts 2018, the R₂ sequence), shifted by the index.
fn low_discrepancy(number: u32, index: u32) -> [f64; 2] {
    let at = |step: f64| (0.5 + step * f64::from(number) + 0.381_966 * f64::from(index) / step).fract();
    [at(0.754_877_666_246_693), at(0.569_840_290_998_053_2)]
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
    fn sets_that_vary_are_those_of_the_sphere_in_the_mean() {
        for (name, set, _) in all() {
            let sets: Vec<Directions> = (0..4096).map(|number| set.varied(number)).collect();
            for set in &sets {
                assert_eq!((set.values.len(), set.quarter), (48 * set.quarter as usize / 2, sets[0].quarter), "{name}");
                let total: f32 = set.values.iter().map(|v| v[3]).sum();
                assert!((total / (4.0 * std::f32::consts::PI) - 1.0).abs() < 1e-5, "{name}: {total}");
                // The first generator's axis is the dominant one, and the sense positive.
                for v in &set.values[..set.quarter as usize] {
                    assert!(v[0] >= v[1].abs() && v[0] >= v[2].abs(), "{name}: {v:?}");
                }
            }
            assert!(sets[1].values != sets[2].values && sets[1].key() != sets[2].key());
            for (f, exact) in [
                ((|d| d.x.powi(4)) as fn(DVec3) -> f64, 4.0 * PI / 5.0),
                (|d| (d.x * d.y).powi(2), 4.0 * PI / 15.0),
                (|d| d.x.powi(6), 4.0 * PI / 7.0),
            ] {
                let mean = sets.iter().map(|set| integral(set, f)).sum::<f64>() / sets.len() as f64;
                assert!((mean / exact - 1.0).abs() < 5e-4, "{name}: {mean} for {exact}");
            }
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
