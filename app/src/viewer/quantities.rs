//! How the numbers of a grasp are written: heads, units, digits.

use endcomfort_core::grasp::Quantity;

use super::format;

/// The head of a column: a letter with a smaller one set low, then more text.
pub(super) fn head(quantity: Quantity) -> (&'static str, &'static str, &'static str) {
    match quantity {
        Quantity::MgStart => ("m", "g", "start"),
        Quantity::MgGoal => ("m", "g", "goal"),
        Quantity::MgMean => ("m", "g", "mean"),
        Quantity::IkStart => ("N", "", "start"),
        Quantity::IkGoal => ("N", "", "goal"),
        Quantity::Score => ("score", "", ""),
        Quantity::Epsilon => ("ε", "", ""),
        Quantity::Volume => ("volume", "", ""),
        Quantity::Success => ("P", "", "%"),
        Quantity::Clearance => ("clear", "", "mm"),
        Quantity::Width => ("wide", "", "mm"),
        Quantity::Contacts => ("contacts", "", ""),
    }
}

/// A few words for lists: `m_g at the goal`.
pub(super) fn short(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::MgStart => "m_g at the start",
        Quantity::MgGoal => "m_g at the goal",
        Quantity::MgMean => "m_g, mean of both",
        Quantity::IkStart => "N at the start",
        Quantity::IkGoal => "N at the goal",
        Quantity::Score => "Weighted score",
        Quantity::Epsilon => "Quality ε",
        Quantity::Volume => "Wrench space volume",
        Quantity::Success => "Success probability",
        Quantity::Clearance => "Clearance",
        Quantity::Width => "Width",
        Quantity::Contacts => "Contacts",
    }
}

/// Width of a column, points.
pub(super) fn width(quantity: Quantity) -> f32 {
    match quantity {
        Quantity::MgStart | Quantity::MgGoal | Quantity::MgMean => 50.0,
        Quantity::IkStart | Quantity::IkGoal => 42.0,
        Quantity::Score | Quantity::Epsilon | Quantity::Success => 38.0,
        Quantity::Volume => 58.0,
        Quantity::Clearance => 54.0,
        Quantity::Width => 54.0,
        Quantity::Contacts => 52.0,
    }
}

/// The unit in which a person reads it, and how many of it are one SI unit.
pub fn unit(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::Success => ("%", 100.0),
        Quantity::Clearance | Quantity::Width => ("mm", 1e3),
        _ => ("", 1.0),
    }
}

/// A value in a column, its unit left to the head.
pub(super) fn cell(quantity: Quantity, value: Option<f64>) -> String {
    let Some(value) = value.filter(|value| value.is_finite()) else { return "–".to_owned() };
    match quantity {
        Quantity::MgStart | Quantity::MgGoal | Quantity::MgMean => format::manipulability(value),
        Quantity::Score | Quantity::Epsilon => format!("{value:.2}"),
        Quantity::Volume => format::significant(value),
        _ => format!("{:.0}", value * unit(quantity).1),
    }
}
