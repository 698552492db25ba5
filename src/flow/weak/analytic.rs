//! The Lagrangian of the flow in its control form, with weights and duals, with analytic derivatives.

use super::{LagrangianDerivatives, PointLagrangian, StatePoints};
use crate::dynamics::{
    Data, InverseDynamicsDerivatives, RneaWeightedHessian, crba, rnea, rnea_second_order,
};
use crate::error::{Result, check_length};
use crate::linalg::weighted_gram;
use crate::model::Model;
use crate::scalar::{AlgebraOver, LANES, Lanes, Scalar, Wide};
use nalgebra::{DMatrix, DVector};

/// The Lagrangian
///
/// $$ L = k\\, |e|^2 + \lambda^T e + u^T W u + v^T W_v v + \dot x_{P2}^T W_a \dot x_{P2}, \qquad e = \dot x_{P1} - x_{P2}, \quad
///    u = ID(x_{P1}, x_{P2}, \dot x_{P2}), $$
///
/// with diagonal weights, in the metric $G = \mathrm{blockdiag}(k I, H W_G H)$. With $W = W_G = I$, without the other
/// weights and without the dual $\lambda$ of the slip it is the paper's. With $[J_q, J_v, H]$ the derivatives of $ID$
/// and $\Phi$ the Hessian of $(2 W u)^T ID$,
///
/// $$ L_x = \begin{bmatrix} 2 J_q^T W u \\\\ 2 J_v^T W u + 2 W_v v - 2 k e - \lambda \end{bmatrix}, \qquad
///    L_{\dot x} = \begin{bmatrix} 2 k e + \lambda \\\\ 2 H W u + 2 W_a \dot x_{P2} \end{bmatrix}, $$
///
/// and the second derivatives are $2 [J_q, J_v, H]^T W [J_q, J_v, H] + \Phi$, the weights, and $\pm 2 k I$ for the
/// terms in $e$.
#[derive(Clone, Debug)]
pub struct AnalyticLagrangian<'m, C: Scalar = f64, S: Scalar = C> {
    model: &'m Model<C>,
    /// The penalty $k$ of the Lagrangian and of the metric.
    pub k: S,
    /// The weights $W$, $W_v$ and $W_a$, `N` entries each.
    pub weights: [DVector<S>; 3],
    /// The weights $W_G$ of the metric, `N` entries.
    pub metric_weights: DVector<S>,
    /// The dual $\lambda$ at all points of the grid, `N` by their number; zero if there are no columns.
    pub slip_duals: DMatrix<S>,
    /// True for each point of the grid at which only terms of others count and $L$ does not; empty if $L$ counts
    /// everywhere.
    pub silent: Vec<bool>,
    data: Data<Wide<S>>,
    id: InverseDynamicsDerivatives<Wide<S>>,
    second: RneaWeightedHessian<Wide<S>>,
    /// $[q; v; \dot x_{P2}; \dot x_{P1}]$ of the points that are evaluated side by side.
    state: Vec<Wide<S>>,
    /// $\partial L / \partial u$ and half the second derivatives.
    slopes: DVector<Wide<S>>,
    curvatures: DVector<Wide<S>>,
    gram: DMatrix<Wide<S>>,
    point: ControlPoint<S>,
}

/// Terms of a Lagrangian in the control of one point: additions to its value and to its first and second derivatives in
/// `u`.
#[derive(Clone, Debug)]
pub struct ControlPoint<S: Scalar> {
    /// The control, `N` entries.
    pub u: DVector<S>,
    /// The value of the terms.
    pub value: S,
    /// Their derivatives in `u`.
    pub slopes: DVector<S>,
    /// The diagonal of their second derivatives, whose other entries are zero.
    pub curvatures: DVector<S>,
}

impl<'m, C: Scalar, S: AlgebraOver<C>> AnalyticLagrangian<'m, C, S> {
    /// The paper's Lagrangian with penalty `k`.
    #[must_use]
    pub fn new(model: &'m Model<C>, k: C) -> Self {
        let n = model.dof();
        let zero = Wide::splat(S::zero());
        let [ones, zeros] = [S::one(), S::zero()].map(|x| DVector::from_element(n, x));
        Self {
            model,
            k: S::lift(k),
            weights: [ones.clone(), zeros.clone(), zeros.clone()],
            metric_weights: ones,
            slip_duals: DMatrix::zeros(n, 0),
            silent: Vec::new(),
            data: Data::new(model),
            id: InverseDynamicsDerivatives::new(n),
            second: RneaWeightedHessian::new(n),
            state: vec![zero; 4 * n],
            slopes: DVector::from_element(n, zero),
            curvatures: DVector::from_element(n, zero),
            gram: DMatrix::from_element(3 * n, 3 * n, zero),
            point: ControlPoint {
                u: zeros.clone(),
                value: S::zero(),
                slopes: zeros.clone(),
                curvatures: zeros,
            },
        }
    }

