//! Running costs that are functions of the motion, with derivatives by hand.

use crate::common::direct::degree;
use crate::common::slider;
use aghf::cost::{
    ControlDerivatives, ControlEffort, ControlTerm, CostWithControl, Point, PointCost, PointDerivatives, Points,
    PointsDerivatives,
};
use aghf::direct::{Direct, DirectSettings};
use aghf::motion::Problem;
use nalgebra::{DMatrix, DVector};

/// A cost of one's own: squared velocities beside the effort, with derivatives by hand.
#[derive(Clone)]
struct WithVelocity<'m> {
    effort: ControlEffort<'m, f64, f64>,
    weight: f64,
}

impl PointCost<f64> for WithVelocity<'_> {
    fn value(&mut self, point: Point<'_, f64>) -> aghf::Result<f64> {
        let speed: f64 = point.v.iter().map(|v| v * v).sum();
        Ok(self.effort.value(point)? + self.weight * speed)
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> aghf::Result<f64> {
        let value = self.effort.derivatives(point, out)?;
        Ok(value + self.add_velocity(point, out))
    }
}

impl WithVelocity<'_> {
    /// Adds the derivatives of the squared velocities; returns their share of the cost.
    fn add_velocity(&self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> f64 {
        let (n, mut value) = (point.v.len(), 0.0);
        for (i, v) in point.v.iter().enumerate() {
            value += self.weight * v * v;
            out.gradient[n + i] += 2.0 * self.weight * v;
            out.hessian[(n + i, n + i)] += 2.0 * self.weight;
        }
        value
    }
}

impl CostWithControl for WithVelocity<'_> {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> aghf::Result<()> {
        self.effort.values_with_control(points, costs, controls)?;
        for (g, cost) in costs.iter_mut().enumerate() {
            *cost += self.weight * points.point(g).v.iter().map(|v| v * v).sum::<f64>();
        }
        Ok(())
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> aghf::Result<()> {
        self.effort.all_derivatives_with(points, out, term)?;
        for g in 0..points.count() {
            let mut single = PointDerivatives::new(points.states.nrows());
            single.hessian = out.hessians.get(g);
            single.metric = out.metrics.get(g);
            single.gradient.copy_from_slice(out.gradients.columns(3 * g, 3).into_owned().as_slice());
            let cost = out.costs[g] + self.add_velocity(points.point(g), &mut single);
            out.set(g, cost, &single);
        }
        Ok(())
    }
}

/// Two wells, $(1 - q^2)^2$, with a little of the acceleration: between them `q = 0` is stationary and no minimum.
#[derive(Clone)]
struct TwoWells;

impl PointCost<f64> for TwoWells {
    fn value(&mut self, point: Point<'_, f64>) -> aghf::Result<f64> {
        Ok((1.0 - point.q[0].powi(2)).powi(2) + 1e-3 * point.a[0].powi(2))
    }

    fn derivatives(&mut self, point: Point<'_, f64>, out: &mut PointDerivatives<f64>) -> aghf::Result<f64> {
        let (q, a) = (point.q[0], point.a[0]);
        let diagonal = |d: [f64; 3]| DMatrix::from_diagonal(&DVector::from_column_slice(&d));
        out.gradient = DVector::from_column_slice(&[4.0 * q * (q * q - 1.0), 0.0, 2e-3 * a]);
        out.hessian = diagonal([12.0 * q * q - 4.0, 0.0, 2e-3]);
        out.metric = diagonal([0.0, 0.0, 2e-3]);
        self.value(point)
    }
}

/// On a slider of mass one the control is the acceleration.
impl CostWithControl for TwoWells {
    fn values_with_control(
        &mut self,
        points: Points<'_, f64>,
        costs: &mut [f64],
        controls: &mut DMatrix<f64>,
    ) -> aghf::Result<()> {
        for (g, mut u) in controls.column_iter_mut().enumerate() {
            u.copy_from_slice(points.point(g).a);
        }
        self.values(points, costs)
    }

    fn all_derivatives_with(
        &mut self,
        points: Points<'_, f64>,
        out: &mut PointsDerivatives<f64>,
        term: &mut impl ControlTerm<f64>,
    ) -> aghf::Result<()> {
        let mut single = PointDerivatives::new(1);
        for g in 0..points.count() {
            let point = points.point(g);
            let cost = self.derivatives(point, &mut single)?;
            let mut by_term = ControlDerivatives::new(1);
            term(point.index, point.a, &mut by_term);
            single.gradient[2] += by_term.gradient[0];
            single.hessian[(2, 2)] += by_term.hessian[0];
            out.set(g, cost, &single);
        }
        Ok(())
    }
}

#[test]
fn a_saddle_is_left() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0; 2], vec![0.0; 2], 4.0).expect("valid");
    let settings = DirectSettings { starts: 1, ..degree(12) };
    let direct = Direct::new(&problem).cost(TwoWells).settings(settings);
    let solution = direct.solve().expect("valid");
    assert!(solution.converged && solution.smallest_curvature > 0.0, "{solution:?}");
    // The line costs one for each second.
    assert!(solution.cost < 2.0, "{}", solution.cost);
    assert!(solution.curve.at(2.0).0[0].abs() > 0.9);
}

/// With $u = m a$ and a weight on $v^2$ the Euler-Lagrange equation is linear: $m^2 q'''' = w q''$.
#[test]
fn another_running_cost_has_its_own_optimum() {
    let model = slider(1.0);
    let problem = Problem::new(&model, vec![0.0, 0.0], vec![1.0, 0.0], 1.0).expect("valid");
    let cost = WithVelocity { effort: ControlEffort::new(&model), weight: 25.0 };
    let direct = Direct::new(&problem).cost(cost).settings(degree(16));
    let solution = direct.solve().expect("valid");
    assert!(solution.converged);
    // q = A (sinh(5 t) - 5 t) + B (cosh(5 t) - 1), antisymmetric about the middle.
    let (sinh, cosh) = (5.0_f64.sinh(), 5.0_f64.cosh());
    let ratio = -(5.0 * cosh - 5.0) / (5.0 * sinh);
    let shape = |t: f64| (5.0 * t).sinh() - 5.0 * t + ratio * ((5.0 * t).cosh() - 1.0);
    for t in [0.1, 0.5, 0.8] {
        let (x, _) = solution.curve.at(t);
        // Degree 16 does not have the exponential functions but for ten digits.
        assert!((x[0] - shape(t) / shape(1.0)).abs() < 1e-10, "{t}");
    }
}
