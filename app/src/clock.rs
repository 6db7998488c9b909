//! The one place that reads the clock.

use web_time::{Instant, SystemTime, UNIX_EPOCH};

/// A stopwatch that starts now and tells the milliseconds since then.
#[cfg_attr(
    not(target_arch = "wasm32"),
    expect(clippy::disallowed_methods, reason = "natively web_time's Instant is the banned one, where it is safe")
)]
pub fn stopwatch() -> impl Fn() -> f64 + Sync {
    let started = Instant::now();
    move || started.elapsed().as_secs_f64() * 1e3
}

/// Seconds since 1970, as this machine has them.
pub fn unix_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |passed| passed.as_secs_f64())
}
