//! The value of an animation at a time.
//!
//! Time is reduced to one round in whole flicks before any rounding, so that a time and the same time a round later
//! give the same bits.

use super::animation::{Animation, Interpolation, KeyValue, Target, Track, Wrap, rotation_from_degrees};
use super::animation::{Meaning, Part, SurfaceField};
use super::clock::{FLICKS_PER_SECOND, flicks};
use super::fields::FieldSample;
use super::{Clock, Transform};
use glam::{EulerRot, Mat3, Quat, Vec3};
use std::f64::consts::TAU;

/// The values of an animation at a time. None: the entity's own value holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Translation \[m\].
    pub translation: Option<Vec3>,
    /// Unit rotation.
    pub rotation: Option<Quat>,
    /// Scale.
    pub scale: Option<Vec3>,
    /// Intensity of the light.
    pub intensity: Option<f32>,
    /// Colour of the light.
    pub color: Option<Vec3>,
    /// Range of the light \[m\].
    pub range: Option<f32>,
    /// Half angle of full intensity of the spot light \[degrees\].
    pub inner: Option<f32>,
    /// Half angle beyond which the spot light does not shine \[degrees\].
    pub outer: Option<f32>,
    /// Field of view of the camera \[degrees\].
    pub fov: Option<f32>,
    /// Height of what the orthographic camera sees \[m\].
    pub height: Option<f32>,
    /// Whether the mesh is drawn.
    pub visible: Option<bool>,
    /// Whether the mesh casts shadows.
    pub casts_shadow: Option<bool>,
    /// Changes of the material.
    pub material: MaterialSample,
    /// Weights of morph targets, by number; later ones hold.
    pub weights: Vec<(usize, f32)>,
    /// Fields by path; later ones hold.
    pub fields: Vec<FieldSample>,
}

/// The values of an animation for a material at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialSample {
    /// Base colour.
    pub color: Option<Vec3>,
    /// Alpha.
    pub alpha: Option<f32>,
    /// Metallic.
    pub metallic: Option<f32>,
    /// Roughness.
    pub roughness: Option<f32>,
    /// Emitted radiance [W/(m² sr)].
    pub emissive: Option<Vec3>,
    /// Strength of the reflection of dielectrics.
    pub specular: Option<f32>,
    /// Colour of that reflection.
    pub specular_color: Option<Vec3>,
    /// Share of light that passes.
    pub transmission: Option<f32>,
    /// Scale of the normal map.
    pub normal_scale: Option<f32>,
    /// Alpha from which on a masked surface is drawn.
    pub alpha_cutoff: Option<f32>,
    /// Whether back faces are drawn.
    pub double_sided: Option<bool>,
    /// Changes of the layers.
    pub layers: LayersSample,
}

/// The values of an animation for the layers of a material at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayersSample {
    /// Share of the surface that a clear coat covers.
    pub clearcoat: Option<f32>,
    /// Its roughness.
    pub clearcoat_roughness: Option<f32>,
    /// Colour of the sheen.
    pub sheen_color: Option<Vec3>,
    /// Its roughness.
    pub sheen_roughness: Option<f32>,
    /// How much highlights are stretched.
    pub anisotropy: Option<f32>,
    /// Turn of the direction \[rad\].
    pub anisotropy_rotation: Option<f32>,
    /// Share of the surface that a film covers.
    pub iridescence: Option<f32>,
    /// Its thickness \[nm\].
    pub iridescence_thickness: Option<f32>,
    /// How far colours part in glass.
    pub dispersion: Option<f32>,
}

impl Animation {
    /// The animation's values at a time, on top of a rest pose. Nothing where it does not play. All values are finite;
    /// the animation must be valid ([`Animation::validate`]).
    pub fn sample(&self, clock: &Clock, rest: &Transform) -> Sample {
        self.sample_over(Sample::default(), clock, rest)
    }

