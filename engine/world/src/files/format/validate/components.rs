//! What values transforms, animations, lights, cameras, fog, particles and the settings of light methods may have.

use super::{Checked, Validator};
use crate::files::error::FileErrorKind as Kind;
use crate::files::format::scene_file::{Rotation, Scale, TransformFile};
use crate::files::ron::tree::Step;
use crate::world::animation::AnimationError;
use crate::world::{
    Animation, Bounces, Camera, CellSize, Clpv, ClpvPlacement, Delta, Fog, FogShape, GatherRays, InstantRadiosity,
    Light, LightKind, Particles, Projection, StochasticLightCulling,
};
use glam::Vec3;
use std::ops::RangeInclusive;

impl Validator {
    pub(super) fn animation(&mut self, a: &Animation) -> Checked {
        use AnimationError as E;
        let Err(error) = a.validate() else { return Ok(()) };
        let (track, key, field) = match &error {
            E::Timing { field, .. } => return Err(self.fault(field, Kind::BadValue, error.to_string(), "")),
            E::Axis { track, .. } => (*track, None, "axis"),
            E::Number { track, field, .. } => (*track, None, *field),
            E::NoKeys { track } => (*track, None, "keys"),
            E::Path { track, .. } => (*track, None, "target"),
            E::Unsorted { track, key, .. } | E::Time { track, key, .. } | E::Value { track, key, .. } => {
                (*track, Some(*key), "keys")
            }
        };
        let mut fault = self.fault("tracks", Kind::BadValue, error.to_string(), "");
        fault.path.extend([Step::Index(track), Step::Key(field.to_owned())]);
        fault.path.extend(key.map(Step::Index));
        Err(fault)
    }

    pub(super) fn transform(&mut self, t: &TransformFile) -> Checked {
        self.finite("translation", &t.translation.to_array())?;
        match t.rotation {
            Some(Rotation::Euler(v)) => self.finite("rotation", &v.to_array())?,
            Some(Rotation::Quaternion(q)) => {
                self.finite("rotation", &q.to_array())?;
                self.require(
                    q.length_squared() > 1e-12,
                    "rotation",
                    "the quaternion is zero",
                    "no rotation is (0, 0, 0, 1)",
                )?;
            }
            None => {}
        }
        match t.scale {
            Some(Scale::Uniform(s)) => self.finite("scale", &[s])?,
            Some(Scale::Axes(s)) => self.finite("scale", &s.to_array())?,
            None => {}
        }
        let Some(target) = t.look_at else { return Ok(()) };
        self.finite("look_at", &target.to_array())?;
        self.require(t.rotation.is_none(), "look_at", "both `rotation` and `look_at` are given", "keep one of them")?;
        self.require(target != t.translation, "look_at", "the entity looks at its own place", "use another point")
    }

    pub(super) fn light(&mut self, l: &Light) -> Checked {
        self.color("color", l.color, f32::MAX)?;
        self.number("intensity", l.intensity, 0.0, f32::MAX)?;
        if let Some(range) = l.range {
            self.require(
                range.is_finite() && range > 0.0,
                "range",
                format!("`range` is {range}"),
                "use a distance above zero [m], or leave it out for no bound",
            )?;
        }
        if let LightKind::Spot { inner, outer } = l.kind {
            let ok = inner >= 0.0 && inner < outer && outer <= 90.0;
            self.require(
                ok,
                "kind",
                format!("the cone goes from {inner}° to {outer}°"),
                "use half angles 0 ≤ inner < outer ≤ 90 degrees",
            )?;
        }
        self.light_surface(l.kind)?;
        let size = |s: u32, low: u32, high: u32| (low..=high).contains(&s);
        self.require(
            size(l.shadow_size, 16, 8192),
            "shadow_size",
            format!("`shadow_size` is {}", l.shadow_size),
            "use 16 to 8192 texels",
        )?;
        self.require(
            size(l.rsm_size, 4, 2048),
            "rsm_size",
            format!("`rsm_size` is {}", l.rsm_size),
            "use 4 to 2048 texels",
        )
    }

