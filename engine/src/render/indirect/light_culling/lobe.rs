//! How virtual lights shine and how far they reach: the functions of `lib/slc.wgsl` on the host, which tests hold
//! against those.

use crate::world::LightBounds;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::f32::consts::PI;

/// `VirtualLight` of `lib/slc.wgsl`: a texel of a reflective shadow map with the reflection of its surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VirtualLight {
    /// World \[m\].
    pub position: [f32; 3],
    /// Area of its surface over π \[m²\].
    pub spread: f32,
    /// ω_i, unit, towards the light that it reflects.
    pub to_light: [f32; 3],
    /// GGX α = roughness².
    pub alpha: f32,
    /// Unit normal.
    pub normal: [f32; 3],
    /// F90.
    pub grazing_reflectance: f32,
    /// Φ received \[W\]; zero: there is no light.
    pub flux: [f32; 3],
    /// Area of its surface \[m²\].
    pub area: f32,
    /// Diffuse reflectance ρ.
    pub albedo: [f32; 3],
    /// Unused.
    pub pad_albedo: f32,
    /// F0.
    pub normal_reflectance: [f32; 3],
    /// Unused.
    pub pad_reflectance: f32,
}

/// `LightRange` of `lib/slc.wgsl`: what holds all points that may accept a light. A radius below 0: there are none.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightRange {
    /// World \[m\].
    pub diffuse_center: [f32; 3],
    /// \[m\].
    pub diffuse_radius: f32,
    /// World \[m\].
    pub specular_center: [f32; 3],
    /// Across the axis \[m\].
    pub specular_radius: f32,
    /// Unit axis of the spheroid.
    pub axis: [f32; 3],
    /// Semi-axis across over the one along the axis, at most 1.
    pub squeeze: f32,
    /// ξ in (0, 1).
    pub xi: f32,
    /// Unused.
    pub pad: [f32; 3],
}

/// Part of a light's reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// Lambert's.
    Diffuse,
    /// GGX.
    Specular,
}

const RANGE_MARGIN: f32 = 1.001;
const COORDINATE_MARGIN: f32 = 1e-6;

fn fresnel(f0: Vec3, f90: f32, cosine: f32) -> Vec3 {
    let m = (1.0 - cosine).clamp(0.0, 1.0);
    f0 + (Vec3::splat(f90) - f0) * m.powi(5)
}

/// D of `lib/brdf.wgsl`.
fn distribution(n: Vec3, h: Vec3, alpha: f32) -> f32 {
    let a = n.dot(h) * alpha;
    let k = alpha / (n.cross(h).length_squared() + a * a).max(1e-20);
    k * k / PI
}

/// Height-correlated Smith visibility of `lib/brdf.wgsl`.
fn visibility(n_dot_l: f32, n_dot_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let term = |a: f32, b: f32| a * (b * b * (1.0 - a2) + a2).sqrt();
    0.5 / (term(n_dot_l, n_dot_v) + term(n_dot_v, n_dot_l)).max(1e-20)
}

fn reach(intensity: f32, delta: f32, xi: f32) -> f32 {
    (intensity / delta / xi).clamp(0.0, 1e30).sqrt()
}

fn with_margin(radius: f32, center: Vec3) -> f32 {
    radius * RANGE_MARGIN + COORDINATE_MARGIN * center.abs().max_element()
}

/// Chance that a light is accepted: p = min(I/(δ·l²), 1).
pub fn acceptance(intensity: Vec3, delta: f32, distance_squared: f32) -> f32 {
    (intensity.max_element() / delta / distance_squared).min(1.0)
}

impl VirtualLight {
    /// Radiant intensity \[W/sr\] of a lobe in a unit direction: Φ·f(ω_i, ω)·max(0, n·ω).
    pub fn intensity(&self, lobe: Lobe, direction: Vec3) -> Vec3 {
        let (n, to_light) = (Vec3::from(self.normal), Vec3::from(self.to_light));
        let (cosine, incident) = (n.dot(direction), n.dot(to_light));
        let half_sum = to_light + direction;
        if cosine <= 0.0 || incident <= 0.0 || half_sum.length_squared() < 1e-12 {
            return Vec3::ZERO;
        }
        let h = half_sum / half_sum.length();
        let f = fresnel(self.normal_reflectance.into(), self.grazing_reflectance, to_light.dot(h));
        let flux = Vec3::from(self.flux);
        match lobe {
            Lobe::Diffuse => flux * Vec3::from(self.albedo) * ((1.0 - f.max_element()) * cosine / PI),
            Lobe::Specular => {
                flux * f * (distribution(n, h, self.alpha) * visibility(incident, cosine, self.alpha) * cosine)
            }
        }
    }