    /// The same on top of what the model says that the entity belongs to.
    pub(super) fn sample_over(&self, mut sample: Sample, clock: &Clock, rest: &Transform) -> Sample {
        if self.playing {
            let time = self.time(clock);
            // Other tracks say nothing of the entity itself.
            for track in self.tracks.iter().filter(|track| track.node().is_empty()) {
                track.apply(&time, rest, &mut sample);
            }
        }
        sample
    }

    /// Time of the tracks.
    pub(super) fn time(&self, clock: &Clock) -> Time {
        Time { flicks: clock.flicks(), speed: self.speed, offset: self.offset }
    }
}

/// Time of a track: speed · clock + offset.
pub(super) struct Time {
    pub(super) flicks: u64,
    pub(super) speed: f64,
    pub(super) offset: f64,
}

impl Time {
    /// Time in a span \[s\], both as whole flicks of the clock. At speed zero the clock plays no part.
    fn of(&self, span: f64) -> (i128, i128) {
        let speed = if self.speed == 0.0 { 1.0 } else { self.speed };
        let clock = if self.speed == 0.0 { 0 } else { i128::from(self.flicks) };
        let offset = (self.offset / speed.abs() * FLICKS_PER_SECOND as f64).round() as i128;
        let round = i128::from(flicks(span / speed.abs()).max(1));
        (if speed < 0.0 { offset - clock } else { offset + clock }, round)
    }

    /// Part of a round that has passed, in 0..1. A negative period runs backwards.
    fn phase(&self, period: f64) -> f64 {
        let (time, round) = self.of(period.abs());
        let time = if period < 0.0 { -time } else { time };
        time.rem_euclid(round) as f64 / round as f64
    }

    /// Time within a span \[s\].
    pub(super) fn within(&self, span: f64, wrap: Wrap) -> f64 {
        match wrap {
            Wrap::Once => {
                let (time, round) = self.of(span);
                time.clamp(0, round) as f64 / round as f64 * span
            }
            Wrap::Loop => self.phase(span) * span,
            Wrap::PingPong => {
                let phase = 2.0 * self.phase(2.0 * span);
                phase.min(2.0 - phase) * span
            }
        }
    }
}

impl Track {
    /// The entity below that it is for; empty for the entity itself.
    pub(super) fn node(&self) -> &str {
        if let Self::Keys { node, .. } = self { node } else { "" }
    }

    pub(super) fn apply(&self, time: &Time, rest: &Transform, out: &mut Sample) {
        match self {
            Self::Spin { axis, degrees_per_second } => {
                let phase = if *degrees_per_second == 0.0 { 0.0 } else { time.phase(360.0 / degrees_per_second) };
                let base = out.rotation.unwrap_or_else(|| rest.unit_rotation());
                out.rotation = Some(base * rotation(*axis, phase * TAU));
            }
            Self::Orbit { center, axis, radius, period, phase, look_at_center } => {
                let axis = axis.normalize_or(Vec3::Y);
                let angle = time.phase(*period) * TAU + f64::from(*phase).to_radians();
                let outwards = on_circle(axis, angle);
                set(&mut out.translation, *center + *radius * outwards, Vec3::is_finite);
                if *look_at_center {
                    let axes = Mat3::from_cols(axis.cross(outwards), axis, outwards);
                    set(&mut out.rotation, Quat::from_mat3(&axes).normalize(), Quat::is_finite);
                }
            }
            Self::Keys { target, keys, interpolation, wrap, .. } => {
                let Some((last, _)) = keys.last() else { return };
                // A single key at zero spans no time, and says the same at all times.
                let now = if *last > 0.0 { time.within(*last, *wrap) } else { 0.0 };
                let rotates = target.is_rotation();
                let curve = Curve { rotates, keys, interpolation: *interpolation, wrap: *wrap };
                write(target, curve.at(now), keys, rest, out);
            }
            // The nodes of the model follow it, not the entity itself.
            Self::Clip { .. } => {}
        }
    }
}

