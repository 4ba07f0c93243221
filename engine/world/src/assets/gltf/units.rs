//! Units of `KHR_lights_punctual`: what the numbers of an exporter stand for in watts.
//!
//! The extension asks for candela and lux. Exporters write what their program has, so that the number alone does not
//! say its unit; the name of the exporter does.

use super::GltfLight;
use crate::core::LightKind;
use serde::{Deserialize, Serialize};
use std::f32::consts::PI;
use std::fmt;
use std::str::FromStr;

/// Lumens that exporters count for a watt: the luminous efficacy of light of 555 nm.
const LUMENS_A_WATT: f32 = 683.0;

/// Units that the punctual lights of a model are read in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LightUnits {
    /// Those of the program that wrote the file, as far as they are known; otherwise radiometric ones.
    #[default]
    Auto,
    /// Candela and lux, with 683 lumens a watt.
    Photometric,
    /// W/sr and W/m².
    Radiometric,
}

impl LightUnits {
    /// Their names on a command line.
    pub const NAMES: [&str; 3] = ["auto", "photometric", "radiometric"];
}

impl FromStr for LightUnits {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "auto" => Ok(Self::Auto),
            "photometric" => Ok(Self::Photometric),
            "radiometric" => Ok(Self::Radiometric),
            _ => Err(format!("`{name}` is none of {}", Self::NAMES.join(", "))),
        }
    }
}

/// Units as files hold them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Written {
    /// cd and lx.
    Photometric,
    /// W/sr and W/m².
    Radiometric,
    /// Radiant flux of point and spot lights \[W\], W/m² of directional ones.
    Flux,
}

/// How the lights of a file become those of a scene, with the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct LightConversion {
    written: Written,
    /// Blender's cones: brightness is a smooth step over the cosine.
    has_blender_cones: bool,
    reason: String,
}

impl LightConversion {
    /// That of a file which says that this program wrote it.
    pub fn of(units: LightUnits, generator: &str) -> Self {
        let blender = blender_version(generator);
        let (written, reason) = match (units, blender) {
            (LightUnits::Photometric, _) => (Written::Photometric, "as asked for".to_owned()),
            (LightUnits::Radiometric, _) => (Written::Radiometric, "as asked for".to_owned()),
            // The exporter converts since its version 3.4, and wrote Blender's own numbers before.
            (LightUnits::Auto, Some(version)) if version >= [3, 4] => (Written::Photometric, wrote(generator)),
            (LightUnits::Auto, Some(_)) => (Written::Flux, wrote(generator)),
            (LightUnits::Auto, None) if generator.trim().is_empty() => {
                (Written::Radiometric, "the file does not say what wrote it".to_owned())
            }
            (LightUnits::Auto, None) => (Written::Radiometric, wrote(generator)),
        };
        Self { written, has_blender_cones: blender.is_some(), reason }
    }

    /// The light in watts.
    pub fn apply(&self, light: &GltfLight) -> GltfLight {
        let factor = match (self.written, light.kind) {
            (Written::Radiometric, _) | (Written::Flux, LightKind::Directional) => 1.0,
            (Written::Photometric, _) => 1.0 / LUMENS_A_WATT,
            (Written::Flux, _) => 0.25 / PI,
        };
        let kind = match light.kind {
            LightKind::Spot { inner, outer } if self.has_blender_cones => blender_cone(inner, outer),
            kind => kind,
        };
        GltfLight { kind, intensity: factor * light.intensity, ..light.clone() }
    }
}

fn wrote(generator: &str) -> String {
    let shown: String = generator.chars().filter(|c| !c.is_control()).take(80).collect();
    format!("\"{}\" wrote the file", shown.trim())
}

impl fmt::Display for LightConversion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let units = match self.written {
            Written::Photometric => "candela and lux, and divided by 683 lm/W",
            Written::Radiometric => "W/sr and W/m², as they are",
            Written::Flux => "watts and W/m²; those of point lights and spots are divided by 4π",
        };
        write!(
            f,
            "intensities of lights are read as {units} ({}; `light_units` or --light-units changes it)",
            self.reason
        )
    }
}

/// Version of the Khronos exporter of Blender; none: it was another program.
fn blender_version(generator: &str) -> Option<[u32; 2]> {
    let rest = generator.trim().strip_prefix("Khronos glTF Blender I/O v")?;
    let mut numbers = rest.split('.').map(|part| part.chars().take_while(char::is_ascii_digit).collect::<String>());
    let mut next = || numbers.next()?.parse().ok();
    Some([next()?, next()?])
}

