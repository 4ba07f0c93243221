//! WGSL files with imports (`#import lightwell::brdf::eval_brdf_cosine`), kept current with the disk.

use super::compose::{self, CompiledShader, Sources};
use super::reflect::{self, EntryPoint, StructLayout};
use super::shader_defs::Defs;
use super::shader_error::ShaderError;
use super::watch::{self, Watcher};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The result of [`ShaderLibrary::poll`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShaderEvent {
    /// The shader was recompiled and is in use.
    Reloaded(String),
    /// The shader is broken; its last good version stays in use.
    Broken(ShaderError),
}

/// All WGSL files of a folder, or those built into the program.
pub struct ShaderLibrary {
    dir: Option<PathBuf>,
    watcher: Mutex<Option<Watcher>>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    sources: Sources,
    variants: HashMap<(String, Defs), Variant>,
    /// Errors of the device on valid shaders, by pipeline.
    pipeline_errors: BTreeMap<(String, String), ShaderError>,
    revision: u64,
}

/// A file compiled with a set of defines.
#[derive(Default)]
struct Variant {
    last_good: Option<Arc<CompiledShader>>,
    /// Why the text on disk does not compile.
    error: Option<ShaderError>,
}

impl ShaderLibrary {
    /// Reads all `.wgsl` files below the folder and watches it. Without a watcher everything works but reload.
    pub(super) fn open(dir: &Path) -> std::io::Result<Self> {
        // Watched before it is read, so that no change falls in between.
        let watcher = Watcher::new(dir)
            .inspect_err(|error| log::warn!("shaders in {} are not watched for changes: {error}", dir.display()))
            .ok();
        let sources = watch::read_shaders(dir)?;
        Ok(Self::of(Some(dir.to_owned()), watcher, sources))
    }

    /// The WGSL that is built into the program.
    pub(super) fn built_in() -> Self {
        Self::of(None, None, built_in())
    }

    fn of(dir: Option<PathBuf>, watcher: Option<Watcher>, sources: Sources) -> Self {
        let state = State { sources, revision: 1, ..Default::default() };
        Self { dir, watcher: Mutex::new(watcher), state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The folder; none for the shaders built into the program.
    pub fn dir(&self) -> Option<&Path> {
        self.dir.as_deref()
    }

    /// Counts up with every shader that was reloaded well: part of every cache key.
    pub fn revision(&self) -> u64 {
        self.state().revision
    }

    /// Shaders that do not compile at present, and pipelines that the device refuses. Each stays in the list until
    /// it is mended.
    pub fn errors(&self) -> Vec<ShaderError> {
        let state = self.state();
        let refused = state.pipeline_errors.values();
        let mut errors: Vec<_> =
            state.variants.values().filter_map(|v| v.error.as_ref()).chain(refused).cloned().collect();
        errors.sort_by(|a, b| (&a.file, a.line, &a.text).cmp(&(&b.file, b.line, &b.text)));
        errors.dedup();
        errors
    }

    /// All files that have an entry point, relative to the folder.
    pub fn shader_files(&self) -> Vec<String> {
        let state = self.state();
        let is_entry = |source: &str| ["@compute", "@vertex", "@fragment"].iter().any(|s| source.contains(s));
        state.sources.iter().filter(|(_, source)| is_entry(source)).map(|(path, _)| path.clone()).collect()
    }

    /// Entry points of a shader with the bindings that each uses.
    ///
    /// # Errors
    /// If it does not compile.
    pub fn entry_points(&self, path: &str) -> Result<Vec<EntryPoint>, ShaderError> {
        let compiled = self.compile(path, &Vec::new())?;
        reflect::entry_points(&compiled).map_err(|what| ShaderError::of_file(path, what))
    }

    /// Size and members of a struct that the shader declares or imports.
    ///
    /// # Errors
    /// If the shader does not compile or has no such struct.
    pub fn struct_layout(&self, path: &str, name: &str) -> Result<StructLayout, ShaderError> {
        let compiled = self.compile(path, &Vec::new())?;
        reflect::struct_layout(&compiled.module, name)
            .ok_or_else(|| ShaderError::of_file(path, format_args!("there is no struct `{name}`")))
    }

    /// Size of a struct that the shader declares or imports \[bytes\].
    ///
    /// # Errors
    /// Those of [`ShaderLibrary::struct_layout`].
    pub fn struct_size(&self, path: &str, name: &str) -> Result<u32, ShaderError> {
        Ok(self.struct_layout(path, name)?.size)
    }

    /// The shader put together from its imports and validated; its last good version while the file is broken. The
    /// same `Arc` comes back until a newer version is good.
    pub(super) fn compile(&self, path: &str, defs: &Defs) -> Result<Arc<CompiledShader>, ShaderError> {
        let mut state = self.state();
        let State { sources, variants, .. } = &mut *state;
        let variant = variants.entry((path.to_string(), defs.clone())).or_insert_with(|| {
            let mut variant = Variant::default();
            variant.take(compose::compile(sources, path, defs));
            variant
        });
        match (&variant.last_good, &variant.error) {
            (Some(compiled), _) => Ok(Arc::clone(compiled)),
            (None, Some(error)) => Err(error.clone()),
            (None, None) => Err(ShaderError::of_file(path, "it was never compiled")),
        }
    }

    /// Remembers, or forgets, that the device refused a pipeline of the shader.
    pub(super) fn set_pipeline_error(&self, path: &str, pipeline: &str, error: Option<&ShaderError>) {
        let key = (path.to_string(), pipeline.to_string());
        let mut state = self.state();
        match error {
            Some(error) => state.pipeline_errors.insert(key, error.clone()),
            None => state.pipeline_errors.remove(&key),
        };
    }

    /// Takes up what changed on disk since the last call; call it once a frame.
    ///
    /// Empty files are passed over, because editors truncate before they write. A file that is gone keeps its last
    /// text, because editors also save by removing and renaming.
    pub fn poll(&self) -> Vec<ShaderEvent> {
        let mut watcher = self.watcher.lock().unwrap_or_else(PoisonError::into_inner);
        if !watcher.as_mut().is_some_and(Watcher::changed) {
            return Vec::new();
        }
        self.read().map_or_else(Vec::new, |found| self.state().take_sources(found))
    }

    /// Present text of the files; `None` if they cannot be read.
    fn read(&self) -> Option<Sources> {
        let Some(dir) = &self.dir else { return Some(built_in()) };
        let failed = |error: &std::io::Error| log::warn!("cannot read shader folder {}: {error}", dir.display());
        watch::read_shaders(dir).inspect_err(failed).ok()
    }
}

impl ShaderLibrary {
    /// Adds a shader that lies in no file of the folder, or puts it in place of the one of that name.
    pub fn add(&self, path: &str, source: &str) -> Vec<ShaderEvent> {
        self.state().take_sources(BTreeMap::from([(path.to_owned(), source.to_owned())]))
    }

    /// Rereads and recompiles all shaders, changed or not; all that depends on them is rebuilt.
    pub fn reload_all(&self) -> Vec<ShaderEvent> {
        let Some(found) = self.read() else { return Vec::new() };
        let all = found.keys().cloned().collect();
        let mut state = self.state();
        state.sources.extend(found);
        state.recompile(&all)
    }
}

fn built_in() -> Sources {
    lightwell_shaders::FILES.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

impl Variant {
    fn take(&mut self, result: Result<CompiledShader, ShaderError>) {
        self.error = match result {
            Ok(compiled) => {
                self.last_good = Some(Arc::new(compiled));
                None
            }
            Err(error) => Some(error),
        };
    }
}

impl State {
    fn take_sources(&mut self, found: Sources) -> Vec<ShaderEvent> {
        let mut changed = BTreeSet::new();
        for (path, source) in found {
            if !source.trim().is_empty() && self.sources.get(&path) != Some(&source) {
                self.sources.insert(path.clone(), source);
                changed.insert(path);
            }
        }
        if changed.is_empty() { Vec::new() } else { self.recompile(&changed) }
    }

    /// Compiles all shaders in use that depend on a changed file.
    fn recompile(&mut self, changed: &BTreeSet<String>) -> Vec<ShaderEvent> {
        let mut events = BTreeMap::new();
        for ((path, defs), variant) in &mut self.variants {
            if compose::with_imports(&self.sources, path).is_disjoint(changed) {
                continue;
            }
            variant.take(compose::compile(&self.sources, path, defs));
            // If one of several sets of defines is broken, that is reported.
            match &variant.error {
                Some(error) => events.insert(path.clone(), ShaderEvent::Broken(error.clone())),
                None => Some(events.entry(path.clone()).or_insert(ShaderEvent::Reloaded(path.clone())).clone()),
            };
            self.revision += u64::from(variant.error.is_none());
        }
        for (path, event) in &events {
            match event {
                ShaderEvent::Reloaded(_) => {
                    log::info!("reloaded shader {path}");
                    // The device is asked again when the pipeline is next wanted.
                    self.pipeline_errors.retain(|(shader, _), _| shader != path);
                }
                ShaderEvent::Broken(error) => log::error!("{error}"),
            }
        }
        events.into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_shaders_built_in_are_those_of_the_source_tree() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
        let (library, source) = (ShaderLibrary::built_in(), ShaderLibrary::open(&folder).unwrap());
        assert_eq!(library.state().sources, source.state().sources);
        assert!(library.dir().is_none() && library.poll().is_empty());
        assert!(library.entry_points("geometry/gbuffer.wgsl").is_ok());
        // The file and the line of a fault are named as ever.
        library.add("broken.wgsl", "#import lightwell::brdf\n\nnonsense");
        let error = library.entry_points("broken.wgsl").unwrap_err();
        assert_eq!((error.file.as_str(), error.line), ("broken.wgsl", 3), "{error}");
    }
}
