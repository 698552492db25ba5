//! The result of one solve of a sweep.

use super::grid::Parameters;
use super::{ParameterSet, Sweep};
use aghf::relax::RelaxSettings;
use aghf_scenario::{Details, Method, SolveReport};
use csv::StringRecord;
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

/// The outcome of a solve of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowOutcome {
    /// The motion reaches the goal.
    Success,
    /// The flow completed, but the simulation with feedback misses the goal.
    GoalMissed,
    /// The motion reaches the goal, but collides or violates an enforced limit.
    Infeasible,
    /// The flow did not complete, the relaxation did not reach a minimum, or the scenario is infeasible.
    Failed,
    /// The time limit was reached.
    TimeLimit,
}

impl RowOutcome {
    /// All outcomes.
    pub const ALL: [Self; 5] = [
        Self::Success,
        Self::GoalMissed,
        Self::Infeasible,
        Self::Failed,
        Self::TimeLimit,
    ];

    /// The name in the results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Success => "success",
            Self::GoalMissed => "goal-missed",
            Self::Infeasible => "infeasible",
            Self::Failed => "failed",
            Self::TimeLimit => "time-limit",
        }
    }
}

/// A row of the results, with its columns in the order of the file. The state of a solve at its time limit depends on
/// the machine, so that it is not recorded; otherwise only `solve_seconds` differs between runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// [`ParameterSet::index`].
    pub set: usize,
    /// The name of the scenario.
    pub scenario: String,
    /// The parameters of its set, one column each.
    pub parameters: Parameters,
    /// The outcome.
    pub outcome: RowOutcome,
    /// The reason of a failure; `None` for a success.
    pub reason: Option<String>,
    /// The final error of the simulation with feedback; `None` if that stopped early.
    pub final_error_inf: Option<f64>,
    /// The final error of the simulation without feedback; `None` if that stopped early.
    pub open_loop_error_inf: Option<f64>,
    /// $\int |u|^2 dt$.
    pub control_effort: Option<f64>,
    /// The minimised quantity: the column `action` of the flow, `cost` of the relaxation.
    pub minimised: Option<f64>,
    /// $\max |\dot q - v|_\infty$.
    pub dynamics_defect: Option<f64>,
    /// The smallest clearance in m; `None` without obstacles.
    pub smallest_clearance_m: Option<f64>,
    /// The details of the method, one column each.
    pub work: Work,
    /// Wall time of the solve, s.
    pub solve_seconds: f64,
}

/// The method-specific details of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Work {
    /// The flow.
    Flow(FlowWork),
    /// The relaxation.
    Relax(RelaxWork),
}

/// The work of a flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub struct FlowWork {
    /// Accepted steps of the integrator.
    pub steps: Option<usize>,
    /// Evaluations of $\Omega$, each at one node.
    pub omega_evaluations: Option<usize>,
    /// Evaluations of the Jacobian of $\Omega$, each at one node.
    pub jacobian_evaluations: Option<usize>,
}

/// The end and the work of a relaxation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub struct RelaxWork {
    /// The duration of the motion, s.
    pub horizon_s: Option<f64>,
    /// The final relative gradient norm.
    pub gradient_norm: Option<f64>,
    /// The largest violation of a constraint, in its own unit; `None` without constraints.
    pub largest_violation: Option<f64>,
    /// The number of starts.
    pub starts_tried: Option<usize>,
    /// The number of minima found.
    pub minima: Option<usize>,
    /// Newton iterations, of all starts and degrees.
    pub iterations: Option<usize>,
    /// Cholesky factorisations.
    pub factorisations: Option<usize>,
}

impl Work {
    /// Details without values.
    fn none(method: Method) -> Self {
        match method {
            Method::Flow => Self::Flow(FlowWork::default()),
            Method::Relax => Self::Relax(RelaxWork::default()),
        }
    }

    fn columns<S: SerializeStruct>(&self, row: &mut S) -> Result<(), S::Error> {
        match self {
            Self::Flow(work) => {
                row.serialize_field("steps", &work.steps)?;
                row.serialize_field("omega_evaluations", &work.omega_evaluations)?;
                row.serialize_field("jacobian_evaluations", &work.jacobian_evaluations)
            }
            Self::Relax(work) => {
                row.serialize_field("horizon_s", &work.horizon_s)?;
                row.serialize_field("gradient_norm", &work.gradient_norm)?;
                row.serialize_field("largest_violation", &work.largest_violation)?;
                row.serialize_field("starts_tried", &work.starts_tried)?;
                row.serialize_field("minima", &work.minima)?;
                row.serialize_field("iterations", &work.iterations)?;
                row.serialize_field("factorisations", &work.factorisations)
            }
        }
    }
}

/// A hint for the number of columns: CSV and JSON only distinguish zero from others.
pub(super) const SOME_COLUMNS: usize = 1;

/// The name of the column of [`Row::minimised`].
pub(super) fn minimised(parameters: &Parameters) -> &'static str {
    match parameters {
        Parameters::Flow(_) => "action",
        Parameters::Relax(_) => "cost",
    }
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("Row", SOME_COLUMNS)?;
        row.serialize_field("set", &self.set)?;
        row.serialize_field("scenario", &self.scenario)?;
        self.parameters.columns(&mut row)?;
        row.serialize_field("outcome", &self.outcome)?;
        row.serialize_field("reason", &self.reason)?;
        row.serialize_field("final_error_inf", &self.final_error_inf)?;
        row.serialize_field("open_loop_error_inf", &self.open_loop_error_inf)?;
        row.serialize_field("control_effort", &self.control_effort)?;
        row.serialize_field(minimised(&self.parameters), &self.minimised)?;
        row.serialize_field("dynamics_defect", &self.dynamics_defect)?;
        row.serialize_field("smallest_clearance_m", &self.smallest_clearance_m)?;
        self.work.columns(&mut row)?;
        row.serialize_field("solve_seconds", &self.solve_seconds)?;
        row.end()
    }
}

