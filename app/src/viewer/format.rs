//! Numbers and words as a person reads them: three significant digits, a unit beside every number.

use endcomfort_core::grasp::{Grasp, GraspStatus};
use nalgebra::Isometry3;

/// Three significant digits; whole numbers from 1000 on, in groups of three.
pub(super) fn significant(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "–".to_owned();
    }
    if size >= 999.5 {
        let sign = if value < 0.0 { "–" } else { "" };
        return format!("{sign}{}", count(size.round() as usize));
    }
    if size < 1e-4 {
        return if size == 0.0 { "0".to_owned() } else { format!("{value:.1e}") };
    }
    // Rounding may carry into a new digit (9.996 is 10.0), so the exponent is taken after it.
    let places = |v: f64| (2 - v.log10().floor() as i32).max(0) as usize;
    let first = places(size);
    let carried = 10_f64.powi(first as i32);
    let decimals = places((size * carried).round() / carried);
    format!("{value:.decimals$}")
}

/// A length, from metres: millimetres below one metre.
pub(super) fn length(metres: f64) -> String {
    if metres.abs() < 0.9995 {
        format!("{} mm", significant(metres * 1e3))
    } else {
        format!("{} m", significant(metres))
    }
}

/// A length in whole millimetres, from metres.
pub(super) fn millimetres(metres: f64) -> String {
    if metres.is_finite() { format!("{:.0} mm", metres * 1e3) } else { "–".to_owned() }
}

/// A length in tenths of a millimetre, from metres.
pub(super) fn millimetres_fine(metres: f64) -> String {
    format!("{:.1}\u{2009}mm", metres * 1e3)
}

/// A volume, from cubic metres: millilitres below ten litres.
pub(super) fn volume(cubic_metres: f64) -> String {
    if cubic_metres < 0.01 {
        format!("{} ml", significant(cubic_metres * 1e6))
    } else {
        format!("{} l", significant(cubic_metres * 1e3))
    }
}

/// A computing time, from milliseconds.
pub(super) fn elapsed(ms: f64) -> String {
    if !ms.is_finite() {
        "–".to_owned()
    } else if ms < 9.95 {
        format!("{ms:.1} ms")
    } else if ms < 999.5 {
        format!("{ms:.0} ms")
    } else {
        format!("{} s", significant(ms / 1e3))
    }
}

/// A time on the timeline, seconds with two digits behind the point.
pub(super) fn clock(seconds: f64) -> String {
    format!("{seconds:.2} s")
}

/// A manipulability, three digits behind the point as in the tables.
pub(super) fn manipulability(value: f64) -> String {
    if value.is_finite() { format!("{value:.3}") } else { "–".to_owned() }
}

/// A whole number in groups of three, set apart by thin spaces.
pub fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3 * 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// A number of things: `1 cluster`, `3 clusters`.
pub(super) fn plural(value: usize, thing: &str) -> String {
    format!("{} {thing}{}", count(value), if value == 1 { "" } else { "s" })
}