/// The rotation about an axis by an angle \[rad\].
fn rotation(axis: Vec3, angle: f64) -> Quat {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let v = axis.normalize_or_zero() * sin as f32;
    Quat::from_xyzw(v.x, v.y, v.z, cos as f32)
}

/// The unit vector at an angle \[rad\] on the circle about a unit axis.
fn on_circle(axis: Vec3, angle: f64) -> Vec3 {
    let start = if axis.x.abs() < 0.999 { Vec3::X } else { Vec3::Z };
    let u = start.reject_from_normalized(axis).normalize_or(Vec3::Z);
    let (sin, cos) = angle.sin_cos();
    u * cos as f32 + axis.cross(u) * sin as f32
}

fn set<T: Copy>(slot: &mut Option<T>, value: T, is_finite: fn(T) -> bool) {
    if is_finite(value) {
        *slot = Some(value);
    }
}

type Lanes = [f64; 4];

/// Says of a target what its curve says.
fn write(target: &Target, lanes: Lanes, keys: &[(f64, KeyValue)], rest: &Transform, out: &mut Sample) {
    match target.meaning() {
        Meaning::Named(target) => target.set(lanes, out),
        Meaning::Lane(part, lane) => set_lane(part, lane, lanes[0], rest, out),
        Meaning::Surface(field) => field.set(lanes, out),
        Meaning::Text(path) => {
            // A spline may swing below zero between keys; colours and sizes must not.
            let floor = |lane: usize| match keys.iter().all(|(_, key)| key.numbers()[lane] >= 0.0) {
                true => 0.0,
                false => f64::NEG_INFINITY,
            };
            let lanes = std::array::from_fn(|lane| lanes[lane].max(floor(lane)));
            let count = keys.first().map_or(1, |(_, key)| key.count());
            out.fields.retain(|field| field.path != path);
            out.fields.push(FieldSample { path: path.to_owned(), lanes, count });
        }
    }
}

/// One number of a transform; the others stay what they are.
fn set_lane(part: Part, lane: usize, value: f64, rest: &Transform, out: &mut Sample) {
    let value = value as f32;
    match part {
        Part::Translation => {
            let mut now = out.translation.unwrap_or(rest.translation);
            now[lane] = value;
            set(&mut out.translation, now, Vec3::is_finite);
        }
        Part::Scale => {
            let mut now = out.scale.unwrap_or(rest.scale);
            now[lane] = value;
            set(&mut out.scale, now, Vec3::is_finite);
        }
        Part::Rotation => {
            let (y, x, z) = out.rotation.unwrap_or_else(|| rest.unit_rotation()).to_euler(EulerRot::YXZ);
            let mut now = Vec3::new(x, y, z).map(f32::to_degrees);
            now[lane] = value;
            set(&mut out.rotation, rotation_from_degrees(now), Quat::is_finite);
        }
    }
}

impl SurfaceField {
    fn set(self, lanes: Lanes, out: &mut Sample) {
        let [x, y, z, _] = lanes.map(|v| v as f32);
        let material = &mut out.material;
        let layers = &mut material.layers;
        let unit = x.clamp(0.0, 1.0);
        match self {
            Self::Clearcoat => set(&mut layers.clearcoat, unit, f32::is_finite),
            Self::ClearcoatRoughness => set(&mut layers.clearcoat_roughness, unit, f32::is_finite),
            Self::SheenColor => {
                set(&mut layers.sheen_color, Vec3::new(x, y, z).clamp(Vec3::ZERO, Vec3::ONE), Vec3::is_finite);
            }
            Self::SheenRoughness => set(&mut layers.sheen_roughness, unit, f32::is_finite),
            Self::Anisotropy => set(&mut layers.anisotropy, unit, f32::is_finite),
            Self::AnisotropyRotation => set(&mut layers.anisotropy_rotation, x.to_radians(), f32::is_finite),
            Self::Iridescence => set(&mut layers.iridescence, unit, f32::is_finite),
            Self::IridescenceThickness => set(&mut layers.iridescence_thickness, x.max(0.0), f32::is_finite),
            Self::Dispersion => set(&mut layers.dispersion, x.max(0.0), f32::is_finite),
            Self::CastsShadow => out.casts_shadow = Some(x >= 0.5),
            Self::DoubleSided => material.double_sided = Some(x >= 0.5),
            Self::Specular => set(&mut material.specular, x.clamp(0.0, 1.0), f32::is_finite),
            Self::SpecularColor => {
                set(&mut material.specular_color, Vec3::new(x, y, z).max(Vec3::ZERO), Vec3::is_finite);
            }
            Self::Transmission => set(&mut material.transmission, x.clamp(0.0, 1.0), f32::is_finite),
            Self::NormalScale => set(&mut material.normal_scale, x, f32::is_finite),
            Self::AlphaCutoff => set(&mut material.alpha_cutoff, x.max(0.0), f32::is_finite),
        }
    }
}

