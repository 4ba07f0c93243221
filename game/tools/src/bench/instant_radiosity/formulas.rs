//! What the report predicts: lights, intersection tests and draws by number of particles, objects and mean reflectance.

/// Virtual lights that N particles leave where none is lost: Σ ⌊ρᵏN⌋ ("Our version of Keller's instant radiosity").
pub(super) fn lights(particles: u32, reflectance: f64) -> u64 {
    // A rounding must not take one away where ρᵏN is whole.
    let count = |k: i32| (f64::from(particles) * reflectance.clamp(0.0, 0.95).powi(k) + 1e-9).floor() as u64;
    (0..).map(count).take_while(|&count| count > 0).sum()
}

/// Ray-object tests of B objects: Σ B·⌊ρᵏN⌋ ("Asymptotic time complexity for the particle simulation").
pub(super) fn tests(particles: u32, reflectance: f64, objects: u64) -> u64 {
    objects * lights(particles, reflectance)
}

/// The bound of that sum: B·N/(1−ρ).
pub(super) fn bound(particles: u32, reflectance: f64, objects: u64) -> f64 {
    objects as f64 * f64::from(particles) / (1.0 - reflectance).max(f64::MIN_POSITIVE)
}

/// Draws of a frame with M virtual lights: (7 + M)·B ("Asymptotic time complexity for the rendering").
pub(super) fn draws(lights: u64, objects: u64) -> u64 {
    (7 + lights) * objects
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_particles_at_one_half() {
        assert_eq!(lights(10, 0.5), 10 + 5 + 2 + 1);
        assert_eq!(tests(10, 0.5, 9), 9 * 18);
        assert_eq!(bound(10, 0.5, 9), 180.0);
        assert_eq!(draws(18, 9), 225);
    }

    #[test]
    fn the_sum_nears_its_bound() {
        for (particles, least) in [(16, 0.9), (4096, 0.998)] {
            let share = tests(particles, 0.5, 7) as f64 / bound(particles, 0.5, 7);
            assert!((least..=1.0).contains(&share), "N = {particles}: {share}");
        }
        assert_eq!(lights(5, 0.0), 5);
        assert!(lights(10, 1.0) < 1000, "white walls end too");
    }
}
