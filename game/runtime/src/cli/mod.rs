//! The parts of a command line that every program has: where scenes come from, and how they are looked at.

mod look;
mod method;
mod parse;

pub use look::{DebugArgs, Edges, LookArgs, Only, Switch, TraceArgs};
pub use method::{built_in_methods, method_parser, parse_method};
pub use parse::{parse_assignment, parse_frame_rate, parse_scale, parse_size, parse_update};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use lightwell::assets::{LightUnits, LoadBudget};
use lightwell::files::{ComponentTypes, LoadOptions};
use lightwell::packed;
use std::ffi::OsString;
use std::path::PathBuf;

/// Options of every command.
#[derive(Args, Clone, Debug, Default)]
pub struct Common {
    /// Folder of third-party models that some scenes use
    #[arg(long, global = true, value_name = "DIR", env = "LIGHTWELL_MODELS")]
    pub models: Option<PathBuf>,
    /// Folder that scenes may name files in, beside their own project and the models; may be given several times, and
    /// as a list of paths in LIGHTWELL_TRUST
    #[arg(long, global = true, value_name = "DIR")]
    pub trust: Vec<PathBuf>,
    /// Limit of what loading a scene may take: bytes, texels, triangles, entities or seconds, such as texels=4e9
    #[arg(long, global = true, value_name = "NAME=N", value_parser = limit)]
    pub budget: Vec<String>,
    /// Units of the lights of models: those of the program that wrote the file, candela and lux, or W/sr and W/m². Import
    /// settings that name other units stand
    #[arg(long, global = true, value_name = "UNITS", default_value = "auto", value_parser = light_units())]
    pub light_units: LightUnits,
    /// Refuse models of which something is broken, in place of a warning
    #[arg(long, global = true)]
    pub strict: bool,
    /// Part of the name of the graphics adapter to use (`lightwell info` lists them)
    #[arg(long, global = true, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Say more: -v what is done, -vv details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

fn limit(written: &str) -> Result<String, String> {
    LoadBudget::default().set(written).map(|()| written.to_owned())
}

fn light_units() -> impl TypedValueParser<Value = LightUnits> {
    PossibleValuesParser::new(LightUnits::NAMES).map(|name| name.parse().unwrap_or_default())
}

impl Common {
    /// How scenes are loaded, with the components of a game that they may hold.
    pub fn load_options(&self, types: ComponentTypes) -> LoadOptions {
        let listed = std::env::var_os("LIGHTWELL_TRUST");
        let listed = listed.iter().flat_map(std::env::split_paths).filter(|folder| !folder.as_os_str().is_empty());
        let mut budget = LoadBudget::default();
        for written in &self.budget {
            // They were checked when the command line was read.
            let _ = budget.set(written);
        }
        // All that lies in a packed game is its own.
        let assets = packed::game().map(packed::Packed::assets);
        let packed = assets.as_ref().map(|assets| assets.join(packed::MODELS)).filter(|folder| folder.is_dir());
        let trusted = self.trust.iter().cloned().chain(listed).chain(assets).collect();
        let models = self.models.clone().or(packed);
        LoadOptions { models, trusted, budget, light_units: self.light_units, strict: self.strict, types }
    }

    /// The arguments that say the same to another process of this program.
    pub fn arguments(&self) -> Vec<OsString> {
        let mut arguments = Vec::new();
        if let Some(models) = &self.models {
            arguments.extend(["--models".into(), models.into()]);
        }
        arguments.extend(self.trust.iter().flat_map(|folder| ["--trust".into(), folder.into()]));
        arguments.extend(self.budget.iter().flat_map(|limit| ["--budget".into(), limit.into()]));
        let units = [LightUnits::Photometric, LightUnits::Radiometric].into_iter().zip(&LightUnits::NAMES[1..]);
        let chosen = units.filter(|(units, _)| *units == self.light_units);
        arguments.extend(chosen.flat_map(|(_, name)| ["--light-units".into(), name.into()]));
        if self.strict {
            arguments.push("--strict".into());
        }
        if let Some(adapter) = &self.adapter {
            arguments.extend(["--adapter".into(), adapter.into()]);
        }
        arguments.extend((0..self.verbose).map(|_| "-v".into()));
        arguments
    }
}
