//! What the paper prints in tables 1 and 2 and figures 9 and 10 (Tokuyoshi and Harada 2017).

use lightwell::world::LightBounds;

/// Bounds in the order of the figures, (a) to (c).
pub const BOUNDS: [(LightBounds, &str); 3] = [
    (LightBounds::CentredSphere, "sphere centred at the light"),
    (LightBounds::EnclosingSphere, "sphere around the ellipsoid"),
    (LightBounds::Ellipsoid, "ellipsoid"),
];

/// Columns of table 1, the last of which is the sum.
pub const STEPS: [&str; 6] =
    ["G-buffer", "reflective shadow map", "lights and ranges", "culling and shading", "denoising", "total"];

/// Rows of table 2.
pub const WAYS: [&str; 3] = ["splatting", "clustered shading", "tiled culling"];
/// Table 2 \[ms\]: diffuse lights, then glossy ones; rows as [`WAYS`]. Its seven columns are pictures without names.
pub const TABLE_2: [[[f64; 7]; 3]; 2] = [
    [
        [17.05, 12.96, 16.48, 53.03, 21.42, 12.39, 7.22],
        [12.69, 10.89, 12.36, 10.81, 6.54, 13.06, 7.19],
        [3.75, 3.05, 3.27, 3.83, 2.56, 3.23, 1.98],
    ],
    [
        [10.12, 8.91, 17.67, 5.93, 58.81, 14.68, 13.02],
        [5.92, 4.99, 8.13, 3.92, 15.66, 10.99, 5.40],
        [3.73, 2.87, 3.94, 2.15, 7.28, 5.14, 2.47],
    ],
];

/// What figures 9 and 10 print of a bound: time of a frame \[ms\], glossy lights a pixel, and those of them in vain.
pub type Row = (f64, f64, f64);

/// A scene of the paper, or a roughness of its figure 10.
pub struct Subject {
    /// Its name in the paper.
    pub name: &'static str,
    /// Our scene.
    pub scene: &'static str,
    /// Our stand-in for where its model is missing.
    pub stand_in: Option<&'static str>,
    /// The preset that gives our scene its roughness.
    pub roughness: Option<&'static str>,
    /// RMSE, where it is legible.
    pub rmse: Option<f64>,
    /// Rows of [`BOUNDS`].
    pub bounds: [Row; 3],
    /// Its column of table 1 \[ms\], as [`STEPS`].
    pub times: Option<[f64; 6]>,
}

impl Subject {
    /// Whether it belongs to figure 10, and not to figure 9.
    pub fn is_of_the_series(&self) -> bool {
        self.roughness.is_some()
    }
}

const fn roughness(name: &'static str, preset: &'static str, rmse: f64, bounds: [Row; 3]) -> Subject {
    let roughness = Some(preset);
    Subject { name, scene: "glossy_ring", stand_in: None, roughness, rmse: Some(rmse), bounds, times: None }
}

/// The scenes of figure 9, and the series of figure 10.
pub const SUBJECTS: [Subject; 7] = [
    Subject {
        name: "Museum",
        scene: "night_court",
        stand_in: None,
        roughness: None,
        rmse: Some(0.0213),
        bounds: [(32.45, 207.9, 206.1), (21.75, 101.8, 100.0), (11.19, 18.3, 16.5)],
        times: Some([0.986, 0.610, 0.136, 7.398, 1.320, 10.450]),
    },
    Subject {
        name: "Sibenik",
        scene: "sibenik",
        stand_in: Some("cathedral"),
        roughness: None,
        rmse: None,
        bounds: [(36.14, 245.2, 241.8), (21.88, 124.5, 121.1), (9.85, 21.4, 17.9)],
        times: Some([0.618, 0.270, 0.140, 6.960, 1.328, 9.176]),
    },
    Subject {
        name: "Sponza",
        scene: "sponza",
        stand_in: Some("courtyard"),
        roughness: None,
        rmse: Some(0.0072),
        bounds: [(60.76, 449.2, 439.6), (39.58, 278.0, 268.3), (12.42, 47.5, 37.8)],
        times: Some([0.628, 0.121, 0.140, 9.745, 1.320, 11.956]),
    },
    roughness("roughness 0.4", "roughness_0.4", 0.0041, [(11.30, 53.6, 48.7), (8.18, 24.0, 19.1), (7.19, 17.5, 12.6)]),
    roughness(
        "roughness 0.2",
        "roughness_0.2",
        0.0099,
        [(18.20, 111.3, 106.5), (10.06, 41.9, 37.1), (7.17, 17.4, 12.7)],
    ),
    roughness(
        "roughness 0.1",
        "roughness_0.1",
        0.0194,
        [(22.30, 153.1, 149.7), (13.27, 68.2, 64.9), (6.63, 14.7, 11.3)],
    ),
    roughness(
        "roughness 0.05",
        "roughness_0.05",
        0.0334,
        [(23.31, 156.3, 154.2), (14.89, 82.5, 80.5), (6.27, 11.4, 9.3)],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Bounds differ in the lights in vain alone.
    #[test]
    fn printed_bounds_leave_the_same_lights_over() {
        for subject in &SUBJECTS {
            let [a, b, c] = subject.bounds.map(|(_, lights, vain)| lights - vain);
            assert!((a - c).abs() < 0.15 && (b - c).abs() < 0.15, "{}: {a}, {b} and {c}", subject.name);
        }
    }

    #[test]
    fn printed_totals_are_sums() {
        for subject in &SUBJECTS {
            let Some([gbuffer, rsm, lights, shading, denoising, total]) = subject.times else { continue };
            // Sibenik's leaves out the generation of lights.
            let lights = if subject.name == "Sibenik" { 0.0 } else { lights };
            let sum = gbuffer + rsm + lights + shading + denoising;
            assert!((sum - total).abs() < 0.005, "{}: {sum} and {total}", subject.name);
        }
    }
}
