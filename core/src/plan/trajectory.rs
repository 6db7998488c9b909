//! A timed motion as samples.

use serde::{Deserialize, Serialize};

/// A timed motion of some joints, sampled at equal steps and at its end.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Trajectory {
    /// Sample times from 0, seconds, ascending.
    #[serde(with = "crate::bulk")]
    pub times_s: Vec<f64>,
    /// Joint positions of each sample, in the order of the arm's joints.
    #[serde(with = "crate::bulk::lists")]
    pub positions: Vec<Vec<f64>>,
}

impl Trajectory {
    /// Duration, seconds.
    pub fn duration_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }

    /// Positions at a time, linear between samples, held before the first and after the last.
    pub fn at(&self, time_s: f64) -> Vec<f64> {
        let after = self.times_s.partition_point(|&t| t <= time_s);
        if after == 0 {
            return self.positions.first().cloned().unwrap_or_default();
        }
        let (Some(from), Some(to)) = (self.positions.get(after - 1), self.positions.get(after)) else {
            return self.positions.last().cloned().unwrap_or_default();
        };
        let span = self.times_s[after] - self.times_s[after - 1];
        let u = if span > 0.0 { (time_s - self.times_s[after - 1]) / span } else { 1.0 };
        from.iter().zip(to).map(|(a, b)| a + u * (b - a)).collect()
    }
}
