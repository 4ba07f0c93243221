//! Tests that need what a machine may lack.
//!
//! ```text
//! #[needs("LIGHTWELL_MODELS", "ffmpeg")]
//! fn sponza_is_filmed() { … }
//! ```
//!
//! takes the place of `#[test]`. Names in capitals are environment variables that must name a folder, others programs on
//! the `PATH`. What is missing when the test is built makes it an *ignored* test with the reason; `./check` ends with the
//! number of those. With `LIGHTWELL_REQUIRE=1` nothing is ignored: the test runs and fails for want of what it needs.

use proc_macro::{Literal, TokenStream, TokenTree};
use std::path::Path;

/// In place of `#[test]`: a test that needs folders (names of environment variables) or programs, see the crate.
#[proc_macro_attribute]
pub fn needs(names: TokenStream, function: TokenStream) -> TokenStream {
    let names: Vec<String> = names.into_iter().filter_map(name).collect();
    if names.is_empty() {
        return r#"compile_error!("`needs` takes names in quotes, as in `#[needs(\"LIGHTWELL_MODELS\")]`");"#
            .parse()
            .unwrap_or_default();
    }
    let required = std::env::var_os("LIGHTWELL_REQUIRE").is_some_and(|value| value == "1");
    let missing = names.iter().find_map(|name| missing(name)).filter(|_| !required);
    let ignore = missing.map_or(String::new(), |why| format!("#[ignore = {}]", Literal::string(&why)));
    // Cargo builds the test anew when one of these changes.
    let tracked = names.iter().map(String::as_str).filter(|name| is_variable(name)).chain(["LIGHTWELL_REQUIRE"]);
    let tracked: String =
        tracked.map(|name| format!("const _: Option<&str> = option_env!({});", Literal::string(name))).collect();
    let mut test: TokenStream = format!("{tracked} #[test] {ignore}").parse().unwrap_or_default();
    test.extend(function);
    test
}

fn name(token: TokenTree) -> Option<String> {
    match token {
        TokenTree::Literal(literal) => Some(literal.to_string().trim_matches('"').to_owned()),
        _ => None,
    }
}

fn is_variable(name: &str) -> bool {
    name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
}

/// Why a test cannot run for want of that, if it is missing.
fn missing(name: &str) -> Option<String> {
    if !is_variable(name) {
        let found = std::env::var_os("PATH").is_some_and(|path| {
            std::env::split_paths(&path)
                .any(|folder| [folder.join(name), folder.join(format!("{name}.exe"))].iter().any(|file| file.is_file()))
        });
        return (!found).then(|| format!("there is no program {name}"));
    }
    match std::env::var_os(name) {
        None => Some(format!("{name} is not set")),
        Some(folder) if !Path::new(&folder).is_dir() => Some(format!("{name} names no folder")),
        Some(_) => None,
    }
}
