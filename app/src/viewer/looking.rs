//! Looking closely: what colours the points and how large they are, a plane that cuts the view open, and distances and
//! angles measured in it.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::{Effect, ViewerState, format};
use crate::render::Cut;

/// Diameters of the points, millimetres: least, most, and the usual one.
pub(super) const POINT_MM: [f64; 3] = [0.5, 10.0, 2.2];

/// What colours the points of the cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CloudColor {
    /// What became of each: its cluster, the table, rejected.
    #[default]
    Fate,
    /// The colours that came with the cloud.
    Own,
    /// Height above the floor.
    Height,
    /// Distance from the camera.
    Distance,
}

impl CloudColor {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Fate, Self::Own, Self::Height, Self::Distance];

    /// What a person reads.
    pub fn title(self) -> &'static str {
        match self {
            Self::Fate => "What became of them",
            Self::Own => "Their own colours",
            Self::Height => "Height",
            Self::Distance => "Distance from the camera",
        }
    }
}

/// How the points of the cloud are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CloudLook {
    /// What colours them.
    pub by: CloudColor,
    /// Diameter, metres.
    pub diameter_m: f32,
}

impl Default for CloudLook {
    fn default() -> Self {
        Self { by: CloudColor::default(), diameter_m: (1e-3 * POINT_MM[2]) as f32 }
    }
}

/// How closely the view is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looking {
    /// How points are drawn.
    pub cloud: CloudLook,
    /// What is taken away.
    pub cut: Option<Cut>,
    /// The points between which it is measured, at most three; `None` while nobody measures.
    pub measured: Option<Vec<Point3<f64>>>,
}

/// What a person does to look closely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookCommand {
    /// Colours the points by something else.
    Color(CloudColor),
    /// Sets their diameter, millimetres.
    PointSize(f64),
    /// Cuts the view, or not.
    Cut(Option<Cut>),
    /// Starts to measure, or ends it.
    Measure(bool),
    /// Measures to a point of the world.
    Point(Point3<f64>),
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// From the first point to the second, metres.
    Distance(f64),
    /// At the second point between the other two, radians.
    Angle(f64),
}

impl Measured {
    /// What lies between two points, or at the second of three; `None` while there are fewer, or where two are one.
    pub fn of(points: &[Point3<f64>]) -> Option<Self> {
        match points {
            [a, b] => Some(Self::Distance((b - a).norm())),
            [a, b, c] => {
                let (u, v) = (a - b, c - b);
                (u.norm() > 0.0 && v.norm() > 0.0).then(|| Self::Angle(u.angle(&v)))
            }
            _ => None,
        }
    }

    /// `143.2 mm`, `37.4°`
    pub fn words(self) -> String {
        match self {
            Self::Distance(m) => format::millimetres_fine(m),
            Self::Angle(rad) => format!("{:.1}°", rad.to_degrees()),
        }
    }
}

impl ViewerState {
    pub(super) fn apply_look(&mut self, command: LookCommand) -> Vec<Effect> {
        let looking = &mut self.looking;
        match command {
            LookCommand::Color(by) => looking.cloud.by = by,
            LookCommand::PointSize(mm) => {
                looking.cloud.diameter_m = (1e-3 * mm.max(POINT_MM[0]).min(POINT_MM[1])) as f32;
            }
            LookCommand::Cut(cut) => looking.cut = cut.filter(|cut| cut.at_m.is_finite()),
            LookCommand::Measure(wanted) => looking.measured = wanted.then(Vec::new),
            LookCommand::Point(p_W) => {
                let Some(points) = &mut looking.measured else { return Vec::new() };
                if points.len() == 3 {
                    points.clear();
                }
                points.push(p_W);
                if let Some(measured) = Measured::of(points) {
                    return vec![Effect::Announce(measured.words())];
                }
            }
        }
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_give_a_distance_and_three_an_angle() {
        let [a, b, c] = [[0.3, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.4]].map(Point3::from);
        assert_eq!(Measured::of(&[a]), None);
        let Some(Measured::Distance(m)) = Measured::of(&[a, c]) else { panic!("no distance") };
        assert!((m - 0.5).abs() < 1e-15);
        let Some(Measured::Angle(rad)) = Measured::of(&[a, b, c]) else { panic!("no angle") };
        assert!((rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(Measured::of(&[a, a, c]), None);
        assert_eq!(Measured::Distance(0.1432).words(), "143.2\u{2009}mm");
        assert_eq!(Measured::Angle(0.5).words(), "28.6°");
    }
}
