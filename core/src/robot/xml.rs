//! Strict reading of attributes: every number must be a finite number, and every complaint has its line.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::RobotError;

/// Parses the file and checks that it is a `<robot>`.
pub(super) fn parse<'a>(file: &'static str, xml: &'a str) -> Result<Document<'a>, RobotError> {
    let document = Document::parse(xml).map_err(|error| RobotError::Xml { file, message: error.to_string() })?;
    let root = document.root_element();
    if !root.has_tag_name("robot") {
        let found = root.tag_name().name().to_owned();
        return Err(RobotError::NotARobot { file, line: line(root), found });
    }
    Ok(document)
}

/// Line on which the element starts, from 1.
pub(super) fn line(node: Node<'_, '_>) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The child elements of this name.
pub(super) fn children<'a, 'd>(node: Node<'a, 'd>, name: &'static str) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The first child element of this name.
pub(super) fn child<'a, 'd>(node: Node<'a, 'd>, name: &'static str) -> Option<Node<'a, 'd>> {
    children(node, name).next()
}

/// An attribute that must be there and not be empty.
pub(super) fn text<'a>(node: Node<'a, '_>, attribute: &str, thing: &str) -> Result<&'a str, RobotError> {
    match node.attribute(attribute) {
        Some(value) if !value.trim().is_empty() => Ok(value.trim()),
        _ => {
            Err(RobotError::Missing {
                line: line(node), thing: thing.to_owned(), wanted: format!("{attribute}=\"…\"")
            })
        }
    }
}

/// `N` finite numbers, or `None` when the attribute is absent.
pub(super) fn numbers<const N: usize>(
    node: Node<'_, '_>,
    attribute: &str,
    thing: &str,
) -> Result<Option<[f64; N]>, RobotError> {
    let Some(found) = node.attribute(attribute) else { return Ok(None) };
    let parsed: Option<Vec<f64>> =
        found.split_whitespace().map(|word| word.parse().ok().filter(|value: &f64| value.is_finite())).collect();
    match parsed.and_then(|values| <[f64; N]>::try_from(values).ok()) {
        Some(values) => Ok(Some(values)),
        None => Err(bad(
            node,
            attribute,
            thing,
            match N {
                1 => "one finite number",
                3 => "three finite numbers",
                4 => "four finite numbers",
                _ => "finite numbers",
            },
        )),
    }
}

/// One finite number, or `None` when the attribute is absent.
pub(super) fn number(node: Node<'_, '_>, attribute: &str, thing: &str) -> Result<Option<f64>, RobotError> {
    Ok(numbers::<1>(node, attribute, thing)?.map(|[value]| value))
}

/// One number greater than 0 that must be there.
pub(super) fn positive(node: Node<'_, '_>, attribute: &str, thing: &str) -> Result<f64, RobotError> {
    text(node, attribute, thing)?;
    match number(node, attribute, thing)? {
        Some(value) if value > 0.0 => Ok(value),
        _ => Err(bad(node, attribute, thing, "a number greater than 0")),
    }
}

/// The error for an attribute's value.
pub(super) fn bad(node: Node<'_, '_>, attribute: &str, thing: &str, wanted: &'static str) -> RobotError {
    RobotError::BadValue {
        line: line(node),
        thing: thing.to_owned(),
        attribute: attribute.to_owned(),
        found: node.attribute(attribute).unwrap_or_default().to_owned(),
        wanted,
    }
}

/// The pose in the `<origin>` child; identity when there is none. `rpy` turns about the fixed axes x, then y, then z.
pub(super) fn origin(node: Node<'_, '_>, thing: &str) -> Result<Isometry3<f64>, RobotError> {
    let Some(origin) = child(node, "origin") else { return Ok(Isometry3::identity()) };
    let [x, y, z] = numbers(origin, "xyz", thing)?.unwrap_or_default();
    let rpy = numbers(origin, "rpy", thing)?.unwrap_or_default();
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), from_rpy(rpy)))
}

/// Turns about the fixed axes x, then y, then z, radians.
pub(super) fn from_rpy([roll, pitch, yaw]: [f64; 3]) -> UnitQuaternion<f64> {
    let about = |axis, angle: f64| {
        let (sin, cos) = crate::math::sin_cos(0.5 * angle);
        UnitQuaternion::from_quaternion(nalgebra::Quaternion::from_parts(cos, axis * sin))
    };
    about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll)
}
