//! What the thesis prints in tables 7.1, 7.3 and 7.4 (Petr Šefčík 2016, "Computing global illumination in real-time
//! using Cascaded Light Propagation Volumes").

/// Columns of tables 7.3 and 7.4, in their order; `TOTAL` is their sum.
pub const STAGES: [&str; 6] = ["IGB", "GRSM", "IL", "IB", "PRP", "REL"];

/// Times of a machine [ms]: the stages (`None`: N/A), and the printed sum.
pub type Row = ([Option<f64>; 6], f64);

/// A scene of the thesis.
pub struct Scene {
    /// Our scene.
    pub scene: &'static str,
    /// Our stand-in of like size and structure, for where its model is missing.
    pub stand_in: Option<&'static str>,
    /// Its name in the thesis.
    pub name: &'static str,
    /// Number of its figure.
    pub figure: &'static str,
    /// Triangles (7.1).
    pub triangles: u64,
    /// Triangles of all reflective shadow maps (7.1).
    pub rsm_triangles: u64,
    /// Injections of light and blockers (7.1).
    pub injections: u64,
    /// Cells times propagation steps (7.1).
    pub cell_steps: u64,
    /// Times at 512×512 and 1024×1024 of a GeForce GTX 980, and the same of a GeForce 930M (7.3, 7.4).
    pub times: [[Row; 2]; 2],
}

/// Machines of the rows.
pub const MACHINES: [&str; 2] = ["GTX 980", "930M"];

const fn with(igb: f64, grsm: f64, il: f64, ib: f64, prp: f64, rel: f64, total: f64) -> Row {
    ([Some(igb), Some(grsm), Some(il), Some(ib), Some(prp), Some(rel)], total)
}

const fn without(grsm: f64, il: f64, ib: f64, prp: f64, rel: f64, total: f64) -> Row {
    ([None, Some(grsm), Some(il), Some(ib), Some(prp), Some(rel)], total)
}

/// The six scenes.
pub const SCENES: [Scene; 6] = [
    Scene {
        scene: "cornell",
        stand_in: None,
        name: "Cornell",
        figure: "7.2",
        triangles: 84,
        rsm_triangles: 84,
        injections: 32_786,
        cell_steps: 7_167,
        times: [
            [without(0.01, 0.19, 0.10, 0.36, 0.03, 0.71), without(0.01, 0.17, 0.16, 0.36, 0.08, 0.78)],
            [without(0.04, 0.43, 0.30, 0.37, 0.18, 1.32), without(0.05, 0.46, 0.32, 0.38, 0.66, 1.86)],
        ],
    },
    Scene {
        scene: "bleeding_gloss",
        stand_in: None,
        name: "B&G",
        figure: "7.3",
        triangles: 360,
        rsm_triangles: 360,
        injections: 32_786,
        cell_steps: 829_440,
        times: [
            [without(0.01, 0.03, 0.03, 2.16, 0.09, 2.34), without(0.01, 0.03, 0.03, 2.14, 0.32, 2.53)],
            [without(0.04, 0.19, 0.16, 7.21, 0.57, 8.17), without(0.04, 0.19, 0.16, 7.24, 2.16, 9.78)],
        ],
    },
    Scene {
        scene: "conference",
        stand_in: Some("meeting_room"),
        name: "Conference",
        figure: "7.4",
        triangles: 188_780,
        rsm_triangles: 188_780,
        injections: 49_152,
        cell_steps: 86_016,
        times: [
            [with(0.06, 0.14, 0.02, 0.02, 0.42, 0.05, 0.73), with(0.10, 0.14, 0.02, 0.03, 0.42, 0.15, 0.86)],
            [with(0.43, 1.55, 0.16, 0.13, 0.80, 0.29, 3.36), with(0.78, 1.56, 0.16, 0.13, 0.81, 1.04, 4.46)],
        ],
    },
    Scene {
        scene: "dabrovic",
        stand_in: Some("night_court"),
        name: "Dabrovic",
        figure: "7.5",
        triangles: 180_320,
        rsm_triangles: 540_960,
        injections: 294_912,
        cell_steps: 1_179_648,
        times: [
            [without(0.24, 0.48, 0.42, 2.23, 0.05, 3.42), without(0.24, 0.59, 0.46, 2.23, 0.15, 3.68)],
            [without(2.37, 2.21, 1.84, 11.24, 0.35, 18.01), without(2.37, 2.45, 1.98, 11.41, 1.27, 19.47)],
        ],
    },
    Scene {
        scene: "sibenik",
        stand_in: Some("cathedral"),
        name: "Sibenik",
        figure: "7.6",
        triangles: 91_300,
        rsm_triangles: 1_095_600,
        injections: 1_228_800,
        cell_steps: 1_179_648,
        times: [
            [with(0.17, 17.66, 2.22, 2.27, 2.96, 0.06, 25.34), with(0.20, 15.99, 2.78, 2.02, 2.58, 0.14, 23.71)],
            [with(0.91, 11.04, 9.29, 7.52, 12.44, 0.43, 41.63), with(1.74, 11.04, 9.25, 7.49, 12.61, 1.43, 43.55)],
        ],
    },
    Scene {
        scene: "sponza",
        stand_in: Some("courtyard"),
        name: "Sponza",
        figure: "7.7",
        triangles: 296_873,
        rsm_triangles: 2_078_111,
        injections: 1_032_192,
        cell_steps: 1_572_864,
        times: [
            [with(0.16, 1.69, 1.17, 1.23, 3.02, 0.05, 7.32), with(0.22, 1.16, 1.65, 1.21, 3.03, 0.16, 7.44)],
            [with(1.02, 12.68, 6.48, 5.28, 15.42, 0.44, 41.32), with(1.88, 12.75, 8.14, 6.20, 15.63, 1.55, 46.15)],
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_sums_are_those_of_their_rows_to_rounding() {
        for scene in &SCENES {
            for (stages, total) in scene.times.iter().flatten() {
                let sum: f64 = stages.iter().flatten().sum();
                // The thesis averages each stage and the sum for itself.
                assert!((sum - total).abs() < 0.03, "{}: {sum} and {total}", scene.name);
            }
        }
    }
}
