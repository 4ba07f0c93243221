//! Defines of shaders.

use naga_oil::compose::ShaderDefValue;

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
