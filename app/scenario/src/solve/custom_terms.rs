//! User-defined constraints and running costs, which no key of a scenario can express.

use crate::Scenario;
use aghf::constraint::{AnyConstraint, Constraint, Evaluator, RowLabel, StageConstraint, StandingFoot};
use aghf::cost::{
    ControlEffort, ControlTerm, CostThroughDynamics, CostWithControl, InPhases, Point, PointCost, PointDerivatives,
    Points, PointsDerivatives, RunningCost,
};
use aghf::direct::DirectSettings;
use aghf::error::{Error, Result};
use aghf::model::Model;
use nalgebra::DMatrix;
use std::fmt::{self, Debug};
use std::sync::{Arc, OnceLock};

/// The most violated row of constraints at a state $[q; v]$, and its [excess](aghf::constraint::RowForm::excess), which
/// is negative if all rows are satisfied; `None` without rows.
pub(crate) fn worst_row(constraints: &[AnyConstraint], model: &Model, x: &[f64]) -> Result<Option<(f64, RowLabel)>> {
    Evaluator::new(model).at(x)?.worst_row(constraints)
}

/// A running cost of any type.
pub type SharedCost = Arc<dyn RunningCost + Send + Sync>;

/// The conditions along the way, a standing foot, user-defined constraints and a user-defined running cost.
#[derive(Clone, Default)]
pub(crate) struct CustomTerms {
    pub constraints: Vec<AnyConstraint>,
    pub stage: Vec<Arc<dyn StageConstraint>>,
    pub foot: Option<StandingFoot>,
    pub running_cost: Option<SharedCost>,
    /// The numbers of constraints on the state and in $(t, q, v, a, u)$ that were added in code, the last ones.
    pub added: [usize; 2],
}

impl CustomTerms {
    /// Adds what was added to others in code, and takes over their running cost.
    pub fn take_added(&mut self, from: &Self) {
        let [state, stage] = from.added;
        self.constraints.extend_from_slice(&from.constraints[from.constraints.len() - state..]);
        self.stage.extend_from_slice(&from.stage[from.stage.len() - stage..]);
        self.running_cost.clone_from(&from.running_cost);
        self.added = from.added;
    }
}

impl Debug for CustomTerms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CustomTerms")
            .field("constraints", &self.constraints)
            .field("stage", &self.stage)
            .field("foot", &self.foot)
            .field("running_cost", &self.running_cost.is_some())
            .finish()
    }
}

impl Scenario {
    /// Adds a constraint on the state to those of the keys. A solve enforces it, and its success depends on it, in the
    /// same way; [`judge`](crate::judge) does not know it, and says so.
    pub fn add_constraint(&mut self, constraint: impl Constraint + Clone + Debug + Send + Sync + 'static) {
        let constraint = AnyConstraint::Other(Box::new(constraint));
        self.own.constraints.push(constraint);
        self.own.added[0] += 1;
        // An end keeps it, too.
        self.ends = OnceLock::new();
    }

    /// Adds rows in $(t, q, v, a, u)$, such as a limit of the power, likewise. Only the direct method supports them.
    pub fn add_stage_constraint(&mut self, constraint: impl StageConstraint + 'static) {
        self.own.stage.push(Arc::new(constraint));
        self.own.added[1] += 1;
    }

    /// The number of constraints that were added in code, which no key has.
    #[must_use]
    pub fn added_constraints(&self) -> usize {
        self.own.added.iter().sum()
    }

    /// Replaces the running cost of the scenario. Only the direct method supports this.
    pub fn set_running_cost(&mut self, cost: SharedCost) {
        self.own.running_cost = Some(cost);
    }

    /// Refuses a boundary state that violates a user-defined constraint.
    pub(crate) fn check_own_constraints(&self, key: &str, q: &[f64], v: &[f64]) -> Result<()> {
        let worst = worst_row(&self.own.constraints, &self.model, &[q, v].concat())?;
        if let Some((by, RowLabel { name, unit, .. })) = worst
            && by > DirectSettings::FEASIBLE
        {
            let space = if unit.is_empty() { "" } else { " " };
            let condition = format!("it violates {name} by {by:.3e}{space}{unit}");
            return Err(Error::input(&self.name, key, condition));
        }
        Ok(())
    }

    /// The user-defined running cost, if there is one.
    pub(crate) fn own_cost(&self) -> Option<ScenarioCost<'_>> {
        let own = self.own.running_cost.clone()?;
        let cost = CostThroughDynamics::of(&self.model, own);
        Some(ScenarioCost::Own(Box::new(cost)))
    }
}

/// The running cost of a scenario.
#[derive(Clone)]
pub(crate) enum ScenarioCost<'m> {
    /// Weighted squares.
    Squares(Box<ControlEffort<'m, f64, f64>>),
    /// A user-defined cost.
    Own(Box<CostThroughDynamics<'m, SharedCost>>),
    /// The control effort in phases.
    Phases(Box<InPhases<ControlEffort<'m, f64, f64>>>),
}

/// Applies the same expression to either variant.
macro_rules! either {
    ($of:expr, $it:ident => $what:expr) => {
        match $of {
            ScenarioCost::Squares($it) => $what,
            ScenarioCost::Own($it) => $what,
            ScenarioCost::Phases($it) => $what,
        }
    };
}

impl PointCost<f64> for ScenarioCost<'_> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        either!(self, it => it.value(point))
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> Result<f64> {
        either!(self, it => it.derivatives(point, out))
    }

    fn time_rate(&mut self, point: Point<'_, f64>) -> Result<f64> {
        either!(self, it => it.time_rate(point))
    }

    fn order(&self) -> usize {
        either!(self, it => it.order())
    }

    fn phases(&self) -> usize {
        either!(self, it => it.phases())
    }

    fn values(&mut self, points: Points<'_, f64>, costs: &mut [f64]) -> Result<()> {
        either!(self, it => it.values(points, costs))
    }

    fn all_derivatives(&mut self, points: Points<'_, f64>, out: &mut PointsDerivatives<f64>) -> Result<()> {
        either!(self, it => it.all_derivatives(points, out))
    }
}

impl CostWithControl for ScenarioCost<'_> {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> Result<()> {
        either!(self, it => it.values_with_control(points, costs, controls))
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<()> {
        either!(self, it => it.all_derivatives_with(points, out, term))
    }
}
