//! Goals that are sets of final configurations.

use crate::common::direct::{solved, solved_within};
use crate::common::{assert_refused, constants, dual_jacobian, point_mass, robot};
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, Constraint, Constraints, Evaluator, PlacedState, RowSet, Side, StageConstraints,
    TorqueLimits,
};
use aghf::direct::{Direct, DirectSettings, DirectSolution, FreeHorizon, GoalEnd, GoalSet};
use aghf::error::Result;
use aghf::model::Model;
use aghf::motion::{Interrupt, Problem, Stopped};
use aghf::scalar::AlgebraOver;
use nalgebra::{DVector, Vector3};
use num_dual::Dual64;

/// The half-plane $a \cdot q \le b$, or its edge.
#[derive(Clone, Debug)]
struct Half {
    a: Vec<f64>,
    b: f64,
    edge: bool,
}

impl Constraint for Half {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        let products = self.a.iter().zip(at.q()).map(|(a, q)| S::lift(*a) * *q);
        g[0] = products.fold(-S::lift(self.b), |sum, x| sum + x);
        Ok(())
    }

    fn row_set(&self, _: usize) -> RowSet {
        if self.edge { RowSet::zero() } else { RowSet::at_most_zero() }
    }
}

/// The tip of the last body at a point of the plane of motion.
#[derive(Clone, Debug)]
struct Tip {
    in_body: Vector3<f64>,
    target: Vector3<f64>,
}

impl Constraint for Tip {
    fn dim(&self) -> usize {
        2
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> Result<()> {
        let p = at.point(Some(at.q().len() - 1), &self.in_body)?;
        for (g, i) in g.iter_mut().zip([0, 2]) {
            *g = p[i] - S::lift(self.target[i]);
        }
        Ok(())
    }

    fn row_set(&self, _: usize) -> RowSet {
        RowSet::zero()
    }
}

fn other(constraint: impl Constraint + Clone + std::fmt::Debug + Send + Sync + 'static) -> Vec<AnyConstraint> {
    vec![AnyConstraint::Other(Box::new(constraint))]
}

/// The line on which the first of two coordinates is `b`.
fn line(b: f64) -> Vec<AnyConstraint> {
    let (a, edge) = (vec![1.0, 0.0], true);
    other(Half { a, b, edge })
}

fn end(q: &[f64], alternative: usize) -> GoalEnd {
    GoalEnd { q: q.to_vec(), alternative }
}

fn with_goal(alternatives: Vec<Vec<AnyConstraint>>, ends: Vec<GoalEnd>) -> DirectSettings {
    DirectSettings { goal: Some(GoalSet { alternatives, ends }), starts: 2, ..DirectSettings::constrained() }
}

fn last(solution: &DirectSolution) -> Vec<f64> {
    let x = solution.curve.x();
    x.column(x.ncols() - 1).iter().copied().collect()
}

/// From rest to rest the effort of a mass is $12 m^2 |d|^2 / T^3$, so that the best end of a line is the one nearest to
/// the start, whatever the first guess; and of a half-plane the same, unless the start is in it.
#[test]
fn a_mass_ends_at_the_nearest_point_of_a_line_or_a_half_plane() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let problem = Problem::new(&model, vec![0.0; 4], vec![9.0, 9.0, 0.0, 0.0], 1.3).expect("valid");
    let half = |a: [f64; 2], b, edge| other(Half { a: a.to_vec(), b, edge });
    for (rows, nearest) in [
        (half([1.0, 2.0], 1.0, true), [0.2, 0.4]),
        (half([-1.0, -2.0], -1.0, false), [0.2, 0.4]),
        (half([1.0, 2.0], 1.0, false), [0.0, 0.0]),
    ] {
        let goal = vec![end(&[1.0, -0.3], 0)];
        let solution = solved(&problem, &with_goal(vec![rows], goal));
        assert!(
            solution.converged && solution.largest_violation < 1e-6,
            "{} {:e}",
            solution.cost,
            solution.largest_violation
        );
        for (found, nearest) in last(&solution).iter().zip(nearest) {
            assert!((found - nearest).abs() < 1e-3, "{found}, not {nearest}");
        }
        let square: f64 = nearest.iter().map(|x| x * x).sum();
        let least = 12.0 * square / 1.3_f64.powi(3);
        assert!((solution.cost - least).abs() < 1e-4, "{}", solution.cost);
    }
}

/// Of two lines the motion takes the nearer one, and says which.
#[test]
fn of_several_alternatives_the_motion_takes_the_cheapest() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let problem = Problem::new(&model, vec![0.0; 4], vec![0.0; 4], 1.0).expect("valid");
    for (far, near) in [(0, 1), (1, 0)] {
        let mut lines = [2.0, 2.0];
        lines[near] = -1.0;
        let alternatives = lines.map(line).to_vec();
        let ends = vec![end(&[1.5, 0.0], 0), end(&[-0.9, 0.3], 1)];
        let solution = solved(&problem, &with_goal(alternatives, ends));
        assert_eq!((solution.alternative, far + near), (near, 1));
        assert!((last(&solution)[0] + 1.0).abs() < 1e-6, "{} {:e}", solution.cost, solution.largest_violation);
    }
}

