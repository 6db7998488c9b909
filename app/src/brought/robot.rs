//! Robots that people bring, with the hand that one without fingers is given.

use endcomfort_core::guest::{Files, GuestRobot, Proposal, Wishes, propose};
use endcomfort_core::library::LibraryError;
use endcomfort_core::robot::HandDescription;
use endcomfort_core::scene::TableTop;

use crate::assets;

/// The hand of `robots/hands/` that an arm without fingers is given: a parallel gripper.
pub const DEFAULT_HAND: &str = "pg70";

/// The robot among files, with everything that was found about it.
///
/// * `hand`: what an arm without fingers is given; the parallel gripper if nothing.
///
/// # Errors
/// A sentence when there is no robot, or its files are wrong.
pub fn proposed(
    files: &Files,
    wishes: &Wishes,
    table: &TableTop,
    hand: Option<&HandDescription>,
) -> Result<Proposal, String> {
    let library = assets::library();
    let built_in;
    let hand = match hand {
        Some(hand) => hand,
        None => {
            built_in = library.hand(DEFAULT_HAND).map_err(|error: LibraryError| error.to_string())?;
            &built_in
        }
    };
    propose(files, wishes, table, hand, &|uri: &str| library.mesh(uri)).map_err(|error| error.to_string())
}

/// The robot with a place and a start posture where its description has none.
///
/// # Errors
/// A sentence when its files do not fit its description.
pub fn settled(guest: GuestRobot, table: &TableTop) -> Result<(GuestRobot, Vec<String>), String> {
    let library = assets::library();
    guest.settled(table, &|uri: &str| library.mesh(uri)).map_err(|error| error.to_string())
}
