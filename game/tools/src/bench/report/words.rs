//! Conclusions from the numbers: which method wins where, and why.

use super::facts::{self, Fact, Light, is_baseline};
use super::markdown::{NONE, list, ms, percent, signed, table, times};
use crate::bench::pareto::{front, time_for_error};
use crate::bench::results::Results;
use crate::bench::stage::STAGES;

/// Share of the squared error from which on a constant factor is called its cause.
const MOSTLY: f64 = 0.6;

/// The meaning of the columns of the tables.
const LEGEND: &str = "*Level* is the share of the squared error that a constant factor would take away: from 60 % on, the image \
    is too bright or too dark as the bias says; below, the light is in the wrong places. *Frame* is the time of a frame from \
    start to end, *device* what of it the device's passes take, *image* the time of the image whose error is stated: a frame, and \
    as often as images are averaged what another shift of the pixels computes anew. Then, of indirect and of all light, the \
    error, and how many times as long plain path tracing takes for the same error, over the time of a frame and over that of the \
    image: volumes that are looked up bring the same light in each image, so that the first is fair to them; rays bring other \
    noise in each, so that the second is. Below 1 path tracing wins. In brackets: by the square-root law from the nearest measured \
    point. `filtered paths` are path tracing behind the filter of the gather, the rival that a denoised path tracer is.";

/// A paragraph and a table a scene.
pub fn verdict(results: &Results) -> Option<String> {
    let section = |scene: &crate::bench::results::SceneFigures| {
        let facts = facts::of(results, &scene.name, false);
        of_scene(&facts).map(|words| format!("**{}.** {words}\n\n", scene.name))
    };
    let text: String = results.scenes.iter().filter_map(section).collect();
    (!text.is_empty()).then(|| format!("## Which method wins where\n\n{LEGEND}\n\n{text}"))
}

fn of_scene(facts: &[Fact]) -> Option<String> {
    let drawn: Vec<&Fact> =
        facts.iter().filter(|fact| !fact.variant.traced && fact.indirect.nrmse.is_finite()).collect();
    let best = drawn.iter().min_by(|a, b| a.indirect.nrmse.total_cmp(&b.indirect.nrmse))?;
    let mut words = vec![format!(
        "Of the methods that draw a frame at once, `{}` comes nearest to the reference: {} error of indirect light and {} of \
         all light in {} ms a frame.",
        best.variant.name,
        percent(best.indirect.nrmse),
        percent(best.total.nrmse),
        ms(best.time()),
    )];
    let light: Vec<&&Fact> = drawn.iter().filter(|fact| fact.indirect.bias > -1.0).collect();
    words.extend(levels(&light));
    words.extend(light.iter().max_by(|a, b| a.time().total_cmp(&b.time())).and_then(|fact| cost(fact)));
    words.extend(front_in_words(facts));
    let rows: Vec<Vec<String>> = light.iter().map(|fact| row(facts, fact)).collect();
    let head = [
        "method",
        "frame [ms]",
        "device [ms]",
        "image [ms]",
        "bias",
        "level",
        "indirect nrmse",
        "path tracing over frame",
        "over image",
        "all light nrmse",
        "path tracing over frame, all",
        "over image, all",
    ];
    let rows = if rows.is_empty() { String::new() } else { format!("\n\n{}", table(&head, &rows)) };
    Some(words.join(" ") + rows.trim_end())
}

/// Share of the squared error that is one of brightness.
fn level(fact: &Fact) -> f64 {
    (fact.indirect.bias / fact.indirect.nrmse).powi(2)
}

/// The methods whose error is mostly one of brightness.
fn levels(light: &[&&Fact]) -> Option<String> {
    let named = |fact: &&&&Fact| {
        let how = if fact.indirect.bias > 0.0 { "bright" } else { "dark" };
        format!("`{}` ({} too {how})", fact.variant.name, percent(fact.indirect.bias.abs()))
    };
    let wrong: Vec<String> = light.iter().filter(|fact| level(fact) > MOSTLY).map(|fact| named(&fact)).collect();
    (!wrong.is_empty()).then(|| format!("What is wrong is mostly the level with {}.", list(&wrong)))
}

fn row(facts: &[Fact], fact: &Fact) -> Vec<String> {
    let mut row = vec![
        format!("`{}`", fact.variant.name),
        ms(fact.time()),
        ms(fact.device_time()),
        fact.image_time.map_or(NONE.to_owned(), ms),
        signed(fact.indirect.bias),
        percent(level(fact)),
    ];
    for light in [Light::Indirect, Light::Total] {
        row.push(super::markdown::error(fact.of(light).nrmse));
        row.extend(over_path_tracing(facts, light, fact.of(light).nrmse, [Some(fact.time()), fact.image_time]));
    }
    row
}

/// How many times as long as each of these times [ms] plain path tracing takes for an error; bracketed where that is beyond
/// what was measured.
pub fn over_path_tracing<const N: usize>(
    facts: &[Fact],
    light: Light,
    error: f64,
    own: [Option<f64>; N],
) -> [String; N] {
    let sampling = time_for_error(&facts::baseline(facts, light), error);
    own.map(|own| match (sampling, own) {
        (None, _) => String::new(),
        (_, None) => NONE.to_owned(),
        (Some((time, true)), Some(own)) => format!("({})", times(time / own)),
        (Some((time, false)), Some(own)) => times(time / own),
    })
}

/// Where the time goes.
fn cost(fact: &Fact) -> Option<String> {
    let mut stages: Vec<(&String, f64)> = fact.timing.stages.iter().map(|(name, time)| (name, time.median)).collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    let all = fact.device_time();
    let named = |(name, time): &(&String, f64)| {
        let what = STAGES.iter().find(|stage| stage.name == name.as_str()).map_or(name.as_str(), |stage| stage.what);
        format!("{what} {}", percent(time / all))
    };
    let first: Vec<String> = stages.iter().take(3).filter(|(_, time)| *time > 0.0).map(named).collect();
    (!first.is_empty()).then(|| format!("The time of `{}` goes into {}.", fact.variant.name, list(&first)))
}

fn front_in_words(facts: &[Fact]) -> Option<String> {
    let points: Vec<(f64, f64)> = facts.iter().map(|fact| (fact.time(), fact.indirect.nrmse)).collect();
    let on_front = front(&points);
    let names: Vec<String> = on_front.iter().map(|&index| format!("`{}`", facts[index].variant.name)).collect();
    let beaten: Vec<String> = (0..facts.len())
        .filter(|index| !on_front.contains(index) && !is_baseline(&facts[*index]))
        .map(|index| format!("`{}`", facts[index].variant.name))
        .collect();
    let front = format!("On the Pareto front of time and indirect error are {}", list(&names));
    (!names.is_empty()).then(|| match beaten.is_empty() {
        true => format!("{front}."),
        false => format!("{front}; something faster and better exists for {}.", list(&beaten)),
    })
}
