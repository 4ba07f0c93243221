//! Plots of time against error.

use super::facts::{self, Light};
use super::markdown::size;
use crate::bench::picture::file_name;
use crate::bench::plot;
use crate::bench::results::Results;
use anyhow::Result;
use std::path::Path;

const LIGHTS: [Light; 2] = [Light::Indirect, Light::Total];

fn file(scene: &str, light: Light) -> String {
    format!("plots/{}_{}.png", file_name(scene), light.name())
}

/// Draws the plots of all scenes.
///
/// # Errors
/// If a file cannot be written.
pub fn draw(folder: &Path, results: &Results) -> Result<()> {
    for scene in &results.scenes {
        let facts = facts::of(results, &scene.name, false);
        for light in LIGHTS {
            let dots = facts::dots(&facts, light);
            if dots.is_empty() {
                continue;
            }
            let at = facts.first().map_or(String::new(), |fact| size(fact.timing.size));
            let title = format!("{}: time against error of {} light", scene.name, light.name());
            let x = format!("time of a frame at {at} from start to end, everything computed [ms]");
            plot::time_error(&folder.join(file(&scene.name, light)), &title, &dots, &x, "nrmse")?;
        }
    }
    Ok(())
}

/// The plots in the report.
pub fn time_error_section(results: &Results) -> Option<String> {
    let mut text = String::from("## Time against error\n\n");
    let mut any = false;
    for scene in &results.scenes {
        let facts = facts::of(results, &scene.name, false);
        for light in LIGHTS.into_iter().filter(|light| !facts::dots(&facts, *light).is_empty()) {
            text += &format!("![{}, {} light]({})\n\n", scene.name, light.name(), file(&scene.name, light));
            any = true;
        }
    }
    any.then_some(text)
}
