//! Solves of the sets of a sweep on all cores.

use super::{ParameterSet, Row, Sweep};
use aghf::direct::DirectSettings;
use aghf::error::{Error, Result, check_count};
use aghf::motion::Interrupt;
use aghf_scenario::Solve;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Solves `sets` of `sweep`, each on one thread, `jobs` at a time or on all cores if `None`. `done` is called with each
/// row as soon as it is complete, from any thread and in any order.
///
/// # Errors
/// `jobs` is out of range, a motion cannot be written, or an error of `done`, after which no further solve begins. A
/// problem that is refused, or whose solve fails, is not an error: its row gives the reason.
pub fn run(
    sweep: &Sweep,
    sets: &[ParameterSet],
    jobs: Option<usize>,
    done: &(dyn Fn(Row) -> Result<()> + Sync),
) -> Result<()> {
    if let Some(jobs) = jobs {
        check_count("jobs", jobs, 1..=DirectSettings::MAX_THREADS)?;
    }
    let threads = ThreadPoolBuilder::new().num_threads(jobs.unwrap_or(0));
    let pool = threads.build().map_err(|e| Error::input("settings", "jobs", e.to_string()))?;
    pool.install(|| {
        // One set at a time, because the times of sets differ by a factor of up to a thousand.
        let queue = sets.par_iter().with_max_len(1);
        queue.try_for_each(|set| done(solve_set(sweep, set)?))
    })
}

/// The row of one set, and its motion if motions are kept. A refused problem is a row, and so is a panic, which should
/// not occur.
fn solve_set(sweep: &Sweep, set: &ParameterSet) -> Result<Row> {
    let started = Instant::now();
    let scenario = match sweep.scenario(set) {
        Ok(scenario) => scenario,
        Err(reason) => return Ok(Row::refused(sweep, set, reason, 0.0)),
    };
    let solved = caught(|| {
        scenario.check_feasible()?;
        let solve = Solve::new(scenario).options(sweep.options(set)?);
        solve.interrupt(Interrupt::after(sweep.time_limit())).run()
    });
    let seconds = started.elapsed().as_secs_f64();
    Ok(match solved {
        Ok(Ok(report)) => {
            if let Some(motions) = &sweep.motions {
                motions.write(&sweep.motion_name(set), scenario, &report)?;
            }
            Row::new(sweep, set, &report)
        }
        Ok(Err(error)) => Row::refused(sweep, set, &error.to_string(), seconds),
        Err(panic) => Row::failed(sweep, set, &panic, seconds),
    })
}

/// The result of `work`, or the message of a panic.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> std::result::Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let message = (panic.downcast_ref::<String>().map(String::as_str))
            .or(panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        format!("it panicked: {message}")
    })
}
