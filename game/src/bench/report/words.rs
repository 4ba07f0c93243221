//! What the numbers say, in words: which method wins where, and why.

use super::facts::{self, Fact, Light, is_baseline};
use super::markdown::{list, ms, percent, times};
use crate::bench::pareto::{front, time_for_error};
use crate::bench::results::Results;
use crate::bench::stage::STAGES;

/// Share of the squared error from which on a constant factor is called its cause.
const MOSTLY: f64 = 0.6;

/// A paragraph a scene.
pub fn verdict(results: &Results) -> Option<String> {
    let paragraph = |scene: &crate::bench::results::SceneFigures| {
        let facts = facts::of(results, &scene.name, false);
        let words = of_scene(&facts);
        (!words.is_empty()).then(|| format!("**{}.** {}\n\n", scene.name, words.join(" ")))
    };
    let text: String = results.scenes.iter().filter_map(paragraph).collect();
    (!text.is_empty()).then(|| format!("## Which method wins where\n\n{text}"))
}

fn of_scene(facts: &[Fact]) -> Vec<String> {
    let mut words = Vec::new();
    let drawn: Vec<&Fact> =
        facts.iter().filter(|fact| !fact.variant.traced && fact.indirect.nrmse.is_finite()).collect();
    let best = drawn.iter().min_by(|a, b| a.indirect.nrmse.total_cmp(&b.indirect.nrmse));
    let Some(best) = best else { return words };
    words.push(format!(
        "Of the methods that draw a frame at once, `{}` comes nearest to the reference: {} error of indirect light and {} of \
         all light in {} ms a frame.",
        best.variant.name,
        percent(best.indirect.nrmse),
        percent(best.total.nrmse),
        ms(best.time()),
    ));
    let light: Vec<&&Fact> = drawn.iter().filter(|fact| fact.indirect.bias > -1.0).collect();
    for fact in &light {
        words.extend(cause(fact));
        words.extend(against_sampling(facts, fact));
    }
    words.extend(light.iter().max_by(|a, b| a.time().total_cmp(&b.time())).and_then(|fact| cost(fact)));
    words.extend(front_in_words(facts));
    words
}

/// Whether the error is one of brightness or of distribution.
fn cause(fact: &Fact) -> Option<String> {
    let error = &fact.indirect;
    let share = (error.bias / error.nrmse).powi(2);
    let name = &fact.variant.name;
    if !(share.is_finite() && error.nrmse > 0.0) {
        return None;
    }
    let how = if error.bias > 0.0 { "too bright" } else { "too dark" };
    let level = format!("{} {how}", percent(error.bias.abs()));
    Some(if share > MOSTLY {
        format!("What is wrong with `{name}` is mostly the level: on average it is {level}.")
    } else {
        format!(
            "`{name}` is {level} on average, which makes {} of its squared error; the rest is light in the wrong places.",
            percent(share)
        )
    })
}

/// What path tracing needs for the same error.
fn against_sampling(facts: &[Fact], fact: &Fact) -> Option<String> {
    let (time, beyond) = time_for_error(&facts::baseline(facts, Light::Indirect), fact.indirect.nrmse)?;
    let factor = time / fact.time();
    let name = &fact.variant.name;
    let source = if beyond { " (by the square-root law from the nearest measured point)" } else { "" };
    Some(if factor >= 1.0 {
        format!("Path tracing needs {} ms{source} for the error of `{name}`, {} its time.", ms(time), times(factor))
    } else {
        format!(
            "Path tracing reaches the error of `{name}` in {} ms{source}: by this measure sampling is {} as fast.",
            ms(time),
            times(1.0 / factor)
        )
    })
}

/// Where the time goes.
fn cost(fact: &Fact) -> Option<String> {
    let mut stages: Vec<(&String, f64)> = fact.timing.stages.iter().map(|(name, time)| (name, time.median)).collect();
    stages.sort_by(|a, b| b.1.total_cmp(&a.1));
    let all = fact.time();
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
