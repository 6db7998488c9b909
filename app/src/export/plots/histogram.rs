//! Signed distances sorted into bars.

/// Bars: odd, so that one stands over zero.
pub const HISTOGRAM_BARS: usize = 33;

/// Distances of points from a surface, sorted.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The bars reach from minus this to plus this, metres: 99 % of the distances lie within.
    pub end_m: f64,
    /// How many distances each bar holds, from the innermost to the outermost.
    pub counts: [usize; HISTOGRAM_BARS],
    /// 95 % of the distances are no larger than this, metres.
    pub within_95_m: f64,
    /// Their mean, metres; negative inside.
    pub mean_m: f64,
}

impl Histogram {
    /// Sorts distances, metres, those that are not finite left out; `None` without any.
    pub fn of(distances_m: &[f64]) -> Option<Self> {
        let mut sizes: Vec<f64> = distances_m.iter().map(|d| d.abs()).filter(|d| d.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len().checked_sub(1)?;
        let share = |part: f64| sizes[((sizes.len() as f64 * part) as usize).min(last)];
        let end_m = share(0.99).max(1e-6);
        let mut counts = [0; HISTOGRAM_BARS];
        for d in distances_m.iter().filter(|d| d.is_finite()) {
            let u = (d / end_m + 1.0) / 2.0;
            counts[(u.max(0.0) * HISTOGRAM_BARS as f64) as usize % HISTOGRAM_BARS] +=
                usize::from((0.0..1.0).contains(&u));
        }
        let mean_m = distances_m.iter().filter(|d| d.is_finite()).sum::<f64>() / sizes.len() as f64;
        Some(Self { end_m, counts, within_95_m: share(0.95), mean_m })
    }

    /// Where a bar begins, metres; the one after the last is the end.
    pub fn edge_m(&self, bar: usize) -> f64 {
        (2.0 * bar as f64 / HISTOGRAM_BARS as f64 - 1.0) * self.end_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_fall_into_their_bars_and_zero_into_the_middle_one() {
        let mut distances_m = vec![0.0; 90];
        distances_m.extend([0.001; 5]);
        distances_m.extend([-0.001; 4]);
        distances_m.extend([f64::NAN, 0.5]);
        let found = Histogram::of(&distances_m).expect("there are some");
        // 99 of 100 lie within a millimetre; the stray one is in no bar.
        assert_eq!((found.end_m, found.counts[HISTOGRAM_BARS / 2], found.counts[0]), (0.5, 99, 0));
        let near = Histogram::of(&distances_m[..99]).expect("there are some");
        assert_eq!((near.end_m, near.counts[HISTOGRAM_BARS / 2]), (0.001, 90));
        assert_eq!(near.counts[0], 4);
        assert!((near.edge_m(HISTOGRAM_BARS) - 0.001).abs() < 1e-15);
        assert_eq!(Histogram::of(&[f64::NAN]), None);
    }
}
