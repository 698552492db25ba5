//! Line searches with equalities, where a penalty of the violation fails or makes steps short.

use crate::common::config;
use crate::dense::{Functions, derivatives};
use crate::smooth::solved;
use aghf::Result;
use aghf::cost::HyperDual64;
use aghf::nlp::{SmoothDerivatives, SmoothProgram, Status};
use nalgebra::{DVector, dvector};
use num_dual::DualNum;
use proptest::prelude::*;

const INFINITE: f64 = f64::INFINITY;

/// A program with its derivatives by duals.
struct Program {
    functions: Functions,
    bounds: Vec<[f64; 2]>,
    row_bounds: Vec<[f64; 2]>,
}

impl SmoothProgram for Program {
    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.clone()
    }

    fn row_bounds(&self) -> Vec<[f64; 2]> {
        self.row_bounds.clone()
    }

    fn value(&mut self, x: &DVector<f64>, g: &mut DVector<f64>) -> Result<f64> {
        let x: Vec<_> = x.iter().map(|x| HyperDual64::from(*x)).collect();
        let (f, rows) = (self.functions)(&x);
        g.iter_mut().zip(rows).for_each(|(g, row)| *g = row.re);
        Ok(f.re)
    }

    fn derivatives(&mut self, x: &DVector<f64>, y: &DVector<f64>, out: &mut SmoothDerivatives) -> Result<()> {
        let all = derivatives(x, |x| {
            let (f, rows) = (self.functions)(x);
            std::iter::once(f).chain(rows).collect()
        });
        (out.gradient, out.hessian) = all[0].clone();
        for (k, (gradient, hessian)) in all[1..].iter().enumerate() {
            out.jacobian.row_mut(k).copy_from(&gradient.transpose());
            out.hessian += hessian * y[k];
        }
        Ok(())
    }
}

/// Steps to the linearised equalities end at bounds away from any feasible point (Wächter and Biegler, *Failure of
/// global convergence for a class of interior point methods for nonlinear programming*, 2000).
#[test]
fn the_example_of_waechter_and_biegler() {
    let functions: Functions = |x| (x[0], vec![x[0] * x[0] - x[1] - 1.0, x[0] - x[2] - 0.5]);
    let bounds = vec![[-INFINITE, INFINITE], [0.0, INFINITE], [0.0, INFINITE]];
    let mut program = Program { functions, bounds, row_bounds: vec![[0.0; 2]; 2] };
    let found = solved(&mut program, &dvector![-2.0, 3.0, 1.0]);
    assert_eq!(found.status, Status::Converged);
    assert_close!(&found.x, &[1.0, 0.0, 0.5], 1e-6);
}

proptest! {
    #![proptest_config(config(64))]

    /// From any point of the circle the whole step increases objective and violation (Maratos; NW 15.4), and few are
    /// needed.
    #[test]
    fn the_example_of_maratos(angle in 0.1..1.2_f64) {
        let functions: Functions = |x| {
            let circle = x[0] * x[0] + x[1] * x[1] - 1.0;
            (circle * 2.0 - x[0], vec![circle])
        };
        let mut program = Program { functions, bounds: vec![[-INFINITE, INFINITE]; 2], row_bounds: vec![[0.0; 2]] };
        let found = solved(&mut program, &dvector![angle.cos(), angle.sin()]);
        prop_assert_eq!(found.status, Status::Converged);
        assert_close!(&found.x, &[1.0, 0.0], 1e-7);
        prop_assert!((found.multipliers[0] + 1.5).abs() < 1e-6, "{}", found.multipliers);
        prop_assert!(found.iterations <= 10, "{}", found.iterations);
    }

    /// The effort and the duration of a motion over a distance of one, as the duration is a row: for negative ones the
    /// objective has no lower bound, so no step may pass zero.
    #[test]
    fn an_objective_that_falls_beyond_a_row(duration in 0.1..20.0_f64, speed in 0.01..5.0_f64) {
        let functions: Functions = |x| (x[0] * (x[1] * x[1] + 1.0), vec![x[0] * x[1] - 1.0, x[0]]);
        let row_bounds = vec![[0.0; 2], [0.05, INFINITE]];
        let mut program = Program { functions, bounds: vec![[-INFINITE, INFINITE]; 2], row_bounds };
        let found = solved(&mut program, &dvector![duration, speed]);
        prop_assert_eq!(found.status, Status::Converged);
        assert_close!(&found.x, &[1.0, 1.0], 1e-6);
        prop_assert!(found.iterations <= 40, "{}", found.iterations);
    }

    /// A bead on a circle in the coordinates of the plane, an equality for each position between the fixed ends. The
    /// energy of the way is that of a constant speed, either way around.
    #[test]
    fn a_bead_on_a_circle(turn in 0.5..2.5_f64, bend in -0.3..0.3_f64) {
        const STEPS: usize = 8;
        // Positions between the ends in units of the radius, and the turn of the last one.
        let functions: Functions = |x| {
            let turn = x[2 * STEPS - 2];
            let ends = [[HyperDual64::from(1.0), HyperDual64::from(0.0)], [turn.cos(), turn.sin()]];
            let inner = x[..2 * STEPS - 2].chunks_exact(2).map(|x| [x[0], x[1]]);
            let all: Vec<_> = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();
            let square = |a: [HyperDual64; 2], b: [HyperDual64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
            let energy = all.windows(2).map(|pair| square(pair[0], pair[1])).sum::<HyperDual64>();
            let circle = all[1..STEPS].iter().map(|x| x[0] * x[0] + x[1] * x[1] - 1.0);
            (energy * (0.5 * STEPS as f64), circle.collect())
        };
        let mut bounds = vec![[-INFINITE, INFINITE]; 2 * STEPS - 1];
        bounds[2 * STEPS - 2] = [turn; 2];
        let straight = (1..STEPS).flat_map(|k| {
            let share = k as f64 / STEPS as f64;
            let off = bend * (std::f64::consts::PI * share).sin();
            [1.0 + share * (turn.cos() - 1.0) + off, share * turn.sin() + off]
        });
        let start = DVector::from_iterator(2 * STEPS - 1, straight.chain([turn]));
        let mut program = Program { functions, bounds, row_bounds: vec![[0.0; 2]; STEPS - 1] };
        let found = solved(&mut program, &start);
        prop_assert_eq!(found.status, Status::Converged);
        let energy = |turn: f64| 2.0 * (STEPS as f64 * (0.5 * turn / STEPS as f64).sin()).powi(2);
        let ways = [turn, std::f64::consts::TAU - turn].map(energy);
        prop_assert!(ways.iter().any(|way| (found.objective - way).abs() < 1e-7), "{} {ways:?}", found.objective);
        prop_assert!(found.iterations <= 20, "{}", found.iterations);
    }
}