    /// Sizes of lights with a surface.
    fn light_surface(&mut self, kind: LightKind) -> Checked {
        let sizes: &[(&str, f32)] = match kind {
            LightKind::Sphere { radius } => &[("radius", radius)],
            LightKind::Disc { radius } => &[("radius", radius)],
            LightKind::Rectangle { width, height } => &[("width", width), ("height", height)],
            LightKind::Tube { length, radius } => &[("length", length), ("radius", radius)],
            LightKind::Sun { angle } => {
                return self.require(
                    LightKind::ANGLES.contains(&angle),
                    "kind",
                    format!("the sun's `angle` is {angle}°"),
                    "use 0.001 to 90 degrees (the sun has 0.53), or Directional for none",
                );
            }
            LightKind::Directional | LightKind::Point | LightKind::Spot { .. } => return Ok(()),
        };
        sizes.iter().try_for_each(|(name, size)| {
            self.require(
                LightKind::SIZES.contains(size),
                "kind",
                format!("the light's `{name}` is {size}"),
                "use 1e-6 to 1e6 m, or Point for a light without a size",
            )
        })
    }

    pub(super) fn fog(&mut self, f: &Fog) -> Checked {
        let (is_valid, message) = match f.shape {
            FogShape::Everywhere => (true, String::new()),
            FogShape::Box { size } => (
                size.to_array().iter().all(|edge| Fog::SIZES.contains(edge)),
                format!("the fog's `size` is ({}, {}, {})", size.x, size.y, size.z),
            ),
            FogShape::Sphere { radius } => (Fog::SIZES.contains(&radius), format!("the fog's `radius` is {radius}")),
        };
        self.require(is_valid, "shape", message, "use 1e-6 to 1e6 m, or Everywhere for a fog without bounds")?;
        self.require(
            Fog::EXTINCTIONS.contains(&f.extinction),
            "extinction",
            format!("`extinction` is {}", f.extinction),
            "use 0 to 1e6 [1/m]; one sees 10 m far with 0.1",
        )?;
        self.color("albedo", f.albedo, 1.0)?;
        self.require(
            Fog::ANISOTROPIES.contains(&f.anisotropy),
            "anisotropy",
            format!("`anisotropy` is {}", f.anisotropy),
            "use -0.95 to 0.95; 0 scatters light to all sides alike",
        )?;
        self.require(
            Fog::FALLOFFS.contains(&f.falloff),
            "falloff",
            format!("`falloff` is {}", f.falloff),
            "use 0 to 1e6 [1/m]; 0 is as dense at all heights",
        )
    }

    pub(super) fn particles(&mut self, p: &Particles) -> Checked {
        self.within("rate", p.rate, Particles::RATES, "use 0 to 1e6 [1/s]")?;
        self.within("life", p.life, Particles::LIVES, "use 0.001 to 1e4 s")?;
        self.require(
            p.count() <= Particles::MOST,
            "rate",
            format!("{} in a second that live for {} s each are {} particles at once", p.rate, p.life, p.count()),
            &format!(
                "a source has at most {}: use a `rate` of at most {}, or a shorter `life`",
                Particles::MOST,
                (Particles::MOST as f32 / p.life).floor()
            ),
        )?;
        self.all_within("source", p.source, Particles::SOURCES, "use edges of 0 to 1e6 m; 0 is a point")?;
        self.all_within("velocity", p.velocity, Particles::SPEEDS, "use -1e4 to 1e4 m/s along each axis")?;
        self.within("spread", p.spread, Particles::SPREADS, "use 0 to 180 degrees; 180 is all directions alike")?;
        self.within("speed_variation", p.speed_variation, 0.0..=1.0, "use 0 to 1; 0 is the same speed for all")?;
        self.all_within("gravity", p.gravity, Particles::SPEEDS, "use -1e4 to 1e4 m/s² along each axis")?;
        self.within("radius", p.radius, Particles::RADII, "use 0 to 1e3 m")?;
        self.within("end_radius", p.end_radius, Particles::RADII, "use 0 to 1e3 m")?;
        self.color("color", p.color, 1.0)?;
        self.color("end_color", p.end_color, 1.0)?;
        self.within("radiance", p.radiance, Particles::RADIANCES, "use 0 to 1e12 W/(m² sr)")
    }

