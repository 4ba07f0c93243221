//! Balls of light: the mesh that stands for many small spheres, as rays and light see particles.
//!
//! Each ball is a convex polyhedron that is turned at random and has the surface of its sphere. Over all turns it then sends
//! out the light that the sphere does, into all directions alike: the mean shadow of a convex body is a quarter of its surface
//! (Cauchy 1841).

use super::{AssetId, Ball, Material, Mesh, Sampling, Texture, Vertex, Wrap};
use crate::core::srgb_encode;
use glam::{Quat, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// Triangles up to which many balls have a finer shape.
const FEW_TRIANGLES: usize = 40_000;
/// Texels of the colours over life.
const RAMP: u32 = 64;

/// A mesh of balls, each turned; `rest` is the mesh of as many balls that it is a pose of.
pub(crate) fn mesh_of_balls(
    name: &str,
    balls: Vec<Ball>,
    turn: impl Fn(usize) -> Quat,
    rest: Option<Arc<Mesh>>,
) -> Mesh {
    let shape = Polyhedron::of(balls.len());
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    vertices.reserve(shape.corners.len() * balls.len());
    indices.reserve(3 * shape.triangles.len() * balls.len());
    for (index, ball) in balls.iter().enumerate() {
        let (turn, first) = (turn(index), vertices.len() as u32);
        vertices.extend(shape.corners.iter().map(|&corner| {
            let corner = turn * corner;
            Vertex {
                position: (Vec3::from(ball.position) + corner * ball.radius).to_array(),
                normal: corner.normalize_or(Vec3::Y).to_array(),
                tangent: [1.0, 0.0, 0.0, 1.0],
                uv: [ball.age, 0.5],
            }
        }));
        indices.extend(shape.triangles.iter().flatten().map(|corner| first + corner));
    }
    let mut mesh = Mesh::new(name, vertices, indices);
    (mesh.balls, mesh.rest) = (Some(Arc::new(balls)), rest);
    mesh
}

/// A black material that emits a colour over life, from the first to the last radiance [W/(m² sr)].
pub(crate) fn material_of_balls(name: &str, radiance: impl Fn(f32) -> Vec3) -> Material {
    let (first, last) = (radiance(0.0), radiance(1.0));
    let emissive = first.max(last);
    let material = Material { emissive, ..Material::diffuse(name, Vec3::ZERO) };
    if first == last {
        return material;
    }
    let byte = |value: f32| (srgb_encode(value) * 255.0).round() as u8;
    let texel = |x: u32| {
        let share = radiance((x as f32 + 0.5) / RAMP as f32) / emissive;
        let [r, g, b] = share.to_array().map(|v| byte(if v.is_finite() { v } else { 0.0 }));
        [r, g, b, 255]
    };
    let texture = Texture {
        id: AssetId::fresh(),
        name: format!("{name}: colours over life"),
        width: RAMP,
        height: 1,
        rgba: (0..RAMP).flat_map(texel).collect(),
        srgb: true,
        sampling: Sampling { wrap_u: Wrap::Clamp, wrap_v: Wrap::Clamp, ..Sampling::default() },
    };
    Material { emissive_texture: Some(Arc::new(texture)), ..material }
}

/// A convex body around the origin with the surface of the unit sphere.
struct Polyhedron {
    corners: Vec<Vec3>,
    /// Counter-clockwise seen from outside.
    triangles: Vec<[u32; 3]>,
}

impl Polyhedron {
    /// The body of that many balls: the more there are, the simpler it is.
    fn of(count: usize) -> Self {
        match FEW_TRIANGLES / count.max(1) {
            80.. => Self::icosahedron().quartered(),
            20..80 => Self::icosahedron(),
            8..20 => Self::octahedron(),
            _ => Self::tetrahedron(),
        }
        .with_surface()
    }

    fn tetrahedron() -> Self {
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        Self::hull(corners.map(|corner| Vec3::from_array(corner.map(|v| v as f32))).to_vec())
    }

    fn octahedron() -> Self {
        Self::hull([Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]).collect())
    }

    fn icosahedron() -> Self {
        let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
        let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let corners = signs.into_iter().flat_map(|[a, b]| {
            let (one, phi) = (a, b * golden);
            [Vec3::new(0.0, one, phi), Vec3::new(one, phi, 0.0), Vec3::new(phi, 0.0, one)]
        });
        Self::hull(corners.collect())
    }

    /// The body of corners whose neighbours are all the same distance apart.
    fn hull(corners: Vec<Vec3>) -> Self {
        let edge = corners[1..].iter().map(|corner| corner.distance(corners[0])).fold(f32::INFINITY, f32::min);
        let is_edge = |a: usize, b: usize| corners[a].distance(corners[b]) < 1.01 * edge;
        let mut triangles = Vec::new();
        for a in 0..corners.len() {
            for b in a + 1..corners.len() {
                for c in (b + 1..corners.len()).filter(|&c| is_edge(a, b) && is_edge(a, c) && is_edge(b, c)) {
                    let outward = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(corners[a]) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|index| index as u32));
                }
            }
        }
        Self { corners, triangles }
    }

    /// Four triangles in place of each, with their corners on a sphere.
    fn quartered(self) -> Self {
        let mut corners: Vec<Vec3> = self.corners.iter().map(|corner| corner.normalize()).collect();
        let mut known = std::collections::HashMap::new();
        let mut between = |corners: &mut Vec<Vec3>, a: u32, b: u32| {
            *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                corners.push((corners[a as usize] + corners[b as usize]).normalize());
                corners.len() as u32 - 1
            })
        };
        let mut triangles = Vec::new();
        for [a, b, c] in self.triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| between(&mut corners, p, q));
            triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        Self { corners, triangles }
    }

    fn with_surface(mut self) -> Self {
        let scale = (4.0 * PI / self.surface()).sqrt();
        self.corners.iter_mut().for_each(|corner| *corner *= scale);
        self
    }

    fn surface(&self) -> f32 {
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| self.corners[corner as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        self.triangles.iter().map(area).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_closed_and_have_the_surface_of_the_sphere() {
        for (count, triangles) in [(1, 80), (500, 80), (501, 20), (2001, 8), (10_000, 4), (1 << 16, 4)] {
            let body = Polyhedron::of(count);
            assert_eq!(body.triangles.len(), triangles, "of {count}");
            assert!((body.surface() / (4.0 * PI) - 1.0).abs() < 1e-5);
            let mut edges = std::collections::HashSet::new();
            for [a, b, c] in &body.triangles {
                for edge in [(a, b), (b, c), (c, a)] {
                    assert!(edges.insert((*edge.0, *edge.1)), "an edge of {count} runs twice the same way");
                }
                let [a, b, c] = [a, b, c].map(|corner| body.corners[*corner as usize]);
                assert!((b - a).cross(c - a).dot(a) > 0.0, "a triangle of {count} faces inwards");
            }
            assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "the body of {count} has holes");
        }
    }

    /// The light of a body in all turns is that of the sphere: its mean shadow has the area π.
    #[test]
    fn turned_bodies_shine_as_spheres() {
        let body = Polyhedron::tetrahedron().with_surface();
        let mut shadow = 0.0;
        const TURNS: i64 = 20_000;
        for turn in 0..TURNS {
            let turn = crate::world::turn_of_particle(0, turn);
            let facing = body.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(|corner| turn * body.corners[corner as usize]);
                (0.5 * (b - a).cross(c - a).z).max(0.0)
            });
            shadow += facing.sum::<f32>() / TURNS as f32;
        }
        assert!((shadow / PI - 1.0).abs() < 0.01, "{shadow}");
    }

    #[test]
    fn colours_over_life_are_those_that_were_asked_for() {
        let of = |age: f32| Vec3::new(100.0, 50.0, 0.0).lerp(Vec3::new(20.0, 80.0, 0.0), age);
        let material = material_of_balls("sparks", of);
        let texture = material.emissive_texture.clone().expect("a ramp");
        for x in [0, 20, 63] {
            let texel = &texture.rgba[4 * x..];
            let linear = Vec3::from_array([0, 1, 2].map(|i| crate::core::srgb_decode(f32::from(texel[i]) / 255.0)));
            let wanted = of((x as f32 + 0.5) / 64.0);
            assert!((linear * material.emissive - wanted).length() < 0.01 * wanted.length(), "{x}: {linear}");
        }
        assert!(material_of_balls("even", |_| Vec3::ONE).emissive_texture.is_none());
    }
}
