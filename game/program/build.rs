//! Lists the shipped scenes and prefabs for the program.

use std::path::{Path, PathBuf};

fn main() -> std::io::Result<()> {
    let source = Path::new(&std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../..");
    let mut lines = Vec::new();
    for folder in ["scenes", "prefabs"] {
        println!("cargo::rerun-if-changed={}", source.join(folder).display());
        for entry in std::fs::read_dir(source.join(folder))? {
            let path = entry?.path().canonicalize()?;
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            if name.ends_with(".ron") {
                lines.push(format!("    (\"{folder}/{name}\", include_str!({path:?})),\n"));
            }
        }
    }
    lines.sort();
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    std::fs::write(out.join("shipped.rs"), format!("&[\n{}]\n", lines.concat()))
}
