//! What came of a solve, in numbers.

use super::{CurveFile, Feasibility, FlowVariant, Method, Provenance};
use crate::flow::jacobian::JacobianKind;
use crate::motion::{Feedback, Guess};
use crate::ode::IntegratorKind;
use crate::relax::{DegreeRefinement, LocalMinimum};
use serde::Serialize;

/// The result of a solve, in numbers. `None` where a simulation could not be carried to its end.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The name of the scenario.
    pub scenario: String,
    /// The name of the robot.
    pub robot: String,
    /// The method by which it was solved.
    pub method: Method,
    /// Degree of the polynomial, or of each piece.
    pub p: usize,
    /// The number of polynomials.
    pub pieces: usize,
    /// True if the method came to its end, and the curve hits nothing, keeps the limits that are enforced, and leaves passive joints
    /// without torque ([`Feasibility::holds`]). After a flow, and with passive joints after any method, the simulation with feedback has to
    /// end within the threshold of the goal as well.
    pub success: bool,
    /// The threshold.
    pub success_threshold: f64,
    /// The final error of the simulation with feedback: the largest of all positions and velocities.
    pub final_error_inf: Option<f64>,
    /// The same without feedback.
    pub open_loop_error_inf: Option<f64>,
    /// The gains of the feedback.
    pub feedback: Feedback,
    /// $\int |u|^2 dt$ on 2001 times, without the torques of passive joints.
    pub control_effort: f64,
    /// $\max |\dot q - v|_\infty$ on 2001 times.
    pub dynamics_defect: f64,
    /// Wall time of the method, s.
    pub solve_seconds: f64,
    /// The details of the method; their fields stand beside the others in JSON.
    #[serde(flatten)]
    pub details: Details,
    /// The reasons why it is no success, if it is none.
    pub failure: Option<String>,
    /// The clearance of the curve from obstacles, the limits that it breaks, and its largest torques.
    #[serde(flatten)]
    pub feasibility: Feasibility,
    /// Boundary positions outside joint limits.
    pub outside_limits: Vec<String>,
    /// The keys of the scenario that the method did not look at, and whatever else is worth knowing, in words.
    pub notes: Vec<String>,
    /// All that the solve depended on.
    pub provenance: Provenance,
    /// The motion.
    pub curve: CurveFile,
}

/// The part of a summary that only one method has.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Details {
    /// Of the published flow.
    Flow(FlowDetails),
    /// Of a flow to rest.
    Rest(RestDetails),
    /// Of the relaxation.
    Relax(RelaxDetails),
}

impl Details {
    /// Those of the published flow, if it was that.
    #[must_use]
    pub fn flow(&self) -> Option<&FlowDetails> {
        match self {
            Self::Flow(flow) => Some(flow),
            Self::Rest(_) | Self::Relax(_) => None,
        }
    }
}

/// The parameters of a flow and the work it took.
#[derive(Clone, Debug, Serialize)]
pub struct FlowDetails {
    /// The way in which the Jacobian was computed.
    pub jacobian: JacobianKind,
    /// The integrator.
    pub integrator: IntegratorKind,
    /// Penalty of (11).
    pub k: f64,
    /// The `s` to which the flow was to run.
    pub s_max: f64,
    /// Tolerance of the integrator.
    pub tolerance: f64,
    /// The curve it started from.
    pub guess: Guess,
    /// Weight of the constraints in (A2), where there are any.
    pub k_cons: Option<f64>,
    /// Sharpness of their activation in (A3).
    pub c_cons: Option<f64>,
    /// The action on 2001 times.
    pub action: f64,
    /// The action by quadrature over the nodes, which is what the flow sees.
    pub action_at_nodes: f64,
    /// The action at the nodes before the flow.
    pub action_at_nodes_of_guess: f64,
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

/// The result of a flow to rest and the work it took.
#[derive(Clone, Debug, Serialize)]
pub struct RestDetails {
    /// The variant.
    pub variant: FlowVariant,
    /// Penalty of (11).
    pub k: f64,
    /// The gradient norm that was asked for, relative to the action.
    pub tolerance: f64,
    /// The gradient norm that was reached.
    pub gradient_norm: f64,
    /// The action with the terms of the duals, which vanish where the constraints hold.
    pub action: f64,
    /// The largest slip at the points of the quadrature, rad/s or m/s.
    pub slip: f64,
    /// The largest violation of a constraint, in its own unit; `None` without constraints.
    pub largest_violation: Option<f64>,
    /// The number of the guess that led here, counted from zero, and how many there were.
    pub guess: usize,
    /// As [`guess`](Self::guess).
    pub guesses: usize,
    /// Steps in `s`, all guesses and degrees together.
    pub steps: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
    /// Updates of the duals.
    pub dual_updates: usize,
}

/// The result of a relaxation and the work it took.
#[derive(Clone, Debug, Serialize)]
pub struct RelaxDetails {
    /// The duration of the motion, s: that of the scenario, or what was found where that is free.
    pub horizon_s: f64,
    /// The cost that was minimised, running cost and price of the horizon together; `None` where that is the control effort.
    pub cost: Option<f64>,
    /// The gradient norm that was asked for, relative to the effort.
    pub tolerance: f64,
    /// The gradient norm that was reached.
    pub gradient_norm: f64,
    /// The smallest eigenvalue of the Hessian in the metric of Gauss and Newton: positive at a minimum.
    pub smallest_curvature: f64,
    /// The largest violation of a constraint, in its own unit; `None` without constraints.
    pub largest_violation: Option<f64>,
    /// The number of unknowns.
    pub unknowns: usize,
    /// The largest distance from the curve to which the control by its values at the nodes alone leads within one interval, see
    /// [`replay_error`](crate::motion::replay_error).
    pub replay_error_inf: Option<f64>,
    /// The refinement of its degree, where that was adaptive.
    pub adapted: Option<DegreeRefinement>,
    /// The number of points of the quadrature of a segment.
    pub quadrature_points: usize,
    /// The efforts, or integrals of another running cost, that the starts came to at the lowest degree, ascending.
    pub efforts_of_starts: Vec<f64>,
    /// The minima that the starts led to, by cost.
    pub minima: Vec<LocalMinimum>,
    /// The relative excess of the cost over that of the minimum with exact complementarity; `None` without constraints.
    pub complementarity: Option<f64>,
    /// Iterations of Newton's method, of all starts and degrees.
    pub iterations: usize,
    /// Cholesky factorisations.
    pub factorisations: usize,
}
