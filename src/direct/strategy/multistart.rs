//! Several starts, each continued from the lowest degree to the highest while it is promising.

use super::passive::minimise_to_the_end;
use crate::constraint::Constraint;
use crate::cost::CostWithControl;
use crate::curve::Basis;
use crate::direct::minimise::{Candidate, Context, minimise};
use crate::direct::settings::{Level, PlannedStarts};
use crate::direct::strategy::planned::Planned;
use crate::direct::strategy::through::times_by_length;
use crate::direct::{DirectSettings, DirectSolution, Iteration};
use crate::error::Result;
use crate::motion::Path;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::sync::{Mutex, PoisonError};
use std::thread::{ScopedJoinHandle, scope};

/// A local minimum found by the starts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalMinimum {
    /// The integral of the running cost.
    pub cost: f64,
    /// The number of starts that led to it.
    pub starts: usize,
}

/// The result of all starts.
pub(crate) struct Outcome {
    pub best: Candidate,
    /// The cost of each start in its first basis (the lowest one except for some planned starts), wave by wave.
    pub first_costs: Vec<f64>,
    /// The minima, by cost.
    pub minima: Vec<LocalMinimum>,
    /// The first candidate that led to each of the first few minima.
    pub curves: Vec<Candidate>,
    /// The number of the start that led to the best minimum, and its initial curve.
    pub best_start: (usize, Candidate),
}

/// A start on its way to higher degrees.
struct Run {
    number: usize,
    /// Its first basis, and the curve there.
    first: usize,
    guess: Candidate,
    candidate: Candidate,
}

/// Continues as many starts as requested through all bases, and further ones while none of them succeeds.
///
/// Starts are processed in waves, whose members run in parallel. Whether a start is continued depends only on those
/// before it, in the order of their numbers: its cost must be hardly more than the best of theirs. Therefore additional
/// starts do not change the results of the others, on any number of cores, and more starts never give a worse result if
/// one of fewer ends within the constraints. Of the starts beyond the requested ones, the first of which is tried by
/// itself, every other one is planned if there are obstacles, or the first one if requested.
pub(crate) fn multistart<K: Constraint + Send + Sync, P: CostWithControl>(
    context: Context<'_, '_, K, P>,
    settings: &DirectSettings,
    levels: &[Level],
    planned: &Planned<'_, '_, K, P>,
    log: &mut dyn FnMut(Iteration),
) -> Result<Outcome> {
    let search = &settings.search;
    let stopped = || context.watch.stopped().is_some();
    // What comes after the starts needs its part of the time.
    let goes_on = settings.free_horizon.is_some() || settings.degree_tolerance.is_some();
    let share = if goes_on { search.share_of_starts } else { 1.0 };
    let passive = context.rows.constraints.torque.has_passive();
    // A start is a single polynomial, whatever it is to become.
    let basis = &levels[0].basis;
    let one = Basis::new(1, basis.degree(), basis.continuity());
    // Who asks for a start that keeps the constraints is content with a motion that does.
    let content = settings.planned_starts == PlannedStarts::First;
    let is_found = |end: &Run| {
        let end = &end.candidate;
        end.converged || (content && end.kept)
    };
    let mut least = vec![f64::INFINITY; levels.len()];
    let (mut first_costs, mut ends) = (Vec::new(), Vec::<Run>::new());
    let mut next = 0;
    loop {
        let found_before = ends.iter().any(is_found);
        // Beyond what was asked for only as long as nothing is found, so that little is tried at once.
        let wave = match settings.time_limit {
            _ if next < settings.starts => next..settings.starts.min(next + search.wave),
            Some(_) => next..next + search.wave,
            // The planned start mostly succeeds.
            None if next == settings.starts => next..next + 1,
            None => next..(next + search.more_starts).min(search.most_starts),
        };
        next = wave.end;
        let start = |number| {
            let problem = planned.problem(number)?;
            // A planned start has its own basis and enters at the highest degree.
            let (first, mut candidate) = match planned.start(number, &problem)? {
                Some(candidate) => (levels.len() - 1, candidate),
                None => {
                    let bends = planned.bends(number);
                    let line = Path::line(&problem, one.clone());
                    let path = line.start(settings.start_amplitude, settings.seed, bends);
                    let path = path.in_basis(levels[0].basis.clone());
                    let times = times_by_length(&problem, &settings.waypoints, number);
                    let path = path.through(&settings.waypoints, number, &times);
                    let horizon = context.problem.horizon();
                    let candidate = Candidate::new(path, horizon);
                    (0, Candidate { times, ..candidate })
                }
            };
            candidate.alternative = context.goal.map_or(0, |goal| goal.end(number).alternative);
            Ok(Run {
                number,
                first,
                guess: candidate.clone(),
                candidate,
            })
        };
        let starts = side_by_side(wave.collect(), settings.threads, start);
        let mut runs = starts.into_iter().collect::<Result<Vec<_>>>()?;
        for (index, level) in levels.iter().enumerate() {
            // Those that come in at the top wait.
            let (waiting, here) = runs.into_iter().partition(|run| run.first > index);
            runs = waiting;
            let found = side_by_side(here, settings.threads, |run| {
                // One candidate is needed; a first look at the others would go on for long after the end.
                if run.number > 0 && index == run.first && stopped() {
                    return Ok(None);
                }
                let mut candidate = run.candidate.clone();
                if run.first < index {
                    candidate.change_basis(level.basis.clone());
                }
                let mut iterations = Vec::new();
                let mut log = |iteration| iterations.push(iteration);
                let found = if index + 1 == levels.len() {
                    let least = least[index];
                    minimise_to_the_end(context, candidate, level.stage, least, &mut log)?
                } else {
                    minimise(context, candidate, level.stage, &mut log)?
                };
                let candidate = found;
                let run = Run { candidate, ..run };
                Ok(Some((run, iterations)))
            });
            for found in found {
                let Some((run, iterations)) = found? else {
                    continue;
                };
                let candidate = &run.candidate;
                for iteration in iterations {
                    let start = Some(run.number);
                    log(Iteration { start, ..iteration });
                }
                if index == run.first && !stopped() {
                    first_costs.push(candidate.objective);
                }
                // The first one has nothing to be compared with, and at the top all have come to their end. What a
                // passive joint is given at a low level says nothing of what the motion costs without.
                let goes_on = match (levels.len() - 1 - index).checked_sub(1) {
                    Some(left) if least[index].is_finite() && !passive => {
                        let hopeless = search.hopeless[left.min(search.hopeless.len() - 1)];
                        candidate.objective <= least[index] + hopeless * least[index].abs()
                    }
                    _ => true,
                };
                let inside = candidate.violation <= level.stage.feasible
                    && candidate.passive_share <= search.passive_share
                    && (!level.stage.last || candidate.deviation <= search.deviation);
                if inside {
                    least[index] = least[index].min(candidate.objective);
                }
                if goes_on || !found_before {
                    runs.push(run);
                }
            }
            if index + 1 < levels.len() && context.goal.is_some() {
                keep_best(&mut runs, index, level.stage.feasible, search.kept_ends);
            }
            runs.sort_by_key(|run| run.number);
        }
        ends.extend(runs);
        let found = ends.iter().any(is_found);
        let more = match settings.time_limit {
            Some(_) => next < DirectSettings::LARGEST_STARTS,
            None => next < settings.starts || (!found && next < search.most_starts),
        };
        if stopped() || context.watch.is_late(share) || !more {
            break;
        }
    }
    ends.sort_by(|a, b| rank(&a.candidate, &b.candidate));
    let (minima, curves) = minima_of(&ends, search.same_minimum);
    let best = ends.swap_remove(0);
    Ok(Outcome {
        best: best.candidate,
        first_costs,
        minima,
        curves,
        best_start: (best.number, best.guess),
    })
}

