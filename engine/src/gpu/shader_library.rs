//! WGSL files with imports (`#import lightwell::brdf::eval_brdf_cosine`), kept current with the disk.

use super::reflect::{self, EntryPoint, StructLayout};
use super::shader_error::ShaderError;
use super::watch::Watcher;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue, get_preprocessor_data,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::naga;

/// A value for `#ifdef`, `#if` and `#{NAME}` in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShaderDef {
    /// Defined or not.
    Flag(bool),
    /// A signed number.
    Int(i32),
    /// An unsigned number.
    Uint(u32),
}

impl From<ShaderDef> for ShaderDefValue {
    fn from(def: ShaderDef) -> Self {
        match def {
            ShaderDef::Flag(value) => Self::Bool(value),
            ShaderDef::Int(value) => Self::Int(value),
            ShaderDef::Uint(value) => Self::UInt(value),
        }
    }
}

/// Defines of one compilation.
pub(super) type Defs = Vec<(&'static str, ShaderDef)>;

/// What a [`ShaderLibrary::poll`] found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShaderEvent {
    /// The shader was compiled anew and is in use.
    Reloaded(String),
    /// The shader is broken; its last good version stays in use.
    Broken(ShaderError),
}

/// A shader put together from its imports and validated.
#[derive(Debug)]
pub(super) struct CompiledShader {
    pub(super) module: naga::Module,
    pub(super) info: naga::valid::ModuleInfo,
}

