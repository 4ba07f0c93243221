//! The settings of light volumes that `bench` compares.

use crate::render::indirect::{Preset, Runs};

const DIFFUSION: (&str, &str) = ("clpv.transport", "Diffusion");
const SWEEP: (&str, &str) = ("clpv.transport", "Sweep");
const AUTO: (&str, &str) = ("clpv.cell_size", "Auto");
const FIXED: (&str, &str) = ("clpv.placement", "Fixed");
const LOW: (&str, &str) = ("clpv.quality", "Low");
const MEDIUM: (&str, &str) = ("clpv.quality", "Medium");
const HIGH: (&str, &str) = ("clpv.quality", "High");
const ULTRA: (&str, &str) = ("clpv.quality", "Ultra");
const NO_RAYS: (&str, &str) = ("clpv.gather_rays", "Count(0)");
const BY_QUALITY: (&str, &str) = ("clpv.gather_rays", "Auto");
const HALF: (&str, &str) = ("clpv.precision", "Half");
const ONE_PATH: (&str, &str) = ("clpv.gather_rays", "Paths(1)");
const FOUR_PATHS: (&str, &str) = ("clpv.gather_rays", "Paths(4)");
const NO_POINTS: (&str, &str) = ("clpv.gather_points", "Count(0)");
const ONE: (&str, &str) = ("clpv.bounces", "Count(1)");

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        name: "clpv",
        sets: &[DIFFUSION],
        about: "the thesis's propagation, in its settings for the scene if it has any",
        runs: Runs::Always,
    },
    Preset {
        name: "sweep low",
        sets: &[SWEEP, FIXED, AUTO, LOW, NO_RAYS],
        about: "sweep transport, low, looked up at the visible surfaces",
        runs: Runs::Always,
    },
    Preset {
        name: "sweep medium",
        sets: &[SWEEP, FIXED, AUTO, MEDIUM, NO_RAYS],
        about: "sweep transport, medium, looked up",
        runs: Runs::Always,
    },
    Preset {
        name: "sweep high",
        sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS],
        about: "sweep transport, high, looked up",
        runs: Runs::Always,
    },
    Preset {
        name: "sweep ultra",
        sets: &[SWEEP, FIXED, AUTO, ULTRA, NO_RAYS],
        about: "sweep transport, ultra, looked up",
        runs: Runs::Thorough,
    },
    Preset {
        name: "sweep high half",
        sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS, HALF],
        about: "sweep transport, high, light on its way in half precision",
        runs: Runs::Asked,
    },
    Preset {
        name: "gather medium",
        sets: &[SWEEP, FIXED, AUTO, MEDIUM, BY_QUALITY],
        about: "medium quality: volumes of low quality, gathered by 4 rays a pixel",
        runs: Runs::Always,
    },
    Preset {
        name: "gather high",
        sets: &[SWEEP, FIXED, AUTO, HIGH, BY_QUALITY],
        about: "high quality: volumes of medium quality, gathered by 8 rays a pixel",
        runs: Runs::Always,
    },
    Preset {
        name: "gather ultra",
        sets: &[SWEEP, FIXED, AUTO, ULTRA, BY_QUALITY],
        about: "ultra quality: volumes of high quality, gathered by 16 rays a pixel",
        runs: Runs::Thorough,
    },
    Preset {
        name: "filtered paths 1 spp",
        sets: &[SWEEP, FIXED, AUTO, ONE_PATH, NO_POINTS],
        about: "path tracing, one path a pixel, behind the gather's filter",
        runs: Runs::Always,
    },
    Preset {
        name: "filtered paths 4 spp",
        sets: &[SWEEP, FIXED, AUTO, FOUR_PATHS, NO_POINTS],
        about: "path tracing, four paths a pixel, behind the gather's filter",
        runs: Runs::Always,
    },
    Preset {
        name: "gather 1 bounce",
        sets: &[SWEEP, FIXED, AUTO, MEDIUM, BY_QUALITY, ONE],
        about: "one bounce, gathered by 4 rays a pixel; nothing is swept",
        runs: Runs::Asked,
    },
    Preset {
        name: "sweep low 1 bounce",
        sets: &[SWEEP, FIXED, AUTO, LOW, NO_RAYS, ONE],
        about: "sweep transport, low, one bounce",
        runs: Runs::Asked,
    },
    Preset {
        name: "sweep high 1 bounce",
        sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS, ONE],
        about: "sweep transport, high, one bounce",
        runs: Runs::Asked,
    },
];
