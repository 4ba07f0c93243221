//! The choice of a method of indirect light on command lines.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use lightwell::render::{GiMethod, MethodInfo, Methods};

/// Descriptions of the engine's methods.
pub fn built_in_methods() -> Vec<MethodInfo> {
    Methods::standard().list().collect()
}

/// A parser of the names of methods, whose help lists them.
pub fn method_parser(methods: Vec<MethodInfo>) -> impl TypedValueParser<Value = GiMethod> {
    let values = methods.iter().map(|method| PossibleValue::new(method.id.name()).help(method.about));
    let values = PossibleValuesParser::new(values.collect::<Vec<_>>());
    values.try_map(move |name| find(&methods, &name))
}

/// The method of the engine of a name.
///
/// # Errors
/// If there is none; the message names those that there are.
pub fn parse_method(name: &str) -> Result<GiMethod, String> {
    find(&built_in_methods(), &name.to_ascii_lowercase())
}

fn find(methods: &[MethodInfo], name: &str) -> Result<GiMethod, String> {
    let found = methods.iter().find(|method| method.id.name() == name);
    found.map(|method| method.id).ok_or_else(|| {
        let known: Vec<&str> = methods.iter().map(|method| method.id.name()).collect();
        format!("there is no method `{name}`; there are {}", known.join(", "))
    })
}
