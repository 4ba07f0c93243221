//! What a camera makes of the light that it sees: focus, bloom, exposure, tone map, vignette and film. See `docs/lens.md`.

use crate::assets::CubeTable;
use bevy_ecs::prelude::Component;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Luminance of white light of one watt [lm/W]: the luminous efficacy of an even spectrum over the visible range, which
/// Radiance converts by (Ward 1994, "The RADIANCE lighting simulation and rendering system").
pub const LUMENS_A_WATT: f32 = 179.0;

/// How light becomes what a screen shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ToneMap {
    /// Khronos PBR Neutral: base colours stay as they are, brighter light is compressed.
    #[default]
    Neutral,
    /// A filmic curve with soft shadows and highlights: the fit of the ACES reference by Narkowicz (2016).
    Filmic,
    /// AgX (Sobotka): low contrast, and bright colours fade to white as on film. Its curve is the polynomial of Wrensch
    /// (2023).
    AgX,
    /// ACES reference and output transform for sRGB displays, as fitted by Hill (2016): high contrast, bright colours
    /// fade.
    Aces,
    /// Reinhard et al. (2002, eq. 4) on luminance: hues stay, and what is 4 times as bright as white becomes white.
    Reinhard,
    /// None: what is brighter than white is cut off.
    Linear,
}

impl ToneMap {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Neutral, Self::Filmic, Self::AgX, Self::Aces, Self::Reinhard, Self::Linear];
}

/// How bright the display shows the light. The scene's `exposure` in stops comes on top.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Exposure {
    /// The scene's `exposure` alone: a radiance of 1 W/(m² sr) is white at 0 stops.
    #[default]
    Scene,
    /// The mean of the logarithm of the luminance becomes middle grey (Reinhard et al. 2002). The scene's `exposure` has
    /// no part in it.
    Automatic,
    /// By the settings of a photographic camera (ISO 2720 and 12232; Lagarde and de Rousiers 2014), with 179 lumens a
    /// watt.
    Photographic {
        /// Aperture as focal length over diameter, 0.1 to 10000.
        f_number: f32,
        /// Time that the shutter is open \[s\], 1e-9 to 1e6.
        shutter: f32,
        /// Sensitivity of the sensor, ISO 0.001 to 1e9.
        iso: f32,
    },
}

/// Apertures that a lens may have, as focal length over diameter.
pub const F_NUMBERS: RangeInclusive<f32> = 0.1..=1e4;
/// Exposure times [s].
const SHUTTERS: RangeInclusive<f32> = 1e-9..=1e6;
/// Sensitivities [ISO].
const ISOS: RangeInclusive<f32> = 1e-3..=1e9;

impl Exposure {
    /// Exposure value at ISO 100: EV₁₀₀ = log₂(N²/t · 100/S) for aperture N, time t and sensitivity S (ISO 2720). None
    /// unless it is photographic.
    pub fn ev100(&self) -> Option<f32> {
        let Self::Photographic { f_number, shutter, iso } = *self else { return None };
        Some((f_number * f_number / shutter * 100.0 / iso).log2())
    }

    /// Factor on radiance, as a power of two \[stops\]. White is what saturates the sensor: a luminance of 1.2·2^EV₁₀₀
    /// cd/m², from the saturation speed of ISO 12232 (78 lx s over the ISO number) and a lens that passes 65 % of the
    /// light (Lagarde and de Rousiers 2014, "Moving Frostbite to physically based rendering").
    pub fn stops(&self) -> f32 {
        self.ev100().map_or(0.0, |ev100| (LUMENS_A_WATT / 1.2).log2() - ev100)
    }

    fn fault(&self) -> Option<LensFault> {
        let Self::Photographic { f_number, shutter, iso } = *self else { return None };
        LensFault::unless("exposure", "f_number", f_number, F_NUMBERS, "")
            .or_else(|| LensFault::unless("exposure", "shutter", shutter, SHUTTERS, " s"))
            .or_else(|| LensFault::unless("exposure", "iso", iso, ISOS, ""))
    }
}

/// Light that scatters in the lens, as a halo around all that is bright. None is lost: what a pixel gives to those around it
/// is taken from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Bloom {
    /// Share of the light that scatters, 0..1.
    pub scatter: f32,
    /// Radius of the widest halo, in heights of the image, 0.001 to 1.
    pub radius: f32,
}

impl Default for Bloom {
    fn default() -> Self {
        Self { scatter: 0.1, radius: 0.25 }
    }
}