/// `first`, `2nd`, `3rd`, `4th`, …
pub(super) fn ordinal(n: usize) -> String {
    let ending = match (n % 10, n % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    if n == 1 { "first".to_owned() } else { format!("{n}{ending}") }
}

/// A name in a file (`mustard_bottle`) as a person reads it (`Mustard bottle`).
pub(super) fn title_of(name: &str) -> String {
    // What somebody brought has a fingerprint behind its name.
    let name = name.split('@').next().unwrap_or(name);
    let words = name.replace(['_', '-'], " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Along which line the fingers close, seen by the robot: `closes left–right`.
pub(super) fn closing(X_WH: &Isometry3<f64>) -> &'static str {
    let x = X_WH.rotation * nalgebra::Vector3::x();
    match x.iter().position(|along| along.abs() > 0.8) {
        Some(0) => "closes front–back",
        Some(1) => "closes left–right",
        Some(_) => "closes up–down",
        None => "closes aslant",
    }
}

/// From where the hand comes, seen by the robot: `from above`, `from left, 30° down`.
///
/// `X_WH` is the hand in the world; z of H is the approach direction. The robot stands at the origin and looks along
/// +x, its left is +y.
pub(super) fn approach(X_WH: &Isometry3<f64>) -> String {
    let z = X_WH.rotation * nalgebra::Vector3::z();
    let down_deg = (-z.z).max(-1.0).min(1.0).asin().to_degrees();
    if down_deg > 65.0 {
        return "from above".to_owned();
    }
    if down_deg < -65.0 {
        return "from below".to_owned();
    }
    let side = match (z.x.abs() >= z.y.abs(), z.x >= 0.0, z.y >= 0.0) {
        (true, true, _) => "from front",
        (true, false, _) => "from behind",
        (false, _, true) => "from right",
        (false, _, false) => "from left",
    };
    // Tens of degrees: finer would pretend that the sampling means more.
    let tens = (down_deg / 10.0).round() as i32 * 10;
    match tens {
        0 => side.to_owned(),
        1.. => format!("{side}, {tens}° down"),
        _ => format!("{side}, {}° up", -tens),
    }
}

/// The fate of a candidate in a few words.
pub(super) fn status_words(status: &GraspStatus) -> &'static str {
    match status {
        GraspStatus::Accepted => "Accepted",
        GraspStatus::TooWide { .. } => "Too wide for the hand",
        GraspStatus::HandInObject { .. } => "Hand inside the object",
        GraspStatus::TooFewContacts { .. } => "Too few contacts",
        GraspStatus::OneSided { .. } => "Touches one side only",
        GraspStatus::HitsTable { .. } => "Hits the table",
        GraspStatus::HitsNeighbour { .. } => "Hits a neighbour",
        GraspStatus::NoIkAtStart { .. } => "Out of reach at start",
        GraspStatus::NoIkAtStep { .. } => "Out of reach at a step",
        GraspStatus::NoWayAtStep { .. } => "No way on from a step",
        GraspStatus::NoIkAtGoal { .. } => "Out of reach at goal",
        GraspStatus::NoWayAtStart { .. } => "No way in or up at start",
        GraspStatus::NoWayAtGoal { .. } => "No way down or out at goal",
        GraspStatus::Unwanted { .. } => "Not wanted",
    }
}

/// Why a grasp stands where it stands: the reason of a rejected one, the approach of an accepted one.
pub(super) fn why(grasp: &Grasp, X_WO_start: Option<&Isometry3<f64>>) -> String {
    let reason = grasp.status.reason();
    match X_WO_start {
        _ if !reason.is_empty() => reason,
        Some(X_WO) => approach(&(X_WO * grasp.X_OH)),
        None => "usable".to_owned(),
    }
}

/// The end-comfort effect in words: how the mean manipulability at the goal compares with that at the start.
pub(super) fn comfort(grasp: &Grasp) -> Option<String> {
    let (start, goal) = (grasp.start.as_ref()?, grasp.goal.as_ref()?);
    let ratio = if start.m_g > 0.0 { goal.m_g / start.m_g } else { return None };
    Some(match ratio {
        1.05.. => format!("{ratio:.2} × the start, easier at the goal"),
        ..0.95 => format!("{ratio:.2} × the start, strained at the goal"),
        _ => "as at the start".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_significant_digits() {
        for (value, text) in [
            (0.093_21, "0.0932"),
            (38.44, "38.4"),
            (9.996, "10.0"),
            (123.4, "123"),
            (999.7, "1\u{2009}000"),
            (0.0, "0"),
            (-2.5, "-2.50"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(significant(value), text);
        }
        assert_eq!(count(6766), "6\u{2009}766");
        assert_eq!(count(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!(length(0.0712), "71.2 mm");
        assert_eq!(elapsed(1240.0), "1.24 s");
        assert_eq!(ordinal(3), "3rd");
        assert_eq!(ordinal(12), "12th");
    }

    #[test]
    fn the_approach_is_told_from_the_robots_side() {
        let towards = |axis: nalgebra::Vector3<f64>, angle: f64| Isometry3::rotation(axis * angle);
        // z_H turned by 180° about x points down: the hand comes from above.
        assert_eq!(approach(&towards(nalgebra::Vector3::x(), std::f64::consts::PI)), "from above");
        // z_H along +x: the hand moves away from the robot, so it comes from the robot's side, the front.
        assert_eq!(approach(&towards(nalgebra::Vector3::y(), std::f64::consts::FRAC_PI_2)), "from front");
        // z_H along -y: the hand comes from +y, the left.
        assert_eq!(approach(&towards(nalgebra::Vector3::x(), std::f64::consts::FRAC_PI_2)), "from left");
        assert_eq!(
            approach(&towards(nalgebra::Vector3::y(), std::f64::consts::FRAC_PI_2 + 0.52)),
            "from front, 30° down"
        );
    }
}
