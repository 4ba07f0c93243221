//! Checks of the work of passes in a frame.

use super::document::FrameExpectation;
use lightwell::files::suggestion;
use lightwell::graph::{Counts, FrameReport, PassReport, PassState};

/// Differences of the report from what is expected, in words.
pub fn check(expected: &FrameExpectation, report: &FrameReport) -> Vec<String> {
    let mut faults = Vec::new();
    let wanted: [(&str, &[String], Held); 4] = [
        ("have run", &expected.ran, |state| *state == PassState::Ran),
        ("be cached", &expected.cached, |state| *state == PassState::Cached),
        ("be culled", &expected.culled, |state| *state == PassState::Culled),
        ("be skipped", &expected.skipped, |state| matches!(state, PassState::Skipped(_))),
    ];
    for (should, patterns, holds) in wanted {
        faults.extend(patterns.iter().flat_map(|pattern| state_faults(report, pattern, should, holds)));
    }
    for pattern in &expected.not_run {
        let ran = matching(report, pattern).filter(|pass| pass.state == PassState::Ran);
        faults.extend(ran.map(|pass| format!("`{}` should not have run, but did: {}", pass.name, pass.why)));
    }
    if expected.idle {
        let ran = report.passes.iter().filter(|pass| pass.state == PassState::Ran);
        faults.extend(ran.map(|pass| format!("nothing should have run, but `{}` did: {}", pass.name, pass.why)));
    }
    for (pattern, bounds) in &expected.counts {
        let mut counts = Counts::default();
        matching(report, pattern).for_each(|pass| counts += pass.counts);
        match matching(report, pattern).next() {
            None => faults.push(unknown(report, pattern, "be counted")),
            Some(_) => faults.extend(bounds.violations(&counts).iter().map(|what| format!("`{pattern}` did {what}"))),
        }
    }
    faults
}

/// Whether a state is the wanted one.
type Held = fn(&PassState) -> bool;

fn state_faults(report: &FrameReport, pattern: &str, should: &str, holds: Held) -> Vec<String> {
    let mut passes = matching(report, pattern).peekable();
    if passes.peek().is_none() {
        return vec![unknown(report, pattern, should)];
    }
    let wrong = passes.filter(|pass| !holds(&pass.state));
    wrong.map(|pass| format!("`{}` should {should}, but {}", pass.name, what_happened(pass))).collect()
}

fn what_happened(pass: &PassReport) -> String {
    match pass.state {
        PassState::Ran => format!("ran: {}", pass.why),
        PassState::Cached | PassState::Culled | PassState::Skipped(_) => format!("was {}: {}", pass.state, pass.why),
    }
}

fn unknown(report: &FrameReport, pattern: &str, should: &str) -> String {
    let help = suggestion(pattern, report.passes.iter().map(|pass| pass.name.as_str())).unwrap_or_default();
    format!("`{pattern}` should {should}, but there is no such pass; {help}")
}

fn matching<'a>(report: &'a FrameReport, pattern: &'a str) -> impl Iterator<Item = &'a PassReport> {
    report.passes.iter().filter(move |pass| matches(pattern, &pass.name))
}

/// Whether the name is the pattern, in which each `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut left) = name.strip_prefix(head) else { return false };
    let mut parts: Vec<&str> = rest.split('*').collect();
    let tail = parts.pop().unwrap_or_default();
    for part in parts {
        match left.find(part) {
            Some(at) => left = &left[at + part.len()..],
            None => return false,
        }
    }
    left.ends_with(tail)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn pass(name: &str, state: PassState, counts: Counts) -> PassReport {
        PassReport { name: name.into(), state, why: "of its reason".into(), counts, gpu_ms: None, cpu_ms: 0.0 }
    }

    fn report() -> FrameReport {
        let draws = |draws| Counts { draws, ..Counts::default() };
        let passes = vec![
            pass("gbuffer", PassState::Ran, draws(3)),
            pass("shadow Lamp#1", PassState::Ran, draws(2)),
            pass("shadow Sun#2", PassState::Cached, draws(0)),
            pass("propagate, cascade 0", PassState::Culled, draws(0)),
            pass("clpv", PassState::Skipped("off".into()), draws(0)),
        ];
        FrameReport { passes, ..FrameReport::default() }
    }

    fn faults(text: &str) -> Vec<String> {
        let (_, expected) =
            lightwell::files::Document::parse::<FrameExpectation>("t".as_ref(), text.to_owned()).unwrap();
        check(&expected, &report())
    }

    #[test]
    fn what_is_as_expected_is_no_fault() {
        let text = r#"(ran: ["gbuffer", "shadow L*"], cached: ["shadow S*"], culled: ["propagate*"], skipped: ["clpv"],
            not_run: ["rsm*", "clpv"], counts: {"shadow*": (draws: 2), "*": (draws: (max: 5))})"#;
        assert_eq!(faults(text), Vec::<String>::new());
    }

    #[test]
    fn what_is_not_is_told_with_the_reason() {
        for (text, words) in [
            (r#"(ran: ["shadow*"])"#, vec!["`shadow Sun#2` should have run, but was cached: of its reason"]),
            (r#"(cached: ["gbuffer"])"#, vec!["`gbuffer` should be cached, but ran: of its reason"]),
            (r#"(culled: ["clpv"])"#, vec!["`clpv` should be culled, but was skipped"]),
            (r#"(skipped: ["gbuffer"])"#, vec!["`gbuffer` should be skipped, but ran"]),
            (r#"(not_run: ["sha*", "gbuffer"])"#, vec!["`shadow Lamp#1` should not have run", "`gbuffer` should not"]),
            ("(idle: true)", vec!["`gbuffer` did", "`shadow Lamp#1` did"]),
            (r#"(counts: {"gbuffer": (draws: 4)})"#, vec!["`gbuffer` did 3 draws, not 4"]),
            (r#"(ran: ["gbufer"])"#, vec!["no such pass; did you mean `gbuffer`?"]),
            (r#"(ran: ["tone map"])"#, vec!["no such pass; known here: `gbuffer`, `shadow Lamp#1`"]),
            (r#"(counts: {"rsm*": (draws: 0)})"#, vec!["no such pass"]),
        ] {
            let found = faults(text);
            assert_eq!(found.len(), words.len(), "{text}: {found:?}");
            assert!(found.iter().zip(&words).all(|(fault, words)| fault.contains(words)), "{text}: {found:?}");
        }
    }

    #[test]
    fn stars_match_any_text() {
        for (pattern, name, expected) in [
            ("*", "", true),
            ("a*", "abc", true),
            ("*c", "abc", true),
            ("a*c", "ac", true),
            ("a*b*c", "axbyc", true),
            ("a*b*c", "acb", false),
            ("ab*b", "ab", false),
            ("abc", "ab", false),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
    }
}
