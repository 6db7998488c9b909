//! Colours for numbers: viridis for amounts, a diverging map with a neutral middle for signed data.

use serde::{Deserialize, Serialize};

/// The grey of what has no value (NaN).
const NO_VALUE: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// A map from [0, 1] to sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColorMap {
    /// Perceptually even from dark violet to yellow; for amounts.
    Viridis,
    /// Red, neutral at 0.5, blue (ColorBrewer's RdBu without its darkest ends, which a dark room swallows); for signed
    /// data.
    Diverging,
}

impl ColorMap {
    /// sRGB and opacity 1 at `t`, which is limited to [0, 1]; NaN is grey.
    pub fn at(self, t: f64) -> [f32; 4] {
        if t.is_nan() {
            return NO_VALUE;
        }
        let t = t.max(0.0).min(1.0);
        let color = match self {
            Self::Viridis => colorous::VIRIDIS.eval_continuous(t),
            Self::Diverging => colorous::RED_BLUE.eval_continuous(0.1 + 0.8 * t),
        };
        let channel = |value: u8| f32::from(value) / 255.0;
        [channel(color.r), channel(color.g), channel(color.b), 1.0]
    }
}

/// A colour map with its range: what a colour bar shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scale {
    /// The colours.
    pub map: ColorMap,
    /// Value of the first colour, in the unit of the data.
    pub min: f64,
    /// Value of the last colour.
    pub max: f64,
    /// Whether equal ratios, not equal differences, are equally far apart; both ends must be greater than 0.
    pub is_log: bool,
}

impl Scale {
    /// The scale that covers all finite values: for a diverging map it is symmetric about 0.
    /// Without finite values it is [0, 1].
    pub fn covering(map: ColorMap, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        if min > max {
            return Self { map, min: 0.0, max: 1.0, is_log: false };
        }
        match map {
            ColorMap::Viridis => Self { map, min, max, is_log: false },
            ColorMap::Diverging => {
                let reach = min.abs().max(max.abs());
                Self { map, min: -reach, max: reach, is_log: false }
            }
        }
    }

    /// sRGB and opacity 1 of a value; values outside the range take its end colours, and if the range is a single
    /// value that value takes the middle colour.
    pub fn color(&self, value: f64) -> [f32; 4] {
        if self.max > self.min {
            self.map.at(self.share(value))
        } else if value.is_nan() {
            NO_VALUE
        } else {
            self.map.at(0.5)
        }
    }

    /// How far along the range a value lies: 0 at its first, 1 at its last; beyond the ends less or more.
    pub fn share(&self, value: f64) -> f64 {
        if self.is_log {
            (value / self.min).ln() / (self.max / self.min).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        }
    }

    /// The value that lies so far along the range: the inverse of [`Scale::share`].
    pub fn value_at(&self, share: f64) -> f64 {
        if self.is_log {
            self.min * (self.max / self.min).powf(share)
        } else {
            self.min + share * (self.max - self.min)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_ends_are_violet_and_yellow_and_it_grows_lighter() {
        assert_eq!(ColorMap::Viridis.at(0.0), [68.0 / 255.0, 1.0 / 255.0, 84.0 / 255.0, 1.0]);
        let luminance = |t: f64| {
            let [r, g, b, _] = ColorMap::Viridis.at(t);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 0..20 {
            assert!(luminance(f64::from(step) / 20.0) < luminance(f64::from(step + 1) / 20.0));
        }
    }

    #[test]
    fn diverging_middle_is_neutral() {
        let [r, g, b, _] = ColorMap::Diverging.at(0.5);
        let spread = r.max(g).max(b) - r.min(g).min(b);
        assert!(spread < 0.02, "middle is ({r}, {g}, {b})");
    }

    #[test]
    fn on_a_logarithmic_scale_equal_ratios_are_equally_far_apart() {
        let scale = Scale { map: ColorMap::Viridis, min: 0.01, max: 1.0, is_log: true };
        assert!((scale.share(0.1) - 0.5).abs() < 1e-12);
        assert_eq!(scale.color(0.1), ColorMap::Viridis.at(0.5));
        assert_eq!(scale.color(0.0), ColorMap::Viridis.at(0.0), "below the range its first colour");
        for linear in [scale, Scale { is_log: false, ..scale }] {
            assert!((linear.value_at(linear.share(0.07)) - 0.07).abs() < 1e-12);
        }
    }

    #[test]
    fn odd_values_still_have_a_colour() {
        let scale = Scale::covering(ColorMap::Diverging, [-3.0, 1.0, f64::NAN]);
        assert_eq!((scale.min, scale.max), (-3.0, 3.0));
        assert_eq!(scale.color(f64::NAN), NO_VALUE);
        assert_eq!(scale.color(99.0), ColorMap::Diverging.at(1.0));
        let single = Scale::covering(ColorMap::Viridis, [2.0, 2.0]);
        assert_eq!(single.color(2.0), ColorMap::Viridis.at(0.5));
        let none = Scale::covering(ColorMap::Viridis, []);
        assert_eq!((none.min, none.max), (0.0, 1.0));
    }
}
