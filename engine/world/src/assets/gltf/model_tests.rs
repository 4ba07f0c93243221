//! Third-party models, where LIGHTWELL_MODELS says they are.
#![allow(clippy::unwrap_used)]

use super::Gltf;
use crate::core::ViewProjection;
use lightwell_needs::needs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The folder of models.
fn models() -> PathBuf {
    std::env::var_os("LIGHTWELL_MODELS").map(PathBuf::from).expect("LIGHTWELL_MODELS is not set")
}

fn files_below(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files_below(&path, out);
        } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
            out.push(path);
        }
    }
}

fn assert_sound(path: &Path, model: &Gltf) {
    for node in &model.nodes {
        for (mesh, _) in &node.primitives {
            assert!(mesh.indices.len() >= 3 && mesh.indices.len() % 3 == 0, "{}", path.display());
            assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.vertices.len()), "{}", path.display());
            for v in &mesh.vertices {
                let all = [&v.position[..], &v.normal, &v.tangent, &v.uv].concat();
                assert!(all.iter().all(|x| x.is_finite()), "{}: {v:?}", path.display());
            }
        }
    }
}

#[needs("LIGHTWELL_MODELS")]
fn conformance_models_load() {
    let models = models();
    let mut files = Vec::new();
    files_below(&models.join("khronos"), &mut files);
    files_below(&models.join("asset-generator"), &mut files);
    let (mut refused, mut remarks, mut clips) = (Vec::new(), Vec::new(), 0);
    for path in &files {
        match Gltf::load(path) {
            Ok(model) => {
                assert_sound(path, &model);
                clips += model.clips.len();
                let name = path.file_name().unwrap().to_string_lossy();
                remarks.extend(model.warnings.iter().map(|warning| format!("{name}: {warning}")));
            }
            Err(e) => refused.push(e.to_string()),
        }
    }
    eprintln!(
        "{} models, {} good with {clips} clips, {} refused: {refused:#?}, {} warnings: {remarks:#?}",
        files.len(),
        files.len() - refused.len(),
        refused.len(),
        remarks.len()
    );
    assert!(files.len() > 100);
    assert!(refused.len() <= 2, "{refused:#?}");
    // Only those that need an extension or version that is not supported may be refused, and it must be named.
    let told = |e: &String| e.contains("needs the extension") || e.contains("minVersion");
    assert!(refused.iter().all(told), "{refused:#?}");
}

/// Files that break rules of content that nothing reads, or that can be drawn all the same: they load without a word.
const TOLERATED: [&str; 7] = [
    "khronos-validator/accessor_data/invalid_elements_float.gltf",
    "khronos-validator/buffer/invalid_uri_data.gltf",
    "khronos-validator/image/invalid_data_uri.gltf",
    "khronos-validator/image/invalid_image_data.gltf",
    "khronos-validator/image/not_found.gltf",
    "khronos-validator/image/png_eos.gltf",
    "khronos-validator/skin/no_common_root.gltf",
];

/// What makes a whole file unreadable.
const REASONS: [&str; 6] = ["GLB", "JSON", "asset.version", "asset.minVersion", "extensionsRequired", "buffer"];

/// A broken file loads with a warning that names the part, or is refused as a whole.
#[needs("LIGHTWELL_MODELS")]
fn broken_models_cost_their_part() {
    let models = models();
    let root = models.join("bad");
    let expected = std::fs::read_to_string(root.join("khronos-validator/expected.json")).unwrap();
    let expected: gltf::json::Value = gltf::json::deserialize::from_str(&expected).unwrap();
    let mut files = Vec::new();
    files_below(&root, &mut files);
    let (mut refused, mut loaded, mut wrong) = (0, 0, Vec::new());
    for path in &files {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        let start = Instant::now();
        let result = Gltf::load(path);
        assert!(start.elapsed() < Duration::from_secs(5), "{name} takes too long");
        let errors = expected.get(&name).and_then(|e| e.get("errors")).and_then(gltf::json::Value::as_u64);
        let is_broken = errors.is_some_and(|errors| errors > 0);
        match result {
            Ok(model) => {
                assert_sound(path, &model);
                loaded += 1;
                if is_broken && model.warnings.is_empty() && !TOLERATED.contains(&name.as_str()) {
                    wrong.push(format!("{name} loads, but has {errors:?} errors {:?}", expected[&name]["codes"]));
                } else {
                    eprintln!("loads: {name}: {:?}", model.warnings);
                }
            }
            Err(e) => {
                refused += 1;
                let message = e.to_string();
                assert!(message.contains(&*path.file_name().unwrap().to_string_lossy()), "{message}");
                if errors == Some(0) || !REASONS.iter().any(|reason| message.contains(reason)) {
                    wrong.push(format!("{name} is refused: {message}"));
                } else {
                    eprintln!("refused: {message}");
                }
            }
        }
    }
    eprintln!("{} files: {refused} refused, {loaded} loaded", files.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[needs("LIGHTWELL_MODELS")]
fn crytek_sponza_loads() {
    let models = models();
    let model = Gltf::load(models.join("sponza/Sponza.gltf")).unwrap();
    assert_eq!(model.triangle_count(), 262_267, "{:?}", model.warnings);
}

/// The model with one camera of each kind.
#[needs("LIGHTWELL_MODELS")]
fn cameras_are_those_of_the_file() {
    let models = models();
    let model = Gltf::load(models.join("khronos/Cameras/Cameras.gltf")).unwrap();
    let cameras: Vec<_> = model.nodes.iter().filter_map(|node| node.camera.as_ref()).collect();
    let [perspective, parallel] = cameras[..] else { panic!("{} cameras", cameras.len()) };
    assert_eq!(perspective.projection, ViewProjection::Perspective { vertical_fov: 0.7 });
    assert_eq!(parallel.projection, ViewProjection::Orthographic { height: 2.0 });
    assert_eq!((parallel.near, parallel.far, parallel.aspect), (0.01, Some(100.0), Some(1.0)));
    assert_eq!(model.warnings, Vec::<String>::new());
}
