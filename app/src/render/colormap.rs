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
}

impl Scale {
    /// The scale that covers all finite values: for a diverging map it is symmetric about 0.
    /// Without finite values it is [0, 1].
    pub fn covering(map: ColorMap, values: impl IntoIterator<Item = f64>) -> Self {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        if min > max {
            return Self { map, min: 0.0, max: 1.0 };
        }
        match map {
            ColorMap::Viridis => Self { map, min, max },
            ColorMap::Diverging => {
                let reach = min.abs().max(max.abs());
                Self { map, min: -reach, max: reach }
            }
        }
    }

    /// sRGB and opacity 1 of a value; values outside the range take its end colours, and if the range is a single
    /// value that value takes the middle colour.
    pub fn color(&self, value: f64) -> [f32; 4] {
        let span = self.max - self.min;
        if span > 0.0 {
            self.map.at((value - self.min) / span)
        } else if value.is_nan() {
            NO_VALUE
        } else {
            self.map.at(0.5)
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
