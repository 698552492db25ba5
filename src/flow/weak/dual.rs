//! Any Lagrangian in any metric at quadrature points, by dual numbers.

use super::{LagrangianDerivatives, PointLagrangian, StatePoints};
use crate::error::{Result, check_length};
use crate::flow::{ActuationMetric, Lagrangian, Metric};
use crate::linalg::positive_part;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar, Tanh};
use nalgebra::DMatrix;

/// The number of entries of $[x; \dot x]$ in which one evaluation differentiates, apart from one more.
const WIDTH: usize = 4;
/// A number with a tangent along one entry, and along several more.
type Moving<S> = Jet<Jet<S, WIDTH>, 1>;

/// Any [`Lagrangian`] with the [`Metric`] of its flow, by default the paper's (11). Gradient and Hessian come from
/// nested dual numbers, `2 N (N + 1)` evaluations per point: slow, but correct for any `L`.
///
/// For an arbitrary Lagrangian the [Gauss-Newton second derivatives](LagrangianDerivatives::convex) are the Hessian
/// with its negative eigenvalues set to zero. They need an order, which a finite field lacks: over any scalar there are
/// [`values_over`](Self::values_over), [`derivatives_over`](Self::derivatives_over) and
/// [`metrics_over`](Self::metrics_over).
#[derive(Clone, Debug)]
pub struct DualLagrangian<'m, L, C: Scalar = f64, M = ActuationMetric<C>> {
    model: &'m Model<C>,
    lagrangian: L,
    metric: M,
    k: C,
}

impl<'m, C: Scalar, L: Lagrangian<C>> DualLagrangian<'m, L, C> {
    /// The Lagrangian `lagrangian` for `model` under the penalty `k`, in the paper's metric.
    #[must_use]
    pub fn new(model: &'m Model<C>, lagrangian: L, k: C) -> Self {
        Self::in_metric(model, lagrangian, ActuationMetric::default(), k)
    }
}

impl<'m, C: Scalar, L: Lagrangian<C>, M: Metric<C>> DualLagrangian<'m, L, C, M> {
    /// The Lagrangian `lagrangian` for `model` in `metric`, both under the penalty `k`.
    #[must_use]
    pub fn in_metric(model: &'m Model<C>, lagrangian: L, metric: M, k: C) -> Self {
        Self {
            model,
            lagrangian,
            metric,
            k,
        }
    }

    /// Computes $L$ of $[x; \dot x]$.
    fn at<S: AlgebraOver<C> + Tanh>(&self, t: S, y: &[S]) -> Result<S> {
        let (x, xdot) = y.split_at(y.len() / 2);
        self.lagrangian.value(self.model, t, x, xdot, self.k)
    }

    /// Computes [`PointLagrangian::values`] over any scalar.
    ///
    /// # Errors
    /// Those of the Lagrangian, or `at` has the wrong number of rows.
    pub fn values_over<S: AlgebraOver<C> + Tanh>(
        &self,
        at: StatePoints<'_, S>,
        values: &mut [S],
    ) -> Result<()> {
        for (g, value) in values.iter_mut().enumerate() {
            *value = self.at(at.times[g], &self.entries(at, g)?)?;
        }
        Ok(())
    }

    /// Computes [`PointLagrangian::derivatives`] over any scalar; the second derivatives are the Hessian.
    ///
    /// # Errors
    /// Those of [`values_over`](Self::values_over).
    pub fn derivatives_over<S: AlgebraOver<C> + Tanh>(
        &self,
        at: StatePoints<'_, S>,
        out: &mut LagrangianDerivatives<S>,
    ) -> Result<()> {
        let (size, count) = (2 * self.model.dof(), at.count());
        out.hessians.fill(S::zero());
        for g in 0..count {
            let y = self.entries(at, g)?;
            let t = Jet::constant(Jet::constant(at.times[g]));
            for row in 0..2 * size {
                for first in (0..=row).step_by(WIDTH) {
                    let moving: Vec<Moving<S>> = (y.iter().enumerate())
                        .map(|(i, y)| {
                            let several = std::array::from_fn(|lane| unit(first + lane == i));
                            Jet::new(Jet::new(*y, several), [Jet::constant(unit(row == i))])
                        })
                        .collect();
                    let l = self.at(t, &moving)?;
                    out.values[g] = l.re.re;
                    let [slope] = l.eps;
                    out.gradients[(row % size, row / size * count + g)] = slope.re;
                    for (column, second) in (first..=row).zip(slope.eps) {
                        out.add(g, row, column, second);
                        if column < row {
                            out.add(g, column, row, second);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Computes [`PointLagrangian::metrics`] over any scalar.
    ///
    /// # Errors
    /// Those of the metric, or it has another number of joints, or `at` has the wrong number of rows.
    pub fn metrics_over<S: AlgebraOver<C> + Tanh>(
        &self,
        at: StatePoints<'_, S>,
        out: &mut DMatrix<S>,
    ) -> Result<()> {
        for g in 0..at.count() {
            let y = self.entries(at, g)?;
            let x = &y[..2 * self.model.dof()];
            let metric = self.metric.matrix(self.model, at.times[g], x, self.k)?;
            check_length("metric", out.nrows(), metric.len())?;
            out.column_mut(g).copy_from_slice(metric.as_slice());
        }
        Ok(())
    }

    /// $[x; \dot x]$ at point `g`.
    fn entries<S: Scalar>(&self, at: StatePoints<'_, S>, g: usize) -> Result<Vec<S>> {
        let n = self.model.dof();
        check_length("states", 4 * n, at.states.nrows())?;
        let column = at.states.column(g);
        let [x, acceleration, rate] = [(0, 2 * n), (2 * n, n), (3 * n, n)]
            .map(|(first, count)| column.rows(first, count).data.into_slice());
        Ok([x, rate, acceleration].concat())
    }
}

/// One or zero.
fn unit<S: Scalar>(one: bool) -> S {
    if one { S::one() } else { S::zero() }
}

impl<L: Lagrangian, M: Metric> PointLagrangian<f64> for DualLagrangian<'_, L, f64, M> {
    fn values(&mut self, at: StatePoints<'_, f64>, values: &mut [f64]) -> Result<()> {
        self.values_over(at, values)
    }

    fn derivatives(
        &mut self,
        at: StatePoints<'_, f64>,
        out: &mut LagrangianDerivatives<f64>,
    ) -> Result<()> {
        self.derivatives_over(at, out)?;
        if out.convex {
            (0..at.count()).for_each(|g| out.cut_negative(g));
        }
        Ok(())
    }

    fn metrics(&mut self, at: StatePoints<'_, f64>, out: &mut DMatrix<f64>) -> Result<()> {
        self.metrics_over(at, out)
    }
}

impl LagrangianDerivatives<f64> {
    /// Sets the negative eigenvalues of the second derivatives at point `g` to zero.
    fn cut_negative(&mut self, g: usize) {
        let size = self.gradients.nrows();
        let mut whole = DMatrix::zeros(2 * size, 2 * size);
        for kind in 0..4 {
            let block = DMatrix::from_column_slice(size, size, self.block_mut(g, kind));
            let at = (kind / 2 * size, kind % 2 * size);
            whole.view_mut(at, (size, size)).copy_from(&block);
        }
        let mut positive = whole.clone();
        positive_part(&whole, &mut positive);
        for kind in 0..4 {
            let at = (kind / 2 * size, kind % 2 * size);
            let block = positive.view(at, (size, size)).into_owned();
            self.block_mut(g, kind).copy_from_slice(block.as_slice());
        }
    }
}
