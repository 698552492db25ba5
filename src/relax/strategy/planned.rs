//! Starts that a planner finds a way for.

use crate::constraint::{Constraint, RowKind};
use crate::error::Result;
use crate::motion::Path;
use crate::plan::{Checker, Plan, PlanSettings, fit, plan};
use crate::relax::interior_point::Context;
use crate::relax::settings::Rung;
use crate::relax::tuning::PLANNED_SAMPLES;
use crate::relax::{CostWithControl, RelaxSettings};

/// Planned starts among those beyond the ones that were asked for: the first, the third and so on.
pub(super) struct Planned<'c, 'a, K, P> {
    context: Context<'c, 'a, K, P>,
    settings: &'c RelaxSettings,
    rungs: &'c [Rung],
    /// True if there is anything to go around.
    wanted: bool,
}

impl<'c, 'a, K: Constraint, P: CostWithControl> Planned<'c, 'a, K, P> {
    pub fn new(
        context: Context<'c, 'a, K, P>,
        settings: &'c RelaxSettings,
        rungs: &'c [Rung],
    ) -> Self {
        let (state, model) = (&context.rows.constraints.state, context.problem.model());
        let rows = 0..state.dim();
        let bounds = |row: usize| {
            matches!(
                state.label(row, model).kind,
                RowKind::Position(_) | RowKind::Velocity(_)
            )
        };
        let wanted = settings.planned_starts
            && !rows.clone().any(|row| state.is_equality(row))
            && !rows.clone().all(bounds);
        Self {
            context,
            settings,
            rungs,
            wanted,
        }
    }

    /// The number of the path of a start that is planned.
    fn number(&self, start: usize) -> Option<u64> {
        let beyond = start.checked_sub(self.settings.num_starts)?;
        (self.wanted && beyond.is_multiple_of(2)).then_some(beyond as u64 / 2)
    }

    /// The number of the bends of a start that is not.
    pub fn bends(&self, start: usize) -> u64 {
        let beyond = start.saturating_sub(self.settings.num_starts);
        let planned = if self.wanted { beyond.div_ceil(2) } else { 0 };
        (start - planned) as u64
    }

    /// The curve of a planned start and the lowest rung whose basis holds it free of obstacles, or the highest where none does; nothing
    /// where the start is not a planned one, no path was found, or the line is free.
    pub fn start(&self, start: usize) -> Result<Option<(usize, Path)>> {
        let Some(number) = self.number(start) else {
            return Ok(None);
        };
        let Context {
            problem,
            rows,
            watch,
            ..
        } = self.context;
        let constraint = &rows.constraints.state;
        let settings = PlanSettings {
            seed: self.settings.seed,
            number,
            ..PlanSettings::default()
        };
        let stopped = || watch.stopped().is_some();
        let Plan::Found(path) = plan(problem, constraint, &settings, &stopped)? else {
            return Ok(None);
        };
        // A line that is free is the first start.
        if path.len() == 2 {
            return Ok(None);
        }
        let mut checker = Checker::new(problem.model(), constraint, settings.resolution)?;
        let mut last = None;
        for (level, rung) in self.rungs.iter().enumerate() {
            let found = fit(problem, &path, rung.basis.clone())?;
            let times = (1..PLANNED_SAMPLES).map(|k| k as f64 / PLANNED_SAMPLES as f64);
            let samples: Vec<_> = times
                .map(|time| rung.basis.evaluate(&found.coefficients, time))
                .collect();
            let samples: Vec<&[f64]> = samples.iter().map(|[q, ..]| q.as_slice()).collect();
            let free = checker.are_free(&samples)?;
            last = Some((level, found));
            if free {
                break;
            }
        }
        Ok(last)
    }
}
