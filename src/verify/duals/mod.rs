//! Analytic derivatives against dual numbers, at random states of any robot.
//!
//! The dual numbers are those of `num-dual`, on which no analytic derivative here is based, and for the weak form of
//! the flow the library's [`Jet`](crate::scalar::Jet). Errors are relative to the largest compared entry. The rows of
//! $\Omega_{P1}$ and of $\Omega_{P2}$ are compared separately, because the former have the size `1 / k` and a wrong
//! term in them would be hidden by the others.

mod constraints;
mod direct;
mod dynamics;
mod general_flow;
mod jacobians;
mod running_cost;
mod tensors;
mod weak_form;

pub use constraints::{check_constraint, check_constraints};
pub use direct::check_direct;
pub use dynamics::{check_dynamics, check_dynamics_at};
pub use general_flow::{FlowUnderTest, check_flow, check_general_flow};
pub use jacobians::{check_jacobian, check_jacobian_at, check_jacobians};
pub use running_cost::check_running_cost;
pub(super) use weak_form::Written;
pub use weak_form::check_weak_form;

use crate::dynamics::{Data, crba, forward_kinematics};
use crate::error::{Result, check_count};
use crate::flow::Node;
use crate::flow::jacobian::Jacobians;
use crate::model::Model;
use crate::spatial::Placement;
use crate::verify::reference::{Differentiable, DualNumber};
use jacobians::compare_jacobians;
use nalgebra::{DMatrix, DMatrixView};
use num_dual::{Dual, Dual64, DualNum};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;

impl<T: DualNum + Copy> DualNumber for Dual<T> {
    type Base = T;

    fn from_parts(real: T, tangent: T) -> Self {
        Self::new(real, tangent)
    }

    fn real(self) -> T {
        self.re
    }

    fn tangent(self) -> T {
        self.eps
    }
}

impl Differentiable for f64 {
    type Dual = Dual64;
}

impl<T: DualNum + Copy> Differentiable for Dual<T> {
    type Dual = Dual<Self>;
}

/// The largest relative error that rounding explains; larger for divisions by an ill-conditioned mass matrix.
pub const BOUND: f64 = 1e-9;
/// The largest bound for any condition number of the mass matrix: a state with larger rounding errors cannot be judged
/// in double precision, and is reported.
pub const MAX_BOUND: f64 = 1e-5;
/// The largest bound for quantities that are divided by the mass matrix twice and then multiplied by it twice, such as
/// the weak form of the direct method.
pub const MAX_BOUND_MULTIPLIED: f64 = 1e-2;
/// Entries below this fraction of the inertia may be rounding errors of zero: with [`BOUND`], 50 units of rounding pass
/// there, as in sums of several products.
const VANISHING: f64 = 1e-5;
/// The largest error of central differences, relative to the largest entry of all blocks; they serve only for
/// comparison.
pub const DIFFERENCE_BOUND: f64 = 1e-4;
/// The bound for central differences whose step is not small relative to the distance over which the mass matrix loses
/// rank. States at which they may be less accurate are not compared.
pub const MAX_DIFFERENCE_BOUND: f64 = 0.1;

/// The settings of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckOptions {
    /// The number of random states.
    pub samples: usize,
    /// The seed of the states: the same seed gives the same states.
    pub seed: u64,
    /// The penalties at which Jacobians are checked; at 1 no term is hidden by `1 / k`.
    pub penalties: Vec<f64>,
}

impl Default for CheckOptions {
    /// Twenty states, at `k = 1` and at the paper's penalties for Digit and Kinova.
    fn default() -> Self {
        Self { samples: 20, seed: 1, penalties: vec![1.0, 1e7, 1e9] }
    }
}

impl CheckOptions {
    /// The largest number of random states: for Digit, with 22 joints, these take 100 MB and hours of computation.
    pub const MAX_SAMPLES: usize = 100_000;

    /// The random states of `model` for these options.
    ///
    /// # Errors
    /// The number of states is zero or above [`MAX_SAMPLES`](Self::MAX_SAMPLES).
    pub fn states(&self, model: &Model) -> Result<Vec<State>> {
        check_count("samples", self.samples, 1..=Self::MAX_SAMPLES)?;
        let states = (0..self.samples).map(|sample| State::random(model, self.seed, sample));
        Ok(states.collect())
    }
}

