//! The relation between the direct method and the flow, checked on any robot.

use super::{At, CheckOptions, Finding, Findings, State, extreme_eigenvalues};
use crate::cost::ControlEffort;
use crate::curve::{Basis, Continuity, gauss_legendre};
use crate::dynamics::{Data, crba, rnea};
use crate::error::Result;
use crate::flow::{ControlForm, Node, RightHandSide};
use crate::model::Model;
use crate::motion::{Path, Problem, curve_of};
use crate::transcription::{Derivatives, Grid, Objective};
use nalgebra::{DMatrix, DVector};

/// The number of points per segment: on curves that turn by a few radians their quadrature is exact up to rounding.
const POINTS: usize = 40;

/// The largest growth of rounding along a curve relative to its start.
const ROUNDING_GROWTH: f64 = 10.0;

/// Compares the gradient of the control effort on random curves of two segments with the right-hand side of the flow
/// there, in the weak form: for each function $\varphi$ of the basis and each joint of the robot, with
/// $\delta x = (\varphi, \dot \varphi)$,
///
/// $$ \delta \int |u|^2 dt = -\int \delta x^T G\\, \Omega\\, dt - 2 \dot \varphi^T H\\, \Delta u, $$
///
/// where $\Delta u$ is the jump of the control from the first segment to the second. At a minimum of the effort the
/// flow is therefore at rest for all variations that keep $v = \dot q$.
///
/// # Errors
/// None for a loaded model.
pub fn check_direct(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    let n = model.dof();
    let mut findings = Findings::default();
    for (sample, state) in options.states(model)?.iter().enumerate() {
        let (path, at) = regular_curve(model, At::new(model, sample, state)?)?;
        let grid = Grid::new(&path.basis, POINTS, 1.0);
        let mut derivatives = Derivatives::new(&grid, n);
        let mut effort = Objective::new(&grid, ControlEffort::new(model), n);
        effort.derivatives(&path.coefficients, &mut derivatives)?;
        let gradient = derivatives.gradient.reshape_generic(nalgebra::Dyn(n), nalgebra::Dyn(path.basis.free().len()));
        for k in &options.penalties {
            let at = at.under(*k);
            findings.compare(
                at.multiplied_again(),
                "Omega on a curve, weak form: gradient of the effort",
                at,
                weak_form(model, &path, *k)?.as_view(),
                gradient.as_view(),
            );
        }
    }
    Ok(findings.all)
}

/// A random curve along which the products of the weak form are accurate, and its tolerances.
///
/// $G \Omega$ is bounded where the mass matrix is singular, but $\Omega$ is not, and $H H \Omega$ then consists of
/// rounding errors. Robots whose hinges imitate ball joints have such configurations, and a curve of a few radians
/// crosses them. Its extent about the start is halved until the condition number along it is about that at the start.
fn regular_curve<'a>(model: &Model, start: At<'a>) -> Result<(Path, At<'a>)> {
    let mut extent = 1.0;
    loop {
        let path = curve_about(start.state, extent);
        let along = along(model, &path, start)?;
        if along.squared_rounding() <= ROUNDING_GROWTH * start.squared_rounding() {
            return Ok((path, along));
        }
        extent /= 2.0;
    }
}

/// The tolerances of quantities divided by the mass matrix at the quadrature points of a curve.
fn along<'a>(model: &Model, path: &Path, start: At<'a>) -> Result<At<'a>> {
    let (n, basis) = (model.dof(), &path.basis);
    let (mut data, mut h) = (Data::new(model), DMatrix::zeros(n, n));
    let mut worst = start;
    let (nodes, _) = gauss_legendre(POINTS);
    for e in 0..basis.segments() {
        for s in &nodes {
            let [q, ..] = basis.evaluate(&path.coefficients, basis.time(e, *s));
            crba(model, &mut data, q.as_slice(), &mut h)?;
            let here = At { eigenvalues: extreme_eigenvalues(&h), ..start };
            if here.condition() > worst.condition() {
                worst = here;
            }
        }
    }
    Ok(worst)
}

