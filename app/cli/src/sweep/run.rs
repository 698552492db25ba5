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
/// Invalid input, or an error of `done`, after which no further solve begins. A failed solve is not an error: its row
/// gives the reason.
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

/// The row of one set. Infeasible limits are a failure of this set alone, and so is a panic, which should not occur.
fn solve_set(sweep: &Sweep, set: &ParameterSet) -> Result<Row> {
    let scenario = sweep.scenario(set);
    let started = Instant::now();
    if let Err(reason) = scenario.check_feasible() {
        let seconds = started.elapsed().as_secs_f64();
        return Ok(Row::failed(sweep, set, &reason.to_string(), seconds));
    }
    let solve = Solve::new(scenario).options(sweep.options(set)?).interrupt(Interrupt::after(sweep.time_limit()));
    let solved = catch_unwind(AssertUnwindSafe(|| solve.run()));
    Ok(match solved {
        Ok(outcome) => Row::new(sweep, set, &outcome?),
        Err(panic) => {
            let message = (panic.downcast_ref::<String>().map(String::as_str))
                .or(panic.downcast_ref::<&str>().copied())
                .unwrap_or("no message");
            let reason = format!("it panicked: {message}");
            Row::failed(sweep, set, &reason, started.elapsed().as_secs_f64())
        }
    })
}
