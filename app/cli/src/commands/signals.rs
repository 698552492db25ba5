//! Termination requests: Ctrl-C, and signals of other programs.

#[cfg(unix)]
use super::tell;
#[cfg(unix)]
use aghf::error::Error;
use aghf::error::Result;
use aghf::motion::Interrupt;
use std::sync::OnceLock;

/// The search that the first request stops; without a search it ends the program.
static SEARCH: OnceLock<Interrupt> = OnceLock::new();

/// Makes the first request stop this search with the best motion so far; the second one ends the program.
pub(super) fn stop_first(interrupt: &Interrupt) {
    // There is one search per program.
    let _ = SEARCH.set(interrupt.clone());
}

/// Installs the handlers of termination requests, which leave nothing unfinished. From then on a file that becomes too
/// large is a write error and does not end the program.
#[cfg(unix)]
pub(super) fn listen() -> Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    let failed = |e| Error::io("signals", e);
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default()).map_err(failed)?;
    // Signals ignored by the parent, as by `nohup`, stay ignored.
    let heard = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|s| !is_ignored(*s));
    let mut signals = Signals::new(heard).map_err(failed)?;
    std::thread::spawn(move || {
        for signal in signals.forever() {
            match SEARCH.get() {
                Some(search) if !search.is_raised() => {
                    search.raise();
                    tell("aghf: stopping with the best motion so far; once more ends at once");
                }
                _ => {
                    crate::output::remove_unfinished();
                    std::process::exit(128 + signal);
                }
            }
        }
    });
    Ok(())
}

/// Returns true if a signal was ignored when the program began, if the system reports this.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (signal - 1)) != 0)
}

/// Leaves Ctrl-C to the system, which ends the program.
#[cfg(not(unix))]
pub(super) fn listen() -> Result<()> {
    Ok(())
}
