//! Variants that a run compares: methods of indirect light with their settings.

use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use lightwell::render::GiMethod;
use lightwell_runtime::cli::{self, LookArgs, Switch, TraceArgs};
use serde::{Deserialize, Serialize};

/// A method that `--method` knows: one line each.
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// The method of indirect light.
    pub gi: GiMethod,
    /// Its changes of the scene, as `--set` writes them.
    pub sets: &'static [(&'static str, &'static str)],
    /// Its description in the report.
    pub what: &'static str,
    /// When it runs without being asked for.
    pub runs: Runs,
}

/// When a method runs without being asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// In every run.
    Always,
    /// Not in quick runs.
    Thorough,
    /// Only by `--method`.
    Asked,
}

pub(super) const DIFFUSION: (&str, &str) = ("clpv.transport", "Diffusion");
const NO_SKY: (&str, &str) = ("scene.sky_light", "false");
const SWEEP: (&str, &str) = ("clpv.transport", "Sweep");
const AUTO: (&str, &str) = ("clpv.cell_size", "Auto");
const FIXED: (&str, &str) = ("clpv.placement", "Fixed");
const LOW: (&str, &str) = ("clpv.quality", "Low");
const MEDIUM: (&str, &str) = ("clpv.quality", "Medium");
const HIGH: (&str, &str) = ("clpv.quality", "High");
const ULTRA: (&str, &str) = ("clpv.quality", "Ultra");
const RAYS: (&str, &str) = ("slc.visibility", "ShadowRays");
const NO_RAYS: (&str, &str) = ("clpv.gather_rays", "Count(0)");
const BY_QUALITY: (&str, &str) = ("clpv.gather_rays", "Auto");
const HALF: (&str, &str) = ("clpv.precision", "Half");
const ONE_PATH: (&str, &str) = ("clpv.gather_rays", "Paths(1)");
const FOUR_PATHS: (&str, &str) = ("clpv.gather_rays", "Paths(4)");
const NO_POINTS: (&str, &str) = ("clpv.gather_points", "Count(0)");
const ONE: (&str, &str) = ("clpv.bounces", "Count(1)");

