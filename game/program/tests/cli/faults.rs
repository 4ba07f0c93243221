//! What the system does to the program: no space, no memory, no right to write, files that go away.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use lightwell::assets::AssetLibrary;
use lightwell::files::{LoadOptions, load_scene, save_scene};
use lightwell::measure::read_image;
use lightwell_runtime::cli::{Common, LookArgs};
use lightwell_runtime::session::Session;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program under limits of the shell.
fn limited(limits: &str, args: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_lightwell");
    // A file that grows beyond its limit is an error then, and no signal.
    let script = format!("trap '' XFSZ; {limits}; exec \"$0\" \"$@\"");
    Command::new("bash").args(["-c", &script, program]).args(args).env_remove("RUST_LOG").output().unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// No more than so many KiB fit into a file: as on a disk that is full.
#[test]
fn a_full_disk_leaves_the_old_picture_and_says_which_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    let render =
        |limits: &str| limited(limits, &["render", "cornell", "-o", text(&path), "--size", "200x200", "--gi", "none"]);
    assert_eq!(render("true").status.code(), Some(0));
    let before = std::fs::read(&path).unwrap();
    assert!(before.len() > 4096, "{} bytes are no test", before.len());
    let full = render("ulimit -f 2");
    assert_eq!(full.status.code(), Some(1), "{}", err(&full));
    assert!(err(&full).contains("a.png"), "{}", err(&full));
    assert!(std::fs::read(&path).unwrap() == before, "the old picture is gone");
    assert_eq!(files(dir.path()), [path]);
}

/// Tells the process that saves which file.
const FILE: &str = "LIGHTWELL_TEST_SAVES_ONCE";

/// The process that has no space: saves a scene over itself.
#[test]
fn saves_once() {
    let Some(path) = std::env::var_os(FILE).map(PathBuf::from) else { return };
    let world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
    let error = save_scene(&world, &path).unwrap_err().to_string();
    assert!(error.contains("a.scene.ron"), "{error}");
}

#[test]
fn a_full_disk_leaves_the_old_scene() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.scene.ron");
    let entities: String = (0..400).map(|i| format!("(name: \"Box {i}\", mesh: Box()),\n")).collect();
    let scene = format!("Scene(entities: [{entities}])");
    std::fs::write(&path, &scene).unwrap();
    let itself = std::env::current_exe().unwrap();
    let script = "trap '' XFSZ; ulimit -f 4; exec \"$0\" --exact saves_once";
    let child = Command::new("bash").args(["-c", script, text(&itself)]).env(FILE, &path).output().unwrap();
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), scene);
    assert!(files(dir.path()).iter().all(|file| file.extension().is_none_or(|ending| ending != "tmp")));
}

/// Whoever is the super-user may write into every folder, but not into that of the processes.
#[test]
fn where_nothing_may_be_written_a_save_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.scene.ron");
    std::fs::write(&path, "Scene(entities: [(name: \"Box\", mesh: Box())])").unwrap();
    let world = load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap();
    for place in ["/proc/self/a.scene.ron", text(&path.join("a.scene.ron"))] {
        let error = save_scene(&world, Path::new(place)).unwrap_err().to_string();
        assert!(error.contains("a.scene.ron"), "{error}");
    }
}

/// A process that may have 3 GiB asks for a frame of 10.
#[test]
fn a_frame_that_finds_no_memory_is_refused_in_words() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    let args = ["render", "cornell", "-o", text(&path), "--size", "16384x16384", "--gi", "none"];
    let refused = limited("ulimit -v 5000000", &args);
    assert_eq!(refused.status.code(), Some(1), "{}", err(&refused));
    let message = err(&refused);
    assert!(message.contains("memory") && !message.contains("panicked"), "{message}");
    assert!(!path.exists());
}