impl Bloom {
    fn fault(&self) -> Option<LensFault> {
        LensFault::unless("bloom", "scatter", self.scatter, 0.0..=1.0, "")
            .or_else(|| LensFault::unless("bloom", "radius", self.radius, 1e-3..=1.0, ""))
    }
}

/// A thin lens: what does not lie on the plane of focus is spread over a circle. Perspective cameras alone have it; it blurs
/// what is measured too, in all methods and the path tracer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DepthOfField {
    /// Distance of the plane of focus along the axis of the view \[m\], 0.001 to 1e9.
    pub focus: f32,
    /// Aperture as focal length over diameter, 0.1 to 10000. Small numbers blur more.
    pub f_number: f32,
    /// Height of the sensor \[mm\], 0.1 to 10000. With the field of view it gives the focal length.
    pub sensor_height: f32,
}

impl Default for DepthOfField {
    fn default() -> Self {
        Self { focus: 5.0, f_number: 2.8, sensor_height: 24.0 }
    }
}

impl DepthOfField {
    fn fault(&self) -> Option<LensFault> {
        let field = "depth_of_field";
        LensFault::unless(field, "focus", self.focus, 1e-3..=1e9, " m")
            .or_else(|| LensFault::unless(field, "f_number", self.f_number, F_NUMBERS, ""))
            .or_else(|| LensFault::unless(field, "sensor_height", self.sensor_height, 0.1..=1e4, " mm"))
    }

    /// Radius of the lens \[m\] for half the image's height at distance 1: r = f/(2N), with the focal length f of a lens that is
    /// focused far away, f = height/(2·tan(fov/2)).
    pub fn lens_radius(&self, half_height: f32) -> f32 {
        let focal_length = 1e-3 * self.sensor_height / (2.0 * half_height);
        (focal_length / (2.0 * self.f_number)).min(1e6)
    }
}

/// What a camera makes of the light that it sees. Whatever is at its default runs no pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// How bright the display shows the light.
    pub exposure: Exposure,
    /// How light becomes what a screen shows.
    pub tone_map: ToneMap,
    /// A lens with a plane of focus; none: all is sharp.
    pub depth_of_field: Option<DepthOfField>,
    /// Light that scatters in the lens; none: all of it goes where it is focused.
    pub bloom: Option<Bloom>,
    /// A `.cube` file with a colour table of three dimensions, for what the tone map gives, sRGB-encoded; its path starts at
    /// this file's folder. An empty path is no table.
    pub grading: Option<String>,
    /// Share of the light that the corners of the image lose, 0 to 0.99: as natural vignetting does, by the fourth power of a
    /// cosine.
    pub vignette: f32,
    /// How much steeper edges become, 0..1: an unsharp mask that stays in the range of each pixel's neighbours.
    pub sharpening: f32,
    /// Grain of film: standard deviation at middle brightness as a share of the display's range, 0 to 0.5. Another one at
    /// each tick of the scene's clock.
    pub grain: f32,
}

/// The colour table that was loaded for a camera, with the path that asked for it.
#[derive(Component, Clone, Debug)]
pub struct GradingTable {
    /// The path, as [`Lens::grading`] has it.
    pub file: String,
    /// The table.
    pub table: Arc<CubeTable>,
}

/// A value of a lens that makes no sense.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LensFault {
    /// The field of [`Lens`].
    pub field: &'static str,
    /// The fault.
    pub message: String,
    /// What to use instead.
    pub help: String,
}

impl LensFault {
    /// A fault of a value inside of a field, unless it is in its range.
    fn unless(
        field: &'static str,
        name: &'static str,
        value: f32,
        range: RangeInclusive<f32>,
        unit: &str,
    ) -> Option<Self> {
        let (message, low, high) = (format!("`{name}` is {value}"), range.start(), range.end());
        (!range.contains(&value)).then(|| Self { field, message, help: format!("use {low} to {high}{unit}") })
    }
}

impl Lens {
    /// The first value that is out of its range.
    pub fn fault(&self) -> Option<LensFault> {
        self.exposure
            .fault()
            .or_else(|| self.depth_of_field.as_ref().and_then(DepthOfField::fault))
            .or_else(|| self.bloom.as_ref().and_then(Bloom::fault))
            .or_else(|| LensFault::unless("vignette", "vignette", self.vignette, 0.0..=0.99, ""))
            .or_else(|| LensFault::unless("sharpening", "sharpening", self.sharpening, 0.0..=1.0, ""))
            .or_else(|| LensFault::unless("grain", "grain", self.grain, 0.0..=0.5, ""))
    }

