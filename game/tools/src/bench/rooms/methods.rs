//! The methods that rooms judge.

use super::figures::MethodFigures;
use crate::bench::plan;
use crate::bench::variant::Variant;
use crate::cli::BenchArgs;
use anyhow::{Result, bail};
use lightwell::render::GiMethod;

/// Frames with shifted pixel grids that are averaged, if not said.
const IMAGES: u32 = 8;

/// A method that is judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Its name in tables.
    pub name: String,
    /// Its settings.
    pub variant: Variant,
    /// Images that are averaged.
    pub images: u32,
    /// The runner of the fixture that draws it.
    pub runner: usize,
}

/// The methods of a command line, and the variants that a fixture needs for them. Without `--method` they are the default
/// settings as a single image and as an average, and the volumes alone.
///
/// # Errors
/// A method that does not exist, a variant that is none, or two of one name.
pub fn of(args: &BenchArgs) -> Result<(Vec<Judged>, Vec<Variant>)> {
    let images = args.aa.unwrap_or(IMAGES);
    let clpv = |what: &str, sets: &[(&str, &str)]| {
        let sets = sets.iter().map(|&(path, value)| (path.to_owned(), value.to_owned())).collect();
        Variant { what: what.to_owned(), ..Variant::new(what, GiMethod::CLPV, sets) }
    };
    let mut asked: Vec<(String, Variant, u32)> = Vec::new();
    if args.method.is_empty() {
        let default = clpv("the default settings", &[]);
        asked.push(("single image".to_owned(), default.clone(), 1));
        if images > 1 {
            asked.push((format!("{images} images"), default, images));
        }
        let volumes =
            clpv("the default volumes, looked up at the visible surfaces", &[("clpv.gather_rays", "Count(0)")]);
        asked.push(("volumes alone".to_owned(), volumes, images));
        for text in &args.variant {
            let variant = Variant::parse(text)?;
            asked.push((variant.name.clone(), variant, images));
        }
    } else {
        let spp = if args.spp.is_empty() { vec![64] } else { args.spp.clone() };
        for variant in plan::variants(args, &spp)? {
            let images = if variant.is_traced() { 1 } else { images };
            asked.push((variant.name.clone(), variant, images));
        }
    }
    let (mut judged, mut variants): (Vec<Judged>, Vec<Variant>) = Default::default();
    for (name, variant, images) in asked {
        if judged.iter().any(|other| other.name == name) {
            bail!("there are two methods `{name}`; give each a name of its own");
        }
        let known = variants.iter().position(|other| other.identity() == variant.identity());
        let runner = known.unwrap_or_else(|| {
            variants.push(variant.clone());
            variants.len() - 1
        });
        judged.push(Judged { name, variant, images, runner });
    }
    Ok((judged, variants))
}

impl Judged {
    /// Its description in results.
    pub fn figures(&self) -> MethodFigures {
        MethodFigures {
            name: self.name.clone(),
            what: self.variant.what.clone(),
            identity: self.variant.identity(),
            images: self.images,
        }
    }
}
