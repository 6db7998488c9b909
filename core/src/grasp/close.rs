//! Closing a hand on a superquadric: each finger until it touches, proximal joint first, then what it touches.

use nalgebra::{Isometry3, Point3};

use super::{Contact, HandModel};
use crate::superquadric::Superquadric;

/// How far rubber pads and packaging give, metres: surfaces this close after closing count as touching.
pub const PAD_GIVE_M: f64 = 0.002;
/// Two contacts of one link are at least this far apart, metres: closer ones are one patch.
const CONTACT_SPACING_M: f64 = 0.008;
/// Contacts kept per link, the firmest first.
const CONTACTS_PER_LINK: usize = 4;
/// Steps of the walk from open to closed; the last one is then halved until it is below a tenth of a millimetre.
const CLOSING_STEPS: usize = 24;
const HALVINGS: usize = 8;

/// How deep the hand is inside the object: the worst link and its depth, metres; negative depths are gaps.
pub fn deepest(
    hand: &HandModel,
    X_HL: &[Isometry3<f64>],
    X_OH: &Isometry3<f64>,
    object: &Superquadric,
    only: impl Fn(usize) -> bool,
) -> (usize, f64) {
    let mut worst = (0, f64::NEG_INFINITY);
    for (index, (link, X_HL)) in hand.links.iter().zip(X_HL).enumerate() {
        if !only(index) {
            continue;
        }
        let X_OL = X_OH * X_HL;
        for (center, radius) in &link.spheres {
            let depth = radius - object.signed_distance(&(X_OL * center));
            if depth > worst.1 {
                worst = (index, depth);
            }
        }
    }
    worst
}

/// Finger positions after closing from the open posture.
///
/// Every joint of a finger, proximal first, turns towards its closed position until a link that it moves touches.
pub fn close(hand: &HandModel, X_OH: &Isometry3<f64>, object: &Superquadric) -> Vec<f64> {
    let mut positions = hand.open.clone();
    for &value in hand.fingers.iter().flatten() {
        let (open, closed) = (hand.open[value], hand.closed[value]);
        let touches = |fraction: f64, positions: &mut Vec<f64>| {
            positions[value] = open + fraction * (closed - open);
            let X_HL = hand.link_poses(positions);
            deepest(hand, &X_HL, X_OH, object, |link| hand.links[link].moved_by.contains(&value)).1 > 0.0
        };
        let mut free = 0.0;
        let mut met = None;
        for step in 1..=CLOSING_STEPS {
            let fraction = step as f64 / CLOSING_STEPS as f64;
            if touches(fraction, &mut positions) {
                met = Some(fraction);
                break;
            }
            free = fraction;
        }
        if let Some(mut met) = met {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (free + met);
                if touches(middle, &mut positions) {
                    met = middle;
                } else {
                    free = middle;
                }
            }
        }
        positions[value] = open + free * (closed - open);
    }
    positions
}

/// Where the closed hand touches the object: points of the object's surface, at most four per link.
pub fn contacts(hand: &HandModel, positions: &[f64], X_OH: &Isometry3<f64>, object: &Superquadric) -> Vec<Contact> {
    let X_HL = hand.link_poses(positions);
    let mut contacts = Vec::new();
    for (link, X_HL) in hand.links.iter().zip(&X_HL) {
        let X_OL = X_OH * X_HL;
        let mut near: Vec<(f64, Point3<f64>)> = link
            .spheres
            .iter()
            .filter_map(|(center, radius)| {
                let p_O = X_OL * center;
                let gap = object.signed_distance(&p_O) - radius;
                (gap < PAD_GIVE_M).then_some((gap, p_O))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first = contacts.len();
        for (_, p_O) in near {
            let (distance_m, n_O) = object.signed_distance_and_normal(&p_O);
            let surface = p_O - n_O * distance_m;
            let taken: &[Contact] = &contacts[first..];
            if taken.len() < CONTACTS_PER_LINK
                && taken.iter().all(|c| (c.p_O - surface).norm() >= CONTACT_SPACING_M)
            {
                contacts.push(Contact { p_O: surface, n_O, link: link.name.clone() });
            }
        }
    }
    contacts
}
