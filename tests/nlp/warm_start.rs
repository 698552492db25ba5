//! Starts with known multipliers.

use crate::dense::{Dense, accurate};
use crate::problems::{assert_near, hs43, hs71};
use aghf::nlp::{Options, Solution, Status, solve};
use nalgebra::DVector;

/// The solution from unknowns with multipliers, and the number of iterations.
fn counted(program: &mut Dense, x: &DVector<f64>, known: &[f64], options: &Options) -> (Solution, usize) {
    let (kkt, mut count) = (program.kkt(), 0);
    let end = solve(program, x.clone(), Some(known), kkt, options, &mut |_| count += 1);
    (end.expect("the functions do not fail"), count)
}

/// With the multipliers of a solution a search near it is shorter than one without, and ends at the same point.
#[test]
fn known_multipliers_shorten_a_search() {
    let program = Dense::new(hs43, &[0.0; 4], 0, 3);
    let near = [0.01, 1.01, 1.99, -1.01];
    let count = |known: Option<&[f64]>| {
        let mut program = program.clone();
        let end = program.solve_from(&near, known, &accurate());
        assert_eq!(end.status, Status::Converged);
        assert_near("HS43", end.x.as_slice(), &[0.0, 1.0, 2.0, -1.0], 1e-6);
        program.evaluations
    };
    let (with, without) = (count(Some(&[1.0, 0.0, 2.0])), count(None));
    assert!(with < without, "{with} evaluations, and {without} without");
}

/// From a solution with its multipliers the search ends there at once, and the number of iterations grows with the
/// distance of the start.
#[test]
fn iterations_grow_with_the_distance_from_the_solution() {
    let programs = [Dense::new(hs43, &[0.0; 4], 0, 3), Dense::new(hs71, &[1.0, 5.0, 5.0, 1.0], 1, 10)];
    for mut program in programs {
        let cold = program.solve(&accurate());
        assert_eq!(cold.status, Status::Converged);
        let known = cold.iterate.multipliers(program.rows.len());
        let mut before = 0;
        for distance in [0.0, 1e-6, 1e-3, 1e-1] {
            let away = DVector::from_fn(cold.x.len(), |i, _| if i % 2 == 0 { -distance } else { distance });
            let (end, count) = counted(&mut program, &(&cold.x + away), &known, &accurate());
            assert_eq!(end.status, Status::Converged);
            assert_near("the solution", end.x.as_slice(), cold.x.as_slice(), 1e-6);
            assert!(before <= count, "{count} at {distance}, {before} nearer");
            assert!(distance > 0.0 || count <= 5, "{count} from the solution");
            before = count;
        }
    }
}

/// Multipliers of another problem are no solution, whatever the distance of the rows from their bounds.
#[test]
fn wrong_multipliers_are_no_solution() {
    let mut program = Dense::new(hs43, &[0.0; 4], 0, 3);
    let x = program.solve(&accurate()).x;
    for known in [[1.0, 0.0, 0.1], [2.0, 0.0, 1.0]] {
        let (end, count) = counted(&mut program, &x, &known, &accurate());
        assert_eq!(end.status, Status::Converged);
        assert!(count > 1, "it converged at once with {known:?}");
        assert_near("HS43", end.x.as_slice(), &[0.0, 1.0, 2.0, -1.0], 1e-6);
    }
}

/// The least first barrier parameter keeps a search from ending at a start that is a solution.
#[test]
fn a_search_may_be_asked_to_leave_a_solution() {
    let mut program = Dense::new(hs43, &[0.0; 4], 0, 3);
    let cold = program.solve(&accurate());
    let known = cold.iterate.multipliers(3);
    let default = accurate();
    let options = Options { min_warm_barrier: default.warm_barrier, ..default };
    let (end, count) = counted(&mut program, &cold.x, &known, &options);
    assert_eq!(end.status, Status::Converged);
    assert!(count > 5, "{count}");
}
