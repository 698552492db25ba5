//! Final configurations in a goal that is a set, by inverse kinematics.

use crate::shapes::scene::{FAR, MILLIMETRES};
use crate::solve::custom_terms::worst_row;
use crate::{Goal, Quantity, Scenario};
use aghf::constraint::{AnyConstraint, RowLabel};
use aghf::curve::{Chebyshev, Curve};
use aghf::direct::{GoalEnd, GoalSet};
use aghf::error::{Error, Result, plain};
use aghf::flow::effort_of;
use aghf::model::{JointKind, Model};
use aghf::motion::Problem;
use aghf::plan::InverseKinematics;
use nalgebra::{DMatrix, Vector3};

/// The number of first guesses for each alternative.
const GUESSES: usize = 64;
/// The number of ends of an alternative after which the search for further ones stops.
const MAX_ENDS: usize = 12;
/// The least difference of some joint by which two configurations are different ends, rad or m.
const DIFFERENT: f64 = 0.2;
/// The degree of the polynomials by which the effort of first motions is compared.
const DEGREE: usize = 16;

impl Scenario {
    /// The final configuration by which the horizon and the units of an objective are measured: the one that is given,
    /// or the first one of [a goal that is a set](Self::goal_with_ends); `None` if none is found.
    pub(crate) fn aim(&self) -> Option<Vec<f64>> {
        if self.goal.is_none() {
            return self.known_goal().map(<[f64]>::to_vec);
        }
        let goal = self.goal_with_ends().ok().flatten()?;
        goal.ends.into_iter().next().map(|end| end.q)
    }

    /// The measure by which ends are compared before any search, in words.
    pub(crate) fn measure(&self) -> &'static str {
        if self.file.has_free_horizon() {
            "the least duration within the limits of the joints, then the distance"
        } else {
            "the effort of a cubic"
        }
    }

    /// The goal with the final configurations from which searches start; `None` if the goal is no set. The first ones
    /// are those with the least bound of the objective: of the duration at the limits of the joints if the horizon is
    /// an unknown, then the nearest; the effort of the cubic to them otherwise.
    ///
    /// # Errors
    /// None is found for any alternative: they are out of reach, in collision, beyond the torques at rest, or the
    /// search did not find one.
    pub fn goal_with_ends(&self) -> Result<Option<GoalSet>> {
        let Some(mut goal) = self.goal.clone() else {
            return Ok(None);
        };
        if let Some((file, ends)) = self.ends.get()
            && *file == self.file
        {
            goal.ends.clone_from(ends);
            return Ok(Some(goal));
        }
        let (mut ends, mut refused) = (Vec::new(), None);
        for alternative in 0..goal.alternatives.len() {
            let key = self.key_of_goal(alternative);
            let poses = &self.file.goal[alternative];
            let rows = &goal.alternatives[alternative];
            match self.ends_of(poses, rows, (&self.file.q_goal, &self.file.q_start), None)? {
                Ok(found) => {
                    for q in found {
                        ends.push((self.measure_of(&q)?, GoalEnd { q, alternative }));
                    }
                }
                Err(condition) => {
                    let error = Error::input(&self.name, key, condition);
                    refused = refused.or(Some(error));
                }
            }
        }
        if let (true, Some(error)) = (ends.is_empty(), refused) {
            return Err(error);
        }
        ends.sort_by(|([a, c], _), ([b, d], _)| a.total_cmp(b).then(c.total_cmp(d)));
        goal.ends = ends.into_iter().map(|(_, end)| end).collect();
        self.ends.get_or_init(|| (self.file.clone(), goal.ends.clone()));
        Ok(Some(goal))
    }

    /// The measures by which ends are compared before any search, the first one first.
    fn measure_of(&self, end: &[f64]) -> Result<[f64; 2]> {
        if !self.file.has_free_horizon() {
            return Ok([effort_to(&self.problem()?, end)?, 0.0]);
        }
        let least = self.least_horizon_to(Some(end));
        let way = self.file.q_start.iter().zip(end);
        let way: f64 = way.map(|(from, to)| (to - from).powi(2)).sum();
        Ok([least.map_or(0.0, |(.., least)| least), way])
    }

    /// Different configurations in a set of poses with these rows, or the reason why there is none. They are searched
    /// from the configuration `near`, to which they are by whole turns as close as possible, and from a first guess,
    /// for the end or for the waypoint with this key.
    pub(crate) fn ends_of(
        &self,
        poses: &Goal,
        rows: &[AnyConstraint],
        (guess, near): (&[f64], &[f64]),
        waypoint: Option<&str>,
    ) -> Result<std::result::Result<Vec<Vec<f64>>, String>> {
        let model = &self.model;
        if let Some(condition) = beyond_reach(poses, model) {
            return Ok(Err(condition));
        }
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let bounds = (0..model.dof()).map(|i| self.bound(Quantity::Position, i).unwrap_or(all));
        // The end also keeps the conditions that hold throughout.
        let rows = &[rows, self.own.constraints.as_slice()].concat()[..];
        let mut search = InverseKinematics::new(model, rows, bounds.collect())?;
        let mut found = Vec::<Vec<f64>>::new();
        let (mut refused, mut reason) = (0, None);
        let mut nearest: Option<(f64, Vec<f64>)> = None;
        let guesses = search.guesses(guess, 0).take(GUESSES);
        for guess in std::iter::once(near.to_vec()).chain(guesses) {
            let end = search.solve(&guess)?;
            if end.violation > InverseKinematics::<[AnyConstraint]>::TOLERANCE {
                if nearest.as_ref().is_none_or(|(least, _)| end.violation < *least) {
                    nearest = Some((end.violation, end.q));
                }
                continue;
            }
            let q = search.nearer(&end.q, near);
            let same = |other: &Vec<f64>| {
                let apart = q.iter().zip(other).map(|(a, b)| (a - b).abs());
                apart.fold(0.0, f64::max) < DIFFERENT
            };
            if found.iter().any(same) {
                continue;
            }
            let checked = match waypoint {
                Some(key) => self.check_on_the_way(key, &q),
                None => self.check_end(&q),
            };
            match checked {
                Ok(()) => found.push(q),
                Err(Error::Input { condition, .. }) => {
                    refused += 1;
                    reason = reason.or(Some(condition));
                }
                Err(other) => return Err(other),
            }
            if found.len() == MAX_ENDS {
                break;
            }
        }
        if !found.is_empty() {
            return Ok(Ok(found));
        }
        if let Some(reason) = reason {
            return Ok(Err(format!(
                "each of {refused} configurations that reach it is refused, the first because {reason}"
            )));
        }
        self.not_found(rows, nearest).map(Err)
    }

    /// The condition of a goal for which no search succeeded, with the configuration that is nearest to it.
    fn not_found(&self, rows: &[AnyConstraint], nearest: Option<(f64, Vec<f64>)>) -> Result<String> {
        let mut condition = format!(
            "none of {GUESSES} searches found a configuration that reaches it, which does not prove that there is none"
        );
        if let Some((_, q)) = nearest {
            let x = [q, vec![0.0; self.model.dof()]].concat();
            if let Some((off, RowLabel { name, unit, .. })) = worst_row(rows, &self.model, &x)? {
                condition += &format!("; the nearest one is off by {off:.3e} {unit}: {name}");
            }
        }
        Ok(condition)
    }

    /// The key of an alternative of the goal.
    fn key_of_goal(&self, alternative: usize) -> String {
        match self.file.goal.len() {
            1 => "goal".to_owned(),
            _ => format!("goal[{alternative}]"),
        }
    }
}

