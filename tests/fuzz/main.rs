//! Mutated input of every kind that a user may hand over: whatever it is, the answer is a result or an error, soon, and
//! never a panic.
//!
//! Each test mutates a few valid inputs, always in the same way, 100,000 times, or as often as 40 seconds allow where that
//! is less. `LIGHTWELL_FUZZ=1000000` tries as many of each, however long it takes, or `LIGHTWELL_FUZZ_SECONDS` at most;
//! `LIGHTWELL_FUZZ_SEED` mutates in another way. What panics, hangs, takes too much memory or reads a file outside the
//! project is written into `out/fuzz/`.

mod mutate;
mod seeds;

use clap::Parser;
use fastrand::Rng;
use lightwell::assets::{AssetLibrary, CubeTable, Gltf, Sampling, SkyMap};
use lightwell::files::{LoadOptions, load_scene};
use lightwell::game::{Actions, Game, InputScript};
use lightwell::gpu::{Gpu, GpuOptions};
use lightwell_program::cli::Cli;
use lightwell_tests::root;
use mutate::{mutated, repair_checksums};
use seeds::{
    ACTIONS, IMPORT, PREFAB, SCENE, SCRIPT, TABLE, glb, gltf_text, pictures_of_all_kinds, skies_of_all_kinds,
    small_models,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Inputs of each kind, where nothing else is asked for.
const EXECUTIONS: u32 = 100_000;
/// Time after which it is enough, where nothing else is asked for: the whole suite shall take minutes.
const BUDGET: Duration = Duration::from_secs(40);
/// No input of this size may take longer, whatever the machine is busy with.
const LONGEST: Duration = Duration::from_secs(10);
/// Memory that the process may have at any time [MiB].
const MEMORY: u64 = 1024;

/// Tries as many mutations of the inputs as are asked for, or as there is time for.
fn fuzz(name: &str, seeds: &[Vec<u8>], mut attempt: impl FnMut(&[u8])) {
    let asked = number("LIGHTWELL_FUZZ");
    let (wanted, budget) = asked.map_or((u64::from(EXECUTIONS), BUDGET), |count| (count, Duration::MAX));
    let budget = number("LIGHTWELL_FUZZ_SECONDS").map_or(budget, Duration::from_secs);
    let seed = number("LIGHTWELL_FUZZ_SEED").unwrap_or(7);
    let mut random = Rng::with_seed(seed);
    let watchdog = Watchdog::new(name);
    let start = Instant::now();
    let mut slowest = Duration::ZERO;
    let mut count = 0;
    while count < wanted && start.elapsed() < budget {
        count += 1;
        let input = mutated(&mut random, seeds);
        watchdog.begin(&input);
        let begin = Instant::now();
        if catch_unwind(AssertUnwindSafe(|| attempt(&input))).is_err() {
            panic!("{name}: panics, see {}", keep(name, &input).display());
        }
        slowest = slowest.max(begin.elapsed());
        let memory = peak_memory();
        assert!(
            memory.is_none_or(|mib| mib < MEMORY),
            "{name}: takes {memory:?} MiB, see {}",
            keep(name, &input).display()
        );
    }
    let seconds = start.elapsed().as_secs_f64();
    let memory = peak_memory().map_or(String::new(), |mib| format!(", at most {mib} MiB in the process"));
    let rate = f64::from(u32::try_from(count).unwrap_or(u32::MAX)) / seconds;
    println!(
        "{name}: seed {seed}, {count} inputs in {seconds:.1} s, {rate:.0} a second, the slowest {slowest:?}{memory}"
    );
}

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok().and_then(|number| number.parse().ok())
}

/// The input under way, and since when.
type Present = Option<(Instant, Vec<u8>)>;

/// Ends the process when an input hangs, and keeps the input.
struct Watchdog {
    present: Arc<Mutex<Present>>,
}

impl Watchdog {
    fn new(name: &str) -> Self {
        let (present, name) = (Arc::new(Mutex::new(None)), name.to_owned());
        let watched: Weak<Mutex<Present>> = Arc::downgrade(&present);
        std::thread::spawn(move || {
            while let Some(present) = watched.upgrade() {
                let hangs = |(begin, _): &(Instant, Vec<u8>)| begin.elapsed() > LONGEST;
                let hanging = present.lock().unwrap_or_else(PoisonError::into_inner).take_if(|input| hangs(input));
                if let Some((_, input)) = hanging {
                    eprintln!("{name}: takes more than {LONGEST:?}, see {}", keep(&name, &input).display());
                    std::process::exit(1);
                }
                drop(present);
                std::thread::sleep(Duration::from_millis(200));
            }
        });
        Self { present }
    }

    fn begin(&self, input: &[u8]) {
        *self.present.lock().unwrap_or_else(PoisonError::into_inner) = Some((Instant::now(), input.to_vec()));
    }
}

fn keep(name: &str, input: &[u8]) -> PathBuf {
    let folder = root().join("out/fuzz");
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, input).expect("written");
    path
}

/// Largest memory that the process had so far, where the system tells [MiB].
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? / 1024)
}

