//! What a reader gives back: a value, and notes about what it left out.

use serde::{Deserialize, Serialize};

/// A value read from a file, with notes on whatever was dropped, repaired or ignored on the way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Loaded<T> {
    /// What was read.
    pub value: T,
    /// Sentences for a person, each naming place, thing and consequence.
    pub notes: Vec<String>,
}
