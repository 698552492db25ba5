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
use std::ops::Range;
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

/// The result of all starts, or of a given one.
pub(crate) struct MultistartOutcome {
    pub best: Candidate,
    /// The costs of all starts in their first basis (the lowest one except for some planned starts), ascending.
    pub first_costs: Vec<f64>,
    /// The minima, by cost.
    pub minima: Vec<LocalMinimum>,
    /// The first candidate that led to each of the first few minima.
    pub curves: Vec<Candidate>,
    /// The number of the start that led to the best minimum, unless it was given, and its initial curve.
    pub best_start: (Option<usize>, Candidate),
}

/// A start on its way to higher degrees.
struct Run {
    number: usize,
    /// Its first basis, and the curve there.
    first: usize,
    guess: Candidate,
    candidate: Candidate,
}

/// The starts of a search.
struct Multistart<'s, 'c, 'a, K, P> {
    context: Context<'c, 'a, K, P>,
    levels: &'s [Level],
    planned: &'s Planned<'c, 'a, K, P>,
    /// The least cost within the constraints per level.
    least: Vec<f64>,
    first_costs: Vec<f64>,
    /// The curves of the planned starts.
    paths: Vec<Path>,
    /// The starts that have come to their end.
    ends: Vec<Run>,
}

/// Continues as many starts as requested through all bases, and further ones while none of them succeeds.
///
/// Starts are processed in batches, whose members run in parallel. Whether a start is continued depends only on those
/// before it, in the order of their numbers: its cost must be little more than the best of theirs. Therefore additional
/// starts do not change the results of the others, on any number of cores, and more starts never give a worse result if
/// one of fewer ends within the constraints. The first start beyond the requested ones is tried by itself. If there are
/// obstacles, every other one of these starts is planned, or the first start of all if requested, until one succeeds;
/// no two of them are on the same path.
/// If a search is cut off before one of them satisfies the constraints, the reserve of the planned starts is the last
/// one.
pub(crate) fn multistart<'c, K: Constraint + Send + Sync, P: CostWithControl>(
    context: Context<'c, '_, K, P>,
    levels: &[Level],
    planned: &Planned<'c, '_, K, P>,
    log: &mut dyn FnMut(Iteration),
) -> Result<MultistartOutcome> {
    let settings = context.settings;
    let mut all = Multistart {
        context,
        levels,
        planned,
        least: vec![f64::INFINITY; levels.len()],
        first_costs: Vec::new(),
        paths: Vec::new(),
        ends: Vec::new(),
    };
    // The stages after the starts need their part of the time.
    let should_continue = settings.free_horizon.is_some() || settings.degree_tolerance.is_some();
    let share = if should_continue { settings.search.share_of_starts } else { 1.0 };
    let mut next = 0;
    loop {
        let batch = all.batch(next);
        next = batch.end;
        let starts = side_by_side(batch.collect(), settings.threads, |number| all.start(number));
        let mut runs = starts.into_iter().collect::<Result<Vec<_>>>()?;
        all.replace_repeated(&mut runs)?;
        all.minimise_on_all_levels(runs, log)?;
        if all.stopped() || context.watch.is_late(share) {
            all.add_reserve(log)?;
            break;
        }
        if next >= settings.starts && (all.is_found() || next >= settings.search.most_starts) {
            break;
        }
    }
    Ok(all.outcome())
}

