//! Manipulability in one byte.

use crate::math;

/// The least manipulability that is told from smaller ones, as a share of the greatest.
const LEAST: f64 = 1e-3;

/// Levels 0 to 255, even in the logarithm, from a thousandth of the greatest manipulability to the greatest: steps of
/// 2.7 %, hence within 1.4 %. What is less counts as level 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) most: f64,
    values: Vec<f64>,
}

impl Scale {
    /// `most` is finite and not negative.
    pub(super) fn up_to(most: f64) -> Self {
        let value = |level: u32| most * math::exp(math::ln(LEAST) * (1.0 - f64::from(level) / 255.0));
        Self { most, values: (0..256).map(value).collect() }
    }

    pub(super) fn level(&self, manipulability: f64) -> u8 {
        let share = (manipulability / self.most).max(LEAST).min(1.0);
        (255.0 * (1.0 - math::ln(share) / math::ln(LEAST))).round() as u8
    }

    pub(super) fn value(&self, level: u8) -> f64 {
        self.values[usize::from(level)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_within_half_a_step_and_its_value_has_it() {
        let scale = Scale::up_to(0.137);
        for k in 0..=1000 {
            let m = 0.137 * math::powf(10.0, -0.003 * f64::from(k));
            assert!((scale.value(scale.level(m)) / m - 1.0).abs() < 0.014, "{m}");
        }
        assert!((0..=255).all(|level| scale.level(scale.value(level)) == level));
        assert_eq!((scale.level(0.0), scale.level(1.0)), (0, 255));
        assert_eq!(Scale::up_to(0.0).value(255), 0.0);
    }
}
