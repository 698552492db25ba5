//! Solving a scenario and testing the result.

use crate::keys::passive::effort_of_joints;
use crate::results::feasibility::three_digits;
use crate::results::summary::{Details, Summary, Verdict};
use crate::solve::by_direct::search_directly;
use crate::solve::by_flow::{solve_by_flow, solve_by_flow_to_rest};
use crate::solve::search::Search;
use crate::{CurveFile, Feasibility, Method, Provenance, Scenario, SolveOptions, Solved};
use aghf::curve::Curve;
use aghf::direct::{DirectSettings, Iteration};
use aghf::error::{Error, Result};
use aghf::flow::rest::RestRecord;
use aghf::flow::{EffortSummary, FlowRecord};
use aghf::motion::{Feedback, Interrupt, Stopped, simulate};

/// The allowed violation of enforced quantities after the flow, in their own unit: penalties are not exact. Also the
/// largest difference of the velocities of a motion from the rates of its positions, as
/// [`judge`](crate::judge::Tolerances) accepts it.
const LIMIT_TOLERANCE: f64 = 1e-3;

/// The number of intervals on which the effort of passive joints is integrated.
const INTERVALS: usize = 2000;

/// The progress of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record {
    /// Progress of the published flow.
    Flow(FlowRecord),
    /// Progress of a flow to rest.
    Rest(RestRecord),
    /// Progress of the direct method.
    Direct(Iteration),
}

/// The result of a solve.
#[derive(Clone, Debug)]
pub struct SolveReport {
    /// The result in numbers.
    pub summary: Summary,
    /// The curve; the last good one if the solve failed.
    pub curve: Curve,
    /// The progress of the method.
    pub history: Vec<Record>,
    /// True if the method terminated normally.
    pub completed: bool,
    /// The reason of an early stop, if there was one.
    pub stopped: Option<Stopped>,
    /// The initial and intermediate curves.
    pub trace: Trace,
}

/// The curves at which a search began, and its other minima.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The initial curve of the motion; `None` for a flow to rest.
    pub first_guess: Option<Curve>,
    /// For the direct method: the curves of the first few [minima](aghf::direct::DirectSolution::minima), that of the
    /// motion included.
    pub minima: Vec<Curve>,
    /// For the direct method: the number of the start that led to the motion.
    pub best_start: Option<usize>,
}

/// A solve of a scenario, whose result is tested by forward simulation.
///
/// ```
/// use aghf_scenario::{DirectOptions, Scenario, Solve};
///
/// let scenario = Scenario::load("pendulum_1_swingup")?;
/// let mut iterations = 0;
/// let report = Solve::new(&scenario)
///     .options(DirectOptions { starts: Some(2), ..DirectOptions::default() })
///     .observe(|_| iterations += 1)
///     .run()?;
/// assert!(report.summary.success);
/// assert_eq!(iterations, report.history.len());
/// # Ok::<(), aghf::Error>(())
/// ```
pub struct Solve<'a> {
    pub(crate) scenario: &'a Scenario,
    pub(crate) options: SolveOptions,
    pub(crate) interrupt: Interrupt,
    pub(crate) start: Option<&'a Solved>,
    pub(crate) observe: Box<dyn FnMut(&Record) + 'a>,
}