/// Drops all but the best `kept` of the runs at this level, for a goal that is a set: they differ in their ends, of
/// which the order of the costs at a low degree is a good sign, and each of them takes a whole search at the next one.
fn keep_best(runs: &mut Vec<Run>, index: usize, feasible: f64, kept: usize) {
    let (mut here, waiting): (Vec<_>, Vec<_>) = runs.drain(..).partition(|run| run.first <= index);
    let order = |run: &Run| {
        let Candidate {
            violation,
            objective,
            ..
        } = run.candidate;
        (violation.max(feasible), objective)
    };
    here.sort_by(|a, b| {
        let [(off, cost), (beside, other)] = [a, b].map(order);
        off.total_cmp(&beside).then(cost.total_cmp(&other))
    });
    here.truncate(kept);
    runs.extend(here);
    runs.extend(waiting);
}

/// The order of candidates: successful ones first, by their cost, then the others by their violation.
fn rank(a: &Candidate, b: &Candidate) -> Ordering {
    let by_cost = a.objective.total_cmp(&b.objective);
    match (a.converged, b.converged) {
        (true, true) => by_cost,
        (false, false) => {
            let excess = |end: &Candidate| {
                let beside = end.passive_share.max(end.deviation);
                end.violation.max(beside)
            };
            let [a, b] = [a, b].map(|end| excess(end).max(DirectSettings::FEASIBLE));
            a.total_cmp(&b).then(by_cost)
        }
        (a, b) => b.cmp(&a),
    }
}

/// The minima among sorted ends, which differ by more than the share `same`, and the curves of the first few.
fn minima_of(ends: &[Run], same: f64) -> (Vec<LocalMinimum>, Vec<Candidate>) {
    let (mut minima, mut curves) = (Vec::<LocalMinimum>::new(), Vec::new());
    let ends = ends.iter().map(|end| &end.candidate);
    for end in ends.filter(|end| end.converged) {
        match minima.last_mut() {
            Some(last) if end.objective - last.cost <= same * last.cost.abs() => last.starts += 1,
            _ => {
                if curves.len() < DirectSolution::MINIMA_CURVES {
                    curves.push(end.clone());
                }
                minima.push(LocalMinimum {
                    cost: end.objective,
                    starts: 1,
                });
            }
        }
    }
    (minima, curves)
}

/// Applies `work` to each item on several threads; the results keep the order of the items.
fn side_by_side<T: Send, R: Send>(
    items: Vec<T>,
    threads: usize,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let threads = threads.min(items.len());
    if threads <= 1 {
        return items.into_iter().map(work).collect();
    }
    let queue = Mutex::new(items.into_iter().enumerate());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let worker = || {
        let mut own = Vec::new();
        while let Some((i, item)) = next() {
            own.push((i, work(item)));
        }
        own
    };
    let mut all: Vec<(usize, R)> = scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let joined = workers.into_iter().map(ScopedJoinHandle::join);
        joined
            .flat_map(|own| own.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    all.sort_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, found)| found).collect()
}