    /// The robot.
    #[must_use]
    pub fn model(&self) -> &'m Model<C> {
        self.model
    }

    /// One if $L$ counts at point `index`, otherwise zero.
    fn share(&self, index: usize) -> S {
        share(&self.silent, index)
    }

    /// The part of $L$ without the control, at a point with the slip duals of its index.
    fn motion_value(&self, at: &StatePoints<'_, S>, g: usize) -> S {
        let (n, y) = (self.model.dof(), at.states.column(g));
        let [_, velocity, acceleration] = &self.weights;
        let mut sum = S::zero();
        for i in 0..n {
            let (v, a) = (y[n + i], y[2 * n + i]);
            let slip = y[3 * n + i] - v;
            sum += self.k * slip * slip + velocity[i] * v * v + acceleration[i] * a * a;
            if self.slip_duals.ncols() > 0 {
                sum += self.slip_duals[(i, at.first + g)] * slip;
            }
        }
        self.share(at.first + g) * sum
    }

    /// Computes [`PointLagrangian::values`] with terms in the control.
    pub(super) fn values_with(
        &mut self,
        at: StatePoints<'_, S>,
        values: &mut [S],
        mut terms: impl FnMut(usize, &mut ControlPoint<S>),
    ) -> Result<()> {
        check_length("states", 4 * self.model.dof(), at.states.nrows())?;
        let n = self.model.dof();
        for start in (0..at.count()).step_by(LANES) {
            let count = Lanes::gather(at.states.as_slice(), start, &mut self.state);
            let [q, v, a] = parts(&self.state);
            let tau = self.slopes.as_mut_slice();
            rnea(self.model, &mut self.data, q, v, a, tau)?;
            for lane in 0..count {
                let g = start + lane;
                self.point.clear();
                let (share, mut sum) = (self.share(at.first + g), S::zero());
                for i in 0..n {
                    let u = self.slopes[i].0[lane];
                    self.point.u[i] = u;
                    sum += share * self.weights[0][i] * u * u;
                }
                terms(at.first + g, &mut self.point);
                values[g] = sum + self.point.value + self.motion_value(&at, g);
            }
        }
        Ok(())
    }

    /// Computes [`PointLagrangian::derivatives`] with terms in the control.
    pub(super) fn derivatives_with(
        &mut self,
        at: StatePoints<'_, S>,
        out: &mut LagrangianDerivatives<S>,
        mut terms: impl FnMut(usize, &mut ControlPoint<S>),
    ) -> Result<()> {
        check_length("states", 4 * self.model.dof(), at.states.nrows())?;
        let n = self.model.dof();
        let two = S::from_f64(2.0);
        for start in (0..at.count()).step_by(LANES) {
            let count = Lanes::gather(at.states.as_slice(), start, &mut self.state);
            let (weights, silent, point) = (&self.weights[0], &self.silent, &mut self.point);
            let (slopes, curvatures) = (&mut self.slopes, &mut self.curvatures);
            let values = &mut out.values;
            let weigh = |tau: &DVector<Wide<S>>, w: &mut [Wide<S>]| {
                for lane in 0..LANES {
                    let g = start + lane.min(count - 1);
                    point.clear();
                    point.u.zip_apply(tau, |u, tau| *u = tau.0[lane]);
                    terms(at.first + g, point);
                    let (share, mut sum) = (share::<S>(silent, at.first + g), point.value);
                    for i in 0..n {
                        let (u, weight) = (point.u[i], share * weights[i]);
                        sum += weight * u * u;
                        slopes[i].0[lane] = two * weight * u + point.slopes[i];
                        curvatures[i].0[lane] = two * weight + point.curvatures[i];
                    }
                    values[g] = sum;
                }
                w.copy_from_slice(slopes.as_slice());
            };
            let z = parts(&self.state);
            let (id, second) = (&mut self.id, &mut self.second);
            rnea_second_order(self.model, &mut self.data, z, weigh, id, second)?;
            let jacobian = [&self.id.dq, &self.id.dv, &self.id.h];
            let column = |c: usize| &jacobian[c / n].as_slice()[c % n * n..(c % n + 1) * n];
            weighted_gram(column, &self.curvatures, &mut self.gram);
            for lane in 0..count {
                self.file(&at, start + lane, lane, out);
            }
        }
        Ok(())
    }

    /// Stores the results of one lane for point `g`.
    fn file(
        &self,
        at: &StatePoints<'_, S>,
        g: usize,
        lane: usize,
        out: &mut LagrangianDerivatives<S>,
    ) {
        let (n, count) = (self.model.dof(), at.count());
        let (y, share) = (at.states.column(g), self.share(at.first + g));
        let two = share * S::from_f64(2.0);
        let stiff = two * self.k;
        out.values[g] += self.motion_value(at, g);
        let jacobian = [&self.id.dq, &self.id.dv, &self.id.h];
        // The place of q, v and the acceleration in [x; xdot].
        let place = [0, n, 3 * n];
        for (x, block) in jacobian.into_iter().enumerate() {
            for (i, column) in block.column_iter().enumerate() {
                let slope = column.dot(&self.slopes).0[lane];
                let to = (place[x] + i) % (2 * n);
                out.gradients[(to, place[x] / (2 * n) * count + g)] = slope;
            }
        }
        for kind in 0..4 {
            self.file_block(kind, lane, out.convex, out.block_mut(g, kind));
        }
        let [_, velocity, acceleration] = &self.weights;
        for i in 0..n {
            let (v, a) = (y[n + i], y[2 * n + i]);
            let mut by_slip = stiff * (y[3 * n + i] - v);
            if self.slip_duals.ncols() > 0 {
                by_slip += share * self.slip_duals[(i, at.first + g)];
            }
            out.gradients[(n + i, g)] += two * velocity[i] * v - by_slip;
            out.gradients[(i, count + g)] = by_slip;
            out.gradients[(n + i, count + g)] += two * acceleration[i] * a;
            out.add(g, n + i, n + i, stiff + two * velocity[i]);
            out.add(g, 2 * n + i, 2 * n + i, stiff);
            out.add(g, n + i, 2 * n + i, -stiff);
            out.add(g, 2 * n + i, n + i, -stiff);
            out.add(g, 3 * n + i, 3 * n + i, two * acceleration[i]);
        }
    }

    /// Stores the second derivatives of the part in the control, for one of the four kinds of
    /// [`LagrangianDerivatives::hessians`].
    fn file_block(&self, kind: usize, lane: usize, convex: bool, block: &mut [S]) {
        let n = self.model.dof();
        let RneaWeightedHessian { qq, qv, vv, qa } = &self.second;
        block.fill(S::zero());
        // The rows and columns of x are q and v, and those of its rate end with the acceleration.
        let of_x = [(0, 0), (1, n)];
        let of_rate = [(2, n)];
        let [rows, columns] = [kind / 2, kind % 2].map(|rate| match rate {
            0 => &of_x[..],
            _ => &of_rate[..],
        });
        for &(y, right) in columns {
            for &(x, below) in rows {
                let (first, second) = (x.min(y), x.max(y));
                let phi = match (first, second) {
                    _ if convex => None,
                    (0, 0) => Some(qq),
                    (0, 1) => Some(qv),
                    (0, 2) => Some(qa),
                    (1, 1) => Some(vv),
                    _ => None,
                };
                for j in 0..n {
                    let to = (right + j) * 2 * n + below;
                    for (i, to) in block[to..to + n].iter_mut().enumerate() {
                        let (row, column) = (x * n + i, y * n + j);
                        *to = self.gram[(row.max(column), row.min(column))].0[lane];
                        if let Some(phi) = phi {
                            let at = if x <= y { (i, j) } else { (j, i) };
                            *to += phi[at].0[lane];
                        }
                    }
                }
            }
        }
    }
}