/// A state for a check: a time, and three slices of `2 N` entries, the input of the flow at a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct State {
    /// The time $t$, in s.
    pub t: f64,
    /// The state $x = [q; v]$.
    pub x: Vec<f64>,
    /// The rate $\dot x$.
    pub xdot: Vec<f64>,
    /// The second derivative $\ddot x$.
    pub xddot: Vec<f64>,
}

impl State {
    /// Draws state number `sample` of the sequence of `seed` for `model`: positions within the limits of the joints, or
    /// within half a turn without limits, the time from 0 to 3 s, everything else from -3 to 3.
    #[must_use]
    pub fn random(model: &Model, seed: u64, sample: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(sample as u64);
        let n = model.dof();
        let mut numbers = |count: usize| -> Vec<f64> { (0..count).map(|_| rng.random_range(-3.0..3.0)).collect() };
        let (mut x, xdot, xddot) = (numbers(2 * n), numbers(2 * n), numbers(2 * n));
        for (q, joint) in x.iter_mut().zip(model.joints()) {
            let limits = joint.limits();
            let (lower, upper) = (limits.lower.max(-PI), limits.upper.min(PI));
            // Limits entirely outside half a turn are ignored.
            if lower < upper {
                *q = lower + (upper - lower) * (*q + 3.0) / 6.0;
            }
        }
        let t = rng.random_range(0.0..3.0);
        Self { t, x, xdot, xddot }
    }

    /// The state as the input of the flow.
    #[must_use]
    pub fn node(&self) -> Node<'_, f64> {
        Node { t: self.t, x: &self.x, xdot: &self.xdot, xddot: &self.xddot }
    }
}

/// The worst error of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The quantity that was compared.
    pub quantity: String,
    /// The penalty, if the quantity depends on it.
    pub k: Option<f64>,
    /// The worst relative error.
    pub error: f64,
    /// The largest allowed error.
    pub bound: f64,
    /// Row and column of the worst entry.
    pub entry: (usize, usize),
    /// The index of the state, counted from zero.
    pub sample: usize,
    /// The state.
    pub state: State,
}

impl Finding {
    /// Returns true if the error is within its bound; NaN is not.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.error <= self.bound
    }
}

/// A collector of the worst error of each quantity, in the order of their first check.
#[derive(Default)]
pub(crate) struct Findings {
    place: BTreeMap<(String, u64), usize>,
    pub(crate) all: Vec<Finding>,
}

/// The largest allowed error, and the size below which entries count as zero.
#[derive(Clone, Copy)]
pub(crate) struct Tolerance {
    bound: f64,
    floor: f64,
}

/// The place of a comparison.
#[derive(Clone, Copy)]
pub(crate) struct At<'a> {
    k: Option<f64>,
    sample: usize,
    state: &'a State,
    /// The smallest and the largest absolute eigenvalue of the mass matrix there.
    eigenvalues: [f64; 2],
    /// The inertia of all bodies about the origin of the base, the frame of all computations.
    inertia: f64,
}

impl<'a> At<'a> {
    pub(crate) fn new(model: &Model, sample: usize, state: &'a State) -> Result<Self> {
        let n = model.dof();
        let mut h = DMatrix::zeros(n, n);
        crba(model, &mut Data::new(model), &state.x[..n], &mut h)?;
        let eigenvalues = extreme_eigenvalues(&h);
        let mut placements = vec![Placement::identity(); n];
        forward_kinematics(model, &state.x[..n], &mut placements)?;
        let inertias = model.inertias().iter().zip(&placements);
        let about_base = inertias.map(|(i, placement)| i.placed(placement).rotational.trace());
        Ok(Self { k: None, sample, state, eigenvalues, inertia: about_base.sum::<f64>().max(eigenvalues[1]) })
    }

    /// The same place with a penalty.
    pub(crate) fn under(self, k: f64) -> Self {
        Self { k: Some(k), ..self }
    }

    /// The condition number of the mass matrix.
    fn condition(&self) -> f64 {
        let [smallest, largest] = self.eigenvalues;
        largest / smallest
    }

    /// The tolerance of sums of products with inertias.
    fn direct(&self) -> Tolerance {
        Tolerance { bound: BOUND, floor: VANISHING * self.inertia }
    }

    /// The tolerance of quantities divided by the mass matrix: rounding grows with its condition number.
    fn divided(&self) -> Tolerance {
        Tolerance {
            bound: (BOUND + 1e-14 * self.condition()).min(MAX_BOUND),
            floor: VANISHING * self.inertia / self.eigenvalues[0],
        }
    }