impl Target {
    fn set(self, lanes: Lanes, out: &mut Sample) {
        let [x, y, z, w] = lanes.map(|v| v as f32);
        let vector = Vec3::new(x, y, z);
        match self {
            Self::Translation => set(&mut out.translation, vector, Vec3::is_finite),
            Self::Rotation => set(&mut out.rotation, Quat::from_xyzw(x, y, z, w), Quat::is_finite),
            Self::Scale => set(&mut out.scale, vector, Vec3::is_finite),
            // A spline may swing below zero between keys; light does not.
            Self::LightIntensity => set(&mut out.intensity, x.max(0.0), f32::is_finite),
            Self::LightColor => set(&mut out.color, vector.max(Vec3::ZERO), Vec3::is_finite),
            Self::CameraFov => set(&mut out.fov, x, f32::is_finite),
            Self::CameraHeight => set(&mut out.height, x.max(1e-6), f32::is_finite),
            Self::LightRange => set(&mut out.range, x.max(1e-6), f32::is_finite),
            Self::LightInner => set(&mut out.inner, x.clamp(0.0, 90.0), f32::is_finite),
            Self::LightOuter => set(&mut out.outer, x.clamp(0.0, 90.0), f32::is_finite),
            Self::MorphWeight(index) => out.weights.extend(x.is_finite().then_some((index as usize, x))),
            Self::Visible => set(&mut out.visible, x >= 0.5, |_| true),
            Self::MaterialEmissive => set(&mut out.material.emissive, vector.max(Vec3::ZERO), Vec3::is_finite),
            Self::MaterialColor => {
                set(&mut out.material.color, vector.clamp(Vec3::ZERO, Vec3::ONE), Vec3::is_finite);
            }
            Self::MaterialAlpha => set(&mut out.material.alpha, x.clamp(0.0, 1.0), f32::is_finite),
            Self::MaterialMetallic => set(&mut out.material.metallic, x.clamp(0.0, 1.0), f32::is_finite),
            Self::MaterialRoughness => set(&mut out.material.roughness, x.clamp(0.0, 1.0), f32::is_finite),
            // Paths are told apart before.
            Self::Field(_) => {}
        }
    }
}

impl KeyValue {
    /// Numbers to interpolate; a rotation as a unit quaternion, a single number in all lanes.
    fn lanes(self, rotates: bool) -> Lanes {
        let widened = |q: Quat| {
            let q = q.to_array().map(f64::from);
            let length = dot(q, q).sqrt();
            q.map(|v| v / length)
        };
        match self {
            Self::Quaternion(q) if rotates => widened(q),
            Self::Vector(v) if rotates => widened(rotation_from_degrees(v)),
            Self::Scalar(v) => [v.into(); 4],
            _ => self.numbers(),
        }
    }
}

/// Keys and the curve through them.
struct Curve<'a> {
    /// Whether the values are rotations.
    rotates: bool,
    keys: &'a [(f64, KeyValue)],
    interpolation: Interpolation,
    wrap: Wrap,
}