    /// The lens without the parts that have values out of their range, and those parts.
    pub fn in_range(&self) -> (Self, Vec<&'static str>) {
        let (mut lens, mut without) = (self.clone(), Vec::new());
        while let Some(fault) = lens.fault() {
            match fault.field {
                "exposure" => lens.exposure = Exposure::default(),
                "depth_of_field" => lens.depth_of_field = None,
                "bloom" => lens.bloom = None,
                "vignette" => lens.vignette = 0.0,
                "sharpening" => lens.sharpening = 0.0,
                "grain" => lens.grain = 0.0,
                _ => return (Self::default(), vec![fault.field]),
            }
            without.push(fault.field);
        }
        (lens, without)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// "Sunny 16": at f/16 and ISO 100 the time is 1/100 s, EV₁₀₀ = 14.64.
    #[test]
    fn exposure_values_are_those_of_photography() {
        let photographic = |f_number, shutter, iso| Exposure::Photographic { f_number, shutter, iso };
        assert_eq!(photographic(1.0, 1.0, 100.0).ev100(), Some(0.0));
        assert!((photographic(16.0, 0.01, 100.0).ev100().unwrap_or_default() - 14.644).abs() < 1e-3);
        // Twice the time, twice the sensitivity or 1/√2 of the f-number is one stop each.
        let base = photographic(4.0, 0.01, 200.0).stops();
        for brighter in [photographic(4.0, 0.02, 200.0), photographic(4.0, 0.01, 400.0)] {
            assert!((brighter.stops() - base - 1.0).abs() < 1e-4);
        }
        assert!((photographic(4.0 / 2_f32.sqrt(), 0.01, 200.0).stops() - base - 1.0).abs() < 1e-4);
        // At EV 0 white has 1.2 cd/m².
        let white = photographic(1.0, 1.0, 100.0).stops().exp2() * 1.2 / LUMENS_A_WATT;
        assert!((white - 1.0).abs() < 1e-5);
        assert_eq!(Exposure::Scene.stops(), 0.0);
    }

    #[test]
    fn values_out_of_range_are_faults_and_left_out() {
        for [f_number, shutter, iso] in [
            [0.0, 0.01, 100.0],
            [f32::INFINITY, 0.01, 100.0],
            [4.0, 0.0, 100.0],
            [4.0, -1.0, 100.0],
            [4.0, 0.01, 0.0],
            [4.0, 0.01, f32::NAN],
        ] {
            let exposure = Exposure::Photographic { f_number, shutter, iso };
            let lens = Lens { exposure, tone_map: ToneMap::AgX, ..Lens::default() };
            assert_eq!(lens.fault().map(|fault| fault.field), Some("exposure"), "{exposure:?}");
            let (lens, without) = lens.in_range();
            assert_eq!((lens.exposure, lens.tone_map, without), (Exposure::Scene, ToneMap::AgX, vec!["exposure"]));
        }
        for (scatter, radius) in [(-0.1, 0.2), (1.1, 0.2), (f32::NAN, 0.2), (0.2, 0.0), (0.2, f32::INFINITY)] {
            let lens = Lens { bloom: Some(Bloom { scatter, radius }), ..Lens::default() };
            assert_eq!(lens.in_range(), (Lens::default(), vec!["bloom"]));
        }
        let wild = Lens { vignette: 1.0, sharpening: f32::NAN, grain: -1.0, ..Lens::default() };
        assert_eq!(wild.in_range(), (Lens::default(), vec!["vignette", "sharpening", "grain"]));
        for (focus, f_number) in [(0.0, 2.0), (-1.0, 2.0), (f32::NAN, 2.0), (2.0, 0.0), (2.0, f32::INFINITY)] {
            let depth_of_field = Some(DepthOfField { focus, f_number, ..DepthOfField::default() });
            let lens = Lens { depth_of_field, ..Lens::default() };
            assert_eq!(lens.in_range(), (Lens::default(), vec!["depth_of_field"]));
        }
        for (f_number, shutter, iso) in [(0.1, 1e-9, 1e-3), (1e4, 1e6, 1e9), (0.1, 1e6, 1e9), (1e4, 1e-9, 1e-3)] {
            let exposure = Exposure::Photographic { f_number, shutter, iso };
            assert!(exposure.stops().is_finite() && exposure.fault().is_none());
        }
    }
}
