//! A running cost along a motion in phases.

use super::{
    ControlDerivatives, ControlTerm, CostWithControl, PackedHessian, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives, alone,
};
use crate::constraint::is_permutation;
use crate::error::{Error, Result, check_length};
use nalgebra::DMatrix;

/// A running cost with one cost per [phase](crate::constraint::Phase) of a motion, each of a robot with the same joints
/// in an order of its own.
#[derive(Clone, Debug)]
pub struct InPhases<P> {
    phases: Vec<OfPhase<P>>,
}

/// The cost of a phase.
#[derive(Clone, Debug)]
struct OfPhase<P> {
    cost: P,
    /// The joint of the motion for each joint of the robot of this phase.
    order: Vec<usize>,
    /// $q, v, a$ and the derivatives of higher orders at the points, the controls and the derivatives, by the joints of
    /// the phase.
    states: DMatrix<f64>,
    higher: Vec<DMatrix<f64>>,
    controls: DMatrix<f64>,
    out: PointsDerivatives<f64>,
}

impl<P> InPhases<P> {
    /// The costs of the phases, each with the joint of the motion for each joint of its robot.
    ///
    /// # Errors
    /// There is no phase, or an order is no permutation of the joints of the first one.
    pub fn new(phases: Vec<(P, Vec<usize>)>) -> Result<Self> {
        let refuse = |condition: &str| Err(Error::input("phases", "cost", condition));
        let Some((_, first)) = phases.first() else {
            return refuse("there is none");
        };
        let n = first.len();
        if !phases.iter().all(|(_, order)| is_permutation(order, n)) {
            return refuse("an order is no permutation of the joints");
        }
        let new = |(cost, order)| OfPhase {
            cost,
            order,
            states: DMatrix::zeros(n, 0),
            higher: Vec::new(),
            controls: DMatrix::zeros(n, 0),
            out: PointsDerivatives::new(n, 0),
        };
        Ok(Self { phases: phases.into_iter().map(new).collect() })
    }

    fn of(&mut self, phase: usize) -> Result<&mut OfPhase<P>> {
        let count = self.phases.len();
        let condition = || format!("phase {phase} of {count} was asked for");
        let of = self.phases.get_mut(phase);
        of.ok_or_else(|| Error::input("phases", "cost", condition()))
    }
}

/// The rows of a matrix in the order of a phase.
fn permuted(of: &DMatrix<f64>, order: &[usize], to: &mut DMatrix<f64>) {
    if to.shape() != of.shape() {
        *to = DMatrix::zeros(of.nrows(), of.ncols());
    }
    for (mut to, from) in to.column_iter_mut().zip(of.column_iter()) {
        for (to, joint) in to.iter_mut().zip(order) {
            *to = from[*joint];
        }
    }
}

/// The rows of a matrix in the order of a phase, as those of the motion.
fn restored(of: &DMatrix<f64>, order: &[usize], to: &mut DMatrix<f64>) {
    if to.shape() != of.shape() {
        *to = DMatrix::zeros(of.nrows(), of.ncols());
    }
    for (mut to, from) in to.column_iter_mut().zip(of.column_iter()) {
        for (from, joint) in from.iter().zip(order) {
            to[*joint] = *from;
        }
    }
}

