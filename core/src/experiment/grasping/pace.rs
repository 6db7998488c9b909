//! What runs beside what in an experiment: cases side by side are soonest done, one after the other they have times.

use crate::parallel;

/// Which cases run at the same time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Cases run side by side; their times would mean nothing.
    #[default]
    SideBySide,
    /// One case after the other, each on all processors: times as a user sees them.
    InTurn,
    /// One case after the other on one processor.
    OneProcessor,
}

impl Pace {
    /// Whether times mean something.
    pub fn has_times(self) -> bool {
        self != Self::SideBySide
    }

    /// Does the work, on one processor if that is asked for.
    pub(super) fn run<R: Send>(self, work: impl FnOnce() -> R + Send) -> R {
        if self == Self::OneProcessor { parallel::on_one_thread(work) } else { work() }
    }

    /// Applies `work` to every case and keeps their order.
    pub(super) fn map<T: Sync, R: Send>(self, cases: &[T], work: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
        if self == Self::SideBySide { parallel::map(cases, work) } else { cases.iter().map(work).collect() }
    }
}