impl<'a> Solve<'a> {
    /// A solve with default options.
    #[must_use]
    pub fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            options: SolveOptions::default(),
            interrupt: Interrupt::default(),
            start: None,
            observe: Box::new(|_| {}),
        }
    }

    /// Replaces the method and its options.
    #[must_use]
    pub fn options(self, options: impl Into<SolveOptions>) -> Self {
        let options = options.into();
        Self { options, ..self }
    }

    /// Sets the handle by which another thread stops the solve, as a time limit does.
    #[must_use]
    pub fn interrupt(self, interrupt: Interrupt) -> Self {
        Self { interrupt, ..self }
    }

    /// Starts a direct solve from the motion of another one, with its multipliers if the number of constraints is the
    /// same, instead of from several starts. The goal, the obstacles and the limits may differ.
    #[must_use]
    pub fn start(self, start: &'a Solved) -> Self {
        let start = Some(start);
        Self { start, ..self }
    }

    /// Sets a function that is called with the progress.
    #[must_use]
    pub fn observe(self, observe: impl FnMut(&Record) + 'a) -> Self {
        let observe = Box::new(observe);
        Self { observe, ..self }
    }

    /// Solves the scenario.
    ///
    /// # Errors
    /// Invalid input, such as a scenario that [has no solution for an obvious reason](Scenario::check_feasible). A
    /// failed solve is not an error: its summary gives the reason.
    pub fn run(self) -> Result<SolveReport> {
        let Self { scenario, options, interrupt, start, mut observe } = self;
        if start.is_some() && options.method() != Method::Direct {
            let condition = "only the direct method starts from another motion";
            return Err(Error::input("options", "start", condition));
        }
        scenario.refuse_walk()?;
        options.check(scenario)?;
        scenario.check_feasible()?;
        scenario.check_for(options.method())?;
        let observe = &mut *observe;
        let found = match &options {
            SolveOptions::Direct(own) => {
                let run = |search: &mut Search<'_, '_>| search.run();
                search_directly(scenario, own, (start, interrupt), observe, run)?.1
            }
            SolveOptions::Flow(own) => solve_by_flow(scenario, own, interrupt, observe)?,
            SolveOptions::Rest(own) | SolveOptions::Duals(own) | SolveOptions::TwoPhases(own) => {
                let method = options.method();
                solve_by_flow_to_rest(scenario, own, method, interrupt, observe)?
            }
        };
        report_of(scenario, &options, found)
    }
}

/// The result of a method.
pub(crate) struct Solution {
    pub curve: Curve,
    pub effort: EffortSummary,
    pub history: Vec<Record>,
    pub details: Details,
    pub solve_seconds: f64,
    /// The reason why the method did not terminate normally.
    pub failure: Option<String>,
    pub stopped: Option<Stopped>,
    pub trace: Trace,
}

/// The report of a curve, independent of the method.
pub(crate) fn report_of(scenario: &Scenario, options: &SolveOptions, found: Solution) -> Result<SolveReport> {
    let (model, passive) = (&scenario.model, scenario.passive());
    let joints = model.joints().iter().map(|joint| joint.name().to_owned());
    let (curve, effort) = (found.curve, found.effort);
    let method = options.method();
    let final_error = |feedback| -> Result<Option<f64>> {
        let simulation = simulate(model, &curve, feedback, &passive)?;
        Ok(simulation.failure.is_none().then_some(simulation.error_inf))
    };
    let final_error_inf = final_error(scenario.file.feedback)?;
    let feasibility = Feasibility::of(scenario, &curve)?;
    let conclusion = Conclusion::new(Outcome {
        method,
        s_max: found.details.s_max(),
        defect: effort.dynamics_defect,
        has_passive: !passive.is_empty(),
        feasibility: &feasibility,
        overflow: !effort.control_effort.is_finite(),
        missed: missed(final_error_inf, scenario.file.success_threshold),
        failure: found.failure,
        stopped: found.stopped,
    });
    let (verdict, success) = (conclusion.verdict, conclusion.verdict.is_success());
    let mut notes = scenario.notes(method);
    notes.extend(scenario.far_obstacles()?);
    if let Details::Direct(details) = &found.details {
        notes.extend(details.start.clone());
    }
    notes.extend(scenario.not_reached(curve.horizon()));
    notes.extend(conclusion.notes);
    let mut reasons = conclusion.reasons;
    reasons.extend(scenario.fixed_horizon());
    let effort_of_passive = effort_of_joints(model, &curve, &passive, INTERVALS)?;
    let summary = Summary {
        scenario: scenario.name.clone(),
        robot: scenario.file.robot.clone(),
        method,
        degree: curve.degree(),
        segments: curve.segments(),
        verdict,
        success,
        success_threshold: scenario.file.success_threshold,
        final_error_inf,
        open_loop_error_inf: final_error(Feedback::NONE)?,
        feedback: scenario.file.feedback,
        // A difference below zero is a rounding error.
        control_effort: (effort.control_effort - effort_of_passive).max(0.0),
        dynamics_defect: effort.dynamics_defect,
        solve_seconds: found.solve_seconds,
        details: found.details,
        failure: (!success).then(|| reasons.join("; ")),
        feasibility,
        outside_limits: scenario.outside_limits(),
        notes,
        provenance: Provenance::new(scenario, options)?,
        curve: CurveFile::new(&curve, joints.collect()),
    };
    Ok(SolveReport {
        summary,
        curve,
        history: found.history,
        completed: conclusion.completed,
        stopped: found.stopped,
        trace: found.trace,
    })
}

