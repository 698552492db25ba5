//! Smooth programs with bounds and rows: known solutions, equivalent forms, and an end that is what it says.

use crate::common::config;
use aghf::Result;
use aghf::nlp::{KktError, Options, Scales, SmoothDerivatives, SmoothProgram, SmoothSolution, Status, solve_smooth};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use proptest::prelude::*;

const INFINITE: f64 = f64::INFINITY;

/// $\tfrac12 x^T Q x + c^T x$ with the rows $A x$ and, if there is a square one, $x^T x$.
#[derive(Clone, Debug)]
struct Quadratic {
    hessian: DMatrix<f64>,
    slope: DVector<f64>,
    rows: DMatrix<f64>,
    has_square: bool,
    bounds: Vec<[f64; 2]>,
    row_bounds: Vec<[f64; 2]>,
    /// The factor of the objective.
    factor: f64,
    /// True if an unknown was evaluated outside its bounds.
    left: bool,
}

/// The accurate end of a search from a start.
pub fn solved<P: SmoothProgram>(program: &mut P, x: &DVector<f64>) -> SmoothSolution {
    let options = Options { tolerance: 1e-8, ..Options::default() };
    solve_smooth(program, x, &options).expect("the functions do not fail")
}

impl Quadratic {
    fn new(hessian: DMatrix<f64>, slope: DVector<f64>) -> Self {
        let n = slope.len();
        let bounds = vec![[-INFINITE, INFINITE]; n];
        let rows = DMatrix::zeros(0, n);
        Self { hessian, slope, rows, has_square: false, bounds, row_bounds: Vec::new(), factor: 1.0, left: false }
    }

    fn solve(&mut self, x: &DVector<f64>) -> SmoothSolution {
        solved(self, x)
    }
}

impl SmoothProgram for Quadratic {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.clone()
    }

    fn row_bounds(&self) -> Vec<[f64; 2]> {
        self.row_bounds.clone()
    }

    fn value(&mut self, x: &DVector<f64>, g: &mut DVector<f64>) -> Result<f64> {
        self.left |= x.iter().zip(&self.bounds).any(|(x, [low, high])| x < low || x > high);
        let linear = &self.rows * x;
        g.rows_mut(0, linear.len()).copy_from(&linear);
        if self.has_square {
            g[linear.len()] = x.norm_squared();
        }
        Ok(self.factor * (0.5 * x.dot(&(&self.hessian * x)) + self.slope.dot(x)))
    }

    fn derivatives(&mut self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> Result<()> {
        let linear = self.rows.nrows();
        out.gradient = (&self.hessian * x + &self.slope) * self.factor;
        out.jacobian.rows_mut(0, linear).copy_from(&self.rows);
        out.hessian = &self.hessian * self.factor;
        if self.has_square {
            out.jacobian.row_mut(linear).copy_from(&(x.transpose() * 2.0));
            out.hessian += DMatrix::identity(x.len(), x.len()) * (2.0 * y[linear]);
        }
        Ok(())
    }
}

/// A convex objective, equalities and bounds that a point keeps.
fn convex() -> impl Strategy<Value = (Quadratic, DVector<f64>)> {
    (1..6_usize, 0..3_usize).prop_flat_map(|(n, m)| {
        let m = m.min(n - 1);
        let entries = |count: usize| prop::collection::vec(-1.0..1.0_f64, count);
        let all = (entries(n * n), entries(n), entries(m * n), entries(n), prop::collection::vec(0.1..1.0_f64, n));
        all.prop_map(move |(root, slope, rows, point, width)| {
            let root = DMatrix::from_vec(n, n, root);
            let mut of = Quadratic::new(root.tr_mul(&root) + DMatrix::identity(n, n) * 0.1, DVector::from_vec(slope));
            let point = DVector::from_vec(point);
            of.rows = DMatrix::from_vec(m, n, rows);
            of.row_bounds = (&of.rows * &point).iter().map(|g| [*g, *g]).collect();
            of.bounds = point.iter().zip(width).map(|(x, width)| [x - width, x + 2.0 * width]).collect();
            (of, point)
        })
    })
}

proptest! {
    #![proptest_config(config(64))]

    /// A convex program converges from any start, is never evaluated outside its bounds, and no feasible direction
    /// descends.
    #[test]
    fn convex_programs_have_their_minima((mut program, point) in convex(), start in -5.0..5.0_f64) {
        let found = program.solve(&DVector::from_element(point.len(), start));
        prop_assert_eq!(found.status, Status::Converged);
        prop_assert!(!program.left);
        let Quadratic { hessian, slope, .. } = &program;
        let descent = (hessian * &found.x + slope).dot(&(&point - &found.x));
        prop_assert!(descent >= -1e-6, "{descent}");
    }

    /// The objective in another unit has the same solution.
    #[test]
    fn an_objective_in_another_unit((mut program, point) in convex(), power in -2.0..3.0_f64) {
        let first = program.solve(&point);
        program.factor = 10.0_f64.powf(power);
        let second = program.solve(&point);
        prop_assert_eq!(second.status, Status::Converged);
        prop_assert!((&first.x - &second.x).amax() <= 1e-3, "{} {}", first.x, second.x);
    }

    /// The errors vanish at the solution alone: a step away from it shows in one of them.
    #[test]
    fn errors_show_a_step_away((mut program, _) in convex(), by in 1e-3..0.5_f64, k in 0..5_usize) {
        let n = program.slope.len();
        let found = program.solve(&DVector::zeros(n));
        let scales = Scales { objective: 1.0, rows: DVector::from_element(program.rows.nrows(), 1.0) };
        let both = [&found.multipliers, &found.bound_multipliers];
        let mut error = |x: &DVector<f64>| KktError::new(&mut program, &scales, x, both).expect("no failure").largest();
        prop_assert!(error(&found.x) <= 1e-7);
        let mut x = found.x.clone();
        x[k % n] += by;
        prop_assert!(error(&x) >= 1e-5 * by);
    }
}