/// Writes inputs into a file, and loads the scene beside it.
struct Loader {
    folder: tempfile::TempDir,
    file: &'static str,
    /// Knows the model from the input before.
    library: AssetLibrary,
    loaded: u32,
}

impl Loader {
    fn new(folder: tempfile::TempDir, file: &'static str) -> Self {
        Self { folder, file, library: AssetLibrary::new(), loaded: 0 }
    }

    fn load(&mut self, input: &[u8]) {
        self.loaded += 1;
        if self.loaded.is_multiple_of(500) {
            self.library = AssetLibrary::new();
        }
        std::fs::write(self.folder.path().join(self.file), input).expect("written");
        let _ = load_scene(&self.folder.path().join("a.scene.ron"), &mut self.library, &LoadOptions::default());
        stays_within(self.folder.path(), &self.library);
    }
}

/// What is read or looked for must lie in the folder.
fn stays_within(folder: &Path, library: &AssetLibrary) {
    let folder = folder.canonicalize().expect("a folder");
    let resolved = |path: &Path| {
        let mut resolved = PathBuf::new();
        for part in path.components() {
            match part {
                Component::ParentDir => drop(resolved.pop()),
                part => resolved.push(part),
            }
        }
        resolved
    };
    for path in library.watched() {
        assert!(resolved(&path).starts_with(&folder), "{} is not in the project", path.display());
    }
}

#[test]
fn the_seeds_are_valid() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.prefab.ron"), PREFAB).expect("written");
    std::fs::write(folder.path().join("a.gltf"), gltf_text()).expect("written");
    std::fs::write(folder.path().join("a.scene.ron"), SCENE).expect("written");
    let path = folder.path().join("a.scene.ron");
    load_scene(&path, &mut AssetLibrary::new(), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    Gltf::from_bytes(Path::new("a.glb"), &glb()).unwrap_or_else(|e| panic!("{e}"));
    Actions::parse(Path::new("a.actions.ron"), ACTIONS).unwrap_or_else(|e| panic!("{e}"));
    InputScript::parse(Path::new("a.script.ron"), SCRIPT).unwrap_or_else(|e| panic!("{e}"));
    CubeTable::parse(TABLE).unwrap_or_else(|(line, e)| panic!("line {line}: {e}"));
    for bytes in pictures_of_all_kinds() {
        let path = folder.path().join("picture");
        std::fs::write(&path, bytes).expect("written");
        AssetLibrary::new().texture(&path, true, Sampling::default()).unwrap_or_else(|e| panic!("{e}"));
    }
    for bytes in skies_of_all_kinds() {
        let path = folder.path().join("sky");
        std::fs::write(&path, bytes).expect("written");
        SkyMap::load(&path, 1.0, 0.0).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn scenes() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.prefab.ron"), PREFAB).expect("written");
    std::fs::write(folder.path().join("a.gltf"), gltf_text()).expect("written");
    let mut loader = Loader::new(folder, "a.scene.ron");
    fuzz("scene.ron", &[SCENE.into()], |input| loader.load(input));
}

#[test]
fn prefabs() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = r#"Scene(entities: [(name: "A", prefab: "a.prefab.ron")])"#;
    std::fs::write(folder.path().join("a.scene.ron"), scene).expect("written");
    let mut loader = Loader::new(folder, "a.prefab.ron");
    fuzz("prefab.ron", &[PREFAB.into()], |input| loader.load(input));
}

