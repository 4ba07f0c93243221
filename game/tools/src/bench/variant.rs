//! Variants that a run compares: methods of indirect light with their settings.

use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use lightwell::render::{GiMethod, Methods, Preset};
use lightwell_runtime::cli::{self, LookArgs, Switch, TraceArgs};
use serde::{Deserialize, Serialize};

pub(super) const DIFFUSION: (&str, &str) = ("clpv.transport", "Diffusion");

/// A preset that `--method` knows, with its method. Path tracing becomes one variant for each number of samples of `--spp`.
pub type Method = (GiMethod, &'static Preset);

/// The presets of all methods.
pub fn methods() -> Vec<Method> {
    Methods::standard().presets().collect()
}

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
    /// A variant of a preset.
    pub fn of((gi, preset): Method) -> Self {
        let sets = preset.sets.iter().map(|&(path, value)| (path.to_owned(), value.to_owned())).collect();
        Self { what: preset.about.to_owned(), ..Self::new(preset.name, gi, sets) }
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
        let mut names: Vec<&str> = methods().iter().map(|(_, preset)| preset.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), methods().len());
    }
}
