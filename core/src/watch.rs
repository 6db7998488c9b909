//! How a long computation is watched: cancelled, timed, and asked how far it is.

/// What a long routine needs from outside: it may be stopped, it reports progress, and it is told the time.
///
/// `core` reads no clock and starts no thread; whoever runs it passes these three functions.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    should_stop: &'a (dyn Fn() -> bool + Sync),
    progress: &'a (dyn Fn(f64, &str) + Sync),
    now_ms: &'a (dyn Fn() -> f64 + Sync),
}

impl<'a> Watch<'a> {
    /// A watch made of a cancel flag, a progress receiver (fraction in [0, 1], note) and a clock in milliseconds.
    pub fn new(
        should_stop: &'a (dyn Fn() -> bool + Sync),
        progress: &'a (dyn Fn(f64, &str) + Sync),
        now_ms: &'a (dyn Fn() -> f64 + Sync),
    ) -> Self {
        Self { should_stop, progress, now_ms }
    }

    /// A watch that never stops anything, drops progress, and whose clock stands still.
    pub fn idle() -> Watch<'static> {
        Watch { should_stop: &|| false, progress: &|_, _| (), now_ms: &|| 0.0 }
    }

    /// The same watch with another reason to stop.
    pub(crate) fn stopping_when<'b>(self, should_stop: &'b (dyn Fn() -> bool + Sync)) -> Watch<'b>
    where
        'a: 'b,
    {
        Watch { should_stop, ..self }
    }

    /// Whether the routine should give up as soon as it can.
    pub fn should_stop(&self) -> bool {
        (self.should_stop)()
    }

    /// Tells how far the routine is, as a fraction in [0, 1] and a few words.
    pub fn progress(&self, fraction: f64, note: &str) {
        (self.progress)(fraction, note);
    }

    /// The time in milliseconds since some fixed moment; only differences mean anything, and no result depends on it.
    pub fn now_ms(&self) -> f64 {
        (self.now_ms)()
    }
}
