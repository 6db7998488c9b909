//! Closing a hand on an object: each finger until it touches, proximal joint first, then what it touches.

use nalgebra::{Isometry3, Point3};

use super::bodies::Bodies;
use super::{Contact, HandModel};

/// How far rubber pads and packaging give, metres: surfaces this close after closing count as touching.
pub(super) const PAD_GIVE_M: f64 = 0.002;
/// Two contacts of one link are at least this far apart, metres: closer ones are one patch.
const CONTACT_SPACING_M: f64 = 0.008;
/// Contacts kept per link, the firmest first.
const CONTACTS_PER_LINK: usize = 4;
/// A link this close to the object touches it, metres: far below what a pad gives.
const TOUCH_M: f64 = 1e-4;
/// Gaps below this are measured with the tight distance, metres: a loose one would stop a finger in the air.
const NEAR_M: f64 = 0.003;
/// Gaps beyond this need not be known well, metres: about the size of a patch.
const FAR_M: f64 = 0.02;
/// Gaps below this are crossed by trying, metres: nothing that a hand holds is thinner.
const STRIDE_M: f64 = 0.0015;
/// Advances of one joint at most; each is as long as the gap allows, so ten are usual.
const MAX_ADVANCES: usize = 400;

/// How deep the hand is inside the object: the worst link and its depth, metres; negative depths are gaps.
///
/// Only depths above `floor_m` count: when there is none, the answer has that depth and link 0. A gap beyond
/// [`FAR_M`] is told as that of the balls around the nearest spheres, which is smaller.
pub(super) fn deepest(
    hand: &HandModel,
    X_HL: &[Isometry3<f64>],
    X_OH: &Isometry3<f64>,
    object: &Bodies,
    floor_m: f64,
    only: impl Fn(usize) -> bool,
) -> (usize, f64) {
    let mut worst = (0, floor_m);
    // The signed distance is a lower bound, so a ball that is clear of the object clears all it holds.
    let depth_of = |X_OL: &Isometry3<f64>, (center, radius): &(Point3<f64>, f64)| {
        radius - object.signed_distance(&(X_OL * center))
    };
    for (index, (link, X_HL)) in hand.links.iter().zip(X_HL).enumerate() {
        if !only(index) {
            continue;
        }
        let X_OL = X_OH * X_HL;
        if depth_of(&X_OL, &link.ball) < worst.1 {
            continue;
        }
        for patch in &link.patches {
            let depth = depth_of(&X_OL, &patch.ball);
            if depth < worst.1 {
                continue;
            }
            if depth < -FAR_M {
                worst = (index, depth);
                continue;
            }
            for (center, radius) in &patch.spheres {
                let p_O = X_OL * center;
                let mut depth = radius - object.signed_distance(&p_O);
                if depth > worst.1 && depth > -NEAR_M {
                    depth = radius - object.near_distance(&p_O);
                }
                if depth > worst.1 {
                    worst = (index, depth);
                }
            }
        }
    }
    worst
}

/// Finger positions after closing from the open posture.
///
/// Every joint of a finger, proximal first, turns towards its closed position until a link that it moves touches. The
/// gap to the object is a lower bound, and no point moves faster than the joint's lever: so the joint may advance by
/// gap / lever without passing the first contact (conservative advancement, Mirtich 1996). Once the gap is small, it
/// takes [`STRIDE_M`] at a time, and where that goes too far the touch is found by halving.
pub(super) fn close(hand: &HandModel, X_OH: &Isometry3<f64>, object: &Bodies) -> Vec<f64> {
    let mut positions = hand.open.clone();
    let mut X_HL = Vec::new();
    for &value in hand.fingers.iter().flatten() {
        let (open, closed) = (hand.open[value], hand.closed[value]);
        let (lever, sense) = (hand.lever(value), (closed - open).signum());
        let moved = |link: usize| hand.links[link].moved_by.contains(&value);
        // The gap after this much of the way, exact unless it is larger than `enough_m`.
        let mut gap_m = |positions: &mut [f64], way: f64, enough_m: f64| {
            positions[value] = open + sense * way;
            hand.link_poses_into(positions, &mut X_HL);
            -deepest(hand, &X_HL, X_OH, object, -enough_m, moved).1
        };
        let whole = (closed - open).abs();
        let mut way = 0.0;
        let mut gap = gap_m(&mut positions, way, whole * lever + TOUCH_M);
        for _ in 0..MAX_ADVANCES {
            if gap < TOUCH_M || way >= whole {
                break;
            }
            let next = (way + gap.max(STRIDE_M) / lever).min(whole);
            gap = gap_m(&mut positions, next, (whole - next) * lever + TOUCH_M);
            if gap < 0.0 {
                way = first_touch(way, next, TOUCH_M / lever, |way| gap_m(&mut positions, way, TOUCH_M) < 0.0);
                break;
            }
            way = next;
        }
        positions[value] = open + sense * way;
    }
    positions
}

/// The last way that touches nothing, between a free one and one that is too far, to within `tolerance`.
fn first_touch(mut free: f64, mut blocked: f64, tolerance: f64, mut is_blocked: impl FnMut(f64) -> bool) -> f64 {
    while blocked - free > tolerance {
        let middle = 0.5 * (free + blocked);
        if is_blocked(middle) {
            blocked = middle;
        } else {
            free = middle;
        }
    }
    free
}

/// Where the closed hand touches the object: points of the object's surface, at most four per link.
pub(super) fn contacts(hand: &HandModel, positions: &[f64], X_OH: &Isometry3<f64>, object: &Bodies) -> Vec<Contact> {
    let X_HL = hand.link_poses(positions);
    let mut contacts = Vec::new();
    for (link, X_HL) in hand.links.iter().zip(&X_HL) {
        let X_OL = X_OH * X_HL;
        if object.signed_distance(&(X_OL * link.ball.0)) > link.ball.1 + PAD_GIVE_M {
            continue;
        }
        let mut near: Vec<(f64, Point3<f64>, f64)> = Vec::new();
        for patch in &link.patches {
            if object.signed_distance(&(X_OL * patch.ball.0)) > patch.ball.1 + PAD_GIVE_M {
                continue;
            }
            near.extend(patch.spheres.iter().filter_map(|(center, radius)| {
                let p_O = X_OL * center;
                let gap = object.signed_distance(&p_O) - radius;
                (gap < PAD_GIVE_M).then_some((gap, p_O, *radius))
            }));
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let first = contacts.len();
        for (_, p_O, radius_m) in near {
            if contacts.len() - first == CONTACTS_PER_LINK {
                break;
            }
            // The foot is within the pad's give of the sphere: too near to another contact, whatever it is.
            let apart = |c: &Contact| (c.p_O - p_O).norm() + radius_m + PAD_GIVE_M;
            if contacts[first..].iter().any(|c| apart(c) < CONTACT_SPACING_M) {
                continue;
            }
            let Some(foot) = object.contact(&p_O, radius_m, PAD_GIVE_M) else { continue };
            if contacts[first..].iter().all(|c: &Contact| (c.p_O - foot.p_F).norm() >= CONTACT_SPACING_M) {
                let penetration_m = radius_m - (p_O - foot.p_F).dot(&foot.n_F);
                contacts.push(Contact { p_O: foot.p_F, n_O: foot.n_F, penetration_m, link: link.name.clone() });
            }
        }
    }
    contacts
}