/// All methods. Path tracing becomes one variant for each number of samples of `--spp`.
#[rustfmt::skip]
pub const METHODS: &[Method] = &[
    Method { name: "none", gi: GiMethod::NONE, sets: &[NO_SKY], what: "direct light alone", runs: Runs::Always },
    Method { name: "clpv", gi: GiMethod::CLPV, sets: &[DIFFUSION], what: "the thesis's propagation, in its settings for the scene if it has any", runs: Runs::Always },
    Method { name: "sweep low", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, LOW, NO_RAYS], what: "sweep transport, low, looked up at the visible surfaces", runs: Runs::Always },
    Method { name: "sweep medium", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, MEDIUM, NO_RAYS], what: "sweep transport, medium, looked up", runs: Runs::Always },
    Method { name: "sweep high", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS], what: "sweep transport, high, looked up", runs: Runs::Always },
    Method { name: "sweep ultra", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, ULTRA, NO_RAYS], what: "sweep transport, ultra, looked up", runs: Runs::Thorough },
    Method { name: "sweep high half", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS, HALF], what: "sweep transport, high, light on its way in half precision", runs: Runs::Asked },
    Method { name: "gather medium", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, MEDIUM, BY_QUALITY], what: "medium quality: volumes of low quality, gathered by 4 rays a pixel", runs: Runs::Always },
    Method { name: "gather high", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, HIGH, BY_QUALITY], what: "high quality: volumes of medium quality, gathered by 8 rays a pixel", runs: Runs::Always },
    Method { name: "gather ultra", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, ULTRA, BY_QUALITY], what: "ultra quality: volumes of high quality, gathered by 16 rays a pixel", runs: Runs::Thorough },
    Method { name: "filtered paths 1 spp", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, ONE_PATH, NO_POINTS], what: "path tracing, one path a pixel, behind the gather's filter", runs: Runs::Always },
    Method { name: "filtered paths 4 spp", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, FOUR_PATHS, NO_POINTS], what: "path tracing, four paths a pixel, behind the gather's filter", runs: Runs::Always },
    Method { name: "gather 1 bounce", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, MEDIUM, BY_QUALITY, ONE], what: "one bounce, gathered by 4 rays a pixel; nothing is swept", runs: Runs::Asked },
    Method { name: "sweep low 1 bounce", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, LOW, NO_RAYS, ONE], what: "sweep transport, low, one bounce", runs: Runs::Asked },
    Method { name: "sweep high 1 bounce", gi: GiMethod::CLPV, sets: &[SWEEP, FIXED, AUTO, HIGH, NO_RAYS, ONE], what: "sweep transport, high, one bounce", runs: Runs::Asked },
    Method { name: "slc coarse", gi: GiMethod::SLC, sets: &[RAYS, ("slc.delta", "Relative(1e-3)")], what: "stochastic light culling, shadow rays, error bound 1e-3 of the mean irradiance", runs: Runs::Always },
    Method { name: "slc", gi: GiMethod::SLC, sets: &[RAYS, ("slc.delta", "Relative(3e-4)")], what: "stochastic light culling, shadow rays, error bound 3e-4", runs: Runs::Always },
    Method { name: "slc fine", gi: GiMethod::SLC, sets: &[RAYS, ("slc.delta", "Relative(1e-4)")], what: "stochastic light culling, shadow rays, error bound 1e-4", runs: Runs::Thorough },
    Method { name: "slc no visibility", gi: GiMethod::SLC, sets: &[("slc.visibility", "None"), ("slc.delta", "Relative(3e-4)")], what: "stochastic light culling as published: light passes through walls", runs: Runs::Thorough },
    Method { name: "slc clustered", gi: GiMethod::SLC, sets: &[("slc.visibility", "None"), ("slc.culling", "Clustered")], what: "stochastic light culling, 32 depth slices", runs: Runs::Asked },
    Method { name: "slc splatting", gi: GiMethod::SLC, sets: &[("slc.visibility", "None"), ("slc.culling", "Splatting")], what: "stochastic light culling, every light drawn", runs: Runs::Asked },
    Method { name: "slc spheres", gi: GiMethod::SLC, sets: &[("slc.visibility", "None"), ("slc.bounds", "CentredSphere")], what: "stochastic light culling, spheres centred on the lights", runs: Runs::Asked },
    Method { name: "slc unculled", gi: GiMethod::SLC, sets: &[("slc.visibility", "None"), ("slc.culling", "None")], what: "all virtual lights with the same interleaving", runs: Runs::Asked },
    Method { name: "vpl 64", gi: GiMethod::VPL, sets: &[("vpl.particles", "64")], what: "instant radiosity, 64 particles, shadow rays", runs: Runs::Always },
    Method { name: "vpl 256", gi: GiMethod::VPL, sets: &[("vpl.particles", "256")], what: "instant radiosity, 256 particles, shadow rays", runs: Runs::Thorough },
    Method { name: "vpl 1024", gi: GiMethod::VPL, sets: &[("vpl.particles", "1024")], what: "instant radiosity, 1,024 particles, shadow rays", runs: Runs::Thorough },
    Method { name: "vpl 4096", gi: GiMethod::VPL, sets: &[("vpl.particles", "4096")], what: "instant radiosity, 4,096 particles, shadow rays", runs: Runs::Thorough },
    Method { name: "reference", gi: GiMethod::REFERENCE, sets: &[], what: "path tracing on the device", runs: Runs::Always },
];

/// One of the things that a run compares.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its name in tables and plots.
    pub name: String,
    /// Method.
    pub gi: GiMethod,
    /// Path tracing: samples a pixel.
    pub spp: u32,
    /// Path tracing: indirect bounces, none: unlimited.
    pub bounces: Option<u32>,
    /// Where frames follow each other, each is averaged with those before; `None`: it is not.
    pub average: Option<Switch>,
    /// Changes of the scene.
    pub sets: Vec<(String, String)>,
    /// Description.
    pub what: String,
    /// The sweep that it is a point of.
    pub sweep: Option<SweepPoint>,
}

/// A point of a sweep of one setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPoint {
    /// The swept setting: `steps` or `grid`.
    pub axis: String,
    /// Its value: steps, or cells along the longest axis.
    pub value: f64,
}

impl Variant {
    /// A variant of a method of the table.
    pub fn of(method: &Method) -> Self {
        let sets = method.sets.iter().map(|&(path, value)| (path.to_owned(), value.to_owned())).collect();
        Self { what: method.what.to_owned(), ..Self::new(method.name, method.gi, sets) }
    }

    /// A variant by its parts.
    pub fn new(name: &str, gi: GiMethod, sets: Vec<(String, String)>) -> Self {
        Self { name: name.to_owned(), gi, spp: 1, bounces: None, average: None, sets, what: String::new(), sweep: None }
    }

    /// Path tracing with so many samples a pixel.
    pub fn path_tracing(spp: u32) -> Self {
        let what = format!("path tracing, {spp} samples a pixel, unlimited bounces");
        Self { spp, what, ..Self::new(&format!("path tracing {spp} spp"), GiMethod::REFERENCE, Vec::new()) }
    }

