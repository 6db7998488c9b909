//! What a person does with keys and fingers, through the browser's own input.

use anyhow::Result;
use serde_json::{Value, json};

use super::Browser;

/// The key that holds a chord.
pub const CONTROL: &str = "\u{e009}";
/// Enter.
pub const ENTER: &str = "\u{e007}";
/// Escape.
pub const ESCAPE: &str = "\u{e00c}";

/// Time that a key or a finger stays down, and between two moves, milliseconds.
const PAUSE_MS: u32 = 80;
/// Moves of one drag.
const MOVES: i32 = 8;

impl Browser {
    /// Presses keys one after the other: a character each, or one of the names above.
    ///
    /// # Errors
    /// When the browser does not take them.
    pub fn press(&self, keys: &[&str]) -> Result<()> {
        let mut actions = Vec::new();
        for key in keys {
            actions.push(json!({ "type": "keyDown", "value": key }));
            actions.push(json!({ "type": "pause", "duration": PAUSE_MS }));
            actions.push(json!({ "type": "keyUp", "value": key }));
            actions.push(json!({ "type": "pause", "duration": PAUSE_MS }));
        }
        self.perform(&[json!({ "type": "key", "id": "keys", "actions": actions })])
    }

    /// Presses a key while another one is held.
    ///
    /// # Errors
    /// As [`Browser::press`].
    pub fn chord(&self, held: &str, key: &str) -> Result<()> {
        let down = |value: &str| json!({ "type": "keyDown", "value": value });
        let up = |value: &str| json!({ "type": "keyUp", "value": value });
        let actions = [down(held), down(key), json!({ "type": "pause", "duration": PAUSE_MS }), up(key), up(held)];
        self.perform(&[json!({ "type": "key", "id": "keys", "actions": actions })])
    }

    /// Moves fingers over the page at the same time, each from one point to another, in CSS pixels.
    ///
    /// # Errors
    /// When the browser does not take them.
    pub fn touch(&self, fingers: &[([i32; 2], [i32; 2])]) -> Result<()> {
        let place = |at: [i32; 2]| json!({ "type": "pointerMove", "duration": 0, "x": at[0], "y": at[1] });
        let pause = || json!({ "type": "pause", "duration": PAUSE_MS });
        let finger = |(id, (from, to)): (usize, &([i32; 2], [i32; 2]))| {
            let mut actions = vec![place(*from), json!({ "type": "pointerDown", "button": 0 }), pause()];
            for step in 1..=MOVES {
                let along = |k: usize| from[k] + (to[k] - from[k]) * step / MOVES;
                actions.push(place([along(0), along(1)]));
                actions.push(pause());
            }
            actions.push(json!({ "type": "pointerUp", "button": 0 }));
            let parameters = json!({ "pointerType": "touch" });
            json!({ "type": "pointer", "id": format!("finger {id}"), "parameters": parameters, "actions": actions })
        };
        let sources: Vec<Value> = fingers.iter().enumerate().map(finger).collect();
        self.perform(&sources)
    }

    fn perform(&self, sources: &[Value]) -> Result<()> {
        self.command("POST", "/actions", &json!({ "actions": sources }))?;
        Ok(())
    }
}