/// The least $x + y$ on a circle, from both sides: a curved equality, and an objective that is negative.
#[test]
fn a_curved_equality_of_either_sign() {
    for (sign, start) in [(1.0, 3.0), (-1.0, 0.1)] {
        let mut program = Quadratic::new(DMatrix::zeros(2, 2), dvector![sign, sign]);
        (program.has_square, program.row_bounds) = (true, vec![[2.0, 2.0]]);
        let found = program.solve(&dvector![start, 0.5 * start]);
        assert_eq!(found.status, Status::Converged);
        assert!((found.x.clone() + dvector![sign, sign]).amax() < 1e-7, "{}", found.x);
        assert!((found.multipliers[0] - 0.5).abs() < 1e-7, "{}", found.multipliers);
        assert!((found.objective + 2.0).abs() < 1e-7);
    }
}

/// The maximum of a convex objective in a box is at a corner, with bounds that are active.
#[test]
fn a_concave_objective_ends_at_a_corner() {
    let mut program = Quadratic::new(-DMatrix::identity(2, 2), dvector![-0.1, 0.1]);
    program.bounds = vec![[-1.0, 1.0]; 2];
    let found = program.solve(&dvector![0.3, -0.4]);
    assert_eq!(found.status, Status::Converged);
    assert!((found.x.clone() - dvector![1.0, -1.0]).amax() < 1e-6, "{}", found.x);
    assert!((found.bound_multipliers.clone() - dvector![1.1, -1.1]).amax() < 1e-5, "{}", found.bound_multipliers);
}

/// Equal bounds fix an unknown; a row twice changes nothing; both bounds of one row may be given.
#[test]
fn degenerate_rows() {
    let mut program = Quadratic::new(DMatrix::identity(3, 3), dvector![-1.0, -2.0, -3.0]);
    program.bounds[2] = [0.5, 0.5];
    program.rows = dmatrix![1.0, 1.0, 0.0; 1.0, 1.0, 0.0; 1.0, -1.0, 0.0];
    program.row_bounds = vec![[2.0, 2.0], [2.0, 2.0], [-0.5, 0.5]];
    let found = program.solve(&DVector::zeros(3));
    assert_eq!(found.status, Status::Converged);
    assert!((found.x.clone() - dvector![0.75, 1.25, 0.5]).amax() < 1e-6, "{}", found.x);
}

/// Rows that exclude each other do not converge, and the error says so.
#[test]
fn rows_that_exclude_each_other() {
    let mut program = Quadratic::new(DMatrix::identity(1, 1), dvector![0.0]);
    program.rows = dmatrix![1.0; 1.0];
    program.row_bounds = vec![[1.0, 1.0], [3.0, INFINITE]];
    let found = program.solve(&dvector![0.0]);
    assert_eq!(found.status, Status::Infeasible);
    assert!(found.error.feasibility > 0.5, "{:?}", found.error);
}

/// An objective without a lower bound does not converge.
#[test]
fn no_lower_bound() {
    let found = Quadratic::new(DMatrix::zeros(1, 1), dvector![1.0]).solve(&dvector![0.0]);
    assert_ne!(found.status, Status::Converged);
    assert!(found.error.stationarity > 0.5);
}

/// A derivative or a multiplier that is not a number is no solution, however small all others are.
#[test]
fn errors_that_are_not_numbers() {
    for (slope, multiplier) in [(f64::NAN, 0.0), (0.0, f64::NAN)] {
        let mut program = Quadratic::new(DMatrix::identity(1, 1), dvector![slope]);
        let (rows, x) = (DVector::zeros(0), dvector![0.0]);
        let scales = Scales { objective: 1.0, rows: rows.clone() };
        let found = KktError::new(&mut program, &scales, &x, [&rows, &dvector![multiplier]]).expect("no failure");
        assert_eq!(found.largest(), INFINITE, "{found:?}");
    }
}

/// Bad input is refused with its place.
#[test]
fn bad_input() {
    let program = Quadratic::new(DMatrix::identity(2, 2), dvector![0.0, 0.0]);
    let refused = |mut program: Quadratic, x: &[f64]| {
        let found = solve_smooth(&mut program, &DVector::from_column_slice(x), &Options::default());
        found.expect_err("it is refused").to_string()
    };
    let crossed = Quadratic { bounds: vec![[0.0, 1.0], [2.0, 1.0]], ..program.clone() };
    let not_a_number = Quadratic { bounds: vec![[0.0, f64::NAN], [0.0, 1.0]], ..program.clone() };
    for (message, part) in [
        (refused(program.clone(), &[0.0]), "1 entries"),
        (refused(crossed, &[0.0; 2]), "unknown 1"),
        (refused(not_a_number, &[0.0; 2]), "unknown 0"),
        (refused(program, &[f64::NAN, 0.0]), "x"),
    ] {
        assert!(message.contains(part), "{message}");
    }
}
