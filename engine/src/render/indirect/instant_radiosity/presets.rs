//! The settings of instant radiosity that `bench` compares.

use crate::render::indirect::{Preset, Runs};

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        name: "vpl 64",
        sets: &[("vpl.particles", "64")],
        about: "instant radiosity, 64 particles, shadow rays",
        runs: Runs::Always,
    },
    Preset {
        name: "vpl 256",
        sets: &[("vpl.particles", "256")],
        about: "instant radiosity, 256 particles, shadow rays",
        runs: Runs::Thorough,
    },
    Preset {
        name: "vpl 1024",
        sets: &[("vpl.particles", "1024")],
        about: "instant radiosity, 1,024 particles, shadow rays",
        runs: Runs::Thorough,
    },
    Preset {
        name: "vpl 4096",
        sets: &[("vpl.particles", "4096")],
        about: "instant radiosity, 4,096 particles, shadow rays",
        runs: Runs::Thorough,
    },
];
