//! The grid searches of the supplement's Tables IX to XIII.

use super::{Settings, System};
use crate::sweep::{FlowPoint, ParameterSet, Ranked, Results, Shard, Sweep, best, ranking_of, run};
use aghf::error::Result;
use std::sync::{Mutex, PoisonError};

/// The result of the grid search of a system.
#[derive(Clone, Debug)]
pub struct Search {
    /// The system.
    pub system: System,
    /// The name of the sweep.
    pub sweep: String,
    /// The number of sets of parameters per scenario.
    pub sets: usize,
    /// The number of sets that succeeded in all scenarios.
    pub succeeding: usize,
    /// The total wall time of all solves, s, from all runs.
    pub solve_seconds: f64,
    /// The fastest of the sets that succeed in most scenarios, and the one of least effort; `None` if no set succeeds
    /// in any.
    pub best: Option<[BestSet; 2]>,
}

/// One of the best sets of a grid.
#[derive(Clone, Debug)]
pub struct BestSet {
    /// The parameters.
    pub point: FlowPoint,
    /// The fraction of its solves that succeeded.
    pub success_rate: f64,
    /// The mean wall time of its solves, s.
    pub solve_seconds: Option<f64>,
}

impl BestSet {
    /// The best set of a ranking entry; `None` for a set of another method.
    fn new(ranked: &Ranked) -> Option<Self> {
        Some(Self {
            point: *ranked.parameters.flow()?,
            success_rate: ranked.success_rate,
            solve_seconds: ranked.solve_seconds,
        })
    }
}

/// Solves the scenarios of `system` with the grid of the first sweep that has them all, on all cores, unless that was
/// done before; `None` without such a sweep. `progress` is called with the state.
pub(super) fn search(
    system: System,
    sweeps: &[Sweep],
    settings: &Settings,
    progress: &mut (dyn FnMut(&str) + Send),
) -> Result<Option<Search>> {
    let has = |sweep: &&Sweep| {
        (system.scenarios()).all(|name| sweep.scenarios.iter().any(|s| s.name == name))
    };
    let Some(sweep) = sweeps.iter().find(has) else {
        return Ok(None);
    };
    let results = Results::open(sweep, Shard::WHOLE, &settings.sweeps.join(&sweep.name))?;
    let (mut missing, mut all) = (results.missing(), sweep.sets.clone());
    let chosen =
        |set: &ParameterSet| (sweep.scenarios[set.scenario].name).starts_with(system.prefix);
    missing.retain(chosen);
    all.retain(chosen);
    let told = Mutex::new((all.len() - missing.len(), progress));
    run(sweep, &missing, None, &|row| {
        results.append(row)?;
        let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
        told.0 += 1;
        let words = format!("{}: {} of {} sets", sweep.name, told.0, all.len());
        (told.1)(&words);
        Ok(())
    })?;
    let rows = results.rows();
    let ranking = ranking_of(sweep, &rows, system.prefix);
    let own = (rows.iter()).filter(|row| row.scenario.starts_with(system.prefix));
    Ok(Some(Search {
        system,
        sweep: sweep.name.clone(),
        sets: ranking.len(),
        succeeding: ranking.iter().filter(|r| r.success_rate == 1.0).count(),
        solve_seconds: own.map(|row| row.solve_seconds).sum(),
        best: best(&ranking)
            .and_then(|[fastest, least]| Some([BestSet::new(fastest)?, BestSet::new(least)?])),
    }))
}
