//! The moving average that bounds the jerk of sampled motions.

/// Samples in a window that is at least this long, at least 1.
pub(crate) fn window_samples(window_s: f64, sample_s: f64) -> usize {
    // 1e-9: a window of exactly 20 samples must not become 21 by round-off; the jerk limit has as much to spare.
    ((window_s / sample_s - 1e-9).ceil().max(1.0)) as usize
}

/// The mean of each sample and those before it in a window, from rest to rest: longer by `window - 1` samples.
///
/// The average of differences is no larger than the largest of them, so velocity and acceleration limits that hold for
/// the samples hold for the average. Its third differences are `(a_k − a_{k−m}) / (m Δt)` for a window of m samples: no
/// larger than twice the largest acceleration over the window. Samples on one straight line stay on it.
pub(crate) fn moving_average(samples: &[Vec<f64>], window: usize) -> Vec<Vec<f64>> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Vec::new() };
    if samples.len() == 1 {
        return samples.to_vec();
    }
    let share = 1.0 / window as f64;
    // Sums of offsets from the first sample: small numbers, and exact zeros at rest.
    let mut sum = vec![0.0; first.len()];
    let mut averaged = Vec::with_capacity(samples.len() + window - 1);
    averaged.push(first.clone());
    for k in 1..samples.len() + window - 1 {
        let enters = samples.get(k).unwrap_or(last);
        let leaves = if k >= window { &samples[k - window] } else { first };
        sum.iter_mut().zip(enters.iter().zip(leaves)).for_each(|(sum, (enters, leaves))| *sum += enters - leaves);
        averaged.push(first.iter().zip(&sum).map(|(first, sum)| first + sum * share).collect());
    }
    averaged
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn the_average_is_the_mean_of_the_window_and_ends_where_the_samples_end() {
        let mut rng = Rng::new(1, 0);
        let samples: Vec<Vec<f64>> = (0..50).map(|_| vec![rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0)]).collect();
        for window in [1, 2, 7, 49, 50, 80] {
            let averaged = moving_average(&samples, window);
            assert_eq!(averaged.len(), 50 + window - 1);
            for (k, found) in averaged.iter().enumerate() {
                for joint in 0..2 {
                    let held = |k: i64| samples[k.max(0).min(49) as usize][joint];
                    let mean = (0..window as i64).map(|back| held(k as i64 - back)).sum::<f64>() / window as f64;
                    // Sums of up to 80 terms of about 3: 1e-14 of round-off per step, 130 steps.
                    assert!((found[joint] - mean).abs() < 1e-12, "window {window}, sample {k}");
                }
            }
        }
        assert!(moving_average(&[], 5).is_empty());
        assert_eq!(moving_average(&[vec![1.0]], 5), vec![vec![1.0]]);
    }

    #[test]
    fn a_window_holds_whole_samples_and_never_none() {
        assert_eq!(window_samples(0.2, 0.01), 20);
        assert_eq!(window_samples(0.201, 0.01), 21);
        assert_eq!(window_samples(0.001, 0.01), 1);
    }
}
