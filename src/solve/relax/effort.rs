//! The control effort as a running cost.

use super::cost::{Point, PointCost, PointDerivatives, Points, PointsDerivatives};
use crate::dynamics::{
    ContractedHessian, Data, InverseDynamicsDerivatives, rnea, rnea_second_order,
};
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{Lanes, Over, Scalar};
use nalgebra::{DMatrix, DVector};

/// How many points are computed side by side.
const LANES: usize = 4;
type Wide<S> = Lanes<S, LANES>;

/// The control effort $l = |u|^2$ with $u = ID(q, v, a)$, by analytic derivatives:
///
/// $$ \frac{\partial l}{\partial z} = 2 J^T u, \qquad \frac{\partial^2 l}{\partial z^2} = 2 J^T J + \Phi(2 u), \qquad
///    J = \left[ \frac{\partial ID}{\partial q}\ \frac{\partial ID}{\partial v}\ H \right], $$
///
/// where $\Phi(w)$ is the Hessian of $w^T ID$. The metric is $2 J^T J$. Four points at a time go through the dynamics side by side.
#[derive(Clone, Debug)]
pub struct SquaredControl<'m, C: Scalar, S: Scalar> {
    model: &'m Model<C>,
    data: Data<Wide<S>>,
    id: InverseDynamicsDerivatives<Wide<S>>,
    second: ContractedHessian<Wide<S>>,
    /// $q, v, a$.
    state: [Vec<Wide<S>>; 3],
    /// $\partial l / \partial u$, and what else than the effort has as second derivatives.
    weights: DVector<Wide<S>>,
    stiffness: DVector<Wide<S>>,
    /// For one point alone.
    single: Data<S>,
    u: DVector<S>,
}

/// What another cost of the control alone adds at a point: it is handed `u` and adds its first and second derivatives, the latter
/// with their own joint only. It says whether it has any of the second.
pub(super) trait Charge<S>: FnMut(usize, &[S], &mut [S], &mut [S]) -> bool {}
impl<S, F: FnMut(usize, &[S], &mut [S], &mut [S]) -> bool> Charge<S> for F {}

impl<'m, C: Scalar, S: Over<C>> SquaredControl<'m, C, S> {
    /// The control effort of `model`.
    #[must_use]
    pub fn new(model: &'m Model<C>) -> Self {
        let n = model.dof();
        let zeros = vec![Wide::splat(S::zero()); n];
        Self {
            model,
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            second: ContractedHessian::new(n),
            state: [zeros.clone(), zeros.clone(), zeros.clone()],
            weights: DVector::from_vec(zeros.clone()),
            stiffness: DVector::from_vec(zeros),
            single: Data::new(model),
            u: DVector::zeros(n),
        }
    }

    /// $u$ at a point.
    pub(super) fn control(&mut self, point: Point<'_, S>) -> Result<&DVector<S>> {
        let Point { q, v, a, .. } = point;
        rnea(self.model, &mut self.single, q, v, a, self.u.as_mut_slice())?;
        Ok(&self.u)
    }

    /// Puts the points from `start` on into the lanes, the last of them into those that are left; says how many there are.
    fn gather(&mut self, points: Points<'_, S>, start: usize) -> usize {
        let count = LANES.min(points.count() - start);
        for lane in 0..LANES {
            let Point { q, v, a, .. } = points.point(start + lane.min(count - 1));
            for (to, from) in self.state.iter_mut().zip([q, v, a]) {
                for (to, from) in to.iter_mut().zip(from) {
                    to.0[lane] = *from;
                }
            }
        }
        count
    }

    /// The derivatives of the effort and of another cost of the control. The metrics and the costs are those of the effort.
    pub(super) fn derivatives_charging(
        &mut self,
        points: Points<'_, S>,
        out: &mut PointsDerivatives<S>,
        charge: &mut impl Charge<S>,
    ) -> Result<()> {
        let n = self.model.dof();
        let two = Wide::from_f64(2.0);
        for start in (0..points.count()).step_by(LANES) {
            let count = self.gather(points, start);
            self.stiffness.fill(Wide::splat(S::zero()));
            let (u, weights, stiffness) = (&mut self.u, &mut self.weights, &mut self.stiffness);
            let (mut first, mut second) = (DVector::zeros(n), DVector::zeros(n));
            let mut stiff = false;
            let weigh = |tau: &DVector<Wide<S>>, w: &mut [Wide<S>]| {
                weights.copy_from(tau);
                *weights *= two;
                for lane in 0..count {
                    u.zip_apply(tau, |u, tau| *u = tau.0[lane]);
                    first.fill(S::zero());
                    second.fill(S::zero());
                    let (first, second) = (first.as_mut_slice(), second.as_mut_slice());
                    let index = points.first + start + lane;
                    stiff |= charge(index, u.as_slice(), first, second);
                    for i in 0..n {
                        weights[i].0[lane] += first[i];
                        stiffness[i].0[lane] = second[i];
                    }
                }
                w.copy_from_slice(weights.as_slice());
            };
            let [q, v, a] = &self.state;
            let (id, second) = (&mut self.id, &mut self.second);
            rnea_second_order(self.model, &mut self.data, [q, v, a], weigh, id, second)?;
            self.file(start, count, stiff, out);
        }
        Ok(())
    }

