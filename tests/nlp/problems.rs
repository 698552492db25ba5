//! Programs of Hock and Schittkowski, *Test Examples for Nonlinear Programming Codes*, 1981 (HS), and others whose
//! solutions are known, with their multipliers.
//!
//! The method measures relative to the objective, which is the integral of a positive cost, so a constant is added to
//! each objective that is not positive.

use crate::dense::{Dense, accurate};
use aghf::cost::HyperDual64;
use aghf::nlp::{Options, Solution, Status};
use num_dual::DualNum;

/// The accuracy of multipliers. The end of a search is measured relative to the condensed matrix, whose entries along
/// the gradients of active rows are in inverse proportion to the barrier parameter.
const MULTIPLIER: f64 = 1e-4;

/// A program with its solution.
struct Known {
    name: &'static str,
    program: Dense,
    x: Vec<f64>,
    multipliers: Vec<f64>,
}

fn known() -> Vec<Known> {
    let sqrt = f64::sqrt;
    let cases: [(_, Dense, &[f64], &[f64]); 6] = [
        ("HS6", Dense::new(hs6, &[-1.2, 1.0], 1, 1), &[1.0, 1.0], &[0.0]),
        ("HS7", Dense::new(hs7, &[2.0, 2.0], 1, 1), &[0.0, sqrt(3.0)], &[0.5 / sqrt(3.0)]),
        ("HS21", Dense::new(hs21, &[-1.0, -1.0], 0, 5), &[2.0, 0.0], &[0.0, 0.04, 0.0, 0.0, 0.0]),
        ("HS35", Dense::new(hs35, &[0.5; 3], 0, 4), &[4.0 / 3.0, 7.0 / 9.0, 4.0 / 9.0], &[2.0 / 9.0, 0.0, 0.0, 0.0]),
        ("HS43", Dense::new(hs43, &[0.0; 4], 0, 3), &[0.0, 1.0, 2.0, -1.0], &[1.0, 0.0, 2.0]),
        (
            "HS71",
            Dense::new(hs71, &[1.0, 5.0, 5.0, 1.0], 1, 10),
            // The digits of HS.
            &[1.0, 4.742_999_4, 3.821_150_3, 1.379_408_2],
            &[0.161_468_6, 0.552_293_7, 1.087_871_2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ),
    ];
    cases
        .into_iter()
        .map(|(name, program, x, multipliers)| Known {
            name,
            program,
            x: x.to_vec(),
            multipliers: multipliers.to_vec(),
        })
        .collect()
}

type Functions = (HyperDual64, Vec<HyperDual64>);

fn hs6(x: &[HyperDual64]) -> Functions {
    let away = -x[0] + 1.0;
    (away * away + 1.0, vec![(x[1] - x[0] * x[0]) * 10.0])
}

fn hs7(x: &[HyperDual64]) -> Functions {
    let square = x[0] * x[0] + 1.0;
    (square.ln() - x[1] + 10.0, vec![square * square + x[1] * x[1] - 4.0])
}

fn hs21(x: &[HyperDual64]) -> Functions {
    let [a, b] = [x[0], x[1]];
    let rows = vec![-a * 10.0 + b + 10.0, -a + 2.0, a - 50.0, -b - 50.0, b - 50.0];
    (a * a * 0.01 + b * b + 1.0, rows)
}

fn hs35(x: &[HyperDual64]) -> Functions {
    let [a, b, c] = [x[0], x[1], x[2]];
    let linear = -a * 8.0 - b * 6.0 - c * 4.0 + 9.0;
    let squares = a * a * 2.0 + b * b * 2.0 + c * c + (b + c) * a * 2.0;
    (linear + squares, vec![a + b + c * 2.0 - 3.0, -a, -b, -c])
}

pub fn hs43(x: &[HyperDual64]) -> Functions {
    let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
    let [aa, bb, cc, dd] = [a * a, b * b, c * c, d * d];
    let rows = vec![
        aa + bb + cc + dd + a - b + c - d - 8.0,
        aa + bb * 2.0 + cc + dd * 2.0 - a - d - 10.0,
        aa * 2.0 + bb + cc + a * 2.0 - b - d - 5.0,
    ];
    let linear = -(a + b) * 5.0 - c * 21.0 + d * 7.0;
    (aa + bb + cc * 2.0 + dd + linear + 100.0, rows)
}

pub fn hs71(x: &[HyperDual64]) -> Functions {
    let [a, b, c, d] = [x[0], x[1], x[2], x[3]];
    let mut rows = vec![a * a + b * b + c * c + d * d - 40.0, -(a * b * c * d) + 25.0];
    rows.extend(x.iter().map(|x| -*x + 1.0));
    rows.extend(x.iter().map(|x| *x - 5.0));
    (a * d * (a + b + c) + c, rows)
}

/// Unknowns and multipliers of a solution.
fn numbers(end: &Solution) -> (Vec<f64>, Vec<f64>) {
    let x = end.x.as_slice().to_vec();
    let count = end.iterate.working.len() + end.iterate.equalities.len();
    (x, end.iterate.multipliers(count))
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

pub fn assert_near(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    let apart = largest_difference(found, expected);
    assert!(apart <= tolerance, "{name}: {found:?}, not {expected:?}: {apart:e}");
}

/// Unknowns and multipliers are those of the literature, and the gradient of the Lagrangian vanishes.
#[test]
fn solutions_are_known() {
    for Known { name, mut program, x, multipliers } in known() {
        let end = program.solve(&accurate());
        assert_eq!(end.status, Status::Converged, "{name}");
        let (found, lambda) = numbers(&end);
        assert_near(name, &found, &x, 1e-6);
        assert_near(name, &lambda, &multipliers, MULTIPLIER);
        let gradient = program.lagrangian_gradient(&end.x, &end.iterate);
        assert!(gradient.amax() <= MULTIPLIER, "{name}: {gradient}");
        let violation = program.violation(&end.x).expect("the functions do not fail");
        assert!(violation <= 1e-9, "{name}: {violation:e}");
    }
}

/// A solution does not depend on the order of the rows, but for rounding.
#[test]
fn rows_in_another_order() {
    for Known { name, program, .. } in known() {
        let [mut program, mut reversed] = [program.clone(), program];
        reversed.rows.reverse();
        let (x, mut multipliers) = numbers(&program.solve(&accurate()));
        let (of_reversed, lambda) = numbers(&reversed.solve(&accurate()));
        multipliers.reverse();
        assert_near(name, &of_reversed, &x, 1e-9);
        assert_near(name, &lambda, &multipliers, MULTIPLIER);
    }
}

/// Rows in another unit have the same solution, and multipliers in the inverse unit. Not in any unit: the first penalty
/// is that of rows of size 1, and HS71 has no lower bound where its rows are violated.
#[test]
fn rows_in_another_unit() {
    for factor in [0.1, 1e2] {
        for Known { name, mut program, x, multipliers } in known() {
            for row in &mut program.rows {
                row.1 = factor;
            }
            let options = accurate();
            let feasible = options.feasible * factor.max(1.0);
            let end = program.solve(&Options { feasible, ..options });
            assert_eq!(end.status, Status::Converged, "{name} {factor}");
            let (found, mut lambda) = numbers(&end);
            for lambda in &mut lambda {
                *lambda *= factor;
            }
            assert_near(name, &found, &x, 1e-6);
            assert_near(name, &lambda, &multipliers, MULTIPLIER);
        }
    }
}

/// The multiplier of a row is that per unit of its weight and of the measure.
#[test]
fn weights_divide_the_multipliers() {
    for Known { name, mut program, x, multipliers } in known() {
        program.measure = 3.0;
        for row in &mut program.rows {
            row.2 = 0.25;
        }
        let end = program.solve(&accurate());
        let (found, mut lambda) = numbers(&end);
        for lambda in &mut lambda {
            *lambda *= 0.75;
        }
        assert_near(name, &found, &x, 1e-6);
        assert_near(name, &lambda, &multipliers, MULTIPLIER);
    }
}

/// A row twice has the same solution, and the sum of the two multipliers is that of the row.
#[test]
fn a_row_twice() {
    for Known { name, mut program, x, multipliers } in known() {
        let first = program.rows[0];
        program.rows.push(first);
        let end = program.solve(&accurate());
        assert_eq!(end.status, Status::Converged, "{name}");
        let (found, mut lambda) = numbers(&end);
        let second = lambda.pop().expect("one was added");
        lambda[0] += second;
        assert_near(name, &found, &x, 1e-6);
        assert_near(name, &lambda, &multipliers, MULTIPLIER);
    }
}

/// $x \ge 1$ and $x \le -1$.
fn contradiction(x: &[HyperDual64]) -> Functions {
    (x[0] * x[0] + 1.0, vec![-x[0] + 1.0, x[0] + 1.0])
}

/// Rows that exclude each other are reported, at the least sum of the violations: among the points between the bounds,
/// all of which have it, that of the least objective.
#[test]
fn infeasible_rows_are_reported() {
    for start in [-3.0, 0.0, 0.4, 5.0] {
        let mut program = Dense::new(contradiction, &[start], 0, 2);
        let end = program.solve(&accurate());
        assert_eq!(end.status, Status::Infeasible, "{start}");
        assert!((-1.0..=1.0).contains(&end.x[0]), "{start}: {}", end.x[0]);
        let violation = program.violation(&end.x).expect("the functions do not fail");
        assert!(violation >= 1.0, "{start}: {violation}");
        // It does not wait for the largest penalty.
        let nu = end.iterate.barrier.nu;
        assert!(nu < 1e-6 * accurate().largest_penalty, "{start}: {nu}");
    }
}

/// $(x - 2)^2 + (y - 1)^2 + 1$ with $x \le 1$, $y \le 3$ and $x + y \le 3$.
pub fn corner(x: &[HyperDual64]) -> Functions {
    let [a, b] = [x[0] - 2.0, x[1] - 1.0];
    let rows = vec![x[0] - 1.0, x[1] - 3.0, x[0] + x[1] - 3.0];
    (a * a + b * b + 1.0, rows)
}

/// If margins grow at the end, the barrier parameter follows, and the search ends at the solution within them soon.
#[test]
fn margins_that_change_at_the_end() {
    let mut program = Dense { margin: 0.5, ..Dense::new(corner, &[0.0, 0.0], 0, 3) };
    let mut all = Vec::new();
    let (x, kkt) = (nalgebra::DVector::zeros(2), program.kkt());
    let end = aghf::nlp::solve(&mut program, x, None, kkt, &accurate(), &mut |progress| {
        all.push((progress.infeasibility, progress.complementarity));
    });
    let end = end.expect("no function fails");
    assert_eq!(end.status, Status::Converged);
    assert_near("within margins", end.x.as_slice(), &[0.5, 1.0], 1e-6);
    // The multiplier of the first row, 2, times the margin, relative to the objective, 2: at most the barrier
    // parameter of a warm start.
    let after = all.iter().find(|(infeasibility, _)| *infeasibility > 0.4);
    let follows = after.is_some_and(|(_, barrier)| *barrier > 5e-3);
    assert!(follows, "{all:?}");
}

/// Margins that swing end when they only grow: looks at the rows at the last barrier parameter count.
#[test]
fn margins_that_swing() {
    let mut program = Dense { margin: 0.5, swing: Some(0.4), ..Dense::new(corner, &[0.0, 0.0], 0, 3) };
    let end = program.solve(&accurate());
    assert_eq!(end.status, Status::Converged);
    let rounds = &program.rounds;
    let counted = rounds.iter().filter(|round| **round == 1).count();
    assert!(rounds.is_sorted() && counted == 1, "{rounds:?}");
    assert!(rounds.last().is_some_and(|last| *last <= 8), "{rounds:?}");
}

/// Without rows the method is Newton's: one step and a test for a quadratic function.
#[test]
fn a_quadratic_function_takes_one_step() {
    let bowl = |x: &[HyperDual64]| (x[0] * x[0] * 7.0 - x[0] * 7.0 + 3.0, Vec::new());
    let mut program = Dense::new(bowl, &[0.0], 0, 0);
    let mut steps = 0;
    let (x, kkt) = (nalgebra::DVector::zeros(1), program.kkt());
    let end = aghf::nlp::solve(&mut program, x, None, kkt, &accurate(), &mut |_| steps += 1);
    let x = end.expect("no function fails").x;
    assert_close!(&x, &[0.5], 1e-15);
    assert_eq!(steps, 2);
}
