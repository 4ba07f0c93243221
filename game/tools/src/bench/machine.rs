//! Where a run is measured: adapter, driver, program, commit, memory.

use super::results::Header;
use anyhow::{Context, Result};
use lightwell::gpu::Gpu;
use std::path::Path;
use std::process::Command;
use xxhash_rust::xxh3::Xxh3;

/// The header of results that are measured here and now.
///
/// # Errors
/// If the program or its shaders cannot be read.
pub fn header(gpu: &Gpu, settings: String) -> Result<Header> {
    let info = &gpu.info;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    Ok(Header {
        adapter: info.name.clone(),
        device_type: format!("{:?}", info.device_type),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        backend: info.backend.to_string(),
        system: format!("{} {}, {threads} threads", std::env::consts::OS, std::env::consts::ARCH),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: commit(),
        program: program(gpu.shaders.dir())?,
        date: jiff::Timestamp::now().strftime("%Y-%m-%d %H:%M UTC").to_string(),
        settings,
        command: command(std::env::args().skip(1)),
    })
}

/// A command line as one would type it.
fn command(args: impl Iterator<Item = String>) -> String {
    let quoted = |arg: String| match arg.contains([' ', '=', '"', '*']) {
        true => format!("\"{}\"", arg.replace('"', "\\\"")),
        false => arg,
    };
    std::iter::once("lightwell".to_owned()).chain(args.map(quoted)).collect::<Vec<_>>().join(" ")
}

/// A hash of the running program and the shaders beside it: results of one build are not mixed with another's.
fn program(shaders: Option<&Path>) -> Result<String> {
    let mut hash = Xxh3::new();
    let program = std::env::current_exe().context("the program does not find its own file")?;
    hash.update(&std::fs::read(&program).with_context(|| format!("cannot read {}", program.display()))?);
    if let Some(shaders) = shaders {
        hash_folder(shaders, &mut hash).with_context(|| format!("cannot read {}", shaders.display()))?;
    }
    Ok(format!("{:016x}", hash.digest()))
}

fn hash_folder(folder: &Path, hash: &mut Xxh3) -> std::io::Result<()> {
    let mut paths: Vec<_> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    paths.sort();
    for path in paths {
        if path.is_dir() {
            hash_folder(&path, hash)?;
        } else if path.extension().is_some_and(|ending| ending == "wgsl") {
            hash.update(path.file_name().unwrap_or_default().as_encoded_bytes());
            hash.update(&std::fs::read(&path)?);
        }
    }
    Ok(())
}

/// The commit of the source tree that the program was built in, if that is a git checkout.
fn commit() -> Option<String> {
    let git = |args: &[&str]| {
        let output = Command::new("git").current_dir(env!("CARGO_MANIFEST_DIR")).args(args).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    // What is written about the program changes nothing that is measured.
    let measured = ["engine", "game", "shaders", "scenes", "prefabs", "Cargo.lock"].map(|name| format!(":/{name}"));
    let status = ["status", "--porcelain", "--untracked-files=no", "--"];
    let status: Vec<&str> = status.into_iter().chain(measured.iter().map(String::as_str)).collect();
    let changed = git(&status).is_some_and(|files| !files.is_empty());
    Some(if changed { format!("{commit}-dirty") } else { commit })
}

/// Most memory that this process took so far [bytes], where the system tells.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_hash_follows_the_shaders() {
        let dir = tempfile::tempdir().unwrap();
        let shader = dir.path().join("a.wgsl");
        std::fs::write(&shader, "one").unwrap();
        let before = program(Some(dir.path())).unwrap();
        assert_eq!(program(Some(dir.path())).unwrap(), before);
        std::fs::write(&shader, "two").unwrap();
        assert_ne!(program(Some(dir.path())).unwrap(), before);
    }

    #[test]
    fn a_command_line_can_be_typed_again() {
        let args = ["bench", "cornell", "--variant", "window: average=on"].map(str::to_owned);
        assert_eq!(command(args.into_iter()), "lightwell bench cornell --variant \"window: average=on\"");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_told() {
        assert!(peak_bytes().unwrap() > 1 << 20);
    }
}
