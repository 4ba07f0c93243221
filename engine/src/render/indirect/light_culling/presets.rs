//! The settings of stochastic light culling that `bench` compares.

use crate::render::indirect::{Preset, Runs};

const RAYS: (&str, &str) = ("slc.visibility", "ShadowRays");

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        name: "slc coarse",
        sets: &[RAYS, ("slc.delta", "Relative(1e-3)")],
        about: "stochastic light culling, shadow rays, error bound 1e-3 of the mean irradiance",
        runs: Runs::Always,
    },
    Preset {
        name: "slc",
        sets: &[RAYS, ("slc.delta", "Relative(3e-4)")],
        about: "stochastic light culling, shadow rays, error bound 3e-4",
        runs: Runs::Always,
    },
    Preset {
        name: "slc fine",
        sets: &[RAYS, ("slc.delta", "Relative(1e-4)")],
        about: "stochastic light culling, shadow rays, error bound 1e-4",
        runs: Runs::Thorough,
    },
    Preset {
        name: "slc no visibility",
        sets: &[("slc.visibility", "None"), ("slc.delta", "Relative(3e-4)")],
        about: "stochastic light culling as published: light passes through walls",
        runs: Runs::Thorough,
    },
    Preset {
        name: "slc clustered",
        sets: &[("slc.visibility", "None"), ("slc.culling", "Clustered")],
        about: "stochastic light culling, 32 depth slices",
        runs: Runs::Asked,
    },
    Preset {
        name: "slc splatting",
        sets: &[("slc.visibility", "None"), ("slc.culling", "Splatting")],
        about: "stochastic light culling, every light drawn",
        runs: Runs::Asked,
    },
    Preset {
        name: "slc spheres",
        sets: &[("slc.visibility", "None"), ("slc.bounds", "CentredSphere")],
        about: "stochastic light culling, spheres centred on the lights",
        runs: Runs::Asked,
    },
    Preset {
        name: "slc unculled",
        sets: &[("slc.visibility", "None"), ("slc.culling", "None")],
        about: "all virtual lights with the same interleaving",
        runs: Runs::Asked,
    },
];