    fn within(&self, field: &str, value: f32, range: RangeInclusive<f32>, help: &str) -> Checked {
        self.require(range.contains(&value), field, format!("`{field}` is {value}"), help)
    }

    fn all_within(&self, field: &str, value: Vec3, range: RangeInclusive<f32>, help: &str) -> Checked {
        let is_valid = value.to_array().iter().all(|v| range.contains(v));
        self.require(is_valid, field, format!("`{field}` is ({}, {}, {})", value.x, value.y, value.z), help)
    }

    pub(super) fn camera(&mut self, c: &Camera) -> Checked {
        self.require(
            c.fov > 0.0 && c.fov < 180.0,
            "fov",
            format!("`fov` is {}", c.fov),
            "use a vertical field of view between 0 and 180 degrees",
        )?;
        let (is_in_range, help) = match c.projection {
            Projection::Perspective => (c.near > 0.0, "use a distance above zero [m]"),
            Projection::Orthographic { height } => {
                let message = format!("the height of what is seen is {height}");
                let is_valid = Projection::HEIGHTS.contains(&height);
                self.require(is_valid, "projection", message, "use Orthographic(height: …) of 1e-6 to 1e9 m")?;
                (c.near >= 0.0, "use a distance from zero up [m]")
            }
        };
        self.require(c.near.is_finite() && is_in_range, "near", format!("`near` is {}", c.near), help)?;
        if let Some(fault) = c.lens.fault() {
            return self.field("lens", |v| Err(v.fault(fault.field, Kind::BadValue, fault.message, fault.help)));
        }
        let Some(far) = c.far else { return Ok(()) };
        self.require(
            far.is_finite() && far > c.near,
            "far",
            format!("`far` is {far}, `near` is {}", c.near),
            "put the far plane behind the near plane, or leave it out",
        )
    }

    pub(super) fn clpv(&mut self, c: &Clpv) -> Checked {
        if let ClpvPlacement::Camera { ahead } = c.placement {
            self.require((0.0..=1.0).contains(&ahead), "placement", format!("`ahead` is {ahead}"), "use 0 to 1")?;
        }
        self.require((1..=4).contains(&c.cascades), "cascades", format!("`cascades` is {}", c.cascades), "use 1 to 4")?;
        for (i, n) in c.cells.iter().enumerate() {
            self.field("cells", |v| {
                v.step(Step::Index(i), |v| {
                    v.require(
                        (1..=128).contains(n),
                        "",
                        format!("{n} cells along {}", ["x", "y", "z"][i]),
                        "use 1 to 128 cells",
                    )
                })
            })?;
        }
        if let CellSize::Meters(h) = c.cell_size {
            self.require(
                h.is_finite() && h > 0.0,
                "cell_size",
                format!("the cell size is {h}"),
                "use a length above zero [m], or Auto",
            )?;
        }
        if let Bounces::Count(n) = c.bounces {
            self.require(
                (1..=32).contains(&n),
                "bounces",
                format!("{n} bounces"),
                "use Count(1) to Count(32), or Converged",
            )?;
        }
        if let GatherRays::Count(n) = c.gather_rays {
            self.require(n <= 16, "gather_rays", format!("{n} rays"), "use Count(0) to Count(16), or Auto")?;
        }
        if let GatherRays::Count(n) = c.gather_points {
            self.require(n <= 16, "gather_points", format!("{n} points"), "use Count(0) to Count(16), or Auto")?;
        }
        if let GatherRays::Count(n) = c.mirror_rays {
            self.require(n <= 16, "mirror_rays", format!("{n} rays"), "use Count(0) to Count(16), or Auto")?;
        }
        if let GatherRays::Paths(n) = c.gather_rays {
            self.require(
                (1..=16).contains(&n),
                "gather_rays",
                format!("{n} paths"),
                "use Paths(1) to Paths(16), or Auto",
            )?;
        }
        let are_points = !matches!(c.gather_points, GatherRays::Paths(_));
        self.require(are_points, "gather_points", "points have no paths", "use Count(0) to Count(16), or Auto")?;
        let are_rays = !matches!(c.mirror_rays, GatherRays::Paths(_));
        self.require(are_rays, "mirror_rays", "mirrors have no paths", "use Count(0) to Count(16), or Auto")?;
        let filter = format!("`gather_filter` is {}", c.gather_filter);
        self.require(c.gather_filter <= 32, "gather_filter", filter, "use 0 to 32 pixels")?;
        self.require(c.steps <= 1024, "steps", format!("`steps` is {}", c.steps), "use 0 to 1024")?;
        self.number("blocker_scale", c.blocker_scale, 0.0, 1e6)?;
        self.number("gain", c.gain, 0.0, 1e6)?;
        self.number("border_fade", c.border_fade, 0.0, 128.0)?;
        self.number("outside_fade", c.outside_fade, 0.0, 128.0)?;
        self.number("gradient_damping", c.gradient_damping, 0.0, 1e6)?;
        self.number("ambient_occlusion", c.ambient_occlusion, 0.0, 1e6)?;
        let samples = c.rsm_samples;
        let help = "use 1 to 65536 texels, or 0 for all of them";
        self.require(samples <= 65_536, "rsm_samples", format!("`rsm_samples` is {samples}"), help)
    }