impl<P> OfPhase<P> {
    /// Calls a function with the cost, the points by the joints of the phase, its controls and its derivatives.
    fn with<T>(
        &mut self,
        points: Points<'_, f64>,
        of: impl FnOnce(&mut P, Points<'_, f64>, &mut DMatrix<f64>, &mut PointsDerivatives<f64>) -> Result<T>,
    ) -> Result<T> {
        check_length("q", self.order.len(), points.states.nrows())?;
        permuted(points.states, &self.order, &mut self.states);
        self.higher.resize_with(points.higher.len(), || DMatrix::zeros(0, 0));
        for (from, to) in points.higher.iter().zip(&mut self.higher) {
            permuted(from, &self.order, to);
        }
        let here = Points { states: &self.states, higher: &self.higher, ..points };
        of(&mut self.cost, here, &mut self.controls, &mut self.out)
    }

    /// Writes the derivatives by the joints of the motion.
    fn restore(&self, out: &mut PointsDerivatives<f64>) {
        let (own, order) = (&self.out, &self.order);
        out.costs.clone_from(&own.costs);
        restored(&own.gradients, order, &mut out.gradients);
        out.hessians.permute(&own.hessians, order);
        if out.with_metrics {
            out.metrics.permute(&own.metrics, order);
        }
        for (to, from) in out.higher.iter_mut().flatten().zip(own.higher.iter().flatten()) {
            restored(from, order, to);
        }
    }
}

/// Makes the derivatives of a phase as large as those of the motion.
fn fit(own: &mut PointsDerivatives<f64>, out: &PointsDerivatives<f64>) {
    let (n, points) = (out.gradients.nrows(), out.costs.len());
    if own.costs.len() != points {
        *own = PointsDerivatives::new(n, points);
    }
    own.with_metrics = out.with_metrics;
    own.clear_higher(out.higher.len(), n, points);
}

impl<P: PointCost<f64>> PointCost<f64> for InPhases<P> {
    fn value(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let (states, mut cost) = (point.states(), [0.0]);
        self.values(point.points(&states), &mut cost)?;
        Ok(cost[0])
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> Result<f64> {
        alone(point, out, |points, all| self.all_derivatives(points, all))
    }

    fn time_rate(&mut self, point: Point<'_, f64>) -> Result<f64> {
        let states = point.states();
        let of = self.of(point.phase)?;
        of.with(point.points(&states), |cost, points, _, _| cost.time_rate(points.point(0)))
    }

    fn order(&self) -> usize {
        self.phases.iter().map(|of| of.cost.order()).fold(2, usize::max)
    }

    fn phases(&self) -> usize {
        self.phases.len()
    }

    fn values(&mut self, points: Points<'_, f64>, costs: &mut [f64]) -> Result<()> {
        let of = self.of(points.phase)?;
        of.with(points, |cost, points, _, _| cost.values(points, costs))
    }

    fn all_derivatives(&mut self, points: Points<'_, f64>, out: &mut PointsDerivatives<f64>) -> Result<()> {
        let of = self.of(points.phase)?;
        of.with(points, |cost, points, _, own| {
            fit(own, out);
            cost.all_derivatives(points, own)
        })?;
        of.restore(out);
        Ok(())
    }
}

impl<P: CostWithControl> CostWithControl for InPhases<P> {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> Result<()> {
        let of = self.of(points.phase)?;
        of.with(points, |cost, points, own, _| {
            if own.shape() != controls.shape() {
                *own = DMatrix::zeros(controls.nrows(), controls.ncols());
            }
            cost.values_with_control(points, costs, own)
        })?;
        restored(&of.controls, &of.order, controls);
        Ok(())
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> Result<()> {
        let of = self.of(points.phase)?;
        let (order, n) = (of.order.clone(), of.order.len());
        let (mut u, mut by_u) = (vec![0.0; n], ControlDerivatives::new(n));
        let mut term = |index: usize, own: &[f64], found: &mut ControlDerivatives<f64>| {
            for (own, joint) in own.iter().zip(&order) {
                u[*joint] = *own;
            }
            by_u.clear();
            let bends = term(index, &u, &mut by_u);
            for (i, joint) in order.iter().enumerate() {
                found.gradient[i] = by_u.gradient[*joint];
                found.curvature_weights[i] = by_u.curvature_weights[*joint];
                found.hessian[i] = by_u.hessian[*joint];
            }
            bends
        };
        of.with(points, |cost, points, _, own| {
            fit(own, out);
            cost.all_derivatives_with(points, own, &mut term)
        })?;
        of.restore(out);
        Ok(())
    }
}

impl PackedHessian<f64> {
    /// Overwrites all matrices by those of a robot with the same joints in another order: joint `i` of `other` is joint
    /// `order[i]` of this one.
    fn permute(&mut self, other: &Self, order: &[usize]) {
        for j in 0..order.len() {
            for i in j..order.len() {
                self.copy_entry([order[i], order[j]], other, [i, j]);
            }
        }
    }
}
