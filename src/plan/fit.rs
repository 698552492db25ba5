//! A path as a curve in a basis.

use super::shorten::Along;
use crate::curve::{Basis, Curve};
use crate::error::{Error, Result, check_length};
use crate::motion::{Path, Problem, curve_of};
use nalgebra::{Cholesky, DMatrix};

/// The weight of squared second derivatives beside squared distances, both in normalised time: it keeps high degrees from swinging.
const STIFFNESS: f64 = 1e-8;
/// Points of the fit for each function of the basis.
const POINTS: usize = 6;

/// The curve in a basis that is nearest to a path in the least squares of many points, with the states of the problem at its ends. The
/// path is timed by its length as a cubic from rest to rest. Cost O($m^3$) for `m` functions of the basis.
///
/// # Errors
/// There is no waypoint, one does not have `N` entries, or the functions of the basis are not independent.
pub fn curve_through(problem: &Problem<'_>, path: &[Vec<f64>], basis: Basis) -> Result<Curve> {
    curve_of(problem, &fit(problem, path, basis)?)
}

/// The same as coefficients.
pub(crate) fn fit(problem: &Problem<'_>, path: &[Vec<f64>], basis: Basis) -> Result<Path> {
    let n = problem.model().dof();
    if path.is_empty() {
        return Err(Error::input("path", "waypoints", "there is none"));
    }
    for waypoint in path {
        check_length("waypoint", n, waypoint.len())?;
    }
    let (count, free) = (basis.count(), basis.free());
    let points = POINTS * count;
    let mut matrix = DMatrix::<f64>::zeros(count, count);
    let mut right = DMatrix::<f64>::zeros(count, n);
    let along = Along::new(path);
    let weight = 1.0 / points as f64;
    for i in 0..points {
        let time = (i as f64 + 0.5) / points as f64;
        let length = along.length() * time * time * (3.0 - 2.0 * time);
        let (_, at) = along.at(path, length);
        let e = ((time * basis.segments() as f64) as usize).min(basis.segments() - 1);
        let s = time / basis.half() - (2 * e + 1) as f64;
        let table = basis.local(s);
        let first = basis.first(e);
        for a in 0..table.ncols() {
            for b in 0..table.ncols() {
                let products = [0, 2].map(|d| table[(d, a)] * table[(d, b)]);
                matrix[(first + a, first + b)] += weight * (products[0] + STIFFNESS * products[1]);
            }
            for (j, q) in at.iter().enumerate() {
                right[(first + a, j)] += weight * table[(0, a)] * q;
            }
        }
    }
    // What is left to fit once value and slope at the ends are those of the problem.
    let mut found = Path {
        coefficients: DMatrix::zeros(n, count),
        basis,
    }
    .between_ends_of(problem);
    let right = right - &matrix * found.coefficients.transpose();
    let own = matrix.view_range(free.clone(), free.clone()).into_owned();
    let Some(cholesky) = Cholesky::new(own) else {
        let condition = "it cannot hold a path: its functions are not independent";
        return Err(Error::input("path", "basis", condition));
    };
    let solution = cholesky.solve(&right.rows_range(free.clone()).into_owned());
    let mut own = found.coefficients.columns_range_mut(free);
    own += solution.transpose();
    Ok(found)
}