    pub(super) fn vpl(&mut self, c: &InstantRadiosity) -> Checked {
        self.require(c.particles > 0, "particles", "there are no particles", "use 1 or more")?;
        if let Bounces::Count(n) = c.bounces {
            let help = "use Count(1) to Count(32), or Converged";
            self.require((1..=32).contains(&n), "bounces", format!("{n} bounces"), help)?;
        }
        self.number("near_bound", c.near_bound, 0.0, 1e3)?;
        let candidates = format!("`candidates` is {}", c.candidates);
        self.require((1..=64).contains(&c.candidates), "candidates", candidates, "use 1 to 64")?;
        let rays = format!("`near_rays` is {}", c.near_rays);
        self.require(c.near_rays <= 16, "near_rays", rays, "use 0 to 16")?;
        let filter = format!("`near_filter` is {}", c.near_filter);
        self.require(c.near_filter <= 32, "near_filter", filter, "use 0 to 32 pixels")?;
        self.number("shadow_bias", c.shadow_bias, 0.0, 1e3)?;
        self.number("shadow_slope_bias", c.shadow_slope_bias, 0.0, 1e3)?;
        self.number("shadow_offset", c.shadow_offset, 0.0, 1e3)?;
        let samples = c.shadow_samples;
        let message = format!("`shadow_samples` is {samples}");
        self.require((1..=64).contains(&samples), "shadow_samples", message, "use 1 to 64")
    }

    pub(super) fn slc(&mut self, c: &StochasticLightCulling) -> Checked {
        let size = c.rsm_size;
        self.require((8..=4096).contains(&size), "rsm_size", format!("`rsm_size` is {size}"), "use 8 to 4096 texels")?;
        let (delta, help) = match c.delta {
            Delta::Relative(x) => ((1e-12..=1e6).contains(&x), "use a share of the mean irradiance, 1e-12 to 1e6"),
            Delta::Absolute(x) => (x.is_finite() && x > 0.0, "use an irradiance above zero [W/m²]"),
        };
        self.require(delta, "delta", format!("`delta` is {:?}", c.delta), help)?;
        let n = c.interleave;
        self.require(
            n <= 16 && n.is_power_of_two(),
            "interleave",
            format!("`interleave` is {n}"),
            "use 1, 2, 4, 8 or 16",
        )?;
        self.require(
            c.filter_radius <= 64,
            "filter_radius",
            format!("`filter_radius` is {}", c.filter_radius),
            "use 0 to 64 pixels",
        )
    }
}