/// One if the Lagrangian counts at point `index`, otherwise zero.
fn share<S: Scalar>(silent: &[bool], index: usize) -> S {
    match silent.get(index) {
        Some(true) => S::zero(),
        _ => S::one(),
    }
}

impl<S: Scalar> ControlPoint<S> {
    /// Sets everything except the control to zero.
    fn clear(&mut self) {
        self.value = S::zero();
        self.slopes.fill(S::zero());
        self.curvatures.fill(S::zero());
    }
}

/// $q$, $v$ and the acceleration of $[q; v; \dot x_{P2}; \dot x_{P1}]$.
fn parts<T>(state: &[T]) -> [&[T]; 3] {
    let n = state.len() / 4;
    [&state[..n], &state[n..2 * n], &state[2 * n..3 * n]]
}

impl<C: Scalar, S: AlgebraOver<C>> PointLagrangian<S> for AnalyticLagrangian<'_, C, S> {
    fn values(&mut self, at: StatePoints<'_, S>, values: &mut [S]) -> Result<()> {
        self.values_with(at, values, |_, _| {})
    }

    fn derivatives(
        &mut self,
        at: StatePoints<'_, S>,
        out: &mut LagrangianDerivatives<S>,
    ) -> Result<()> {
        self.derivatives_with(at, out, |_, _| {})
    }

    fn metrics(&mut self, at: StatePoints<'_, S>, out: &mut DMatrix<S>) -> Result<()> {
        check_length("states", 4 * self.model.dof(), at.states.nrows())?;
        let n = self.model.dof();
        out.fill(S::zero());
        for start in (0..at.count()).step_by(LANES) {
            let count = Lanes::gather(at.states.as_slice(), start, &mut self.state);
            let (h, gram) = (&mut self.id.h, &mut self.gram);
            crba(self.model, &mut self.data, &self.state[..n], h)?;
            let weights = self.metric_weights.map(Wide::splat);
            let mut lower = gram.view_mut((0, 0), (n, n)).into_owned();
            let column = |c: usize| &h.as_slice()[c * n..(c + 1) * n];
            weighted_gram(column, &weights, &mut lower);
            for lane in 0..count {
                let mut block = out.column_mut(start + lane);
                for i in 0..n {
                    block[i * 2 * n + i] = self.k;
                    for j in 0..n {
                        let entry = lower[(i.max(j), i.min(j))].0[lane];
                        block[(n + j) * 2 * n + n + i] = entry;
                    }
                }
            }
        }
        Ok(())
    }
}