/// A search that is stopped goes on with the alternative that was kept, though it is not that of the first start and
/// violates a limit of velocity, which none can keep.
#[test]
fn a_search_that_is_stopped_has_the_best_of_its_ends() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let problem = Problem::new(&model, vec![0.0; 4], vec![0.0; 4], 1.0).expect("valid");
    let ends = vec![end(&[2.0, 0.0], 0), end(&[-1.0, 0.0], 1)];
    let interrupt = Interrupt::default();
    let settings = DirectSettings { interrupt: interrupt.clone(), ..with_goal([2.0, -1.0].map(line).to_vec(), ends) };
    let bound = |(side, value)| Bound { entry: 2, side, value };
    let constraints = Constraints {
        state: Bounds([(Side::Lower, -0.5), (Side::Upper, 0.5)].map(bound).to_vec()),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints::NONE,
    };
    let solver = Direct::new(&problem).constraints(&constraints);
    let solver = solver.settings(settings).observe(|_| interrupt.raise());
    let found = solver.solve().expect("valid");
    assert_eq!(found.stopped, Some(Stopped::Interrupt));
    assert_eq!((found.best_start, found.alternative), (Some(1), 1));
    assert!(found.largest_violation > 0.1 && !found.kept);
}

/// The configuration beside `q` that keeps the rows, moved along their null space.
fn beside(model: &Model, tip: &Tip, q: &[f64], step: f64) -> Vec<f64> {
    let rows = |q: &[Dual64]| {
        let x = [q, &constants(&[0.0; 3])].concat();
        let mut g = constants(&[0.0; 2]);
        let mut evaluator = Evaluator::<f64, Dual64>::new(model);
        let placed = evaluator.at(&x).expect("a state");
        placed.value(tip, &mut g).expect("it has the body");
        g
    };
    let jacobian = |q: &[f64]| dual_jacobian(rows, q);
    let j = jacobian(q);
    let along = j.row(0).cross(&j.row(1)).transpose();
    let mut q = DVector::from_column_slice(q) + along.normalize() * step;
    for _ in 0..20 {
        let j = jacobian(q.as_slice());
        let g = rows(&constants(q.as_slice())).into_iter().map(|g| g.re);
        let g = DVector::from_iterator(2, g);
        let squares = (&j * j.transpose()).try_inverse();
        q -= j.transpose() * squares.expect("not stretched out") * g;
    }
    q.as_slice().to_vec()
}

/// The cost to the found end is the least among those to ends nearby that keep the point, within limits that bind and
/// with a free horizon as well: the multipliers of the goal belong to the optimality conditions.
#[test]
fn no_end_nearby_that_keeps_the_goal_costs_less() {
    let model = robot("pendulum_3");
    let tip = Tip { in_body: Vector3::new(0.0, 0.0, -0.5), target: Vector3::new(0.4, 0.0, -0.6) };
    let start = vec![0.1, -0.2, 0.3, 0.0, 0.0, 0.0];
    let problem = Problem::new(&model, start, vec![0.0; 6], 1.5).expect("valid");
    for (limit, free) in [(None, false), (None, true), (Some(2.5), false), (Some(2.5), true)] {
        let bound = |(entry, value): (usize, f64)| {
            [(Side::Lower, -value), (Side::Upper, value)].map(|(side, value)| Bound { entry, side, value })
        };
        let limits = limit.into_iter().flat_map(|v: f64| (3..6).map(move |entry| (entry, v)));
        let constraints = Constraints {
            state: Bounds(limits.flat_map(bound).collect()),
            torque: TorqueLimits(Vec::new()),
            stage: StageConstraints::NONE,
        };
        let settings = DirectSettings {
            free_horizon: free.then_some(FreeHorizon { weight: 20.0, shortest: 0.5, longest: 5.0 }),
            ..with_goal(vec![other(tip.clone())], vec![end(&[0.5, 0.5, 0.5], 0)])
        };
        let solution = solved_within(&problem, &settings, &constraints);
        assert!(solution.converged, "{} {:e}", solution.cost, solution.largest_violation);
        let q = last(&solution)[..3].to_vec();
        let to = |q: &[f64]| {
            let goal = problem.with_final_position(q).expect("valid");
            let settings =
                DirectSettings { goal: None, starts: 1, start: Some(solution.curve.clone()), ..settings.clone() };
            let found = solved_within(&goal, &settings, &constraints);
            assert!(found.converged, "{} {:e}", found.cost, found.largest_violation);
            let time = settings.free_horizon.map_or(0.0, |free| free.weight * found.curve.horizon());
            found.cost + time
        };
        let least = to(&q);
        // Margins between the points of the quadrature differ from search to search, and with them the cost within
        // limits by parts in a thousand.
        let above = if limit.is_some() { -1e-3 } else { 1e-5 };
        for step in [-0.05, 0.05] {
            let cost = to(&beside(&model, &tip, &q, step));
            assert!(cost > least * (1.0 + above), "{cost} beside {least}");
        }
    }
}

/// Ends of another length, of no alternative or with a number that is not finite are refused, and a goal without one.
#[test]
fn faulty_goals_are_refused() {
    let model = robot("pendulum_3");
    let problem = Problem::new(&model, vec![0.0; 6], vec![0.0; 6], 1.0).expect("valid");
    for (ends, words) in [
        (vec![], "no first guess"),
        (vec![end(&[0.0; 2], 0)], "final configuration"),
        (vec![end(&[0.0; 3], 0), end(&[0.0; 3], 1)], "alternative 1"),
        (vec![end(&[0.0, f64::NAN, 0.0], 0)], "not finite"),
    ] {
        let settings = with_goal(vec![Vec::new()], ends);
        assert_refused(Direct::new(&problem).settings(settings).solve(), words);
    }
}
