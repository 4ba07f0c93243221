//! Flicker: methods by scenes, and what it means in words.

use super::facts::{self, Light};
use super::markdown::{error, list, ms, percent, table};
use super::words::over_path_tracing;
use crate::bench::results::{Flicker, Mode, Results};

/// From this share of trembling in the change on, it is called one to and fro.
const NOISE: f64 = 0.7;
/// Up to this share, the change is called steady.
const STEADY: f64 = 0.35;

/// The tables, and a paragraph a scene.
pub fn section(results: &Results) -> Option<String> {
    let scenes: Vec<&str> =
        results.scenes.iter().map(|s| s.name.as_str()).filter(|name| of(results, name).next().is_some()).collect();
    let first = results.flicker.first()?;
    let mut text = format!(
        "## Flicker\n\nOf {} successive frames: root mean square over pixels and frames of the change of indirect light from \
         frame to frame that the reference does not make, over the mean of that light. A method that shows none has the \
         reference's own change; one that shows less follows the motion of the light; one that shows more adds unrest. \
         Frames are single ones, as they are played: where the camera moves, edges that jump by a pixel count for every \
         method alike.\n\n",
        first.frames
    );
    text += &grid(results, &scenes, |f| Some(f.change), |f| Some(f.reference));
    let trembles = results.flicker.iter().any(|flicker| flicker.tremble.is_some());
    if trembles {
        text += "\nTrembling, what of that goes to and fro (second differences over √3): noise that is another one in each \
                 frame has as much of it as of change, light that is wrong but moves evenly has none.\n\n";
        text += &grid(results, &scenes, |f| f.tremble, |f| f.reference_tremble);
    }
    if results.flicker.iter().any(|flicker| flicker.error.is_some()) {
        text += "\nError of those frames, each against the reference of its time, as it is played after 20 frames before it where \
                 frames are averaged; then the bias.\n\n";
        text += &grid(results, &scenes, |f| f.error, |_| None);
        text += "\n";
        text += &grid(results, &scenes, |f| f.bias, |_| None);
    }
    text += &as_played(results);
    if results.flicker.iter().any(|flicker| flicker.smooth.is_some()) {
        text += "\nThe change again with smooth edges: each frame is the mean of several, shifted by parts of a pixel, as the \
                 reference's are. What is left is the light's own unrest; noise is less by the number of those frames, so that \
                 it is a figure for methods that have none (`clpv`, `sweep`).\n\n";
        text += &grid(results, &scenes, |f| f.smooth, |f| Some(f.reference));
    }
    for scene in scenes {
        let words = words(&of(results, scene).collect::<Vec<_>>());
        text += &format!("\n**{scene}.** {}\n", words.join(" "));
    }
    Some(text + &pictures(results))
}

/// Frames as a window shows them, one after the other, against plain path tracing of each.
fn as_played(results: &Results) -> String {
    let mut rows = Vec::new();
    for flicker in &results.flicker {
        let facts = facts::of(results, &flicker.scene, false);
        let timing = facts::timing(results, &flicker.scene, &flicker.variant, Mode::Animated);
        let (Some(timing), Some(indirect), Some(total)) = (timing, flicker.error, flicker.total_error) else {
            continue;
        };
        let own = timing.wall.median;
        let mut row = vec![flicker.scene.clone(), format!("`{}`", flicker.variant), ms(own)];
        for (light, found) in [(Light::Indirect, indirect), (Light::Total, total)] {
            row.push(error(found));
            row.extend(over_path_tracing(&facts, light, found, [Some(own)]));
        }
        rows.push(row);
    }
    let head = [
        "scene",
        "variant",
        "frame [ms]",
        "indirect nrmse",
        "path tracing over frame",
        "all light nrmse",
        "path tracing over frame, all",
    ];
    match rows.is_empty() {
        true => String::new(),
        false => format!(
            "\nThe same frames against plain path tracing of each: how many times as long as an animated frame it takes for the \
             error of indirect and of all light. Where frames are averaged, those before it lend theirs.\n\n{}",
            table(&head, &rows)
        ),
    }
}

fn of<'a>(results: &'a Results, scene: &str) -> impl Iterator<Item = &'a Flicker> {
    results.flicker.iter().filter(move |flicker| flicker.scene == scene)
}

/// Rows of methods, columns of scenes; the reference first.
fn grid(
    results: &Results,
    scenes: &[&str],
    value: fn(&Flicker) -> Option<f64>,
    reference: fn(&Flicker) -> Option<f64>,
) -> String {
    let shown = |value: Option<f64>| value.map_or("–".to_owned(), percent);
    let row = |name: &str, cell: &dyn Fn(&str) -> Option<f64>| {
        let cells = scenes.iter().map(|scene| shown(cell(scene)));
        std::iter::once(name.to_owned()).chain(cells).collect::<Vec<_>>()
    };
    let mut rows = vec![row("*the reference itself*", &|scene| of(results, scene).next().and_then(reference))];
    let mut variants: Vec<&str> = Vec::new();
    for flicker in &results.flicker {
        if !variants.contains(&flicker.variant.as_str()) {
            variants.push(&flicker.variant);
        }
    }
    let found = |scene: &str, variant: &str| of(results, scene).find(|f| f.variant == variant).and_then(value);
    rows.extend(variants.iter().map(|variant| row(variant, &|scene| found(scene, variant))));
    table(&[&["variant"], scenes].concat(), &rows)
}

/// Conclusions from the figures of a scene.
fn words(all: &[&Flicker]) -> Vec<String> {
    let Some(own) = all.first().map(|flicker| flicker.reference) else { return Vec::new() };
    let mut words =
        vec![format!("The reference changes by {} of the mean from frame to frame by itself.", percent(own))];
    let share = |flicker: &Flicker| flicker.tremble.map(|tremble| tremble / flicker.change);
    // Without indirect light there is nothing to flicker.
    let mut lit: Vec<&&Flicker> = all.iter().filter(|flicker| flicker.variant != "none").collect();
    lit.sort_by(|a, b| a.change.total_cmp(&b.change));
    if let [steadiest, .., worst] = lit[..] {
        words.push(format!(
            "Steadiest is `{}` ({} beyond that), least steady `{}` ({}).",
            steadiest.variant,
            percent(steadiest.change),
            worst.variant,
            percent(worst.change)
        ));
    }
    let named = |holds: &dyn Fn(&Flicker) -> bool| -> Vec<String> {
        lit.iter().filter(|flicker| holds(flicker)).map(|flicker| format!("`{}`", flicker.variant)).collect()
    };
    let mut say = |names: Vec<String>, what: &str| {
        if !names.is_empty() {
            words.push(format!("{what}: {}.", list(&names)));
        }
    };
    say(named(&|f| f.change > own), "More change of their own than the light has");
    say(named(&|f| share(f).is_some_and(|s| s >= NOISE)), "Mostly to and fro, by noise or by edges that jump");
    say(
        named(&|f| share(f).is_some_and(|s| s < STEADY)),
        "Mostly light that moves evenly, but too far or not far enough",
    );
    words
}

/// The images of those that are drawn.
fn pictures(results: &Results) -> String {
    let traced = |name: &str| results.variants.iter().any(|variant| variant.name == name && variant.traced);
    let mut text = String::new();
    for flicker in results.flicker.iter().filter(|flicker| !traced(&flicker.variant)) {
        if let Some(picture) = &flicker.picture {
            text += &format!("\n![flicker of {}, {}]({picture})\n", flicker.scene, flicker.variant);
        }
    }
    text
}
