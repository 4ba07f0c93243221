//! The debug check of keys: a pass with the key of an earlier execution must bind what that one bound.

use super::error::GraphError;
use super::key::Recipe;
use crate::gpu::Note;
use std::collections::HashMap;

/// The bindings of passes, by the keys that must cover them.
#[derive(Debug, Default)]
pub(super) struct Audited {
    bound: HashMap<Recipe, Vec<Note>>,
}

impl Audited {
    /// Compares what a pass has bound with what it bound under the same key before. Passes without a key run in every
    /// frame, so that there is nothing to check.
    ///
    /// # Errors
    /// [`GraphError::Key`] names the first input that differs.
    pub fn check(&mut self, recipe: &Recipe, notes: Vec<Note>) -> Result<(), GraphError> {
        if recipe.own.is_none() || recipe.inputs.iter().any(|(_, key)| key.is_none()) {
            return Ok(());
        }
        let Some(before) = self.bound.get(recipe) else {
            self.bound.insert(recipe.clone(), notes);
            return Ok(());
        };
        match difference(before, &notes) {
            Some(input) => Err(GraphError::Key { pass: recipe.pass.clone(), input }),
            None => Ok(()),
        }
    }
}

fn difference(before: &[Note], now: &[Note]) -> Option<String> {
    let differs = before.iter().zip(now).find(|(before, now)| before != now);
    match differs {
        Some(((then, _), (name, _))) if then == name => Some(format!("what it binds as `{name}`")),
        Some(((then, _), (name, _))) => Some(format!("what makes it bind `{name}` in place of `{then}`")),
        None if before.len() != now.len() => {
            let longer = if before.len() > now.len() { before } else { now };
            let (name, _) = &longer[before.len().min(now.len())];
            Some(format!("what makes it bind `{name}` or not ({} resources before, {} now)", before.len(), now.len()))
        }
        None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(own: Option<u64>, input: Option<u64>) -> Recipe {
        Recipe { pass: "shade".into(), seed: 0, own, inputs: vec![("lights".into(), input)] }
    }

    fn notes(values: &[(&str, u64)]) -> Vec<Note> {
        values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    }

    fn input(result: Result<(), GraphError>) -> Option<String> {
        match result {
            Err(GraphError::Key { pass, input }) if pass == "shade" => Some(input),
            _ => None,
        }
    }

    #[test]
    fn another_input_under_the_same_key_is_found() {
        let mut audited = Audited::default();
        let first = notes(&[("view", 1), ("light", 2)]);
        assert!(audited.check(&recipe(Some(1), Some(1)), first.clone()).is_ok());
        assert!(audited.check(&recipe(Some(1), Some(1)), first.clone()).is_ok());
        let changed = audited.check(&recipe(Some(1), Some(1)), notes(&[("view", 1), ("light", 3)]));
        assert_eq!(input(changed).as_deref(), Some("what it binds as `light`"));
        let fewer = input(audited.check(&recipe(Some(1), Some(1)), notes(&[("view", 1)])));
        assert!(fewer.is_some_and(|what| what.contains("`light` or not (2 resources before, 1 now)")));
        // Another key, of its own or of an input, may bind what it likes; a volatile pass too.
        for other in [recipe(Some(2), Some(1)), recipe(Some(1), Some(2)), recipe(None, Some(1)), recipe(Some(1), None)]
        {
            assert!(audited.check(&other, notes(&[("view", 7)])).is_ok());
        }
    }
}
