//! Puts shaders together from files that import one another.

use super::shader_defs::Defs;
use super::shader_error::ShaderError;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue, get_preprocessor_data,
};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use wgpu::naga;

/// Texts of the WGSL files by path below the shader folder, with `/` on every system.
pub(super) type Sources = BTreeMap<String, String>;

/// A shader put together from its imports and validated.
#[derive(Debug)]
pub(super) struct CompiledShader {
    pub(super) module: naga::Module,
    pub(super) info: naga::valid::ModuleInfo,
}

/// Which file defines each import path (`#define_import_path`).
fn files_by_import_path(sources: &Sources) -> HashMap<String, String> {
    let named = |(file, source): (&String, &String)| Some((get_preprocessor_data(source).0?, file.clone()));
    sources.iter().filter_map(named).collect()
}

/// The file and all files that it imports, directly or not.
pub(super) fn with_imports(sources: &Sources, path: &str) -> BTreeSet<String> {
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

thread_local! {
    /// The making of a composer takes longer than most shaders: it compiles two dozen regular expressions.
    static COMPOSER: RefCell<Composer> =
        RefCell::new(Composer::default().with_capabilities(naga::valid::Capabilities::all()));
}

/// Composes and validates a file. Everything that WGSL allows is accepted here: what this adapter cannot do, the
/// device says when the pipeline is made.
pub(super) fn compile(sources: &Sources, path: &str, defs: &Defs) -> Result<CompiledShader, ShaderError> {
    COMPOSER.with_borrow_mut(|composer| {
        // Nothing is kept of another shader, whose defines may be others.
        composer.module_sets.clear();
        composer.module_index.clear();
        compile_with(composer, sources, path, defs)
    })
}

fn compile_with(
    composer: &mut Composer,
    sources: &Sources,
    path: &str,
    defs: &Defs,
) -> Result<CompiledShader, ShaderError> {
    let source = sources.get(path).ok_or_else(|| ShaderError::of_file(path, "there is no such file"))?;
    let shader_defs: HashMap<String, ShaderDefValue> =
        defs.iter().map(|&(name, def)| (name.to_string(), def.into())).collect();
    let files = files_by_import_path(sources);
    let mut modules = Modules { sources, files: &files, shader_defs: &shader_defs, added: BTreeSet::new() };
    for file in imports_of(source, &files) {
        modules.add(composer, &file).map_err(|report| ShaderError::of_report(path, &report))?;
    }
    let composed = composer.make_naga_module(NagaModuleDescriptor {
        source,
        file_path: path,
        shader_defs: shader_defs.clone(),
        ..Default::default()
    });
    let module = composed.map_err(|error| ShaderError::of_report(path, &error.emit_to_string(composer)))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
    let info = validator.validate(&module).map_err(|error| ShaderError::of_validation(path, &error))?;
    Ok(CompiledShader { module, info })
}

/// The files that a shader imports, on their way into the composer.
struct Modules<'a> {
    sources: &'a Sources,
    files: &'a HashMap<String, String>,
    shader_defs: &'a HashMap<String, ShaderDefValue>,
    added: BTreeSet<String>,
}

impl Modules<'_> {
    /// Adds a file after all that it imports. The error is the composer's report.
    fn add(&mut self, composer: &mut Composer, file: &str) -> Result<(), String> {
        let Some(source) = self.sources.get(file).filter(|_| self.added.insert(file.to_string())) else {
            return Ok(());
        };
        for import in imports_of(source, self.files) {
            self.add(composer, &import)?;
        }
        let result = composer.add_composable_module(ComposableModuleDescriptor {
            source,
            file_path: file,
            shader_defs: self.shader_defs.clone(),
            ..Default::default()
        });
        match result {
            Ok(_) => Ok(()),
            Err(error) => Err(error.emit_to_string(composer)),
        }
    }
}
