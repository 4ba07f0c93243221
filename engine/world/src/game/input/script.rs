//! Recorded input.

use super::super::GameError;
use super::InputEvent;
use crate::files::{Document, FileError, FileErrorKind, Step, ron_options, write_atomically};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Input by steps: the same script plays the same game.
///
/// ```ron
/// Script(steps: 300, events: [
///     (1, Press(Key(Enter))),
///     (2, Release(Key(Enter))),
///     (10, Press(Key(W))),
/// ])
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename = "Script")]
pub struct InputScript {
    /// Length \[steps\].
    pub steps: u64,
    /// Events with the step that they belong to, counted from 1, in order.
    pub events: Vec<(u64, InputEvent)>,
}

impl InputScript {
    /// Most steps of a script: a day and four hours at 100 a second.
    pub const MOST_STEPS: u64 = 10_000_000;

    /// Reads a script from its file.
    ///
    /// # Errors
    /// When there is no such file, or its events are not in order; with line and column.
    pub fn read(path: &Path) -> Result<Self, GameError> {
        Ok(Self::checked(Document::read::<Self>(path)?)?)
    }

    /// Reads a script from a text; `path` names it in errors.
    ///
    /// # Errors
    /// As [`InputScript::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, GameError> {
        Ok(Self::checked(Document::parse::<Self>(path, text.to_owned())?)?)
    }

    fn checked((document, script): (Document, Self)) -> Result<Self, FileError> {
        if script.steps > Self::MOST_STEPS {
            let message = format!("{} steps are too many: at most {} are played", script.steps, Self::MOST_STEPS);
            let error = document.error(&[Step::Key("steps".into())], FileErrorKind::Budget, message);
            return Err(error.with_help("a script lasts as long as its last event, and a little longer"));
        }
        let mut last = 1;
        for (index, (step, _)) in script.events.iter().enumerate() {
            let wrong = match *step {
                step if step < last => format!("step {step} comes after step {last}: give the events in order, from 1"),
                step if step > script.steps => format!("step {step} is behind the end, `steps: {}`", script.steps),
                _ => {
                    last = *step;
                    continue;
                }
            };
            return Err(document.error(
                &[Step::Key("events".into()), Step::Index(index)],
                FileErrorKind::BadValue,
                wrong,
            ));
        }
        Ok(script)
    }

    /// Adds the events of the next step.
    pub fn record(&mut self, events: &[InputEvent]) {
        self.steps += 1;
        self.events.extend(events.iter().map(|event| (self.steps, *event)));
    }

    /// The events of a step.
    pub fn at(&self, step: u64) -> Vec<InputEvent> {
        let first = self.events.partition_point(|(at, _)| *at < step);
        self.events[first..].iter().take_while(|(at, _)| *at == step).map(|(_, event)| *event).collect()
    }

    /// Writes it, in one step.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), GameError> {
        let pretty = ron::ser::PrettyConfig::new().depth_limit(2);
        let text = ron_options().to_string_pretty(self, pretty);
        let text = text.map_err(|error| FileError::new(path, FileErrorKind::Unsavable, error.to_string()))?;
        Ok(write_atomically(path, &text)?)
    }
}