/// A model comes and goes while it is loaded: each time there is a scene, or an error that names the file.
#[test]
fn a_file_that_vanishes_while_it_is_loaded_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, sky) = (dir.path().join("a.scene.ron"), dir.path().join("sky.exr"));
    std::fs::write(
        &scene,
        "Scene(settings: (environment: Image(file: \"sky.exr\")), entities: [(name: \"Camera\", camera: ()), (name: \"Box\", mesh: Box())])",
    )
    .unwrap();
    let image = lightwell::measure::Image::filled(64, 32, [0.5; 3]);
    lightwell::measure::write_image(&sky, &image).unwrap();
    let bytes = std::fs::read(&sky).unwrap();
    let [mut loaded, mut refused] = [0, 0];
    let comes_and_goes = std::sync::atomic::AtomicBool::new(true);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while comes_and_goes.load(std::sync::atomic::Ordering::Relaxed) {
                let _ = std::fs::remove_file(&sky);
                std::thread::yield_now();
                // In pieces: half a file is there for a while.
                let _ = std::fs::write(&sky, &bytes[..bytes.len() / 2]);
                std::thread::yield_now();
                let _ = std::fs::write(&sky, &bytes);
                std::thread::sleep(std::time::Duration::from_micros(300));
            }
        });
        for _ in 0..400 {
            match load_scene(&scene, &mut AssetLibrary::new(), &LoadOptions::default()) {
                Ok(_) => loaded += 1,
                Err(error) => {
                    refused += 1;
                    assert!(error.to_string().contains("sky.exr"), "{error}");
                }
            }
        }
        comes_and_goes.store(false, std::sync::atomic::Ordering::Relaxed);
    });
    assert!(loaded > 0 && refused > 0, "{loaded} loaded, {refused} refused");
}

#[test]
fn a_lost_device_is_an_error() {
    let mut session = Session::headless("cornell", &LookArgs::default(), &Common::default()).unwrap();
    let view = lightwell::scene::SceneView { camera: session.camera().unwrap(), size: [32, 32], jitter: [0.0; 2] };
    let settings = session.render_settings(true);
    session.render(&view, &settings).unwrap();
    session.gpu.device.destroy();
    session.set_seconds(1.0);
    let error = session.render(&view, &settings).err().map(|error| format!("{error:#}")).unwrap_or_default();
    assert!(error.contains("lost"), "{error}");
    assert!(session.display_bytes().is_err());
}

/// Wider than textures of most adapters: it is halved until it fits.
#[test]
fn a_texture_of_16384_texels_is_drawn() {
    let dir = tempfile::tempdir().unwrap();
    let (model, picture) = (dir.path().join("a.gltf"), dir.path().join("a.png"));
    // Columns of red and green, half each.
    let columns = (0..16_384).map(|x| if x < 8_192 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
    let image = lightwell::measure::Image::from_pixels(16_384, 1, columns.collect()).unwrap();
    lightwell::measure::write_image(&dir.path().join("wide.png"), &image).unwrap();
    let corners = [-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];
    let uvs = [0.0_f32, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let mut bytes: Vec<u8> = corners.iter().chain(&uvs).flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    std::fs::write(dir.path().join("a.bin"), &bytes).unwrap();
    std::fs::write(
        &model,
        r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}}],
        "extensionsUsed": ["KHR_materials_unlit"], "textures": [{"source": 0}], "images": [{"uri": "wide.png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 0, "byteOffset": 80, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 92}], "buffers": [{"byteLength": 92, "uri": "a.bin"}]}"#,
    )
    .unwrap();
    let drawn = limited("true", &["render", text(&model), "-o", text(&picture), "--size", "64x64", "--gi", "none"]);
    assert_eq!(drawn.status.code(), Some(0), "{}", err(&drawn));
    let image = read_image(&picture).unwrap();
    let (left, right) = (image.pixel(24, 32), image.pixel(40, 32));
    assert!(left[0] > 2.0 * left[1] && right[1] > 2.0 * right[0], "{left:?} {right:?}");
}