/// The reason why the forward simulation does not reach the goal, `None` if it does. Its final error is `None` if it
/// stopped before its end.
fn missed(final_error: Option<f64>, threshold: f64) -> Option<String> {
    match final_error {
        Some(error) if error < threshold => None,
        Some(error) => {
            Some(format!("the forward simulation with feedback ends {error:.2e} from the goal, beyond {threshold}"))
        }
        None => Some("the forward simulation with feedback stopped before its end".to_owned()),
    }
}

/// The end of a solve, as far as the verdict depends on it.
struct Outcome<'a> {
    method: Method,
    /// The end of the published flow.
    s_max: Option<f64>,
    /// The largest difference of velocities from the rates of positions, rad/s or m/s.
    defect: f64,
    has_passive: bool,
    feasibility: &'a Feasibility,
    /// True if the torques are no finite numbers.
    overflow: bool,
    missed: Option<String>,
    failure: Option<String>,
    stopped: Option<Stopped>,
}

/// A verdict with its reasons.
struct Conclusion {
    verdict: Verdict,
    /// True if the method terminated normally.
    completed: bool,
    /// The remarks on a motion that is valid.
    notes: Vec<String>,
    /// The reasons why a motion is not valid: all violations, and the simulation where it decides.
    reasons: Vec<String>,
}

impl Conclusion {
    fn new(outcome: Outcome<'_>) -> Self {
        let Outcome { method, s_max, defect, failure, .. } = outcome;
        let tolerance = match method {
            Method::Direct => DirectSettings::FEASIBLE,
            Method::Flow | Method::Rest | Method::Duals | Method::TwoPhases => LIMIT_TOLERANCE,
        };
        let completed = failure.is_none();
        // After a flow the simulation decides as well. After the direct method it only measures sensitivity, except
        // with passive joints, where it shows whether zero torque there suffices.
        let simulated = method != Method::Direct || outcome.has_passive;
        // Before its end the curve of the published flow is no motion: velocities are not the rates of positions.
        let ended = completed || method != Method::Flow;
        let kept = outcome.feasibility.holds(tolerance) && !outcome.overflow;
        // The published flow ends with a defect that decreases with s_max and with k.
        let is_motion = s_max.is_some() || defect <= LIMIT_TOLERANCE;
        let reaches_goal = outcome.missed.is_none() || !simulated;
        let verdict = match ended && kept && is_motion && reaches_goal {
            true if s_max.is_some() => Verdict::AtSMax,
            true if completed => Verdict::Optimal,
            true => Verdict::Valid,
            false => Verdict::NotValid,
        };
        let off = three_digits(defect, f64::round);
        let off = format!("velocities differ from the rates of positions by up to {off}");
        let (mut notes, mut reasons) = (Vec::new(), Vec::new());
        if verdict.is_success() {
            notes.extend(
                s_max.map(|s_max| format!("the curve of the flow at s = {s_max:e}, which is no minimum: its {off}")),
            );
            let controlled = |missed| format!("{missed}: the motion needs a better controller");
            notes.extend(outcome.missed.map(controlled));
            notes.extend(match (failure, outcome.stopped) {
                (Some(failure), _) => Some(format!("not optimal: {failure}")),
                (None, Some(stopped)) => Some(format!("{stopped}: the motion is the best minimum until then")),
                (None, None) => None,
            });
        } else {
            let overflow = "the torques of the motion are not finite".to_owned();
            let missed = outcome.missed.filter(|_| completed && simulated);
            reasons.extend(failure);
            reasons.extend(outcome.feasibility.reason(tolerance));
            reasons.extend(outcome.overflow.then_some(overflow));
            reasons.extend((!is_motion).then(|| format!("{off}, beyond {LIMIT_TOLERANCE}")));
            reasons.extend(missed);
        }
        Self { verdict, completed, notes, reasons }
    }
}
