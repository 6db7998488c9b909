//! The fastest run along a path under speed and acceleration limits (time-optimal path parameterisation by
//! reachability: Pham and Pham 2018).

use super::smooth::Stretch;

/// A grid interval of a run: slopes at both ends, the constant bend, and its width in s.
struct Interval {
    stretch: usize,
    /// s in the stretch where the interval begins.
    begin: f64,
    width: f64,
}

/// A run along stretches with its speed profile; starts and ends at rest.
pub(crate) struct TimedRun<'a> {
    stretches: &'a [Stretch],
    intervals: Vec<Interval>,
    /// Squared speed ds/dt at the grid points.
    x: Vec<f64>,
    /// Times of the grid points, seconds.
    times: Vec<f64>,
}

/// |slope · s̈ + bend · ṡ²| <= limit, solved for s̈: the centre moves with ṡ², the half width does not.
struct Row {
    half_width: f64,
    tilt: f64,
}

impl<'a> TimedRun<'a> {
    /// Maximises the speed everywhere; `velocity` and `acceleration` are per joint, greater than 0.
    ///
    /// With x = ṡ², constant s̈ in an interval makes x linear in s. Joint accelerations `q' s̈ + q'' x` are then linear
    /// in s too, so that limits that hold at both ends of an interval hold inside. Backwards, the largest x from which
    /// the end can still be reached is found at every grid point; forwards, the largest s̈ that stays below is taken.
    pub(crate) fn new(stretches: &'a [Stretch], velocity: &[f64], acceleration: &[f64]) -> Self {
        let mut intervals = Vec::new();
        for (stretch, shape) in stretches.iter().enumerate() {
            // Fine enough that a bend is followed closely; limits hold for any number.
            let count = 8 + (shape.length / 0.02) as usize;
            let width = shape.length / count as f64;
            intervals.extend((0..count).map(|k| Interval { stretch, begin: k as f64 * width, width }));
        }
        let n = intervals.len();
        let mut ceiling = vec![f64::INFINITY; n + 1];
        for (index, interval) in intervals.iter().enumerate() {
            let shape = &stretches[interval.stretch];
            for (joint, limit) in velocity.iter().enumerate() {
                let slope = shape
                    .slope(joint, interval.begin)
                    .abs()
                    .max(shape.slope(joint, interval.begin + interval.width).abs());
                if slope > 0.0 {
                    let bound = (limit / slope) * (limit / slope);
                    ceiling[index] = ceiling[index].min(bound);
                    ceiling[index + 1] = ceiling[index + 1].min(bound);
                }
            }
        }
        let mut rows = Vec::new();
        // Backwards: the controllable speeds.
        ceiling[n] = 0.0;
        for index in (0..n).rev() {
            let next = ceiling[index + 1];
            let limit = fill_rows(&mut rows, &stretches[intervals[index].stretch], &intervals[index], acceleration);
            ceiling[index] = highest(&rows, intervals[index].width, ceiling[index].min(limit), next);
        }
        ceiling[0] = 0.0;
        // Forwards: as fast as possible.
        let mut x = vec![0.0; n + 1];
        for index in 0..n {
            let interval = &intervals[index];
            fill_rows(&mut rows, &stretches[interval.stretch], interval, acceleration);
            let fastest = rows.iter().map(|row| row.half_width - row.tilt * x[index]).fold(f64::INFINITY, f64::min);
            x[index + 1] = (x[index] + 2.0 * interval.width * fastest).max(0.0).min(ceiling[index + 1]);
        }
        let mut times = vec![0.0];
        for (index, interval) in intervals.iter().enumerate() {
            let speed = x[index].sqrt() + x[index + 1].sqrt();
            // Never both at rest: from rest some acceleration is always possible.
            times.push(times[index] + 2.0 * interval.width / speed.max(1e-9));
        }
        Self { stretches, intervals, x, times }
    }

    /// Duration, seconds.
    pub(crate) fn duration_s(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Appends joint positions at `steps` equal steps of time, without the start.
    pub(crate) fn sample(&self, steps: usize, samples: &mut Vec<Vec<f64>>) {
        let mut index = 0;
        for step in 1..=steps {
            let time_s = self.duration_s() * step as f64 / steps as f64;
            while index + 1 < self.intervals.len() && self.times[index + 1] <= time_s {
                index += 1;
            }
            let interval = &self.intervals[index];
            let elapsed = (time_s - self.times[index]).max(0.0);
            let s_dot = self.x[index].sqrt();
            let s_ddot = (self.x[index + 1] - self.x[index]) / (2.0 * interval.width);
            let s = (s_dot * elapsed + 0.5 * s_ddot * elapsed * elapsed).max(0.0).min(interval.width);
            samples.push(self.stretches[interval.stretch].at(interval.begin + s));
        }
    }
}

/// Fills in the acceleration limits of an interval at both of its ends; the answer is the x beyond which joints
/// without slope exceed their limits.
fn fill_rows(rows: &mut Vec<Row>, shape: &Stretch, interval: &Interval, acceleration: &[f64]) -> f64 {
    rows.clear();
    let mut ceiling = f64::INFINITY;
    for (joint, limit) in acceleration.iter().enumerate() {
        let bend = shape.bend(joint);
        let begin = shape.slope(joint, interval.begin);
        // At the far end x is x + 2 width s̈, which adds to the factor of s̈.
        let end = shape.slope(joint, interval.begin + interval.width) + 2.0 * interval.width * bend;
        for slope in [begin, end] {
            if slope.abs() > 1e-12 {
                rows.push(Row { half_width: limit / slope.abs(), tilt: bend / slope });
            } else if bend != 0.0 {
                ceiling = ceiling.min(limit / bend.abs());
            }
        }
    }
    ceiling
}

/// The largest x up to `ceiling` for which some s̈ obeys all rows and leads to an x in [0, next].
///
/// Every row asks for `−w − t x <= s̈ <= w − t x`. The room between the highest lower bound and the lowest upper bound
/// is concave in x and not negative at x = 0, so Newton's steps from above end at the largest x that has room.
fn highest(rows: &[Row], width: f64, ceiling: f64, next: f64) -> f64 {
    let per_s = 0.5 / width;
    // No speed limit at all is none that is ever reached.
    let mut x = ceiling.min(1e12);
    loop {
        // The next x is at least 0 and at most `next`; then the rows. Bounds as (value at x, slope).
        let mut lower = (-per_s * x, -per_s);
        let mut upper = ((next - x) * per_s, -per_s);
        for row in rows {
            let shift = row.tilt * x;
            if -row.half_width - shift > lower.0 {
                lower = (-row.half_width - shift, -row.tilt);
            }
            if row.half_width - shift < upper.0 {
                upper = (row.half_width - shift, -row.tilt);
            }
        }
        let missing = lower.0 - upper.0;
        let closing = lower.1 - upper.1;
        if missing <= 0.0 || closing <= 0.0 {
            return x;
        }
        let nearer = (x - missing / closing).max(0.0);
        if nearer >= x {
            return x;
        }
        x = nearer;
    }
}