/// The cone that comes nearest to that of Blender. The exporter writes the angle `outer·(1 − blend)` as the inner one. Blender
/// has a smooth step of the cosine from the outer cone to the share `blend` of the way to the axis; glTF has a square of
/// it. Over 3/4 of the way the square lets as much light through.
fn blender_cone(inner: f32, outer: f32) -> LightKind {
    if !(outer > 0.0 && inner < outer) {
        return LightKind::Spot { inner, outer };
    }
    let (blend, cosine) = (1.0 - inner / outer, outer.to_radians().cos());
    let edge = cosine + 0.75 * blend * (1.0 - cosine);
    LightKind::Spot { inner: edge.clamp(-1.0, 1.0).acos().to_degrees().min(outer), outer }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn light(kind: LightKind) -> GltfLight {
        GltfLight { name: String::new(), kind, color: Vec3::ONE, intensity: 683.0, range: None }
    }

    fn intensities(units: LightUnits, generator: &str) -> [f32; 3] {
        let conversion = LightConversion::of(units, generator);
        let spot = LightKind::Spot { inner: 10.0, outer: 20.0 };
        [LightKind::Point, spot, LightKind::Directional].map(|kind| conversion.apply(&light(kind)).intensity)
    }

    #[test]
    fn the_exporter_decides_what_the_numbers_mean() {
        let (lumens, watts) = ([1.0; 3], [683.0; 3]);
        let flux = [683.0 / (4.0 * PI), 683.0 / (4.0 * PI), 683.0];
        for (generator, expected) in [
            ("Khronos glTF Blender I/O v5.0.21", lumens),
            ("Khronos glTF Blender I/O v3.4.49", lumens),
            ("Khronos glTF Blender I/O v10.1.0", lumens),
            ("Khronos glTF Blender I/O v3.3.36", flux),
            ("Khronos glTF Blender I/O v1.8.19", flux),
            ("Khronos glTF Blender I/O v", watts),
            ("THREE.GLTFExporter r180", watts),
            ("Godot Engine v4.5", watts),
            ("", watts),
        ] {
            let found = intensities(LightUnits::Auto, generator);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4 * b), "{generator}: {found:?}");
            assert_eq!(intensities(LightUnits::Radiometric, generator), watts, "{generator}");
            assert!(intensities(LightUnits::Photometric, generator).iter().all(|i| (i - 1.0).abs() < 1e-6));
        }
    }

    /// The light of a whole cone, over the cosine, by glTF's falloff and by Blender's.
    #[test]
    fn blender_spots_keep_their_flux() {
        let conversion = LightConversion::of(LightUnits::Auto, "Khronos glTF Blender I/O v5.0.21");
        for (outer, blend) in [(28.65f32, 0.15f32), (40.0, 1.0), (80.0, 0.5), (5.0, 0.3), (30.0, 0.0)] {
            let read = conversion.apply(&light(LightKind::Spot { inner: outer * (1.0 - blend), outer }));
            let LightKind::Spot { inner, outer } = read.kind else { panic!("{:?}", read.kind) };
            let [inside, edge] = [inner, outer].map(|angle| angle.to_radians().cos());
            let (mut ours, mut blenders) = (0.0, 0.0);
            for step in 0..10_000 {
                let cosine = edge + (1.0 - edge) * (step as f32 + 0.5) / 10_000.0;
                ours += ((cosine - edge) / (inside - edge).max(1e-6)).clamp(0.0, 1.0).powi(2);
                let t = ((cosine - edge) / ((1.0 - edge) * blend).max(1e-6)).clamp(0.0, 1.0);
                blenders += t * t * (3.0 - 2.0 * t);
            }
            assert!((ours / blenders - 1.0).abs() < 0.01, "{outer} {blend}: {ours} {blenders}");
        }
        let hard =
            LightConversion::of(LightUnits::Auto, "").apply(&light(LightKind::Spot { inner: 10.0, outer: 20.0 }));
        assert_eq!(hard.kind, LightKind::Spot { inner: 10.0, outer: 20.0 }, "others have glTF's cones");
    }

    #[test]
    fn names_are_read_back() {
        for (name, units) in
            LightUnits::NAMES.iter().zip([LightUnits::Auto, LightUnits::Photometric, LightUnits::Radiometric])
        {
            assert_eq!(name.parse(), Ok(units));
        }
        assert!("lumens".parse::<LightUnits>().is_err_and(|error| error.contains("photometric")));
    }
}