#[test]
fn models() {
    let mut seeds = vec![glb()];
    seeds.extend(small_models("glb"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    fuzz("model.glb", &seeds, |input| drop(Gltf::from_bytes(&path, input)));
}

#[test]
fn model_texts() {
    let mut seeds = vec![gltf_text().into_bytes()];
    seeds.extend(small_models("gltf"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gltf");
    fuzz("model.gltf", &seeds, |input| drop(Gltf::from_bytes(&path, input)));
}

#[test]
fn import_files() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.glb"), glb()).expect("written");
    let scene = r#"Scene(entities: [(name: "A", model: "a.glb")])"#;
    std::fs::write(folder.path().join("a.scene.ron"), scene).expect("written");
    let mut loader = Loader::new(folder, "a.import.ron");
    fuzz("a.import.ron", &[IMPORT.into()], |input| loader.load(input));
}

#[test]
fn actions() {
    let path = Path::new("a.actions.ron");
    fuzz("actions.ron", &[ACTIONS.into()], |input| drop(Actions::parse(path, &String::from_utf8_lossy(input))));
}

#[test]
fn scripts() {
    let path = Path::new("a.script.ron");
    fuzz("script.ron", &[SCRIPT.into()], |input| {
        if let Ok(script) = InputScript::parse(path, &String::from_utf8_lossy(input)) {
            assert!(script.steps <= InputScript::MOST_STEPS);
        }
    });
}

#[test]
fn saved_games() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.prefab.ron"), PREFAB).expect("written");
    std::fs::write(folder.path().join("a.gltf"), gltf_text()).expect("written");
    let (scene, file) = (folder.path().join("a.scene.ron"), folder.path().join("slot.save.ron"));
    std::fs::write(&scene, SCENE).expect("written");
    let begin = || {
        let mut game = Game::new();
        game.enter(&scene).unwrap_or_else(|e| panic!("{e}"));
        game
    };
    let mut game = begin();
    game.save(&file).unwrap_or_else(|e| panic!("{e}"));
    let seed = std::fs::read(&file).expect("read");
    let mut count = 0;
    fuzz("slot.save.ron", &[seed], |input| {
        count += 1;
        if count % 500 == 0 {
            game = begin();
        }
        std::fs::write(&file, input).expect("written");
        if game.load(&file).is_ok() {
            let _ = game.step(&[]);
        }
    });
}

#[test]
fn pictures() {
    let (_, others): (Vec<_>, Vec<_>) = pictures_of_all_kinds().into_iter().partition(|picture| is_ktx2(picture));
    fuzz_pictures("picture.png", &others);
}

#[test]
fn ktx2_pictures() {
    let (pictures, _): (Vec<_>, Vec<_>) = pictures_of_all_kinds().into_iter().partition(|picture| is_ktx2(picture));
    fuzz_pictures("picture.ktx2", &pictures);
}

fn is_ktx2(picture: &[u8]) -> bool {
    picture.starts_with(b"\xabKTX 20")
}

fn fuzz_pictures(name: &str, seeds: &[Vec<u8>]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    let mut turn = 0;
    fuzz(name, seeds, |input| {
        let mut input = input.to_vec();
        turn += 1;
        if turn % 4 != 0 && input.starts_with(b"\x89PNG") {
            repair_checksums(&mut input);
        }
        std::fs::write(&path, input).expect("written");
        let _ = AssetLibrary::new().texture(&path, true, Sampling::default());
    });
}

#[test]
fn radiance_skies() {
    fuzz_skies("sky.hdr", &skies_of_all_kinds()[..1]);
}

#[test]
fn exr_skies() {
    fuzz_skies("sky.exr", &skies_of_all_kinds()[1..]);
}

fn fuzz_skies(name: &str, seeds: &[Vec<u8>]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fuzz(name, seeds, |input| {
        std::fs::write(&path, input).expect("written");
        let _ = SkyMap::load(&path, 1.0, 0.0);
        let _ = lightwell::measure::read_image(&path);
    });
}

#[test]
fn colour_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.cube");
    fuzz("table.cube", &[TABLE.as_bytes().to_vec()], |input| {
        std::fs::write(&path, input).expect("written");
        let _ = CubeTable::load(&path);
    });
}

#[test]
fn shaders() {
    const LIBRARY: &str = "#define_import_path lightwell::part\n\nstruct Part { a: vec3f, b: u32 }\n\nfn twice(x: f32) -> f32 {\n    return 2.0 * x;\n}\n";
    const SHADER: &str = "#import lightwell::part::{Part, twice}\n\n@group(0) @binding(0) var<uniform> part: Part;\n\
        @group(0) @binding(1) var<storage, read_write> values: array<f32>;\n#ifdef SIZE\nconst SIZE: u32 = #{SIZE}u;\n#else\n\
        const SIZE: u32 = 4u;\n#endif\n\n@compute @workgroup_size(64)\nfn main(@builtin(global_invocation_id) id: vec3u) {\n    \
        for (var i = 0u; i < SIZE; i++) {\n        values[id.x] += twice(part.a[i % 3u]) * f32(part.b);\n    }\n}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).expect("written");
    write("part.wgsl", LIBRARY.as_bytes());
    write("a.wgsl", SHADER.as_bytes());
    let options = GpuOptions { adapter: None, shader_dir: folder.path().to_owned() };
    let gpu = Gpu::headless(&options).expect("a device");
    gpu.shaders.entry_points("a.wgsl").unwrap_or_else(|e| panic!("{e}"));
    // The shader, and what it imports. The library composes anew what depends on the one that changed.
    let add = |name: &str, text: &[u8]| gpu.shaders.add(name, &String::from_utf8_lossy(text));
    for (name, text) in [("a.wgsl", SHADER), ("part.wgsl", LIBRARY)] {
        fuzz(name, &[text.into()], |input| {
            add(name, input);
            let _ = gpu.shaders.entry_points("a.wgsl");
        });
        add(name, text.as_bytes());
    }
}

#[test]
fn command_lines() {
    let lines = [
        "lightwell render cornell -o a.png --size 64x64 --frames 0..3 --set clpv.steps=3 --only direct --gi reference --spp 4",
        "lightwell bench cornell -o out --quick --variant a: clpv.steps=3, spp=4 --sweep steps",
        "lightwell compare a.exr b.exr --max nrmse=0.1,bias=0.02 --metric nrmse --halves c.exr d.exr",
        "lightwell test --filter a --jobs 3 -o out --bless -v",
        "lightwell stress --full --method sweep,vpl -o out",
    ];
    let seeds: Vec<Vec<u8>> = lines.iter().map(|line| line.as_bytes().to_vec()).collect();
    fuzz("command line", &seeds, |input| {
        let text = String::from_utf8_lossy(input);
        let _ = Cli::try_parse_from(text.split(' '));
    });
}
