//! Checks of the Lagrangian of the weak form of the flow.

use super::general_flow::wave;
use super::{At, BOUND, CheckOptions, Finding, Findings, State, Tolerance, VANISHING};
use crate::cost::{ControlEffort, PointCost, Points, PointsDerivatives};
use crate::dynamics::{Data, rnea};
use crate::error::Result;
use crate::flow::Lagrangian;
use crate::flow::weak::{DualLagrangian, WithSlip};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar, Tanh};
use nalgebra::{DMatrix, DVector};

/// The number of states that are evaluated together: one more than the SIMD lanes of the dynamics.
const TOGETHER: usize = 5;
/// The parts of $[x; \dot x]$.
const PARTS: [&str; 4] = ["x_P1", "x_P2", "xdot_P1", "xdot_P2"];

/// The Lagrangian of [`WithSlip`] with weighted squares, implemented only by its value,
/// $k |e|^2 + \lambda^T e + u^T W u + v^T W_v v + \dot x_{P2}^T W_a \dot x_{P2}$.
pub(crate) struct Written<C: Scalar> {
    /// $W$, $W_v$ and $W_a$, `N` entries each.
    pub weights: [DVector<C>; 3],
    /// $\lambda$.
    pub dual: DVector<C>,
}

impl<C: Scalar> Lagrangian<C> for Written<C> {
    fn value<S: AlgebraOver<C> + Tanh>(&self, model: &Model<C>, _: S, x: &[S], xdot: &[S], k: C) -> Result<S> {
        let n = model.dof();
        let ((q, v), (rate, a)) = (x.split_at(n), xdot.split_at(n));
        let mut u = vec![S::zero(); n];
        rnea(model, &mut Data::new(model), q, v, a, &mut u)?;
        Ok((0..n).fold(S::zero(), |sum, i| {
            let (slip, [w, wv, wa]) = (rate[i] - v[i], self.weights.each_ref().map(|w| w[i]));
            let squares = (u[i] * u[i]).scale(w) + (v[i] * v[i]).scale(wv) + (a[i] * a[i]).scale(wa);
            sum + squares + (slip * slip).scale(k) + slip.scale(self.dual[i])
        }))
    }
}

/// Compares the analytic Lagrangian of the weak form of the flow, with all weights and a multiplier of the slip, with
/// dual numbers of the value: the worst of each part at each penalty.
///
/// # Errors
/// None for a loaded model.
pub fn check_weak_form(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    let n = model.dof();
    let mut findings = Findings::default();
    let vector = |shift: usize| DVector::from_fn(n, |i, _| 2.0 + wave(i, shift));
    let written = Written { weights: [0, 1, 2].map(vector), dual: vector(3) };
    for (chunk, states) in options.states(model)?.chunks(TOGETHER).enumerate() {
        let count = states.len();
        let columns: Vec<_> = states.iter().flat_map(columns).collect();
        let (times, columns) = (vec![0.0; count], DMatrix::from_columns(&columns));
        let points = Points { first: 1, phase: 0, times: &times, states: &columns, higher: &[] };
        for k in &options.penalties {
            let effort = ControlEffort::with_weights(model, &written.weights)?;
            let mut analytic = WithSlip::new(effort, *k, n, count + 1);
            analytic.multipliers = DMatrix::from_fn(n, count + 1, |i, _| written.dual[i]);
            let mut by_duals = DualLagrangian::new(model, &written, *k);
            let ours = looked_at(&mut analytic, points)?;
            let expected = looked_at(&mut by_duals, points)?;
            for (g, state) in states.iter().enumerate() {
                let at = At::new(model, chunk * TOGETHER + g, state)?.under(*k);
                let tolerance = at.squared();
                for ((what, ours), (_, expected)) in ours.of(g).iter().zip(expected.of(g)) {
                    let quantity = format!("weak form: {what}");
                    let (ours, expected) = (ours.as_view(), expected.as_view());
                    findings.compare(tolerance, &quantity, at, ours, expected);
                }
            }
        }
    }
    Ok(findings.all)
}

impl At<'_> {
    /// The tolerance of sums of products with two inertias.
    fn squared(&self) -> Tolerance {
        Tolerance { bound: BOUND, floor: VANISHING * self.inertia.powi(2) }
    }
}

/// $x$, $\dot x$ and zero, which no Lagrangian depends on.
fn columns(state: &State) -> [DVector<f64>; 3] {
    let zero = vec![0.0; state.x.len()];
    [&state.x[..], &state.xdot[..], &zero].map(DVector::from_column_slice)
}

/// The values and derivatives of a Lagrangian at several points.
struct Found {
    values: Vec<f64>,
    derivatives: PointsDerivatives<f64>,
}

fn looked_at(lagrangian: &mut impl PointCost<f64>, at: Points<'_, f64>) -> Result<Found> {
    let mut found =
        Found { values: vec![0.0; at.count()], derivatives: PointsDerivatives::new(at.states.nrows(), at.count()) };
    lagrangian.values(at, &mut found.values)?;
    lagrangian.all_derivatives(at, &mut found.derivatives)?;
    Ok(found)
}

impl Found {
    /// The quantities of point `g`, with the rows that depend on the penalty separate from the others.
    fn of(&self, g: usize) -> Vec<(String, DMatrix<f64>)> {
        let all = &self.derivatives;
        let n = all.gradients.nrows() / 2;
        let hessian = all.hessians.get(g);
        let values = [self.values[g], all.costs[g]];
        let mut found = vec![("L".to_owned(), DMatrix::from_row_slice(1, 2, &values))];
        for (part, name) in PARTS.iter().enumerate() {
            let slopes = &all.gradients.as_slice()[6 * n * g + part * n..][..n];
            let slopes = DMatrix::from_column_slice(n, 1, slopes);
            found.push((format!("dL/d{name}"), slopes));
            let rows = hessian.rows(part * n, n).into_owned();
            found.push((format!("Hessian, rows of {name}"), rows));
        }
        found
    }
}
