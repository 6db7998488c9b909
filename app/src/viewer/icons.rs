//! Small icons drawn with lines, so that no icon font travels with the page.

use egui::{Color32, Painter, Pos2, Shape, Stroke, pos2, vec2};

/// What can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Icon {
    Play,
    Pause,
    StepBack,
    StepForth,
    Up,
    Loop,
    Eye,
    EyeOff,
    Check,
    Cross,
    Down,
    Left,
    Right,
    Camera,
    Undo,
    Redo,
    Sun,
    Moon,
    Help,
    Steps,
    Inspector,
    Frame,
    Warning,
    Note,
    File,
    Save,
    Follow,
    Present,
    Sliders,
    Link,
    Search,
}

/// Draws an icon in a square of `size` points around `centre`.
pub(super) fn paint(painter: &Painter, icon: Icon, centre: Pos2, size: f32, color: Color32) {
    let pen = Pen { painter, centre, scale: size / 16.0, color };
    match icon {
        Icon::Search => {
            pen.ring((7.0, 7.0), 4.2);
            pen.line(&[(10.2, 10.2), (13.2, 13.2)]);
        }
        Icon::Play => pen.fill(&[(4.5, 2.5), (13.5, 8.0), (4.5, 13.5)]),
        Icon::Pause => {
            pen.bar(4.0, 3.0, 3.0, 10.0);
            pen.bar(9.0, 3.0, 3.0, 10.0);
        }
        Icon::StepBack => {
            pen.fill(&[(12.5, 3.5), (5.5, 8.0), (12.5, 12.5)]);
            pen.bar(3.0, 3.5, 1.8, 9.0);
        }
        Icon::StepForth => {
            pen.fill(&[(3.5, 3.5), (10.5, 8.0), (3.5, 12.5)]);
            pen.bar(11.2, 3.5, 1.8, 9.0);
        }
        Icon::Up => pen.line(&[(4.0, 9.8), (8.0, 5.8), (12.0, 9.8)]),
        Icon::Loop => {
            pen.line(&[(3.0, 7.0), (3.0, 5.5), (4.5, 4.0), (12.5, 4.0)]);
            pen.line(&[(10.5, 2.0), (12.7, 4.0), (10.5, 6.0)]);
            pen.line(&[(13.0, 9.0), (13.0, 10.5), (11.5, 12.0), (3.5, 12.0)]);
            pen.line(&[(5.5, 10.0), (3.3, 12.0), (5.5, 14.0)]);
        }
        Icon::Eye | Icon::EyeOff => {
            pen.lid(1.0);
            pen.lid(-1.0);
            if icon == Icon::Eye {
                pen.disc((8.0, 8.0), 2.1);
            } else {
                pen.line(&[(3.0, 13.0), (13.0, 3.0)]);
            }
        }
        Icon::Check => pen.line(&[(3.5, 8.5), (6.7, 11.5), (12.5, 4.8)]),
        Icon::Cross => {
            pen.line(&[(4.0, 4.0), (12.0, 12.0)]);
            pen.line(&[(12.0, 4.0), (4.0, 12.0)]);
        }
        Icon::Down => pen.line(&[(4.0, 6.2), (8.0, 10.2), (12.0, 6.2)]),
        Icon::Left => pen.line(&[(9.8, 4.0), (5.8, 8.0), (9.8, 12.0)]),
        Icon::Right => pen.line(&[(6.2, 4.0), (10.2, 8.0), (6.2, 12.0)]),
        Icon::Camera => {
            pen.closed(&[
                (1.8, 5.0),
                (4.8, 5.0),
                (6.0, 3.0),
                (10.0, 3.0),
                (11.2, 5.0),
                (14.2, 5.0),
                (14.2, 13.0),
                (1.8, 13.0),
            ]);
            pen.ring((8.0, 8.8), 2.4);
        }
        Icon::Undo => {
            pen.line(&[(5.8, 3.2), (2.8, 6.2), (5.8, 9.2)]);
            pen.arc((9.2, 9.7), 3.5, -90.0, 90.0);
            pen.line(&[(2.8, 6.2), (9.2, 6.2)]);
            pen.line(&[(9.2, 13.2), (6.0, 13.2)]);
        }
        Icon::Redo => {
            pen.line(&[(10.2, 3.2), (13.2, 6.2), (10.2, 9.2)]);
            pen.arc((6.8, 9.7), 3.5, 90.0, 270.0);
            pen.line(&[(13.2, 6.2), (6.8, 6.2)]);
            pen.line(&[(6.8, 13.2), (10.0, 13.2)]);
        }
        Icon::Sun => {
            pen.ring((8.0, 8.0), 3.0);
            for step in 0..8 {
                let angle = step as f32 * std::f32::consts::FRAC_PI_4;
                let (sin, cos) = angle.sin_cos();
                pen.line(&[(8.0 + 5.0 * cos, 8.0 + 5.0 * sin), (8.0 + 6.6 * cos, 8.0 + 6.6 * sin)]);
            }
        }
        Icon::Moon => {
            // A disc of radius 5.6 bitten by one of 4.6; the angles are those where the two circles meet.
            let mut points = pen.arc_points((7.6, 8.4), 5.6, 9.3, 260.7);
            points.append(&mut pen.arc_points((10.4, 5.6), 4.6, 216.3, 53.7));
            pen.painter.add(Shape::closed_line(points, pen.stroke()));
        }
        Icon::Help => {
            pen.arc((8.0, 5.9), 2.9, -170.0, 60.0);
            pen.line(&[(9.4, 8.4), (8.1, 9.4), (8.0, 10.6)]);
            pen.disc((8.0, 13.0), 0.95);
        }
        Icon::Steps | Icon::Inspector => {
            pen.closed(&[(2.0, 3.0), (14.0, 3.0), (14.0, 13.0), (2.0, 13.0)]);
            let x = if icon == Icon::Steps { 6.5 } else { 9.5 };
            pen.line(&[(x, 3.0), (x, 13.0)]);
        }
        Icon::Frame => {
            for (x, y) in [(1.0_f32, 1.0_f32), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
                let corner = |u: f32, v: f32| (8.0 - x * (6.0 - u), 8.0 - y * (6.0 - v));
                pen.line(&[corner(3.5, 0.0), corner(0.0, 0.0), corner(0.0, 3.5)]);
            }
        }
        Icon::Warning => {
            pen.closed(&[(8.0, 2.2), (14.4, 13.4), (1.6, 13.4)]);
            pen.line(&[(8.0, 6.4), (8.0, 9.6)]);
            pen.disc((8.0, 11.6), 0.8);
        }
        Icon::Note => {
            pen.ring((8.0, 8.0), 6.0);
            pen.line(&[(8.0, 7.4), (8.0, 11.2)]);
            pen.disc((8.0, 5.0), 0.85);
        }
        Icon::Save => {
            pen.line(&[(8.0, 2.0), (8.0, 10.0)]);
            pen.line(&[(4.8, 7.0), (8.0, 10.2), (11.2, 7.0)]);
            pen.line(&[(2.5, 10.5), (2.5, 13.5), (13.5, 13.5), (13.5, 10.5)]);
        }
        Icon::Follow => {
            pen.ring((8.0, 8.0), 4.4);
            pen.disc((8.0, 8.0), 1.6);
            for (x, y) in [(1.0_f32, 0.0_f32), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                pen.line(&[(8.0 + 4.4 * x, 8.0 + 4.4 * y), (8.0 + 6.8 * x, 8.0 + 6.8 * y)]);
            }
        }
        Icon::Present => {
            pen.closed(&[(1.8, 2.6), (14.2, 2.6), (14.2, 10.8), (1.8, 10.8)]);
            pen.line(&[(8.0, 10.8), (8.0, 13.6)]);
            pen.line(&[(4.6, 13.8), (11.4, 13.8)]);
        }
        Icon::Sliders => {
            for (y, x) in [(3.5, 10.5), (8.0, 5.0), (12.5, 9.0)] {
                pen.line(&[(2.0, y), (14.0, y)]);
                pen.disc((x, y), 2.1);
            }
        }
        Icon::Link => {
            pen.line(&[(6.8, 9.2), (9.2, 6.8)]);
            pen.line(&[(7.6, 4.8), (9.2, 3.2), (11.0, 2.8), (13.2, 5.0), (12.8, 6.8), (11.2, 8.4)]);
            pen.line(&[(8.4, 11.2), (6.8, 12.8), (5.0, 13.2), (2.8, 11.0), (3.2, 9.2), (4.8, 7.6)]);
        }
        Icon::File => {
            pen.closed(&[(3.5, 1.8), (9.5, 1.8), (12.5, 4.8), (12.5, 14.2), (3.5, 14.2)]);
            pen.line(&[(9.3, 2.0), (9.3, 5.0), (12.3, 5.0)]);
        }
    }
}