impl Curve<'_> {
    fn at(&self, time: f64) -> Lanes {
        let next = self.keys.partition_point(|(t, _)| *t <= time);
        if next == 0 {
            return self.value(0);
        }
        let here = next - 1;
        let (start, value) = (self.keys[here].0, self.value(here));
        let is_step = self.interpolation == Interpolation::Step || matches!(self.keys[here].1, KeyValue::Flag(_));
        if next == self.keys.len() || start == time || is_step {
            return value;
        }
        let s = (time - start) / (self.keys[next].0 - start);
        let end = self.aligned(self.value(next), value);
        match self.interpolation {
            Interpolation::Cubic => self.cubic(here, value, end, s),
            _ if self.rotates => slerp(value, end, s),
            _ => std::array::from_fn(|i| value[i] + s * (end[i] - value[i])),
        }
    }

    fn value(&self, key: usize) -> Lanes {
        self.keys[key].1.lanes(self.rotates)
    }

    /// The same rotation, by the quaternion that is nearer to another; other values as they are.
    fn aligned(&self, value: Lanes, to: Lanes) -> Lanes {
        if self.rotates && dot(value, to) < 0.0 { value.map(|v| -v) } else { value }
    }

    /// Hermite spline between keys `here` and `here + 1`, whose values are a and b.
    fn cubic(&self, here: usize, a: Lanes, b: Lanes, s: f64) -> Lanes {
        let (t0, t1) = (self.keys[here].0, self.keys[here + 1].0);
        let span = t1 - t0;
        let (before_time, before) = self.neighbour(here, -1, a).unwrap_or((t0, a));
        let (after_time, after) = self.neighbour(here + 1, 1, b).unwrap_or((t1, b));
        let (s2, s3) = (s * s, s * s * s);
        let (h00, h10, h01, h11) = (2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, 3.0 * s2 - 2.0 * s3, s3 - s2);
        let lanes: Lanes = std::array::from_fn(|i| {
            let tangent_a = (b[i] - before[i]) / (t1 - before_time);
            let tangent_b = (after[i] - a[i]) / (after_time - t0);
            h00 * a[i] + h10 * span * tangent_a + h01 * b[i] + h11 * span * tangent_b
        });
        if self.rotates { normalized(lanes, a) } else { lanes }
    }

    /// Time and value of the key before or after one, over the seam of a closed loop; none at an open end.
    fn neighbour(&self, key: usize, step: isize, to: Lanes) -> Option<(f64, Lanes)> {
        if let Some(other) = key.checked_add_signed(step).filter(|k| *k < self.keys.len()) {
            return Some((self.keys[other].0, self.aligned(self.value(other), to)));
        }
        let last = self.keys.len() - 1;
        let seam = self.aligned(self.value(last), self.value(0)) == self.value(0);
        if self.wrap != Wrap::Loop || self.keys[0].0 != 0.0 || !seam {
            return None;
        }
        let (other, shift) = if step < 0 { (last - 1, -1.0) } else { (1, 1.0) };
        Some((self.keys[other].0 + shift * self.keys[last].0, self.aligned(self.value(other), to)))
    }
}

fn dot(a: Lanes, b: Lanes) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The unit quaternion, or a fallback for one without direction.
fn normalized(q: Lanes, fallback: Lanes) -> Lanes {
    let length = dot(q, q).sqrt();
    if length > 1e-9 && length.is_finite() { q.map(|v| v / length) } else { fallback }
}

/// Spherical linear interpolation of unit quaternions (Shoemake 1985).
fn slerp(a: Lanes, b: Lanes, s: f64) -> Lanes {
    let angle = dot(a, b).clamp(-1.0, 1.0).acos();
    let sin = angle.sin();
    // Nearly the same rotation: the chord is the arc to rounding.
    let (wa, wb) = if sin < 1e-6 { (1.0 - s, s) } else { (((1.0 - s) * angle).sin() / sin, (s * angle).sin() / sin) };
    normalized(std::array::from_fn(|i| wa * a[i] + wb * b[i]), a)
}