impl<K: Constraint + Send + Sync, P: CostWithControl> Multistart<'_, '_, '_, K, P> {
    fn stopped(&self) -> bool {
        self.context.watch.stopped().is_some()
    }

    /// Returns true if a start has led to a motion. With a planned first start, which keeps the constraints, the motion
    /// need not be a minimum.
    fn is_found(&self) -> bool {
        let content = self.context.settings.planned_starts == PlannedStarts::First;
        let mut ends = self.ends.iter().map(|end| &end.candidate);
        ends.any(|end| end.converged || (content && end.kept))
    }

    /// The numbers of the starts of the next batch: beyond those asked for only as long as nothing is found, so that
    /// little is tried at once.
    fn batch(&self, next: usize) -> Range<usize> {
        let settings = self.context.settings;
        let search = &settings.search;
        if next < settings.starts {
            next..settings.starts.min(next + search.batch)
        } else if next == settings.starts {
            // The planned start mostly succeeds.
            next..next + 1
        } else {
            next..(next + search.more_starts).min(search.most_starts)
        }
    }

    fn start(&self, number: usize) -> Result<Run> {
        if let Some(candidate) = self.planned.start(number, &self.planned.problem(number)?)? {
            // A planned start has its own basis and enters at the highest degree.
            return Ok(self.run(number, self.levels.len() - 1, candidate));
        }
        self.bent(number)
    }

    /// A start without a path.
    fn bent(&self, number: usize) -> Result<Run> {
        let (context, settings) = (&self.context, self.context.settings);
        let problem = self.planned.problem(number)?;
        // A start is a single polynomial, whatever its later basis.
        let basis = &self.levels[0].basis;
        let one = Basis::new(1, basis.degree(), basis.continuity());
        let line = Path::line(&problem, one);
        let bends = self.planned.bends(number);
        let path = line.start(settings.start_amplitude, settings.seed, bends);
        let path = path.in_basis(basis.clone());
        let times = times_by_length(&problem, &settings.waypoints, number);
        let path = path.through(&settings.waypoints, number, &times);
        let candidate = Candidate::new(path, context.problem.horizon());
        Ok(self.run(number, 0, Candidate { times, ..candidate }))
    }

    fn run(&self, number: usize, first: usize, mut candidate: Candidate) -> Run {
        candidate.alternative = self.context.goal.map_or(0, |goal| goal.end(number).alternative);
        Run { number, first, guess: candidate.clone(), candidate }
    }

    /// Replaces planned starts on the curve of an earlier one by bent ones: where the straight line is free, it is the
    /// only path.
    fn replace_repeated(&mut self, runs: &mut [Run]) -> Result<()> {
        for run in runs.iter_mut().filter(|run| run.guess.penalty.is_some()) {
            if self.paths.contains(&run.guess.path) {
                *run = self.bent(run.number)?;
            } else {
                self.paths.push(run.guess.path.clone());
            }
        }
        Ok(())
    }

    /// Continues the starts of a batch from level to level while they are promising.
    fn minimise_on_all_levels(&mut self, mut runs: Vec<Run>, log: &mut dyn FnMut(Iteration)) -> Result<()> {
        let found_before = self.is_found();
        for (index, level) in self.levels.iter().enumerate() {
            // Starts that enter at the highest level wait.
            let (waiting, here) = runs.into_iter().partition(|run| run.first > index);
            runs = waiting;
            let work = |run| self.minimised(run, index);
            for found in side_by_side(here, self.context.settings.threads, work) {
                let Some((run, iterations)) = found? else {
                    continue;
                };
                for iteration in iterations {
                    let start = Some(run.number);
                    log(Iteration { start, ..iteration });
                }
                let should_continue = self.is_promising(&run, index) || !found_before;
                self.record(&run, index);
                if should_continue {
                    runs.push(run);
                }
            }
            if index + 1 < self.levels.len() && self.context.goal.is_some() {
                let kept = self.context.settings.search.kept_ends;
                keep_best(&mut runs, index, level.stage.feasible, kept);
            }
            runs.sort_by_key(|run| run.number);
        }
        self.ends.extend(runs);
        Ok(())
    }

    /// Minimises a start at a level, with its iterations; `None` if there is no time for it.
    fn minimised(&self, mut run: Run, index: usize) -> Result<Option<(Run, Vec<Iteration>)>> {
        let level = &self.levels[index];
        // After the end of the time one candidate is needed: the reserve if there is one, otherwise the first start.
        // First solves of the others would take long, and so would last solves of those that are worse than the
        // reserve.
        let is_needed = match &self.planned.reserve {
            Some(_) => index > run.first && run.candidate.violation <= level.stage.feasible,
            None => index > run.first || run.number == 0,
        };
        if self.stopped() && !is_needed {
            return Ok(None);
        }
        if run.first < index {
            run.candidate.change_basis(level.basis.clone());
        }
        let mut iterations = Vec::new();
        let mut log = |iteration| iterations.push(iteration);
        run.candidate = if index + 1 == self.levels.len() {
            let least = self.least[index];
            minimise_to_the_end(self.context, run.candidate, level.stage, least, &mut log)?
        } else {
            minimise(self.context, run.candidate, level.stage, &mut log)?
        };
        Ok(Some((run, iterations)))
    }

    /// Returns true if the cost of a start at a level is little more than the least one before it.
    fn is_promising(&self, run: &Run, index: usize) -> bool {
        let (least, drop_ratio) = (self.least[index], &self.context.settings.search.drop_ratio);
        let passive = self.context.rows.constraints.torque.has_passive();
        // The first one has nothing to be compared with, and at the highest level all have ended. With torques of
        // passive joints at a low level the cost says nothing about the cost without them.
        match (self.levels.len() - 1 - index).checked_sub(1) {
            Some(left) if least.is_finite() && !passive => {
                let drop_ratio = drop_ratio[left.min(drop_ratio.len() - 1)];
                run.candidate.objective <= least + drop_ratio * least.abs()
            }
            _ => true,
        }
    }

    /// Takes the cost of a start at a level into account for those after it.
    fn record(&mut self, run: &Run, index: usize) {
        let (search, candidate) = (&self.context.settings.search, &run.candidate);
        let stage = self.levels[index].stage;
        if index == run.first && !self.stopped() {
            self.first_costs.push(candidate.objective);
        }
        let inside = candidate.violation <= stage.feasible
            && candidate.passive_share <= search.passive_share
            && (!stage.last || candidate.deviation <= search.deviation);
        if inside {
            self.least[index] = self.least[index].min(candidate.objective);
        }
    }

    /// Minimises the reserve in the time that is left, if nothing satisfies the constraints.
    fn add_reserve(&mut self, log: &mut dyn FnMut(Iteration)) -> Result<()> {
        let number = self.context.settings.starts;
        let mut ends = self.ends.iter();
        let enough = |end: &Run| {
            let Candidate { converged, kept, .. } = end.candidate;
            converged || kept
        };
        if ends.any(enough) {
            return Ok(());
        }
        let Some(reserve) = self.planned.reserve_start()? else {
            return Ok(());
        };
        let mut run = self.run(number, self.levels.len() - 1, reserve);
        let stage = self.levels[run.first].stage;
        let mut log = |iteration| {
            let start = Some(number);
            log(Iteration { start, ..iteration });
        };
        run.candidate = minimise(self.context, run.candidate, stage, &mut log)?;
        self.ends.push(run);
        Ok(())
    }

    fn outcome(mut self) -> MultistartOutcome {
        let same = self.context.settings.search.same_minimum;
        self.first_costs.sort_by(f64::total_cmp);
        self.ends.sort_by(|a, b| rank(&a.candidate, &b.candidate));
        let (minima, curves) = minima_of(&self.ends, same);
        let best = self.ends.swap_remove(0);
        MultistartOutcome {
            best: best.candidate,
            first_costs: self.first_costs,
            minima,
            curves,
            best_start: (Some(best.number), best.guess),
        }
    }
}

/// The violation at a low degree up to which starts are compared by their costs, relative to the accepted one: a higher
/// degree removes so much of it.
const SMALL: f64 = 10.0;

/// Drops all but the best `kept` of the runs at this level, for a goal that is a set: they differ in their ends, which
/// the costs at a low degree rank well, and each run takes a whole search at the next degree.
fn keep_best(runs: &mut Vec<Run>, index: usize, feasible: f64, kept: usize) {
    let (mut here, waiting): (Vec<_>, Vec<_>) = runs.drain(..).partition(|run| run.first <= index);
    let order = |run: &Run| {
        let Candidate { violation, objective, .. } = run.candidate;
        (violation.max(SMALL * feasible), objective)
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
                minima.push(LocalMinimum { cost: end.objective, starts: 1 });
            }
        }
    }
    (minima, curves)
}

/// Applies `work` to each item on several threads; the results keep the order of the items.
fn side_by_side<T: Send, R: Send>(items: Vec<T>, threads: usize, work: impl Fn(T) -> R + Sync) -> Vec<R> {
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
        joined.flat_map(|own| own.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    all.sort_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, found)| found).collect()
}