/// A random curve of two segments of degree 5 that begins in a random state and lasts one second. Everything but the
/// start is scaled by `extent`.
fn curve_about(state: &State, extent: f64) -> Path {
    let basis = Basis::new(2, 5, Continuity::default());
    let n = state.x.len() / 2;
    let part = |x: &[f64], half: usize| DVector::from_column_slice(&x[half * n..(half + 1) * n]);
    let q = part(&state.x, 0);
    let slopes = [part(&state.x, 1), part(&state.xdot, 1), part(&state.xddot, 0)].map(|slope| slope * extent);
    let away = [0.0, 0.1, -0.2].map(|size| part(&state.xdot, 0) * (size * extent));
    let bend = part(&state.xddot, 1) * extent;
    let mut coefficients = DMatrix::zeros(n, basis.count());
    for (e, (slope, away)) in slopes.iter().zip(&away).enumerate() {
        coefficients.set_column(basis.slope(e), slope);
        coefficients.set_column(basis.value(e), &(&q + away));
    }
    for (i, column) in [2, 3, 6, 7].into_iter().enumerate() {
        coefficients.set_column(column, &(&bend * (i as f64).cos()));
    }
    Path { basis, coefficients }
}

/// The right-hand side of the formula, one column per free function.
fn weak_form(model: &Model, path: &Path, k: f64) -> Result<DMatrix<f64>> {
    let (n, basis) = (model.dof(), &path.basis);
    let end = |time: f64| {
        let [q, v, _] = basis.evaluate(&path.coefficients, time);
        [q.as_slice(), v.as_slice()].concat()
    };
    let curve = curve_of(&Problem::new(model, end(0.0), end(1.0), 1.0)?, path)?;
    let chebyshev = curve.chebyshev(0);
    let (mut data, mut flow) = (Data::new(model), ControlForm::new(model));
    let (mut h, mut omega) = (DMatrix::zeros(n, n), DVector::zeros(2 * n));
    let mut interpolation = DVector::zeros(basis.degree() + 1);
    let mut sum = DMatrix::zeros(n, basis.count());
    let (nodes, weights) = gauss_legendre(POINTS);
    for e in 0..basis.segments() {
        let own = path.coefficients.columns(basis.first(e), basis.degree() + 1);
        let second = curve.segment(e) * chebyshev.d2().transpose();
        for (s, weight) in nodes.iter().zip(&weights) {
            let table = basis.local(*s);
            let state = own * table.transpose();
            chebyshev.interpolation(basis.half() * (1.0 + s), &mut interpolation);
            let jerk = second.rows(n, n) * &interpolation;
            let [q, v, a] = [0, 1, 2].map(|d| &state.as_slice()[d * n..(d + 1) * n]);
            let node =
                Node { t: 0.0, x: &[q, v].concat(), xdot: &[v, a].concat(), xddot: &[a, jerk.as_slice()].concat() };
            flow.omega(node, k, omega.as_mut_slice())?;
            crba(model, &mut data, q, &mut h)?;
            let (upper, lower) = (omega.rows(0, n) * k, &h * (&h * omega.rows(n, n)));
            for m in 0..=basis.degree() {
                let push = &upper * table[(0, m)] + &lower * table[(1, m)];
                let mut column = sum.column_mut(basis.first(e) + m);
                column.axpy(-weight * basis.half(), &push, 1.0);
            }
        }
    }
    for e in 1..basis.segments() {
        let mut control = |segment: usize, s: f64| -> Result<DVector<f64>> {
            let own = path.coefficients.columns(basis.first(segment), basis.degree() + 1);
            let state = own * basis.local(s).transpose();
            let [q, v, a] = [0, 1, 2].map(|d| &state.as_slice()[d * n..(d + 1) * n]);
            let mut u = DVector::zeros(n);
            rnea(model, &mut data, q, v, a, u.as_mut_slice())?;
            crba(model, &mut data, q, &mut h)?;
            Ok(u)
        };
        let jump = control(e, -1.0)? - control(e - 1, 1.0)?;
        // At a breakpoint only the slope function has a nonzero slope, which is one.
        let mut column = sum.column_mut(basis.slope(e));
        column.axpy(-2.0, &(&h * jump), 1.0);
    }
    Ok(sum.select_columns(&basis.free()))
}
