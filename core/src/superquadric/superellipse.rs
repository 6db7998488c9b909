//! One quarter of a superellipse, cut into steps that are equal by arc length or by arc length and turning.
//!
//! Pilu and Fisher (1995) walk along the curve with a differential step in the angle of the explicit form, which needs
//! special cases near the axes and loses its way for exponents above 1. The same equal steps come here from a table
//! of arc lengths over the polar angle, where the curve has no singular point for any exponent.

use crate::math;

/// Entries of the table; at exponent 0.1 a rounded corner of the curve is about eight of them wide.
const ENTRIES: usize = 512;

/// A point of the unit superellipse, `u^(2/e) + v^(2/e) = 1` with u, v ≥ 0; the curve is `(p u, q v)`.
pub(super) type UnitPoint = [f64; 2];

/// The table of one quarter, from (1, 0) to (0, 1).
pub(super) struct QuarterArc {
    e: f64,
    /// Arc length from (1, 0) to each entry, metres.
    lengths: Vec<f64>,
    /// Angle by which the curve has turned up to each entry, radians.
    turns: Vec<f64>,
    /// Largest distance of the curve from its centre, metres.
    pub(super) largest_radius_m: f64,
}

impl QuarterArc {
    /// Tabulates the quarter with semi-axes p and q, metres, and exponent e.
    pub(super) fn new(p: f64, q: f64, e: f64) -> Self {
        let mut lengths = vec![0.0];
        let mut turns = vec![0.0];
        let mut largest: f64 = p.max(q);
        let mut last = [p, 0.0];
        let mut heading = std::f64::consts::FRAC_PI_2; // the curve leaves (p, 0) along +y
        let (mut length, mut turn) = (0.0, 0.0);
        for k in 1..=ENTRIES {
            let [u, v] = unit_point(polar(k as f64), e);
            let here = [p * u, q * v];
            let step = [here[0] - last[0], here[1] - last[1]];
            let next_heading = math::atan2(step[1], step[0]);
            length += (step[0] * step[0] + step[1] * step[1]).sqrt();
            turn += math::wrap_angle(next_heading - heading).abs();
            heading = next_heading;
            last = here;
            largest = largest.max((here[0] * here[0] + here[1] * here[1]).sqrt());
            lengths.push(length);
            turns.push(turn);
        }
        Self { e, lengths, turns, largest_radius_m: largest }
    }

    /// Length of the quarter, metres.
    pub(super) fn length_m(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// `steps + 1` points from (1, 0) to (0, 1), equally far apart along the curve.
    pub(super) fn equal_steps(&self, steps: usize) -> Vec<UnitPoint> {
        self.cut(&self.lengths, 0, ENTRIES, steps)
    }

    /// `2 · half + 1` points from (1, 0) to (0, 1), dense where the curve bends, one of them exactly at the corner.
    pub(super) fn silhouette_steps(&self, half: usize) -> Vec<UnitPoint> {
        let (length, turn) = (self.length_m(), self.turns.last().copied().unwrap_or(0.0));
        let measure: Vec<f64> = self.lengths.iter().zip(&self.turns).map(|(l, t)| l / length + t / turn).collect();
        let mut points = self.cut(&measure, 0, ENTRIES / 2, half);
        points.pop();
        points.extend(self.cut(&measure, ENTRIES / 2, ENTRIES, half));
        points
    }

    /// Cuts the entries `from..=to` into steps with equal increments of `measure`, which does not decrease.
    fn cut(&self, measure: &[f64], from: usize, to: usize, steps: usize) -> Vec<UnitPoint> {
        let steps = steps.max(1);
        let (start, end) = (measure[from], measure[to]);
        let mut entry = from;
        (0..=steps)
            .map(|k| {
                if k == 0 {
                    return unit_point(polar(from as f64), self.e);
                }
                if k == steps {
                    return unit_point(polar(to as f64), self.e);
                }
                let wanted = start + (end - start) * k as f64 / steps as f64;
                while entry + 1 < to && measure[entry + 1] < wanted {
                    entry += 1;
                }
                let span = measure[entry + 1] - measure[entry];
                let within = if span > 0.0 { ((wanted - measure[entry]) / span).min(1.0) } else { 0.0 };
                unit_point(polar(entry as f64 + within), self.e)
            })
            .collect()
    }
}

/// Polar angle of a (fractional) entry, radians.
fn polar(entry: f64) -> f64 {
    std::f64::consts::FRAC_PI_2 * entry / ENTRIES as f64
}

/// The point of the unit superellipse at a polar angle in [0, π/2].
pub(super) fn unit_point(phi_rad: f64, e: f64) -> UnitPoint {
    if phi_rad <= 0.0 {
        return [1.0, 0.0];
    }
    if phi_rad >= std::f64::consts::FRAC_PI_2 - 1e-15 {
        return [0.0, 1.0];
    }
    let (sin, cos) = math::sin_cos(phi_rad);
    let ln_gauge = 0.5 * e * math::ln_add_exp(2.0 / e * math::ln(cos), 2.0 / e * math::ln(sin));
    let scale = math::exp(-ln_gauge);
    [cos * scale, sin * scale]
}

/// A quarter unfolded into the whole closed curve, counter-clockwise from (1, 0), without repeating a point.
pub(super) fn unfold(quarter: &[UnitPoint]) -> Vec<UnitPoint> {
    let Some(last) = quarter.len().checked_sub(1) else { return Vec::new() };
    let forward = || quarter[..last].iter();
    let backward = || quarter[1..].iter().rev();
    let mut ring: Vec<UnitPoint> = forward().copied().collect();
    ring.extend(backward().map(|[u, v]| [-u, *v]));
    ring.extend(forward().map(|[u, v]| [-u, -v]));
    ring.extend(backward().map(|[u, v]| [*u, -v]));
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_equal_for_every_exponent() {
        for e in [0.01, 0.1, 0.5, 1.0, 1.5, 1.99] {
            for (p, q) in [(1.0, 1.0), (1.0, 10.0), (5.0, 0.2)] {
                let arc = QuarterArc::new(p, q, e);
                let points = arc.equal_steps(40);
                let chords: Vec<f64> = points
                    .windows(2)
                    .map(|w| math::powf((p * (w[1][0] - w[0][0])).powi(2) + (q * (w[1][1] - w[0][1])).powi(2), 0.5))
                    .collect();
                let wanted = arc.length_m() / 40.0;
                // A chord over a right-angled corner is √½ of its arc at worst.
                assert!(chords.iter().all(|c| *c > 0.70 * wanted && *c < 1.01 * wanted), "e {e} p {p} q {q}");
            }
        }
    }

    #[test]
    fn a_circle_has_its_length_and_a_square_its_corner() {
        let circle = QuarterArc::new(2.0, 2.0, 1.0);
        assert!((circle.length_m() / std::f64::consts::PI - 1.0).abs() < 1e-6);
        let square = QuarterArc::new(1.0, 1.0, 0.1).silhouette_steps(6);
        assert_eq!(square.len(), 13);
        assert!((square[6][0] - math::powf(0.5, 0.05)).abs() < 1e-12 && (square[6][0] - square[6][1]).abs() < 1e-12);
        assert_eq!(unfold(&square).len(), 48);
    }
}
