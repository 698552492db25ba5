//! Motions to several ends of a goal that is a set.

use crate::solve::search::Search;
use aghf::direct::{DirectSettings, DirectSolution, GoalEnd, GoalSet};
use aghf::error::Result;

/// The largest number of ends to which motions are compared.
const COMPARED: usize = 4;

/// The part of the duration of the best motion below which the bound of another end has to be for it to be tried: no
/// motion is as short as the bounds of its joints.
const PROMISING: f64 = 0.95;

impl Search<'_, '_> {
    /// The shortest of the motions that `search` finds to one end each, in the order of their bounds, as long as the
    /// bound of an end is below the duration of the best motion; by a search to all of them at once if none is valid.
    pub(crate) fn compare_ends(
        &mut self,
        search: impl Fn(&mut Search<'_, '_>) -> Result<DirectSolution>,
    ) -> Result<DirectSolution> {
        let goal = self.settings.goal.clone();
        let Some(goal) = goal.filter(|_| self.settings.start.is_none()) else {
            return search(self);
        };
        let mut best: Option<DirectSolution> = None;
        let mut iterations = Vec::new();
        let mut tried = 0;
        for end in goal.ends.iter().take(COMPARED) {
            let least = self.scenario.least_horizon_to(Some(&end.q));
            let least = least.map_or(0.0, |(.., least)| least);
            let best_yet = best.as_ref().map_or(f64::INFINITY, |best| best.curve.horizon());
            if least > PROMISING * best_yet || !self.settings.has_time(self.started) {
                break;
            }
            tried += 1;
            let settings = self.settings_to(&goal, end);
            let mut own = Search::new(self.scenario, settings, &mut *self.observe);
            let mut found = search(&mut own)?;
            iterations.append(&mut found.iterations);
            if !(found.converged && found.is_feasible()) && own.settings.has_time(own.started) {
                // To this very configuration, which is in the set.
                (own.settings.goal, own.end) = (None, Some(end.q.clone()));
                let mut fixed = search(&mut own)?;
                iterations.append(&mut fixed.iterations);
                if fixed.is_feasible() && (!found.is_feasible() || fixed.curve.horizon() < found.curve.horizon()) {
                    found = fixed;
                }
            }
            found.alternative = end.alternative;
            if found.is_feasible() && found.curve.horizon() < best_yet {
                best = Some(found);
            }
        }
        self.tried = best.is_some().then_some(tried);
        let mut found = match best {
            Some(best) => best,
            None => search(self)?,
        };
        iterations.append(&mut found.iterations);
        found.iterations = iterations;
        Ok(found)
    }

    /// The settings of a search to one end of a goal.
    fn settings_to(&self, goal: &GoalSet, end: &GoalEnd) -> DirectSettings {
        let settings = &self.settings;
        let left = |limit: std::time::Duration| limit.saturating_sub(self.started.elapsed());
        let mut own = DirectSettings {
            goal: Some(goal.with_end(end)),
            starts: settings.starts.div_ceil(COMPARED),
            time_limit: settings.time_limit.map(|limit| left(limit) / COMPARED as u32),
            ..settings.clone()
        };
        // A planned one in addition; others follow if no end is reached.
        own.search.most_starts = own.starts + 1;
        own
    }
}
