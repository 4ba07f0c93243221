//! Materials of a room.

use super::random::Random;

/// A material, as scene files have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Name.
    pub name: String,
    /// Base colour, linear RGB.
    pub color: [f64; 3],
    /// Perceptual roughness.
    pub roughness: f64,
    /// 1: metal.
    pub metallic: f64,
    /// Strength of the reflection of dielectrics.
    pub specular: f64,
    /// Emitted radiance [W/(m² sr)].
    pub emissive: [f64; 3],
    /// Whether both sides are drawn.
    pub double_sided: bool,
}

/// A colour of an albedo from .05 to .9: mostly near grey, one time in four saturated.
fn color(random: &mut Random) -> [f64; 3] {
    let albedo = random.within(0.05, 0.9);
    if random.chance(0.75) {
        return [0; 3].map(|_| (albedo * random.within(0.85, 1.1)).clamp(0.05, 0.9));
    }
    // One channel leads, the others fall behind, each by as much as chance has it.
    let lead = random.below(3);
    let mut color = [0, 1, 2].map(|_| albedo * random.log_within(0.06, 0.8));
    color[lead] = albedo.max(0.3);
    color.map(|channel| channel.clamp(0.02, 0.9))
}

/// A diffuse material.
pub fn diffuse(random: &mut Random, name: &str) -> Surface {
    Surface {
        name: name.to_owned(),
        color: color(random),
        roughness: 1.0,
        metallic: 0.0,
        specular: 0.0,
        emissive: [0.0; 3],
        double_sided: false,
    }
}

/// Any material: three in five are diffuse, the others rough or polished dielectrics and metals.
pub fn any(random: &mut Random, name: &str) -> Surface {
    let surface = diffuse(random, name);
    match random.weighted(&[0.6, 0.16, 0.16, 0.08]) {
        1 => Surface { specular: 1.0, roughness: random.within(0.5, 1.0), ..surface },
        2 => Surface { specular: 1.0, roughness: random.within(0.1, 0.5), ..surface },
        3 => Surface { metallic: 1.0, roughness: random.within(0.15, 0.6), ..surface },
        _ => surface,
    }
}

/// The colour of a light: white, warm, cold or saturated. Its mean is 1 or so.
pub fn light_color(random: &mut Random) -> [f64; 3] {
    match random.weighted(&[0.4, 0.3, 0.15, 0.15]) {
        0 => [1.0; 3],
        1 => [1.25, 1.0, 0.7],
        2 => [0.8, 1.0, 1.25],
        _ => [0; 3].map(|_| random.within(0.2, 1.8)),
    }
}

impl Surface {
    /// Whether it reflects more than a rough surface does.
    pub fn is_glossy(&self) -> bool {
        (self.specular > 0.0 || self.metallic > 0.0) && self.roughness < 0.5
    }
}
