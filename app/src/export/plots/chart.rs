//! What a plot consists of, before it is drawn.

/// Charts one above the other, with one title.
pub(super) struct Sheet {
    /// Above everything.
    pub(super) title: String,
    /// What colours mean that run through all charts: phases.
    pub(super) key: Vec<(String, String)>,
    /// From top to bottom; they share the axis of the last one if `shares_x`.
    pub(super) charts: Vec<Chart>,
    /// Whether only the last chart has numbers and words at its x axis.
    pub(super) shares_x: bool,
    /// Height of one chart's field, pixels.
    pub(super) height: f64,
}

/// A field with two axes.
pub(super) struct Chart {
    /// Above the field, to the left; may be empty.
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) lines: Vec<Line>,
    pub(super) bars: Vec<Bar>,
    /// Dashed lines across: limits.
    pub(super) limits: Vec<f64>,
    /// Strips on the x axis: phases.
    pub(super) strips: Vec<Strip>,
}

/// An axis in the unit that a person reads.
pub(super) struct Axis {
    /// Quantity and unit: `time, s`.
    pub(super) label: String,
    pub(super) min: f64,
    pub(super) max: f64,
    /// Whether equal factors are equally long.
    pub(super) is_log: bool,
}

impl Axis {
    /// A linear axis.
    pub(super) fn new(label: &str, min: f64, max: f64) -> Self {
        Self { label: label.to_owned(), min, max, is_log: false }
    }

    /// A linear axis that holds all values with a little room; around a single value it is as long as that.
    pub(super) fn around(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return Self::new(label, 0.0, 1.0);
        }
        let room = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1e-3) };
        Self::new(label, low - room, high + room)
    }

    /// Where a value lies, 0 at the start and 1 at the end.
    pub(super) fn share(&self, value: f64) -> f64 {
        let place = |value: f64| if self.is_log { value.max(f64::MIN_POSITIVE).log10() } else { value };
        (place(value) - place(self.min)) / (place(self.max) - place(self.min)).max(f64::MIN_POSITIVE)
    }

    /// Round values to be marked, about `count` of them and at least three, if three can be.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        let attempts = (count..count + 8).map(|count| self.about(count));
        attempts.fold(Vec::new(), |found, more| if found.len() < 3 { more } else { found })
    }

    fn about(&self, count: usize) -> Vec<f64> {
        let wanted = count.max(1) as f64;
        if self.is_log {
            let (first, last) = (self.min.log10().floor() as i32, self.max.log10().ceil() as i32);
            let digits: &[f64] = if f64::from(last - first) > 3.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
            let values = (first..=last).flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)));
            return values.filter(|value| (self.min..=self.max).contains(value)).collect();
        }
        let rough = ((self.max - self.min) / wanted).max(f64::MIN_POSITIVE);
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * decade).find(|step| *step >= 0.999 * rough);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) = ((self.min / step - 1e-9).ceil() as i64, (self.max / step + 1e-9).floor() as i64);
        (first..=last).map(|k| k as f64 * step).collect()
    }
}

/// A curve.
pub(super) struct Line {
    /// What it shows; an empty name is not in the legend.
    pub(super) name: String,
    /// `#rrggbb`.
    pub(super) color: String,
    /// Pixels.
    pub(super) width: f64,
    pub(super) points: Vec<(f64, f64)>,
}

/// A bar from zero.
pub(super) struct Bar {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) height: f64,
    pub(super) color: String,
}

/// A coloured part of the x axis.
pub(super) struct Strip {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) color: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_inside() {
        let ticks = |min: f64, max: f64, count: usize| Axis::new("", min, max).ticks(count);
        assert_eq!(ticks(0.0, 10.0, 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks(-0.13, 0.21, 4), [-0.1, 0.0, 0.1, 0.2]);
        assert_eq!(ticks(-190.0, 190.0, 3), [-100.0, 0.0, 100.0], "zero alone would say nothing");
        let log = Axis { is_log: true, ..Axis::new("", 0.3, 40.0) };
        let found = log.ticks(5);
        let wanted = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
        assert!(found.len() == 6 && found.iter().zip(wanted).all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{found:?}");
        assert!((log.share(12.0_f64.sqrt()) - 0.5).abs() < 1e-12, "the geometric middle is in the middle");
    }

    #[test]
    fn an_axis_holds_its_values_and_survives_none_or_one() {
        let axis = Axis::around("", [3.0, 1.0, f64::NAN, 2.0]);
        assert!(axis.min < 1.0 && axis.max > 3.0 && axis.max < 3.3);
        let one = Axis::around("", [5.0]);
        assert!(one.min < 5.0 && one.max > 5.0);
        let none = Axis::around("", []);
        assert_eq!((none.min, none.max), (0.0, 1.0));
        assert!(Axis::around("", [0.0, 0.0]).ticks(4).len() > 1);
    }
}
