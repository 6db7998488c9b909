//! Mean, median and 95th percentile of what the trials gave.

/// Three numbers for many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Arithmetic mean.
    pub mean: f64,
    /// Half of the values are at most this.
    pub median: f64,
    /// 95 % of the values are at most this.
    pub p95: f64,
}

impl Summary {
    /// The summary of values; `None` for none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let count = values.len();
        let at = |index: usize| values.get(index).copied();
        // Two middle values of an even count; for 95 %, the nearest rank.
        let (low, high) = (at(count.checked_sub(1)? / 2)?, at(count / 2)?);
        let p95 = at((count * 95).div_ceil(100).max(1) - 1)?;
        Some(Self { mean: values.iter().sum::<f64>() / count as f64, median: 0.5 * (low + high), p95 })
    }
}

/// 97.5 % quantile of the normal distribution: an interval of ± this many deviations holds 95 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// Wilson's score interval (1927) of a share, 95 %, percent: also sensible where all or none succeeded.
pub(super) fn wilson_percent(success: usize, trials: usize) -> [f64; 2] {
    let (n, z2) = (trials.max(1) as f64, Z_95 * Z_95);
    let share = success as f64 / n;
    let middle = share + z2 / (2.0 * n);
    let spread = Z_95 * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    [middle - spread, middle + spread].map(|x| 100.0 * (x / (1.0 + z2 / n)).max(0.0).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_wilsons_interval_are_where_the_score_test_turns() {
        for (success, trials) in [(0, 5), (33, 35), (21, 35), (275, 278), (278, 278)] {
            let found = 100.0 * success as f64 / trials as f64;
            let ends = wilson_percent(success, trials);
            assert!(ends[0] <= found + 1e-9 && found <= ends[1] + 1e-9, "{ends:?}");
            for p in ends.map(|end| end / 100.0).into_iter().filter(|p| *p > 1e-9 && *p < 1.0 - 1e-9) {
                // At an end, the observed share is exactly z deviations of a binomial with that end's share away.
                let deviation = (p * (1.0 - p) / trials as f64).sqrt();
                assert!(((found / 100.0 - p).abs() / deviation - Z_95).abs() < 1e-9, "{p}");
            }
        }
    }

    #[test]
    fn order_and_parity_do_not_matter() {
        let summary = |values: &[f64]| Summary::of(values.iter().copied());
        assert_eq!(summary(&[]), None);
        assert_eq!(summary(&[3.0]), Some(Summary { mean: 3.0, median: 3.0, p95: 3.0 }));
        assert_eq!(summary(&[4.0, 1.0, 2.0, 5.0]), Some(Summary { mean: 3.0, median: 3.0, p95: 5.0 }));
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(summary(&hundred), Some(Summary { mean: 50.5, median: 50.5, p95: 95.0 }));
    }
}
