//! What came of one solve of a sweep.

use super::{ParameterSet, Parameters, Sweep};
use crate::motion::Guess;
use crate::motion::Stopped;
use crate::scenario::SolveReport;
use serde::{Deserialize, Serialize};

/// The outcome of a solve of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowOutcome {
    /// At the goal.
    Success,
    /// At the end of the flow, but the simulation with feedback misses the goal.
    GoalMissed,
    /// At the goal, but it hits something or breaks a limit that is enforced.
    Infeasible,
    /// Before the end of the flow.
    Failed,
    /// At the time limit.
    TimeLimit,
}

impl RowOutcome {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Success,
        Self::GoalMissed,
        Self::Infeasible,
        Self::Failed,
        Self::TimeLimit,
    ];

    /// Its name in the results.
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

/// A row of the results, with the columns in this order. What a solve leaves at its time limit depends on the machine, so
/// nothing is measured there; elsewhere only `solve_seconds` differs from one run to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// [`ParameterSet::index`].
    pub set: usize,
    /// The name of the scenario.
    pub scenario: String,
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The `s` to which the flow was to run.
    pub s_max: f64,
    /// The curve it started from.
    pub guess: Guess,
    /// Weight (A2) of the constraints, if it was set.
    pub k_cons: Option<f64>,
    /// Sharpness (A3) of the constraints, if it was set.
    pub c_cons: Option<f64>,
    /// The outcome.
    pub outcome: RowOutcome,
    /// The reason why it failed, if it did.
    pub reason: Option<String>,
    /// The final error of the simulation with feedback, if that came to its end.
    pub final_error_inf: Option<f64>,
    /// The same without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// $\int |u|^2 dt$.
    pub control_effort: Option<f64>,
    /// The action.
    pub action: Option<f64>,
    /// $\max |\dot q - v|_\infty$.
    pub dynamics_defect: Option<f64>,
    /// The smallest clearance in m, where there are obstacles.
    pub smallest_clearance_m: Option<f64>,
    /// Accepted steps of the integrator.
    pub steps: Option<usize>,
    /// Evaluations of $\Omega$, each at one node.
    pub omega_evaluations: Option<usize>,
    /// Evaluations of the Jacobian of $\Omega$, each at one node.
    pub jacobian_evaluations: Option<usize>,
    /// Wall time of the solve.
    pub solve_seconds: f64,
}

impl Row {
    /// The row of a set that failed for this reason before anything could be measured.
    #[must_use]
    pub fn failed(sweep: &Sweep, set: &ParameterSet, reason: &str, solve_seconds: f64) -> Self {
        let p = set.parameters;
        Self {
            set: set.index,
            scenario: sweep.scenarios[set.scenario].name.clone(),
            p: p.p,
            k: p.k,
            s_max: p.s_max,
            guess: p.guess,
            k_cons: p.k_cons,
            c_cons: p.c_cons,
            outcome: RowOutcome::Failed,
            reason: Some(one_line(reason)),
            final_error_inf: None,
            open_loop_error_inf: None,
            control_effort: None,
            action: None,
            dynamics_defect: None,
            smallest_clearance_m: None,
            steps: None,
            omega_evaluations: None,
            jacobian_evaluations: None,
            solve_seconds,
        }
    }

    /// The row of a set that was solved.
    #[must_use]
    pub fn new(sweep: &Sweep, set: &ParameterSet, outcome: &SolveReport) -> Self {
        let s = &outcome.summary;
        let flow = s.details.flow();
        if matches!(outcome.stopped, Some(Stopped::TimeLimit(_))) {
            let reason = format!("time limit of {} s reached", sweep.file.timeout_s);
            return Self {
                outcome: RowOutcome::TimeLimit,
                ..Self::failed(sweep, set, &reason, s.solve_seconds)
            };
        }
        Self {
            reason: s.failure.as_deref().map(one_line),
            outcome: if s.success {
                RowOutcome::Success
            } else if !outcome.completed {
                RowOutcome::Failed
            } else if s.final_error_inf.is_some_and(|e| e < s.success_threshold) {
                RowOutcome::Infeasible
            } else {
                RowOutcome::GoalMissed
            },
            final_error_inf: s.final_error_inf,
            open_loop_error_inf: s.open_loop_error_inf,
            control_effort: Some(s.control_effort),
            action: flow.map(|f| f.action),
            dynamics_defect: Some(s.dynamics_defect),
            smallest_clearance_m: s.feasibility.smallest_clearance_m,
            steps: flow.map(|f| f.steps),
            omega_evaluations: flow.map(|f| f.omega_evaluations),
            jacobian_evaluations: flow.map(|f| f.jacobian_evaluations),
            ..Self::failed(sweep, set, "", s.solve_seconds)
        }
    }

    /// The parameters of its set.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        Parameters {
            p: self.p,
            k: self.k,
            s_max: self.s_max,
            guess: self.guess,
            k_cons: self.k_cons,
            c_cons: self.c_cons,
        }
    }

    /// Tells whether another run came to the same, whatever time it took.
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

/// A row is one line of the file.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