/// All WGSL files of a folder.
pub struct ShaderLibrary {
    dir: PathBuf,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    sources: BTreeMap<String, String>,
    used: BTreeSet<(String, Vec<(&'static str, DefKey)>)>,
    errors: BTreeMap<String, ShaderError>,
    revision: u64,
    watcher: Option<Watcher>,
}

/// [`ShaderDef`] with an order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct DefKey(u8, i64);

impl From<ShaderDef> for DefKey {
    fn from(def: ShaderDef) -> Self {
        match def {
            ShaderDef::Flag(value) => Self(0, value.into()),
            ShaderDef::Int(value) => Self(1, value.into()),
            ShaderDef::Uint(value) => Self(2, value.into()),
        }
    }
}

impl From<DefKey> for ShaderDef {
    fn from(DefKey(kind, value): DefKey) -> Self {
        match kind {
            0 => Self::Flag(value != 0),
            1 => Self::Int(value as i32),
            _ => Self::Uint(value as u32),
        }
    }
}

impl ShaderLibrary {
    /// Reads all `.wgsl` files below the folder and watches it. Without a watcher everything works but reload.
    pub(super) fn open(dir: &Path) -> std::io::Result<Self> {
        let mut sources = BTreeMap::new();
        read_folder(dir, dir, &mut sources)?;
        let watcher = Watcher::new(dir)
            .inspect_err(|error| log::warn!("shaders in {} are not watched for changes: {error}", dir.display()))
            .ok();
        let state = State { sources, watcher, revision: 1, ..Default::default() };
        Ok(Self { dir: dir.to_owned(), state: Mutex::new(state) })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Counts up with every shader that was reloaded well: part of every cache key.
    pub fn revision(&self) -> u64 {
        self.state().revision
    }

    /// Shaders that do not compile at present.
    pub fn errors(&self) -> Vec<ShaderError> {
        self.state().errors.values().cloned().collect()
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

    /// Puts the shader together from its imports and validates it.
    pub(super) fn compile(&self, path: &str, defs: &Defs) -> Result<Arc<CompiledShader>, ShaderError> {
        let mut state = self.state();
        let result = compile(&state.sources, path, defs);
        let keys = defs.iter().map(|&(name, def)| (name, def.into())).collect();
        state.used.insert((path.to_string(), keys));
        match &result {
            Ok(_) => state.errors.remove(path),
            Err(error) => state.errors.insert(path.to_string(), error.clone()),
        };
        result.map(Arc::new)
    }

    /// Changes with the shader's text and with that of everything that it imports.
    pub(super) fn source_hash(&self, path: &str) -> u64 {
        let state = self.state();
        let mut hasher = DefaultHasher::new();
        for file in with_imports(&state.sources, path) {
            state.sources.get(&file).hash(&mut hasher);
        }
        hasher.finish()
    }

    /// Takes up what changed on disk since the last call; call it once a frame.
    ///
    /// Empty files are passed over: editors truncate before they write.
    pub fn poll(&self) -> Vec<ShaderEvent> {
        let mut state = self.state();
        let Some(paths) = state.watcher.as_ref().map(Watcher::changed) else { return Vec::new() };
        let mut changed = BTreeSet::new();
        for path in paths {
            let (Some(name), Ok(source)) = (relative_name(&self.dir, &path), std::fs::read_to_string(&path)) else {
                continue;
            };
            if !source.trim().is_empty() && state.sources.get(&name) != Some(&source) {
                state.sources.insert(name.clone(), source);
                changed.insert(name);
            }
        }
        if changed.is_empty() { Vec::new() } else { state.recompile(&changed) }
    }
}

impl State {
    /// Compiles all shaders in use that depend on a changed file.
    fn recompile(&mut self, changed: &BTreeSet<String>) -> Vec<ShaderEvent> {
        let mut events = BTreeMap::new();
        for (path, keys) in self.used.clone() {
            if with_imports(&self.sources, &path).is_disjoint(changed) {
                continue;
            }
            let defs = keys.into_iter().map(|(name, key)| (name, key.into())).collect();
            match compile(&self.sources, &path, &defs) {
                Ok(_) => {
                    events.entry(path.clone()).or_insert(ShaderEvent::Reloaded(path));
                }
                Err(error) => {
                    events.insert(path, ShaderEvent::Broken(error));
                }
            }
        }
        for (path, event) in &events {
            match event {
                ShaderEvent::Reloaded(_) => {
                    self.errors.remove(path);
                    self.revision += 1;
                    log::info!("reloaded shader {path}");
                }
                ShaderEvent::Broken(error) => {
                    log::error!("{error}");
                    self.errors.insert(path.clone(), error.clone());
                }
            }
        }
        events.into_values().collect()
    }
}

/// The file's name within the folder, with `/` on every system; none if it is no shader.
fn relative_name(dir: &Path, path: &Path) -> Option<String> {
    if path.extension()? != "wgsl" {
        return None;
    }
    let parts = path.strip_prefix(dir).ok()?.iter().map(|part| part.to_str());
    Some(parts.collect::<Option<Vec<_>>>()?.join("/"))
}

fn read_folder(root: &Path, dir: &Path, sources: &mut BTreeMap<String, String>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(dir)? {
        let path = entry?.path();
        if path.is_dir() {
            read_folder(root, &path, sources)?;
        } else if let Some(name) = relative_name(root, &path) {
            sources.insert(name, std::fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

/// Files of which each import path is made.
fn files_by_import_path(sources: &BTreeMap<String, String>) -> HashMap<String, String> {
    let named = |(file, source): (&String, &String)| Some((get_preprocessor_data(source).0?, file.clone()));
    sources.iter().filter_map(named).collect()
}

/// The file and all files that it imports, directly or not.
fn with_imports(sources: &BTreeMap<String, String>, path: &str) -> BTreeSet<String> {
    let files = files_by_import_path(sources);
    let mut found = BTreeSet::new();
    let mut open = vec![path.to_string()];
    while let Some(file) = open.pop() {
        if found.insert(file.clone())
            && let Some(source) = sources.get(&file)
        {
            open.extend(imports_of(source, &files));
        }
    }
    found
}

fn imports_of(source: &str, files: &HashMap<String, String>) -> Vec<String> {
    let (_, imports, _) = get_preprocessor_data(source);
    imports.iter().filter_map(|import| files.get(&import.import).cloned()).collect()
}

fn compile(sources: &BTreeMap<String, String>, path: &str, defs: &Defs) -> Result<CompiledShader, ShaderError> {
    let source = sources.get(path).ok_or_else(|| ShaderError::of_file(path, "there is no such file"))?;
    let shader_defs: HashMap<String, ShaderDefValue> =
        defs.iter().map(|&(name, def)| (name.to_string(), def.into())).collect();
    let mut composer = Composer::default().with_capabilities(naga::valid::Capabilities::all());
    let files = files_by_import_path(sources);
    let mut added = BTreeSet::new();
    for file in imports_of(source, &files) {
        add_module(&mut composer, sources, &files, &shader_defs, &file, &mut added)
            .map_err(|report| ShaderError::of_report(path, &report))?;
    }
    let composed = composer.make_naga_module(NagaModuleDescriptor {
        source,
        file_path: path,
        shader_defs,
        ..Default::default()
    });
    let module = composed.map_err(|error| ShaderError::of_report(path, &error.emit_to_string(&composer)))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
    let info = validator.validate(&module).map_err(|error| ShaderError::of_validation(path, &error))?;
    Ok(CompiledShader { module, info })
}

/// Adds a file after all that it imports. The error is the composer's report.
fn add_module(
    composer: &mut Composer,
    sources: &BTreeMap<String, String>,
    files: &HashMap<String, String>,
    shader_defs: &HashMap<String, ShaderDefValue>,
    file: &str,
    added: &mut BTreeSet<String>,
) -> Result<(), String> {
    let Some(source) = sources.get(file).filter(|_| added.insert(file.to_string())) else { return Ok(()) };
    for import in imports_of(source, files) {
        add_module(composer, sources, files, shader_defs, &import, added)?;
    }
    let result = composer.add_composable_module(ComposableModuleDescriptor {
        source,
        file_path: file,
        shader_defs: shader_defs.clone(),
        ..Default::default()
    });
    match result {
        Ok(_) => Ok(()),
        Err(error) => Err(error.emit_to_string(composer)),
    }
}