/// Draws an arc of a circle; degrees from +x, clockwise on screen.
pub(super) fn arc(painter: &Painter, centre: Pos2, radius: f32, from_deg: f32, to_deg: f32, stroke: Stroke) {
    let pen = Pen { painter, centre, scale: 1.0, color: stroke.color };
    let points = pen.arc_points((8.0, 8.0), radius, from_deg, to_deg);
    painter.add(Shape::line(points, stroke));
}

struct Pen<'a> {
    painter: &'a Painter,
    centre: Pos2,
    scale: f32,
    color: Color32,
}

impl Pen<'_> {
    fn at(&self, (x, y): (f32, f32)) -> Pos2 {
        self.centre + self.scale * vec2(x - 8.0, y - 8.0)
    }

    fn stroke(&self) -> Stroke {
        Stroke::new((1.5 * self.scale).max(1.2), self.color)
    }

    fn points(&self, points: &[(f32, f32)]) -> Vec<Pos2> {
        points.iter().map(|&p| self.at(p)).collect()
    }

    fn line(&self, points: &[(f32, f32)]) {
        self.painter.add(Shape::line(self.points(points), self.stroke()));
    }

    fn closed(&self, points: &[(f32, f32)]) {
        self.painter.add(Shape::closed_line(self.points(points), self.stroke()));
    }

    fn fill(&self, points: &[(f32, f32)]) {
        self.painter.add(Shape::convex_polygon(self.points(points), self.color, Stroke::NONE));
    }

    fn bar(&self, x: f32, y: f32, width: f32, height: f32) {
        let rect = egui::Rect::from_two_pos(self.at((x, y)), self.at((x + width, y + height)));
        self.painter.rect_filled(rect, 1.0, self.color);
    }

    fn disc(&self, centre: (f32, f32), radius: f32) {
        self.painter.circle_filled(self.at(centre), radius * self.scale, self.color);
    }

    fn ring(&self, centre: (f32, f32), radius: f32) {
        self.painter.circle_stroke(self.at(centre), radius * self.scale, self.stroke());
    }

    fn arc(&self, centre: (f32, f32), radius: f32, from_deg: f32, to_deg: f32) {
        self.painter.add(Shape::line(self.arc_points(centre, radius, from_deg, to_deg), self.stroke()));
    }

    fn arc_points(&self, centre: (f32, f32), radius: f32, from_deg: f32, to_deg: f32) -> Vec<Pos2> {
        let steps = 24;
        (0..=steps)
            .map(|i| {
                let angle = (from_deg + (to_deg - from_deg) * i as f32 / steps as f32).to_radians();
                let (sin, cos) = angle.sin_cos();
                self.at((centre.0 + radius * cos, centre.1 + radius * sin))
            })
            .collect()
    }

    /// One lid of the eye, bulging down for +1.
    fn lid(&self, side: f32) {
        let points: Vec<Pos2> = (0..=16)
            .map(|i| {
                let u = i as f32 / 8.0 - 1.0;
                self.at((8.0 + 6.6 * u, 8.0 + side * 4.3 * (1.0 - u * u)))
            })
            .collect();
        self.painter.add(Shape::line(points, self.stroke()));
    }
}

/// The middle of an icon that stands at the left end of a row.
pub(super) fn leading(rect: egui::Rect, size: f32) -> Pos2 {
    pos2(rect.left() + 0.5 * size, rect.center().y)
}