    /// Files what the lanes hold: `count` points from `start` on.
    fn file(&self, start: usize, count: usize, stiff: bool, out: &mut PointsDerivatives<S>) {
        let (n, points) = (self.model.dof(), out.costs.len());
        let InverseDynamicsDerivatives { tau, dq, dv, h } = &self.id;
        let ContractedHessian { qq, qv, vv, qa } = &self.second;
        let two = Wide::from_f64(2.0);
        let cost = tau.dot(tau);
        out.costs[start..start + count].copy_from_slice(&cost.0[..count]);
        let jacobian = [dq, dv, h];
        for (x, block) in jacobian.into_iter().enumerate() {
            for (i, column) in block.column_iter().enumerate() {
                let slope = column.dot(&self.weights);
                for lane in 0..count {
                    out.gradients[(i, 3 * (start + lane) + x)] = slope.0[lane];
                }
            }
        }
        for (x, y, phi) in [
            (0, 0, Some(qq)),
            (0, 1, Some(qv)),
            (0, 2, Some(qa)),
            (1, 1, Some(vv)),
            (1, 2, None),
            (2, 2, None),
        ] {
            for j in 0..n {
                let right = jacobian[y].column(j);
                // Blocks on the diagonal are symmetric.
                for i in if x == y { j } else { 0 }..n {
                    let left = jacobian[x].column(i);
                    let metric = left.dot(&right) * two;
                    let mut hessian = metric;
                    if let Some(phi) = phi {
                        hessian += phi[(i, j)];
                    }
                    if stiff {
                        for ((l, c), r) in left.iter().zip(&self.stiffness).zip(&right) {
                            hessian += *l * *c * *r;
                        }
                    }
                    for (x, y, i, j) in [(x, y, i, j), (y, x, j, i)] {
                        let row = (3 * x + y) * points + start;
                        let rows = row..row + count;
                        let put = |matrix: &mut DMatrix<S>, lanes: &Wide<S>| {
                            let first = (i + n * j) * 9 * points;
                            let column = &mut matrix.as_mut_slice()[first..first + 9 * points];
                            column[rows.clone()].copy_from_slice(&lanes.0[..count]);
                        };
                        put(&mut out.hessians, &hessian);
                        if out.with_metrics {
                            put(&mut out.metrics, &metric);
                        }
                    }
                }
            }
        }
    }
}

impl<C: Scalar, S: Over<C>> PointCost<S> for SquaredControl<'_, C, S> {
    fn value(&mut self, point: Point<'_, S>) -> Result<S> {
        let u = self.control(point)?;
        Ok(u.dot(u))
    }

    fn derivatives(&mut self, point: Point<'_, S>, out: &mut PointDerivatives<S>) -> Result<S> {
        alone(self, point, out)
    }

    fn values(&mut self, points: Points<'_, S>, costs: &mut [S]) -> Result<()> {
        for start in (0..points.count()).step_by(LANES) {
            let count = self.gather(points, start);
            let ([q, v, a], tau) = (&self.state, &mut self.weights);
            rnea(self.model, &mut self.data, q, v, a, tau.as_mut_slice())?;
            let cost = tau.dot(tau);
            costs[start..start + count].copy_from_slice(&cost.0[..count]);
        }
        Ok(())
    }

    fn all_derivatives(
        &mut self,
        points: Points<'_, S>,
        out: &mut PointsDerivatives<S>,
    ) -> Result<()> {
        self.derivatives_charging(points, out, &mut |_, _, _, _| false)
    }
}

/// The derivatives at a single point of a cost that is for many.
pub(super) fn alone<S: Scalar>(
    cost: &mut impl PointCost<S>,
    point: Point<'_, S>,
    out: &mut PointDerivatives<S>,
) -> Result<S> {
    let Point { q, v, a, .. } = point;
    let states = DMatrix::from_fn(q.len(), 3, |i, x| [q, v, a][x][i]);
    let mut all = PointsDerivatives::new(q.len(), 1);
    let points = Points {
        first: point.index,
        times: &[point.time],
        states: &states,
    };
    cost.all_derivatives(points, &mut all)?;
    for column in 0..3 * q.len() {
        for row in 0..3 * q.len() {
            let at = all.entry(0, row, column);
            out.hessian[(row, column)] = all.hessians[at];
            out.metric[(row, column)] = all.metrics[at];
        }
    }
    out.gradient.copy_from_slice(all.gradients.as_slice());
    Ok(all.costs[0])
}
