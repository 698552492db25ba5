//! The derivatives of the quantities of Theorem B4, by a second level of dual numbers.

use aghf::flow::Node;
use aghf::model::Model;
use aghf::scalar::Scalar;
use aghf::verify::reference::{
    At, Differentiable, DifferentiableOver, alpha_1, alpha_2, capital_gamma, gamma, jacobian,
    omega_terms,
};
use nalgebra::{DMatrix, DVector};

/// `x`, `xdot` and `xddot`.
pub type Parts<S> = [Vec<S>; 3];

pub fn node<S: Scalar>(parts: &Parts<S>) -> Node<'_, S> {
    Node {
        t: S::zero(),
        x: &parts[0],
        xdot: &parts[1],
        xddot: &parts[2],
    }
}

/// The function that the blocks of Theorem B4 differentiate.
#[derive(Clone, Copy, Debug)]
pub enum Quantity {
    Gamma,
    Alpha1,
    Alpha2,
    CapitalGamma,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
}

/// All quantities at a node, concatenated in the order of [`Quantity`].
fn quantities<S: DifferentiableOver<f64>>(at: &At<'_, f64, S>) -> DVector<S> {
    let all = || {
        let mut all = vec![gamma(at)?, alpha_1(at)?, alpha_2(at)?, capital_gamma(at)?];
        all.extend(omega_terms(at)?);
        aghf::Result::Ok(all)
    };
    let all = all().expect("lengths agree");
    DVector::from_vec(all.iter().flatten().copied().collect())
}

/// All quantities at a node and their derivatives.
pub struct Derivatives {
    pub n: usize,
    values: DVector<f64>,
    /// One column per entry of `[x; xdot; xddot]`.
    derivatives: DMatrix<f64>,
}

impl Derivatives {
    pub fn new(model: &Model, parts: &Parts<f64>, k: f64) -> Self {
        let z = parts.concat();
        let f = |z: &[<f64 as Differentiable>::Dual]| Ok(quantities(&At::new(model, z, k)));
        Self {
            n: model.dof(),
            values: quantities(&At::new(model, &z, k)),
            derivatives: jacobian(&z, f).expect("lengths agree"),
        }
    }

    /// The first row of a quantity and its number of rows: `N` for the first four, `2 N` for the others.
    fn rows(&self, of: Quantity) -> (usize, usize) {
        let number = of as usize;
        let first = number + number.saturating_sub(4);
        (first * self.n, if number < 4 { self.n } else { 2 * self.n })
    }

    pub fn value(&self, of: Quantity) -> DVector<f64> {
        let (first, count) = self.rows(of);
        self.values.rows(first, count).into_owned()
    }

    /// The derivative in half `half` of part `part` of the node.
    pub fn derivative(&self, of: Quantity, part: usize, half: usize) -> DMatrix<f64> {
        let ((first, count), n) = (self.rows(of), self.n);
        let column = (2 * part + half) * n;
        self.derivatives
            .view((first, column), (count, n))
            .into_owned()
    }

    /// The derivative in part `part` of the node.
    pub fn block(&self, of: Quantity, part: usize) -> DMatrix<f64> {
        let ((first, count), n) = (self.rows(of), self.n);
        self.derivatives
            .view((first, 2 * part * n), (count, 2 * n))
            .into_owned()
    }
}