    /// Reads `NAME: PATH=VALUE, …`. Beside the paths of `--set` there are `gi`, `spp`, `bounces` and `average`; the method
    /// is `clpv` where none is given.
    ///
    /// # Errors
    /// If there is no name, or an entry is no assignment.
    pub fn parse(text: &str) -> Result<Self> {
        let (name, rest) = text
            .split_once(':')
            .ok_or_else(|| anyhow!("write it as 'NAME: PATH=VALUE, …', for instance 'soft: clpv.gather_filter=16'"))?;
        let name = name.trim();
        if name.is_empty() {
            bail!("a variant needs a name before the `:`");
        }
        let mut variant = Self::new(name, GiMethod::CLPV, Vec::new());
        for entry in split(rest) {
            let (path, value) = cli::parse_assignment(entry).map_err(|error| anyhow!("`{entry}`: {error}"))?;
            match path.as_str() {
                "gi" => variant.gi = cli::parse_method(&value).map_err(anyhow::Error::msg)?,
                "spp" => variant.spp = number(&path, &value)?.max(1),
                "average" => variant.average = Some(switch(&value)?),
                "bounces" => variant.bounces = Some(number(&path, &value)?),
                _ => variant.sets.push((path, value)),
            }
        }
        variant.what = rest.trim().to_owned();
        Ok(variant)
    }

    /// Whether it traces paths rather than draws.
    pub fn is_traced(&self) -> bool {
        self.gi == GiMethod::REFERENCE
    }

    /// The command-line options that ask for the same.
    pub fn look(&self, camera: Option<&str>) -> LookArgs {
        LookArgs {
            gi: Some(self.gi),
            only: cli::Only::Total,
            no_mlaa: true,
            light_over: None,
            average: self.average,
            each_light_alone: false,
            mlaa_edges: cli::Edges::default(),
            virtual_light: None,
            particle_paths: 0,
            debug: cli::DebugArgs::default(),
            trace: TraceArgs { spp: self.spp, bounces: self.bounces, seed: 0 },
            camera: camera.map(str::to_owned),
            sets: self.sets.clone(),
        }
    }

    /// All that makes it what it is, for keys.
    pub fn identity(&self) -> String {
        let average = if self.average == Some(Switch::On) { " averaged" } else { "" };
        format!("{:?} spp={} bounces={:?} {:?}{average}", self.gi, self.spp, self.bounces, self.sets)
    }
}

fn switch(value: &str) -> Result<Switch> {
    Switch::from_str(value, true).map_err(|_| anyhow!("`average={value}`: give `on` or `off`"))
}

fn number(path: &str, value: &str) -> Result<u32> {
    value.parse().map_err(|_| anyhow!("`{path}={value}`: give a whole number"))
}

/// Splits at the commas outside of brackets.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth) = (Vec::new(), 0, 0_i32);
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts.into_iter().map(str::trim).filter(|part| !part.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn variants_are_read() {
        let variant = Variant::parse("fine: clpv.cells=(16, 16, 14), clpv.cell_size=Meters(0.15)").unwrap();
        assert_eq!((variant.name.as_str(), variant.gi), ("fine", GiMethod::CLPV));
        let sets = [("clpv.cells", "(16, 16, 14)"), ("clpv.cell_size", "Meters(0.15)")];
        assert_eq!(variant.sets, sets.map(|(path, value)| (path.to_owned(), value.to_owned())));
        let averaged = Variant::parse("calm: average=on, clpv.quality=High").unwrap();
        assert_eq!((averaged.average, averaged.sets.len()), (Some(Switch::On), 1));
        assert!(averaged.identity() != Variant::parse("calm: clpv.quality=High").unwrap().identity());
        let traced = Variant::parse("one bounce: gi=reference, spp=64, bounces=1").unwrap();
        assert_eq!((traced.gi, traced.spp, traced.bounces, traced.sets.len()), (GiMethod::REFERENCE, 64, Some(1), 0));
    }

    #[test]
    fn what_is_no_variant_is_refused() {
        for (text, what) in [
            ("clpv.steps=32", "NAME"),
            (": clpv.steps=32", "name"),
            ("a: clpv.steps", "clpv.steps"),
            ("a: gi=magic", "magic"),
            ("a: spp=many", "many"),
            ("a: average=much", "much"),
        ] {
            let message = format!("{:#}", Variant::parse(text).unwrap_err());
            assert!(message.contains(what), "{text}: {message}");
        }
    }

    #[test]
    fn names_of_methods_are_unique() {
        let mut names: Vec<&str> = METHODS.iter().map(|method| method.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), METHODS.len());
    }
}
