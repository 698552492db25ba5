//! The result of a solve in numbers.

use crate::{CurveFile, Feasibility, Method, MultipliersFile, Provenance, Quantity};
use aghf::direct::{DegreeRefinement, LocalMinimum};
use aghf::flow::jacobian::JacobianKind;
use aghf::motion::{Feedback, Guess};
use aghf::ode::IntegratorKind;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// The verdict on a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is valid, and the search converged.
    Optimal,
    /// It keeps everything that the scenario enforces.
    Valid,
    /// The curve of the published flow at `s_max` as a successful one in the paper: it keeps the constraints, and the
    /// simulation with feedback ends at the goal. It is neither a minimum nor, as its velocities differ from the rates
    /// of its positions by [`Summary::dynamics_defect`], exactly a motion.
    AtSMax,
    /// It violates something, or there is none.
    NotValid,
}

impl Verdict {
    /// True unless the motion is not valid.
    #[must_use]
    pub fn is_success(self) -> bool {
        self != Self::NotValid
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Optimal => "optimal",
            Self::Valid => "valid",
            Self::AtSMax => "at s_max",
            Self::NotValid => "not valid",
        })
    }
}

/// The result of a solve in numbers. `None` if a simulation could not be completed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Summary {
    /// The name of the scenario.
    pub scenario: String,
    /// The name of the robot.
    pub robot: String,
    /// The method.
    pub method: Method,
    /// Degree of the polynomial, or of each segment.
    pub degree: usize,
    /// The number of polynomials on equal parts of the horizon.
    pub segments: usize,
    /// The verdict. A motion is valid if it is free of collisions, satisfies the enforced limits, leaves passive joints
    /// without torque ([`Feasibility::holds`]), and has the rates of its positions as velocities, to 1e-3. After a
    /// flow, and with passive joints after any method, the simulation with feedback must also end within the threshold
    /// of the goal. It is optimal if the method terminated normally as well. The published flow does not test whether
    /// it is at rest, so at its end a curve is at most [at s_max](Verdict::AtSMax).
    pub verdict: Verdict,
    /// True unless the motion is not valid.
    pub success: bool,
    /// The largest final error of the simulation with feedback, where that decides.
    pub success_threshold: f64,
    /// The final error of the simulation with feedback: the largest of all positions and velocities.
    pub final_error_inf: Option<f64>,
    /// The final error of the simulation without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// The gains of the feedback.
    pub feedback: Feedback,
    /// $\int |u|^2 dt$ on 2001 times, without the torques of passive joints.
    pub control_effort: f64,
    /// $\max |\dot q - v|_\infty$ on 2001 times.
    pub dynamics_defect: f64,
    /// Wall time of the method, s.
    pub solve_seconds: f64,
    /// The details of the method; in JSON their fields are at the level of the others.
    #[serde(flatten)]
    pub details: Details,
    /// The reasons why the motion is not valid, the worst violations first; `None` if it is.
    pub failure: Option<String>,
    /// The clearance of the curve, the limits that it violates, and its largest torques.
    #[serde(flatten)]
    pub feasibility: Feasibility,
    /// Boundary positions outside joint limits.
    pub outside_limits: Vec<String>,
    /// The keys of the scenario that the method ignored, and other remarks, in words.
    pub notes: Vec<String>,
    /// All inputs of the solve.
    pub provenance: Provenance,
    /// The motion.
    pub curve: CurveFile,
}

/// The method-specific part of a summary.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Details {
    /// Details of the published flow.
    Flow(FlowDetails),
    /// Details of a flow to rest.
    Rest(RestDetails),
    /// Details of the direct method.
    Direct(Box<DirectDetails>),
}

impl Details {
    /// The end of the published flow.
    pub(crate) fn s_max(&self) -> Option<f64> {
        match self {
            Self::Flow(details) => Some(details.s_max),
            Self::Rest(_) | Self::Direct(_) => None,
        }
    }
}

/// The parameters and the work of a flow.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FlowDetails {
    /// The method of computing the Jacobian.
    pub jacobian: JacobianKind,
    /// The integrator.
    pub integrator: IntegratorKind,
    /// Penalty of (11).
    pub k: f64,
    /// The value of `s` at which the flow was to stop.
    pub s_max: f64,
    /// Tolerance of the integrator.
    pub tolerance: f64,
    /// The initial curve.
    pub guess: Guess,
    /// Weight of the constraints in (A2), where there are any.
    pub k_cons: Option<f64>,
    /// Sharpness of their activation in (A3).
    pub c_cons: Option<f64>,
    /// The action on 2001 times.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub action: f64,
    /// The action by quadrature over the nodes, which the flow minimises.
    pub action_at_nodes: f64,
    /// The action at the nodes before the flow; `None` if the flow could not begin.
    pub action_at_nodes_of_guess: Option<f64>,
    /// Accepted steps of the integrator.
    pub steps: usize,
    /// Rejected steps.
    pub rejected_steps: usize,
    /// Evaluations of $\Omega$, each at one node.
    pub omega_evaluations: usize,
    /// Evaluations of the Jacobian of $\Omega$, each at one node.
    pub jacobian_evaluations: usize,
    /// LU factorisations of the Newton matrix.
    pub factorisations: usize,
}

