//! Work that Ctrl-C interrupts.

use pyo3::prelude::*;
use std::thread;
use std::time::Duration;

/// The interval at which the Python thread checks for signals such as Ctrl-C.
pub const LOOK: Duration = Duration::from_millis(50);

/// Works on another thread with the GIL released. After a signal it calls `stop`, waits for the work to end, and
/// returns the exception.
pub fn until_signalled<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send, stop: impl Fn()) -> PyResult<T> {
    thread::scope(|scope| {
        let work = scope.spawn(work);
        let mut signals = Ok(());
        while !work.is_finished() {
            py.detach(|| thread::sleep(LOOK));
            if let Err(error) = py.check_signals() {
                stop();
                signals = Err(error);
            }
        }
        let done = work.join();
        let done = done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        signals.map(|()| done)
    })
}
