//! What a stage gave last time, and for which inputs.

use serde::Serialize;

/// The last value of a stage and the inputs that it was computed from.
#[derive(Debug)]
pub(super) struct Memory<T> {
    last: Option<(Vec<String>, T)>,
}

impl<T> Default for Memory<T> {
    fn default() -> Self {
        Self { last: None }
    }
}

impl<T> Memory<T> {
    /// The last value.
    pub(super) fn last(&self) -> Option<&T> {
        self.last.as_ref().map(|(_, value)| value)
    }

    /// The value for these inputs: the last one if they are the same, else a new one. A refusal is not kept.
    pub(super) fn get<E>(&mut self, inputs: Vec<String>, compute: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
        if self.last.as_ref().is_none_or(|(known, _)| *known != inputs) {
            self.last = None;
            self.last = Some((inputs, compute()?));
        }
        match &self.last {
            Some((_, value)) => Ok(value),
            None => unreachable!("a value was stored just above"),
        }
    }
}

/// An input as text; equal inputs give equal text.
pub(super) fn text(input: &impl Serialize) -> String {
    // Serialising plain data into a string cannot fail; if it ever did, the empty text would only mean recomputing.
    serde_json::to_string(input).unwrap_or_default()
}