/// The result and the work of a flow to rest.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RestDetails {
    /// Penalty of (11).
    pub k: f64,
    /// The requested gradient norm, relative to the action.
    pub tolerance: f64,
    /// The final gradient norm.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub gradient_norm: f64,
    /// The action with the terms of the duals, which vanish where the constraints hold.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub action: f64,
    /// The largest slip at the points of the quadrature, rad/s or m/s.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub slip: f64,
    /// The largest [violation](aghf::motion::Violation::by) of a constraint; `None` without constraints.
    pub largest_violation: Option<f64>,
    /// The number of the start that led to this result, counted from zero.
    pub best_start: usize,
    /// The number of starts.
    pub starts_tried: usize,
    /// Steps in `s`, over all starts and degrees.
    pub steps: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
    /// Updates of the duals.
    pub dual_updates: usize,
}

/// The result and the work of a direct solve.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DirectDetails {
    /// A note on the motion from which the search [started](crate::Solve::start), if there was one: whether its
    /// multipliers were kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// The multipliers of the rows, from which another search can start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multipliers: Option<MultipliersFile>,
    /// The bounds of the duration and the cost of a second in the last search, to which the multipliers belong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_search: Option<LastSearch>,
    /// The duration of the motion, s: that of the scenario, or the optimal one if it is free.
    pub horizon_s: f64,
    /// The shortest horizon that the limits of the joints allow, if the horizon is free; `None` without such limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_bound: Option<HorizonBound>,
    /// The minimised cost in the units of the objective: the control effort or the weighted sum; with the preset
    /// `least-time` the effort alone, which was not minimised.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub cost: f64,
    /// The requested gradient norm, relative to the effort.
    pub tolerance: f64,
    /// The final gradient norm.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub gradient_norm: f64,
    /// The smallest eigenvalue of the Hessian in the Gauss-Newton metric: positive at a minimum. NaN, `null` in JSON,
    /// if the search has not converged.
    #[serde(deserialize_with = "not_finite_for_null")]
    pub smallest_curvature: f64,
    /// The largest [violation](aghf::motion::Violation::by) of a constraint; `None` without constraints.
    pub largest_violation: Option<f64>,
    /// The number of unknowns.
    pub unknowns: usize,
    /// The largest deviation within one interval of a replay that uses only the control values at the nodes, see
    /// [`replay_error`](aghf::motion::replay_error).
    pub replay_error_inf: Option<f64>,
    /// The refinement of the degree, if that was adaptive.
    pub adapted: Option<DegreeRefinement>,
    /// The number of quadrature points per segment.
    pub quadrature_points: usize,
    /// The number of starts.
    pub starts_tried: usize,
    /// The costs of the starts at the lowest degree, without that of a free horizon, ascending.
    #[serde(deserialize_with = "not_finite_in_list")]
    pub start_costs: Vec<f64>,
    /// The minima found from the starts, by cost.
    pub minima: Vec<LocalMinimum>,
    /// The norm of the gradient of the Lagrangian relative to the cost, dual to that of velocities.
    pub stationarity: f64,
    /// The relative excess of the cost over that of the minimum with exact complementarity; `None` without constraints.
    pub complementarity: Option<f64>,
    /// Newton iterations over all starts and degrees.
    pub iterations: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
    /// The times of the waypoints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waypoint_times_s: Vec<f64>,
    /// The end in a goal that is a set; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end: Option<ReachedEnd>,
}

/// The bounds of a free horizon and its weight in the last search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LastSearch {
    /// The shortest horizon, s.
    pub shortest_s: f64,
    /// The longest horizon, s.
    pub longest_s: f64,
    /// The cost of a second.
    pub weight: f64,
}

/// A lower bound of the duration of a motion: no motion between the ends is shorter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HorizonBound {
    /// The bound, s.
    pub least_s: f64,
    /// The joint that takes longest.
    pub joint: String,
    /// The limit at which it takes that long: of velocity, acceleration or jerk.
    pub limit: Quantity,
}

/// The end of a motion in a goal that is a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReachedEnd {
    /// The index of the goal in the list of the scenario.
    pub goal: usize,
    /// The final configuration, rad or m, `N` entries.
    pub q: Vec<f64>,
    /// The number of configurations in the set that were found and compared before the search.
    pub found: usize,
    /// The number of these from which a search started.
    pub tried: usize,
    /// The measure by which they were compared, in words.
    pub measure: String,
}

/// Reads a number that JSON has no name for, written as null, as not a number.
fn not_finite_for_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Reads the numbers of a list in the same way.
fn not_finite_in_list<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let list = Vec::<Option<f64>>::deserialize(from)?.into_iter();
    Ok(list.map(|x| x.unwrap_or(f64::NAN)).collect())
}