    /// The tolerance of quantities divided by it twice. The worst case of rounding grows with the square of the
    /// condition number, but rounding changes `H` in a way that both solves share, and the measured growth is linear:
    /// on the URDFs of example-robot-data, on random trees and on arms of condition numbers up to `1e10` errors stay
    /// below 70 units of rounding times the condition number, of which seven times as much is allowed.
    pub(crate) fn divided_twice(&self) -> Tolerance {
        Tolerance { bound: (BOUND + 1e-13 * self.condition()).min(MAX_BOUND), floor: 0.0 }
    }

    /// The tolerance of quantities divided by it twice and then multiplied by it twice, whose rounding grows with the
    /// square of the condition number.
    pub(crate) fn multiplied_again(&self) -> Tolerance {
        Tolerance { bound: (BOUND * self.squared_rounding()).min(MAX_BOUND_MULTIPLIED), floor: 0.0 }
    }

    /// The growth of rounding by two divisions by the mass matrix.
    fn squared_rounding(&self) -> f64 {
        1.0 + 1e-9 * self.condition().powi(2)
    }
}

/// The smallest and the largest absolute eigenvalue of a symmetric matrix.
fn extreme_eigenvalues(h: &DMatrix<f64>) -> [f64; 2] {
    let eigenvalues = h.symmetric_eigenvalues().abs();
    [eigenvalues.min(), eigenvalues.max()]
}

impl Findings {
    /// Compares named derivatives with the blocks of `n` columns of `expected`, in the same order.
    fn compare_columns(
        &mut self,
        tolerance: Tolerance,
        of: &str,
        at: At<'_>,
        ours: &[(&str, &DMatrix<f64>)],
        expected: &DMatrix<f64>,
    ) {
        for (block, (by, ours)) in ours.iter().enumerate() {
            let columns = expected.columns(block * ours.ncols(), ours.ncols());
            let quantity = format!("{of}: d/{by}");
            self.compare(tolerance, &quantity, at, ours.as_view(), columns.as_view());
        }
    }

    /// Compares `a` with the reference `b`. Of several findings the one with the largest error relative to its bound is
    /// kept.
    pub(crate) fn compare(
        &mut self,
        tolerance: Tolerance,
        quantity: &str,
        at: At<'_>,
        a: DMatrixView<'_, f64>,
        b: DMatrixView<'_, f64>,
    ) {
        let difference = a - b;
        // NaN counts as the largest error.
        let key = |x: &f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
        let (entry, worst) = (difference.iter().map(key).enumerate())
            .fold((0, 0.0), |worst, next| if next.1 > worst.1 { next } else { worst });
        let size = b.iter().map(key).fold(tolerance.floor, f64::max);
        let error = if worst == 0.0 { 0.0 } else { worst / size };
        let rows = difference.nrows().max(1);
        let finding = Finding {
            quantity: quantity.to_owned(),
            k: at.k,
            error,
            bound: tolerance.bound,
            entry: (entry % rows, entry / rows),
            sample: at.sample,
            state: at.state.clone(),
        };
        let key = (quantity.to_owned(), at.k.unwrap_or(0.0).to_bits());
        match self.place.get(&key) {
            None => {
                self.place.insert(key, self.all.len());
                self.all.push(finding);
            }
            Some(place) => {
                let worst = &mut self.all[*place];
                if finding.error / finding.bound > worst.error / worst.bound {
                    *worst = finding;
                }
            }
        }
    }
}

/// Checks all analytic derivatives: those of the dynamics, the two forms of $\Omega$ with each other, every Jacobian of
/// [`JacobianKind`](crate::flow::jacobian::JacobianKind), the flow of a general Lagrangian and its weak form, those of
/// constraints, and the gradient of the direct method with the flow. Dual numbers of the control form are in turn
/// compared with dual numbers of Algorithm B1.
///
/// # Errors
/// None for a loaded model.
pub fn check_all(model: &Model, options: &CheckOptions) -> Result<Vec<Finding>> {
    let mut findings = check_dynamics(model, options)?;
    findings.extend(check_jacobians(model, &Jacobians::built_in(), options)?);
    findings.extend(check_general_flow(model, options)?);
    findings.extend(check_weak_form(model, options)?);
    findings.extend(check_constraints(model, options)?);
    findings.extend(check_direct(model, options)?);
    Ok(findings)
}
