//! The augmented Lagrangian of constraints, added to the Lagrangian of a flow.

use super::row_terms::RowTerms;
use super::{AnalyticLagrangian, LagrangianDerivatives, PointLagrangian, StateGrid, StatePoints};
use crate::constraint::{Constraint, Constraints};
use crate::error::Result;
use crate::scalar::LANES;
use nalgebra::DMatrix;

/// A [`AnalyticLagrangian`] $L_0$ with rows of constraints by duals,
///
/// $$ L = L_0 + \sum_j \psi(h_j, z_j), \qquad \psi(h, z) = \tfrac{1}{2 \rho} \left( \max(0, z + \rho h)^2 - z^2 \right) , $$
///
/// for a row $h \le 0$, and $\psi = z h + \tfrac12 \rho h^2$ for $h = 0$ (Hestenes, 1969; Powell, 1969; Rockafellar,
/// 1973). A row is a row of the constraints divided by its [scale](Constraint::row_scales), or the excess of a torque
/// over its limit divided by the limit, plus a margin. Duals belong to a point, so that the integral over time turns
/// them into densities.
///
/// An equality in the control, for a passive joint, is enforced at Gauss points, as many per segment as it has
/// coefficients of its own: a polynomial cannot satisfy it everywhere.
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian<'a, K> {
    /// The Lagrangian $L_0$.
    pub lagrangian: AnalyticLagrangian<'a>,
    pub(in crate::flow) rows: RowTerms<'a, K>,
}

impl<'a, K: Constraint> AugmentedLagrangian<'a, K> {
    /// Adds `constraints` to `lagrangian` at the points of a grid, with all duals zero.
    ///
    /// # Errors
    /// The torque limits are not one per joint, or one is negative or not finite.
    pub fn new(
        lagrangian: AnalyticLagrangian<'a>,
        constraints: &'a Constraints<K>,
        grid: &StateGrid<f64>,
    ) -> Result<Self> {
        let rows = RowTerms::new(lagrangian.model(), constraints, grid)?;
        Ok(Self { lagrangian, rows })
    }
}

impl<K: Constraint> PointLagrangian<f64> for AugmentedLagrangian<'_, K> {
    fn values(&mut self, at: StatePoints<'_, f64>, values: &mut [f64]) -> Result<()> {
        let Self { lagrangian, rows } = self;
        lagrangian.values_with(at, values, |index, point| rows.add_control(index, point))?;
        rows.place(at)?;
        for (g, value) in values.iter_mut().enumerate() {
            *value += rows.state_value(at.first + g);
        }
        Ok(())
    }

    fn derivatives(
        &mut self,
        at: StatePoints<'_, f64>,
        out: &mut LagrangianDerivatives<f64>,
    ) -> Result<()> {
        let Self { lagrangian, rows } = self;
        lagrangian.derivatives_with(at, out, |index, point| rows.add_control(index, point))?;
        rows.place(at)?;
        for g in 0..at.count() {
            out.values[g] += rows.state_value(at.first + g);
        }
        for start in (0..at.count()).step_by(LANES) {
            rows.add_state(at, start, out)?;
        }
        Ok(())
    }

    fn metrics(&mut self, at: StatePoints<'_, f64>, out: &mut DMatrix<f64>) -> Result<()> {
        self.lagrangian.metrics(at, out)
    }
}
