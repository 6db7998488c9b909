//! Links, session files and what is kept from visit to visit: a view that somebody else, or oneself later, opens again.
//!
//! Results are never stored: they follow from scene and seed, so whoever opens a link computes them again and gets the
//! same. A link names a demo and what differs from it, or holds a whole scene ([`content`]), and is packed to fit into
//! an address ([`packing`]). A session is the same as plain JSON with the whole scene and a dropped cloud's bytes.
//!
//! Not here: robots and maps, which travel with the program.

mod autosave;
mod content;
mod error;
mod open;
mod packing;
mod patch;
mod view;

pub(super) use autosave::Autosave;
pub use autosave::Offer;
pub(super) use content::is_session;
pub use content::{Opened, link_text, read_link, read_session, session_text};
pub use error::ShareError;
pub use view::SharedView;

#[cfg(test)]
mod tests;
