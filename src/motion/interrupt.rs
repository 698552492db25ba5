//! A stop request, shared by all threads of a search.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A handle that stops a search. All clones share one request, so that another thread, such as a signal handler, can
/// raise it.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    raised: Arc<AtomicBool>,
    /// The time at which the search has to stop in any case, and the duration until then.
    limit: Option<(Instant, Duration)>,
}

impl Interrupt {
    /// A request with a time limit as well, counted from now.
    #[must_use]
    pub fn after(time: Duration) -> Self {
        Self { raised: Arc::default(), limit: Some((Instant::now() + time, time)) }
    }

    /// Requests that the search stop.
    pub fn raise(&self) {
        self.raised.store(true, Ordering::Relaxed);
    }

    /// The reason to stop the search, if there is one.
    #[must_use]
    pub fn stopped(&self) -> Option<Stopped> {
        if self.raised.load(Ordering::Relaxed) {
            return Some(Stopped::Interrupt);
        }
        let over = self.limit.filter(|(at, _)| Instant::now() >= *at);
        over.map(|(_, limit)| Stopped::TimeLimit(limit))
    }

    /// Returns true if the search has to stop.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.stopped().is_some()
    }
}

/// The reason for stopping a search early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The time limit was reached.
    TimeLimit(Duration),
    /// The [`Interrupt`] was raised.
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

/// The timer of a search: its start, and the conditions that stop it.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    began: Instant,
    limit: Option<Duration>,
    interrupt: Interrupt,
}

impl Watch {
    /// Starts the timer now.
    pub fn start(limit: Option<Duration>, interrupt: &Interrupt) -> Self {
        Self { began: Instant::now(), limit, interrupt: interrupt.clone() }
    }

    /// Returns true if this fraction of the time limit has passed.
    pub fn is_late(&self, share: f64) -> bool {
        let limit = self.limit.map(|limit| limit.mul_f64(share));
        limit.is_some_and(|limit| self.began.elapsed() >= limit)
    }

    /// The reason to stop, if there is one.
    pub fn stopped(&self) -> Option<Stopped> {
        let over = || self.limit.filter(|_| self.is_late(1.0));
        self.interrupt.stopped().or_else(|| over().map(Stopped::TimeLimit))
    }
}
