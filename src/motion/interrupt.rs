//! A request to stop, seen by all threads that look for a motion.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A request to stop a search. All clones are one request, so that one of them can be raised from another thread, such as
/// that of a signal.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    raised: Arc<AtomicBool>,
    /// The time at which it raises itself.
    at: Option<Instant>,
}

impl Interrupt {
    /// A request that raises itself after a time, counted from now.
    #[must_use]
    pub fn after(time: Duration) -> Self {
        Self {
            raised: Arc::default(),
            at: Some(Instant::now() + time),
        }
    }

    /// Asks for the search to stop.
    pub fn raise(&self) {
        self.raised.store(true, Ordering::Relaxed);
    }

    /// Tells whether it is to stop.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed) || self.at.is_some_and(|at| Instant::now() >= at)
    }
}

/// The reason why a search was stopped before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// Its time was over.
    TimeLimit(Duration),
    /// Its [`Interrupt`] was raised.
    Interrupt,
}

impl std::fmt::Display for Stopped {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TimeLimit(limit) => write!(f, "time limit of {} s reached", limit.as_secs_f64()),
            Self::Interrupt => f.write_str("interrupted"),
        }
    }
}

/// A search in time: when it began, and what may stop it.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    began: Instant,
    limit: Option<Duration>,
    interrupt: Interrupt,
}

impl Watch {
    /// From now on.
    pub fn start(limit: Option<Duration>, interrupt: &Interrupt) -> Self {
        Self {
            began: Instant::now(),
            limit,
            interrupt: interrupt.clone(),
        }
    }

    /// Tells whether this share of the time limit is over.
    pub fn is_late(&self, share: f64) -> bool {
        let limit = self.limit.map(|limit| limit.mul_f64(share));
        limit.is_some_and(|limit| self.began.elapsed() >= limit)
    }

    /// The reason to stop, once there is one.
    pub fn stopped(&self) -> Option<Stopped> {
        if self.interrupt.is_raised() {
            return Some(Stopped::Interrupt);
        }
        let over = self.limit.filter(|_| self.is_late(1.0));
        over.map(Stopped::TimeLimit)
    }
}
