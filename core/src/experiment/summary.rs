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

#[cfg(test)]
mod tests {
    use super::*;

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