/// The columns of all methods.
#[derive(Deserialize)]
struct Common {
    set: usize,
    scenario: String,
    outcome: RowOutcome,
    reason: Option<String>,
    final_error_inf: Option<f64>,
    open_loop_error_inf: Option<f64>,
    control_effort: Option<f64>,
    #[serde(alias = "action", alias = "cost")]
    minimised: Option<f64>,
    dynamics_defect: Option<f64>,
    smallest_clearance_m: Option<f64>,
    solve_seconds: f64,
}

impl Row {
    /// Reads a row of a sweep of this method from a line.
    pub(super) fn read(
        line: &StringRecord,
        header: &StringRecord,
        method: Method,
    ) -> csv::Result<Self> {
        let common: Common = line.deserialize(Some(header))?;
        let (parameters, work) = match method {
            Method::Flow => (
                Parameters::Flow(line.deserialize(Some(header))?),
                Work::Flow(line.deserialize(Some(header))?),
            ),
            Method::Relax => (
                Parameters::Relax(line.deserialize(Some(header))?),
                Work::Relax(line.deserialize(Some(header))?),
            ),
        };
        Ok(Self {
            set: common.set,
            scenario: common.scenario,
            parameters,
            outcome: common.outcome,
            reason: common.reason,
            final_error_inf: common.final_error_inf,
            open_loop_error_inf: common.open_loop_error_inf,
            control_effort: common.control_effort,
            minimised: common.minimised,
            dynamics_defect: common.dynamics_defect,
            smallest_clearance_m: common.smallest_clearance_m,
            work,
            solve_seconds: common.solve_seconds,
        })
    }

    /// The row of a set that failed for this reason before any measurement.
    #[must_use]
    pub fn failed(sweep: &Sweep, set: &ParameterSet, reason: &str, solve_seconds: f64) -> Self {
        Self {
            set: set.index,
            scenario: sweep.scenarios[set.scenario].name.clone(),
            parameters: set.parameters,
            outcome: RowOutcome::Failed,
            reason: Some(one_line(reason)),
            final_error_inf: None,
            open_loop_error_inf: None,
            control_effort: None,
            minimised: None,
            dynamics_defect: None,
            smallest_clearance_m: None,
            work: Work::none(sweep.method()),
            solve_seconds,
        }
    }

    /// The row of a set that reached its time limit.
    pub(super) fn late(sweep: &Sweep, set: &ParameterSet, solve_seconds: f64) -> Self {
        let reason = format!("time limit of {} s reached", sweep.file.timeout_s);
        Self {
            outcome: RowOutcome::TimeLimit,
            ..Self::failed(sweep, set, &reason, solve_seconds)
        }
    }

    /// The row of a solved set.
    #[must_use]
    pub fn new(sweep: &Sweep, set: &ParameterSet, report: &SolveReport) -> Self {
        let s = &report.summary;
        // An interruption that comes at the very end is noticed by none but the clock.
        if report.stopped.is_some() || s.solve_seconds >= sweep.file.timeout_s {
            return Self::late(sweep, set, s.solve_seconds);
        }
        let (minimised, work, violated) = match &s.details {
            Details::Flow(f) => {
                let work = FlowWork {
                    steps: Some(f.steps),
                    omega_evaluations: Some(f.omega_evaluations),
                    jacobian_evaluations: Some(f.jacobian_evaluations),
                };
                (f.action, Work::Flow(work), false)
            }
            Details::Rest(r) => {
                let work = FlowWork {
                    steps: Some(r.steps),
                    ..FlowWork::default()
                };
                (r.action, Work::Flow(work), false)
            }
            Details::Relax(r) => {
                let work = RelaxWork {
                    horizon_s: Some(r.horizon_s),
                    gradient_norm: Some(r.gradient_norm),
                    largest_violation: r.largest_violation,
                    starts_tried: Some(r.efforts_of_starts.len()),
                    minima: Some(r.minima.len()),
                    iterations: Some(r.iterations),
                    factorisations: Some(r.factorisations),
                };
                let violated = !s.feasibility.holds(RelaxSettings::FEASIBLE);
                let cost = r.cost.unwrap_or(s.control_effort);
                (cost, Work::Relax(work), violated)
            }
        };
        Self {
            reason: s.failure.as_deref().map(one_line),
            outcome: if s.success {
                RowOutcome::Success
            } else if violated {
                RowOutcome::Infeasible
            } else if !report.completed {
                RowOutcome::Failed
            } else if s.final_error_inf.is_some_and(|e| e < s.success_threshold) {
                RowOutcome::Infeasible
            } else {
                RowOutcome::GoalMissed
            },
            final_error_inf: s.final_error_inf,
            open_loop_error_inf: s.open_loop_error_inf,
            control_effort: Some(s.control_effort),
            minimised: Some(minimised),
            dynamics_defect: Some(s.dynamics_defect),
            smallest_clearance_m: s.feasibility.smallest_clearance_m,
            work,
            ..Self::failed(sweep, set, "", s.solve_seconds)
        }
    }

    /// Returns true if another run gave the same results, apart from the time.
    #[must_use]
    pub fn agrees(&self, other: &Self) -> bool {
        let timeless = |row: &Self| Self {
            solve_seconds: 0.0,
            ..row.clone()
        };
        // As text, because a NaN agrees with a NaN here.
        format!("{:?}", timeless(self)) == format!("{:?}", timeless(other))
    }
}

/// Removes line breaks, because a row is one line of the file.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
