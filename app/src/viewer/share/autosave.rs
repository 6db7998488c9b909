//! What is kept from visit to visit, where the host has a place for it.

use serde_json::{Value, json};

use super::content::{self, session_json};
use super::{Opened, read_session};
use crate::clock;
use crate::host::{Entry, Store};
use crate::render::Camera;
use crate::viewer::{Demo, ViewerState};

/// It is written no more often than this, seconds.
const EVERY_S: f64 = 2.0;
/// A browser keeps about five million characters for a site: what is longer is written without the files that were brought.
const MAX_CHARACTERS: usize = 4_000_000;
/// What is older is not offered any more, seconds: 30 days.
const KEPT_FOR_S: f64 = 30.0 * 24.0 * 3600.0;

/// What stood on the page when it was left.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// What was open.
    pub title: String,
    /// How long ago that was, seconds.
    pub age_s: f64,
    /// The session.
    pub(in crate::viewer) opened: Opened,
}

/// Remembers what was written last.
#[derive(Default)]
pub(in crate::viewer) struct Autosave {
    revision: u64,
    written_s: f64,
}

impl Autosave {
    /// Starts with a state that nobody has edited.
    pub(in crate::viewer) fn new(revision: u64) -> Self {
        Self { revision, written_s: f64::NEG_INFINITY }
    }

    /// How long until a settled edit has to be written, seconds; `None` if there is none.
    pub(in crate::viewer) fn due_in_s(&self, state: &ViewerState, now_s: f64) -> Option<f64> {
        let is_settled = !state.running && !state.is_dragging_goal();
        (is_settled && state.revision != self.revision).then(|| (self.written_s + EVERY_S - now_s).max(0.0))
    }

    /// Writes what stands.
    pub(in crate::viewer) fn write(&mut self, state: &ViewerState, camera: Camera, now_s: f64, store: &mut dyn Store) {
        (self.revision, self.written_s) = (state.revision, now_s);
        // Base64 makes four characters of three bytes.
        let fits = content::brought_bytes(state) / 3 * 4 < MAX_CHARACTERS;
        let is_short = |text: &String| text.len() <= MAX_CHARACTERS;
        let whole = fits.then(|| record(state, camera, true)).flatten().filter(is_short);
        let text = whole.or_else(|| record(state, camera, false).filter(is_short));
        match text.map(|text| store.write(Entry::Session, &text)) {
            Some(Ok(())) => {}
            Some(Err(reason)) => log::warn!("what is open is not kept for the next visit: {reason}"),
            None => log::warn!("what is open is not kept for the next visit: it is too large"),
        }
    }
}

fn record(state: &ViewerState, camera: Camera, with_cloud: bool) -> Option<String> {
    let session = session_json(state, Some(camera), with_cloud).ok()?;
    let title = match &state.document.cloud {
        Some(cloud) if with_cloud => &cloud.name,
        _ => &state.document.scene.title,
    };
    Some(json!({ "title": title, "saved_unix_s": clock::unix_s(), "session": session }).to_string())
}

impl Offer {
    /// What the store holds, if it can be opened; what is wrong or old is dropped with a line in the log.
    pub(in crate::viewer) fn read(store: &mut dyn Store, demos: &[Demo]) -> Option<Self> {
        let text = store.read(Entry::Session)?;
        match Self::parse(&text, demos, clock::unix_s()) {
            Ok(offer) => Some(offer),
            Err(reason) => {
                log::warn!("what was kept from the last visit is dropped: {reason}");
                store.forget(Entry::Session);
                None
            }
        }
    }

    pub(super) fn parse(text: &str, demos: &[Demo], now_s: f64) -> Result<Self, String> {
        let mut record: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let saved_s = record["saved_unix_s"].as_f64().ok_or("it says no time")?;
        // A clock that was set back makes no difference worth a word.
        let age_s = (now_s - saved_s).max(0.0);
        if age_s > KEPT_FOR_S {
            return Err(format!("it is {:.0} days old", age_s / 86_400.0));
        }
        let title = record["title"].as_str().ok_or("it says no title")?.to_owned();
        let opened = read_session(record["session"].take(), demos).map_err(|error| error.to_string())?;
        Ok(Self { title, age_s, opened })
    }

    /// When it was left, in words: `12 minutes ago`.
    pub fn when(&self) -> String {
        let (count, unit) = match self.age_s {
            age_s if age_s < 90.0 => return "just now".to_owned(),
            age_s if age_s < 5400.0 => ((age_s / 60.0).round(), "minute"),
            age_s if age_s < 129_600.0 => ((age_s / 3600.0).round(), "hour"),
            age_s => ((age_s / 86_400.0).round(), "day"),
        };
        let plural = if count > 1.0 { "s" } else { "" };
        format!("{count:.0} {unit}{plural} ago")
    }
}
