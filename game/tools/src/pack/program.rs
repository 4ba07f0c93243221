//! The program of a game, which cargo builds.

use crate::cli::PackArgs;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The profile that programs are packed with where the game's workspace has none of that name: small, and without debug
/// information. As in the Cargo.toml of Lightwell.
const PROFILE: [&str; 14] = [
    "profile.dist.inherits=\"release\"",
    "profile.dist.opt-level=2",
    "profile.dist.debug=false",
    "profile.dist.strip=true",
    "profile.dist.lto=\"fat\"",
    "profile.dist.codegen-units=1",
    "profile.dist.incremental=false",
    "profile.dist.package.\"*\".opt-level=\"s\"",
    "profile.dist.package.bevy_ecs.opt-level=2",
    "profile.dist.package.glam.opt-level=2",
    "profile.dist.package.hashbrown.opt-level=2",
    "profile.dist.package.lightwell.opt-level=2",
    "profile.dist.package.wgpu-core.opt-level=2",
    "profile.dist.package.wgpu-hal.opt-level=2",
];

/// A program that was built.
pub struct Program {
    pub name: String,
    pub file: PathBuf,
    /// Where its paths start; none: in the current folder.
    pub folder: Option<PathBuf>,
}

impl Program {
    /// Builds the program, unless it is given.
    ///
    /// # Errors
    /// If there is no such program, or cargo cannot build it.
    pub fn find(args: &PackArgs, name: String) -> Result<Self> {
        let manifest = args.manifest_path.as_deref().map(super::absolute).transpose()?;
        let folder = manifest.as_deref().and_then(Path::parent).map(Path::to_owned);
        let file = match &args.program {
            Some(file) => super::absolute(file)?,
            None => build(args, &name)?,
        };
        Ok(Self { name, file, folder })
    }
}

/// Cargo with a command, without anything about the game.
pub fn bare_cargo(command: &str) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.arg(command);
    cargo
}

/// Cargo with a command, for the game's Cargo.toml.
pub fn cargo(args: &PackArgs, command: &str) -> Command {
    let mut cargo = bare_cargo(command);
    if let Some(path) = &args.manifest_path {
        cargo.arg("--manifest-path").arg(path);
    }
    cargo
}

/// What cargo says, as text.
///
/// # Errors
/// If there is no cargo, or it fails.
pub fn output(command: &mut Command) -> Result<String> {
    let output = command.output().context("cannot start cargo, which packs are built with: https://rustup.rs")?;
    if !output.status.success() {
        bail!("cargo: {}", String::from_utf8_lossy(&output.stderr).trim_end().trim_start_matches("error: "));
    }
    String::from_utf8(output.stdout).context("cargo's words are not Unicode")
}

/// The packages of the game's workspace.
///
/// # Errors
/// If there is no Cargo.toml, or it is faulty.
pub fn workspace(args: &PackArgs) -> Result<Value> {
    let text = output(cargo(args, "metadata").args(["--format-version", "1", "--no-deps"]))?;
    serde_json::from_str(&text).context("cargo metadata cannot be read")
}

/// The name of the program: what was asked for, or the only one that there is.
///
/// # Errors
/// If there is none, or several.
pub fn name(args: &PackArgs) -> Result<String> {
    let given = args.example.as_ref().or(args.bin.as_ref()).cloned();
    let stem = || Some(args.program.as_ref()?.file_stem()?.to_string_lossy().into_owned());
    if let Some(name) = given.or_else(stem) {
        return Ok(name);
    }
    let workspace = workspace(args)?;
    let package = package(args, &workspace)?;
    if let Some(name) = package["default_run"].as_str() {
        return Ok(name.to_owned());
    }
    let is_program = |target: &&Value| target["kind"].as_array().is_some_and(|kinds| kinds.contains(&"bin".into()));
    let targets = package["targets"].as_array().into_iter().flatten().filter(is_program);
    let names: Vec<&str> = targets.filter_map(|target| target["name"].as_str()).collect();
    match names[..] {
        [name] => Ok(name.to_owned()),
        [] => bail!("the package {} has no program; name an example with --example NAME", package["name"]),
        _ => {
            bail!("the package {} has several programs; pass --bin with one of: {}", package["name"], names.join(", "))
        }
    }
}

/// The package that is asked for, or the one in the folder of the Cargo.toml.
fn package<'a>(args: &PackArgs, workspace: &'a Value) -> Result<&'a Value> {
    let packages = workspace["packages"].as_array().map(Vec::as_slice).unwrap_or_default();
    if let Some(name) = &args.package {
        let found = packages.iter().find(|package| package["name"] == name.as_str());
        return found.with_context(|| format!("there is no package `{name}` in the workspace"));
    }
    let folder = match args.manifest_path.as_deref().and_then(Path::parent) {
        Some(folder) => folder.canonicalize()?,
        None => std::env::current_dir()?.canonicalize()?,
    };
    let manifest = |package: &Value| Path::new(package["manifest_path"].as_str()?).parent()?.canonicalize().ok();
    let around = packages.iter().filter(|package| manifest(package).is_some_and(|own| folder.starts_with(own)));
    around
        .max_by_key(|package| manifest(package).map_or(0, |own| own.components().count()))
        .or(if let [only] = packages { Some(only) } else { None })
        .context("this is a workspace of several packages: pass -p with the game's, or --example")
}

fn build(args: &PackArgs, name: &str) -> Result<PathBuf> {
    let workspace = workspace(args)?;
    let root = Path::new(workspace["workspace_root"].as_str().unwrap_or_default()).join("Cargo.toml");
    let mut cargo = cargo(args, "build");
    cargo.args(["--profile", "dist", "--message-format", "json-render-diagnostics"]);
    let has_profile = std::fs::read_to_string(root).is_ok_and(|text| text.contains("[profile.dist]"));
    if !has_profile {
        cargo.args(PROFILE.iter().flat_map(|line| ["--config", line]));
    }
    if let Some(package) = &args.package {
        cargo.args(["--package", package]);
    }
    cargo.args([if args.example.is_some() { "--example" } else { "--bin" }, name]);
    if let Some(features) = &args.features {
        cargo.args(["--features", features]);
    }
    lightwell_runtime::say!("building {name} with the profile `dist` ...");
    let output = cargo.stderr(Stdio::inherit()).output().context("cannot start cargo: https://rustup.rs")?;
    if !output.status.success() {
        bail!("cargo cannot build {name}; its errors stand above");
    }
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let messages = lines.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let programs = messages.filter(|message| message["target"]["name"] == name);
    let path = programs.filter_map(|message| Some(PathBuf::from(message["executable"].as_str()?))).next_back();
    path.with_context(|| format!("cargo built no program `{name}`"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn games_elsewhere_have_the_profile_of_this_workspace() {
        let manifest = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.toml")).unwrap();
        let own = manifest.split("[profile.dist]").nth(1).unwrap();
        for line in PROFILE {
            let (key, value) = line.strip_prefix("profile.dist.").unwrap().split_once('=').unwrap();
            let written = match key.strip_prefix("package.") {
                // A member of this workspace.
                Some("lightwell.opt-level") => continue,
                Some(package) => format!("{} = {{ opt-level = {value} }}", package.strip_suffix(".opt-level").unwrap()),
                None => format!("{key} = {value}"),
            };
            assert!(own.contains(&written), "no line `{written}` in Cargo.toml");
        }
    }
}