/// The control effort of the cubic from the start to a final configuration.
fn effort_to(problem: &Problem<'_>, q: &[f64]) -> Result<f64> {
    let (chebyshev, n) = (Chebyshev::new(DEGREE, problem.horizon())?, q.len());
    let (start, goal, horizon) = (problem.start(), problem.goal(), problem.horizon());
    let hermite = |i: usize, k: usize| {
        let s = chebyshev.times()[k] / horizon;
        let bends = [s * (1.0 - s) * (1.0 - s), s * s * (s - 1.0)];
        let bent = horizon * (bends[0] * start[n + i] + bends[1] * goal[n + i]);
        start[i] + (q[i] - start[i]) * s * s * (3.0 - 2.0 * s) + bent
    };
    let positions = DMatrix::from_fn(n, DEGREE + 1, hermite);
    let velocities = &positions * chebyshev.d().transpose();
    let mut x = DMatrix::zeros(2 * n, DEGREE + 1);
    x.rows_mut(0, n).copy_from(&positions);
    x.rows_mut(n, n).copy_from(&velocities);
    let curve = Curve::new(chebyshev, x)?;
    Ok(effort_of(problem.model(), &curve, 1.0)?.control_effort)
}

/// The reason why a position is beyond the reach of the frame: it is farther from the first joint of the frame than all
/// links and strokes from there on add up to.
fn beyond_reach(goal: &Goal, model: &Model) -> Option<String> {
    let frame = model.frames().iter().find(|frame| frame.name == goal.frame)?;
    if goal.relative_to.is_some() {
        return None;
    }
    let position = Vector3::from(goal.position_m?);
    let (mut reach, mut first) = (frame.placement.translation.norm(), None);
    let mut body = frame.body;
    while let Some(i) = body {
        let joint = &model.joints()[i];
        if joint.kind() == JointKind::Prismatic {
            reach += joint.limits().lower.abs().max(joint.limits().upper.abs());
        }
        body = joint.parent();
        match body {
            Some(_) => reach += joint.origin().translation.norm(),
            None => first = Some((joint.name(), joint.origin().translation)),
        }
    }
    let (name, origin) = first?;
    let distance = (position - origin).norm() - goal.tolerance_m.unwrap_or(0.0);
    (distance > reach + f64::EPSILON.sqrt()).then(|| {
        let units = if distance > FAR * reach { format!("; {MILLIMETRES}") } else { String::new() };
        let [distance, reach] = [distance, reach].map(|x| plain((1e4 * x).round() / 1e4));
        format!(
            "its position is {distance} m from joint '{name}', and the links to frame '{}' add up to {reach} m{units}",
            goal.frame
        )
    })
}
