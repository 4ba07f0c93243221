//! Cost of compiling a shader: its size with every call inlined, and values that are indexed at run time.

use super::compose::CompiledShader;
use std::collections::HashMap;
use std::fmt;
use wgpu::naga::{Block, Expression, Function, Handle, Module, Statement};

/// The size of an entry point with every call inlined, as drivers for graphics cards and for processors do it: time of
/// compilation follows it. A function that is called in three places counts three times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct InlinedSize {
    /// Expressions and statements.
    pub operations: u64,
    /// Name, copies and operations of all copies without what they call, by functions, the largest first.
    pub functions: Vec<(String, u64, u64)>,
}

impl InlinedSize {
    /// The size of the entry point of that name; nothing if there is none.
    pub fn of(module: &Module, entry: &str) -> Self {
        let mut copies = HashMap::new();
        let Some(entry) = module.entry_points.iter().find(|point| point.name == entry) else { return Self::default() };
        count_calls(module, &entry.function.body, &mut copies);
        let mut functions: Vec<(String, u64, u64)> = copies
            .iter()
            .map(|(&handle, &count)| {
                let function = &module.functions[handle];
                (function.name.clone().unwrap_or_default(), count, count * own_operations(function))
            })
            .collect();
        functions.sort_by(|a, b| b.2.cmp(&a.2).then_with(|| a.0.cmp(&b.0)));
        let called: u64 = functions.iter().map(|function| function.2).sum();
        Self { operations: own_operations(&entry.function) + called, functions }
    }
}

impl fmt::Display for InlinedSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} operations", self.operations)?;
        for (name, copies, operations) in self.functions.iter().take(12) {
            write!(f, ", {name} {copies} × {}", operations / copies)?;
        }
        Ok(())
    }
}

fn own_operations(function: &Function) -> u64 {
    function.expressions.len() as u64 + statements(&function.body)
}

fn statements(block: &Block) -> u64 {
    block.iter().map(|statement| 1 + inner_blocks(statement).into_iter().map(statements).sum::<u64>()).sum()
}

fn inner_blocks(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// Adds how many times each function is entered from the block, by all ways. WGSL has no recursion.
fn count_calls(module: &Module, block: &Block, copies: &mut HashMap<Handle<Function>, u64>) {
    for statement in block {
        if let Statement::Call { function, .. } = statement {
            *copies.entry(*function).or_default() += 1;
            count_calls(module, &module.functions[*function].body, copies);
        }
        for inner in inner_blocks(statement) {
            count_calls(module, inner, copies);
        }
    }
}

/// Bytes that a value which is indexed at run time may have.
const SMALL: u32 = 128;

/// Functions that index into a value, not into memory, at run time: drivers write the value to memory of each thread
/// first, and Mesa's software driver compiles seconds for one of a few hundred bytes.
pub(super) fn indexed_values(shader: &CompiledShader) -> Vec<String> {
    let module = &shader.module;
    let named = module.functions.iter().map(|(handle, function)| (function, &shader.info[handle]));
    let entries = module.entry_points.iter().enumerate();
    let entries = entries.map(|(index, entry)| (&entry.function, shader.info.get_entry_point(index)));
    let mut found = Vec::new();
    for (function, info) in named.chain(entries) {
        for (_, expression) in function.expressions.iter() {
            let Expression::Access { base, .. } = expression else { continue };
            let ty = info[*base].ty.inner_with(&module.types);
            let bytes = ty.size(module.to_ctx());
            if ty.pointer_space().is_none() && bytes > SMALL {
                let name = function.name.as_deref().unwrap_or_default();
                found.push(format!("`{name}` indexes into a value of {bytes} bytes"));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;

    #[test]
    fn a_function_counts_as_often_as_it_is_reached() {
        let size = |text: &str| {
            let module = naga::front::wgsl::parse_str(text).expect("valid WGSL");
            InlinedSize::of(&module, "main")
        };
        let twice = "fn leaf(x: f32) -> f32 { return x * x + 1.0; }
            fn node(x: f32) -> f32 { if x > 1.0 { return leaf(x); } return leaf(leaf(x)); }
            fn unused(x: f32) -> f32 { return leaf(x); }
            @compute @workgroup_size(1) fn main() { let a = node(2.0) + node(3.0); }";
        let found = size(twice);
        let copies = |name: &str| found.functions.iter().find(|f| f.0 == name).map(|f| f.1);
        assert_eq!((copies("leaf"), copies("node"), copies("unused")), (Some(6), Some(2), None));
        assert!(found.operations > size(&twice.replace("+ node(3.0)", "")).operations);
        assert_eq!(InlinedSize::of(&naga::Module::default(), "main"), InlinedSize::default());
    }

    #[test]
    fn values_that_are_indexed_at_run_time_are_named() {
        let found = |parameter: &str, argument: &str| {
            let text = format!(
                "struct Faces {{ faces: array<mat4x4f, 6>, count: u32 }}
                @group(0) @binding(0) var<uniform> shadow: Faces;
                @group(0) @binding(1) var<storage, read_write> sums: array<vec4f>;
                fn row(faces: {parameter}, i: u32) -> vec4f {{ return {argument}; }}
                @compute @workgroup_size(1) fn main() {{ sums[0] = row(shadow{}, u32(sums[1].x)); }}",
                if parameter == "Faces" { "" } else { ".count" }
            );
            let module = naga::front::wgsl::parse_str(&text).expect("valid WGSL");
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
            let info = validator.validate(&module).expect("valid WGSL");
            indexed_values(&CompiledShader { module, info })
        };
        assert_eq!(found("Faces", "faces.faces[i][0]"), ["`row` indexes into a value of 384 bytes"]);
        assert!(found("Faces", "faces.faces[2][0]").is_empty(), "by a constant");
        assert!(found("u32", "shadow.faces[i + faces][0]").is_empty(), "of memory");
    }
}