    /// Semi-axis r of the spheroid of the specular lobe \[m\].
    fn specular_semi_axis(&self, delta: f32, xi: f32) -> f32 {
        let c = Vec3::from(self.normal).dot(self.to_light.into()).clamp(0.0, 1.0);
        let a2 = self.alpha * self.alpha;
        let masking = 2.0 / (c + ((1.0 - a2) * c * c + a2).sqrt());
        let sine = (1.0 - c * c).max(0.0).sqrt();
        let f = fresnel(self.normal_reflectance.into(), self.grazing_reflectance, (0.5 * (1.0 - sine)).max(0.0).sqrt());
        reach((Vec3::from(self.flux) * f).max_element() * masking / (4.0 * PI), delta, xi)
    }

    fn diffuse_sphere(&self, delta: f32, xi: f32, bounds: LightBounds) -> (Vec3, f32) {
        let position = Vec3::from(self.position);
        let least = Vec3::from(self.normal_reflectance).max_element().min(self.grazing_reflectance);
        let intensity = (Vec3::from(self.flux) * Vec3::from(self.albedo)).max_element() * (1.0 - least) / PI;
        if !(intensity > 0.0) {
            return (position, -1.0);
        }
        let r = reach(intensity, delta, xi);
        if bounds == LightBounds::CentredSphere {
            return (position, with_margin(r, position));
        }
        let center = position + Vec3::from(self.normal) * (3.0_f32.powf(-0.75) * r);
        (center, with_margin((4.0_f32 / 27.0).powf(0.25) * r, position))
    }

    /// The range that holds all points with p > ξ.
    pub fn range(&self, delta: f32, xi: f32, bounds: LightBounds) -> LightRange {
        let (n, to_light) = (Vec3::from(self.normal), Vec3::from(self.to_light));
        let mut range = LightRange {
            xi,
            axis: [0.0, 1.0, 0.0],
            squeeze: 1.0,
            diffuse_radius: -1.0,
            specular_radius: -1.0,
            ..Default::default()
        };
        if Vec3::from(self.flux).max_element() <= 0.0 || n.dot(to_light) <= 0.0 {
            return range;
        }
        let (center, radius) = self.diffuse_sphere(delta, xi, bounds);
        (range.diffuse_center, range.diffuse_radius) = (center.into(), radius);
        let r = self.specular_semi_axis(delta, xi);
        if !(r > 0.0) {
            return range;
        }
        let mirror = (2.0 * n.dot(to_light) * n - to_light).normalize_or_zero();
        let a2 = self.alpha * self.alpha;
        let long = r * (1.0 + a2) / (2.0 * self.alpha);
        let position = Vec3::from(self.position);
        let center = position + mirror * (r * (1.0 - a2) / (2.0 * self.alpha));
        let (center, radius) = match bounds {
            LightBounds::CentredSphere => (position, with_margin(r / self.alpha, position)),
            LightBounds::EnclosingSphere => (center, with_margin(long, center)),
            LightBounds::Ellipsoid => {
                (range.axis, range.squeeze) = (mirror.into(), r / long);
                (center, with_margin(r, center))
            }
        };
        (range.specular_center, range.specular_radius) = (center.into(), radius);
        range
    }
}

impl LightRange {
    /// Whether a point may accept the light.
    pub fn holds(&self, lobe: Lobe, point: Vec3) -> bool {
        let (center, radius, squeeze) = match lobe {
            Lobe::Diffuse => (self.diffuse_center, self.diffuse_radius, 1.0),
            Lobe::Specular => (self.specular_center, self.specular_radius, self.squeeze),
        };
        let axis = Vec3::from(self.axis);
        let offset = point - Vec3::from(center);
        let squeezed = offset + axis * ((squeeze - 1.0) * axis.dot(offset));
        radius > 0.0 && squeezed.length_squared() <= radius * radius
    }
}
