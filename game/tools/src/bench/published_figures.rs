//! Figures that others published, for the report to show beside ours.

/// A scene of the thesis (Petr Šefčík 2016, "Computing global illumination in real-time using Cascaded Light
/// Propagation Volumes"), with its figures as far as they are known to us.
pub struct PublishedScene {
    /// Our scene.
    pub scene: &'static str,
    /// Our stand-in of like size and structure, for where its model is missing.
    pub stand_in: Option<&'static str>,
    /// Its name there.
    pub name: &'static str,
    /// Triangles (table 7.1).
    pub triangles: Option<&'static str>,
    /// Volumes (table 7.1).
    pub volumes: &'static str,
    /// Time of a frame at 512×512 on a GeForce GTX 980 [ms] (table 7.3).
    pub frame_ms: f64,
    /// Elementary injections of light and blockers (table 7.1; Cornell is printed as 32786).
    pub injections: u64,
    /// Cells times propagation steps (table 7.1; Cornell is printed as 7167).
    pub cell_steps: u64,
    /// Merges of blocker volumes (section 7.3.4).
    pub merges: Option<u64>,
}

/// The six scenes of the thesis.
pub const SCENES: &[PublishedScene] = &[
    PublishedScene {
        scene: "cornell",
        stand_in: None,
        name: "Cornell Box",
        triangles: Some("84"),
        volumes: "1 × 8×8×7",
        frame_ms: 0.71,
        injections: 32_768,
        cell_steps: 7_168,
        merges: None,
    },
    PublishedScene {
        scene: "bleeding_gloss",
        stand_in: None,
        name: "Bleeding & Gloss",
        triangles: Some("360"),
        volumes: "1 × 32×15×27",
        frame_ms: 2.34,
        injections: 32_768,
        cell_steps: 829_440,
        merges: None,
    },
    PublishedScene {
        scene: "conference",
        stand_in: Some("meeting_room"),
        name: "Conference",
        triangles: None,
        volumes: "1 × 32×8×21",
        frame_ms: 0.73,
        injections: 49_152,
        cell_steps: 86_016,
        merges: None,
    },
    PublishedScene {
        scene: "dabrovic",
        stand_in: Some("night_court"),
        name: "Dabrovic Sponza",
        triangles: None,
        volumes: "3 × 32×32×32",
        frame_ms: 3.42,
        injections: 294_912,
        cell_steps: 1_179_648,
        merges: Some(6),
    },
    PublishedScene {
        scene: "sibenik",
        stand_in: Some("cathedral"),
        name: "Sibenik",
        triangles: None,
        volumes: "3 × 32×32×32",
        frame_ms: 25.34,
        injections: 1_228_800,
        cell_steps: 1_179_648,
        merges: Some(36),
    },
    PublishedScene {
        scene: "sponza",
        stand_in: Some("courtyard"),
        name: "Crytek Sponza",
        triangles: Some("≈ 297 k"),
        volumes: "3 × 32×32×32",
        frame_ms: 7.32,
        injections: 1_032_192,
        cell_steps: 1_572_864,
        merges: None,
    },
];

/// Time to error of an independent renderer, so that a slow tracer of ours proves nothing.
pub const INDEPENDENT: &str = "For scale: an independent, optimised renderer (Mitsuba 3, two CPU cores) takes 1.75 s \
    for 25 % and 6.9 s for 9.2 % error of one-bounce indirect light in a Cornell box at 512×512.";

/// The figures of one of our scenes; the flag says that ours is a stand-in.
pub fn of(scene: &str) -> Option<(&'static PublishedScene, bool)> {
    SCENES.iter().find_map(|paper| {
        let stand_in = paper.stand_in == Some(scene);
        (paper.scene == scene || stand_in).then_some((paper, stand_in))
    })
}
