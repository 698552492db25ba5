//! The dynamics and the flow over any scalar.

use super::differentiation::{
    Differentiable, DifferentiableOver, DualNumber, SecondDual, constant, dual, entries, gradient, jacobian, rate,
    vector,
};
use crate::dynamics::{Data, aba, bias, crba, rnea};
use crate::error::Result;
use crate::flow::{Node, TheoremB3, lagrangian};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};
use num_traits::Zero;

/// Computes the mass matrix $H$ at `q`.
///
/// # Errors
/// `q` does not have `N` entries.
pub fn mass<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, q: &[S]) -> Result<DMatrix<S>> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h)?;
    Ok(h)
}

/// Computes the bias force $C$ at `q` and `v`.
///
/// # Errors
/// `q` or `v` does not have `N` entries.
pub fn bias_force<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, q: &[S], v: &[S]) -> Result<DVector<S>> {
    let mut c = DVector::zeros(model.dof());
    bias(model, &mut Data::new(model), q, v, c.as_mut_slice())?;
    Ok(c)
}

/// Computes inverse dynamics $ID$ at `q`, `v` and `a`.
///
/// # Errors
/// `q`, `v` or `a` does not have `N` entries.
pub fn inverse_dynamics<C: Scalar, S: AlgebraOver<C>>(
    model: &Model<C>,
    q: &[S],
    v: &[S],
    a: &[S],
) -> Result<DVector<S>> {
    let mut tau = DVector::zeros(model.dof());
    rnea(model, &mut Data::new(model), q, v, a, tau.as_mut_slice())?;
    Ok(tau)
}

/// Computes forward dynamics without a force, $FD_0 = -H^{-1} C$, by ABA.
///
/// # Errors
/// `q` or `v` does not have `N` entries.
pub fn fd_0<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, q: &[S], v: &[S]) -> Result<DVector<S>> {
    let (mut a, tau) = (DVector::zeros(model.dof()), vec![S::zero(); model.dof()]);
    aba(model, &mut Data::new(model), q, v, &tau, a.as_mut_slice())?;
    Ok(a)
}

/// Computes $F_d = [x_{P2}; FD_0]$ at `x`.
///
/// # Errors
/// `x` does not have `2 N` entries.
pub fn f_d<C: Scalar, S: AlgebraOver<C>>(model: &Model<C>, x: &[S]) -> Result<DVector<S>> {
    let (q, v) = x.split_at(x.len() / 2);
    Ok(vector(&[v, fd_0(model, q, v)?.as_slice()].concat()))
}

/// The arguments of every quantity of the flow: a robot, the state and its derivatives at a node, and the penalty.
#[derive(Debug)]
pub struct At<'a, C: Scalar, S> {
    /// The robot.
    pub model: &'a Model<C>,
    /// The state and its derivatives, $x$, $\dot x$ and $\ddot x$.
    pub node: Node<'a, S>,
    /// The penalty.
    pub k: C,
}

impl<'a, C: Scalar, S: Scalar> At<'a, C, S> {
    /// The arguments at `z` $= [x; \dot x; \ddot x]$, `6 N` entries, at time zero, on which the paper's flow does not
    /// depend.
    pub fn new(model: &'a Model<C>, z: &'a [S], k: C) -> Self {
        let m = z.len() / 3;
        let node = Node { t: S::zero(), x: &z[..m], xdot: &z[m..2 * m], xddot: &z[2 * m..] };
        Self { model, node, k }
    }
}

/// Computes $\dot H$ along $\dot x_{P1}$, its entries in column-major order.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn mass_rate<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let (q, qdot) = (at.node.x_p1(), at.node.xdot_p1());
    rate(q, qdot, |q| Ok(entries(&mass(at.model, q)?)))
}

/// Computes $\dot C$ along $\dot x$.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn bias_rate<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let n = at.model.dof();
    let force = |x: &[S::Dual]| bias_force(at.model, &x[..n], &x[n..]);
    rate(at.node.x, at.node.xdot, force)
}

/// Computes $\gamma$, the rate of $H (H \dot x_{P2} + C)$ along the curve (B15).
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn gamma<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let (n, node) = (at.model.dof(), at.node);
    let y = [node.x, node.xdot_p2()].concat();
    let along = [node.xdot, node.xddot_p2()].concat();
    rate(&y, &along, |y| {
        let h = mass(at.model, &y[..n])?;
        let c = bias_force(at.model, &y[..n], &y[n..2 * n])?;
        Ok(&h * (&h * vector(&y[2 * n..]) + c))
    })
}

/// $2 H (H \dot x_{P2} + C)$ as a constant.
fn twice_h_force<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S::Dual>> {
    let (q, v) = (at.node.x_p1(), at.node.x_p2());
    let h = mass(at.model, q)?;
    let force = &h * vector(at.node.xdot_p2()) + bias_force(at.model, q, v)?;
    let twice = h * force * S::from_f64(2.0);
    Ok(vector(&constant(twice.as_slice())))
}

/// Computes $\alpha_1$, the gradient in $x_{P1}$ of $-FD_0$ times $2 H (H \dot x_{P2} + C)$ at constant
/// $2 H (H \dot x_{P2} + C)$.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn alpha_1<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let (fixed, v) = (twice_h_force(at)?, constant(at.node.x_p2()));
    gradient(at.node.x_p1(), |q| Ok(-fd_0(at.model, q, &v)?.dot(&fixed)))
}

/// Computes $\alpha_2$, the same gradient in $x_{P2}$.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn alpha_2<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let (fixed, q) = (twice_h_force(at)?, constant(at.node.x_p1()));
    gradient(at.node.x_p2(), |v| Ok(-fd_0(at.model, &q, v)?.dot(&fixed)))
}

/// $w = \dot x_{P2} - FD_0$ as a constant.
fn fixed_w<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S::Dual>> {
    let w = vector(at.node.xdot_p2()) - fd_0(at.model, at.node.x_p1(), at.node.x_p2())?;
    Ok(vector(&constant(w.as_slice())))
}

/// Computes $\Gamma$, the gradient in $x_{P1}$ of $|H w|^2 / 2$ at constant $w = \dot x_{P2} - FD_0$.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn capital_gamma<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let w = fixed_w(at)?;
    gradient(at.node.x_p1(), |q| {
        let force = mass(at.model, q)? * &w;
        Ok(force.dot(&force) * Scalar::from_f64(0.5))
    })
}

/// Computes the quantities of Theorem B3 by dual numbers.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn theorem_b3<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<TheoremB3<S>> {
    let (n, model) = (at.model.dof(), at.model);
    let (q, v) = (at.node.x_p1(), at.node.x_p2());
    let (fixed_q, fixed_v, w) = (constant(q), constant(v), fixed_w(at)?);
    let mut t = TheoremB3::new(n);
    t.h = mass(model, q)?;
    t.hdot = mass_rate(at)?.reshape_generic(nalgebra::Dyn(n), nalgebra::Dyn(n));
    t.c = bias_force(model, q, v)?;
    t.cdot = bias_rate(at)?;
    t.fd0 = fd_0(model, q, v)?;
    t.dfd0_dq = jacobian(q, |q| fd_0(model, q, &fixed_v))?;
    t.dfd0_dv = jacobian(v, |v| fd_0(model, &fixed_q, v))?;
    t.dh_dq_w = jacobian(q, |q| Ok(mass(model, q)? * &w))?;
    Ok(t)
}

/// Computes $\Omega_1$, $\Omega_2$, $\Omega_3$ and $\Omega_4$ of Theorem B3 (B6) to (B9) by dual numbers.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn omega_terms<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<[DVector<S>; 4]> {
    let (node, k, mut t) = (at.node, at.k, theorem_b3(at)?);
    let mut terms = [(); 4].map(|()| DVector::zeros(2 * at.model.dof()));
    t.omega_1(node, &mut terms[0]);
    t.omega_2(node, k, &mut terms[1]);
    t.omega_3(node, k, &mut terms[2]);
    t.omega_4(node, k, &mut terms[3]);
    Ok(terms)
}

/// Computes $\Omega_1 - (\Omega_2 - \Omega_3 + \Omega_4)$ (B5) of Theorem B3 by dual numbers.
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn omega_by_theorem_b3<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let mut omega = DVector::zeros(2 * at.model.dof());
    theorem_b3(at)?.omega(at.node, at.k, omega.as_mut_slice())?;
    Ok(omega)
}

/// Computes the gradient of a Lagrangian $L(x, \dot x)$ in $[x; \dot x]$ at `y`, and the rate of that gradient along
/// `along`.
///
/// # Errors
/// Those of the Lagrangian.
pub fn gradient_and_rate<S: Differentiable>(
    y: &[S],
    along: &[S],
    value: impl Fn(&[SecondDual<S>], &[SecondDual<S>]) -> Result<SecondDual<S>>,
) -> Result<[DVector<S>; 2]> {
    let moving = dual(y, along);
    let gradient = gradient(&moving, |y| {
        let (x, xdot) = y.split_at(y.len() / 2);
        value(x, xdot)
    })?;
    Ok([gradient.map(DualNumber::real), gradient.map(DualNumber::tangent)])
}

/// The terms of the heat flow of a Lagrangian, `2 N` entries each.
#[derive(Debug)]
pub struct Variation<S> {
    /// $\partial L / \partial x$.
    pub by_x: DVector<S>,
    /// $\partial L / \partial \dot x$.
    pub by_xdot: DVector<S>,
    /// $\frac{d}{dt} \partial L / \partial \dot x$ along the curve.
    pub momentum_rate: DVector<S>,
}

/// Computes the variation of a Lagrangian $L(t, x, \dot x)$ at a node by nested dual numbers.
///
/// # Errors
/// Those of the Lagrangian.
pub fn variation<S: Differentiable>(
    node: Node<'_, S>,
    value: impl Fn(SecondDual<S>, &[SecondDual<S>], &[SecondDual<S>]) -> Result<SecondDual<S>>,
) -> Result<Variation<S>> {
    let (y, along) = ([node.x, node.xdot].concat(), [node.xdot, node.xddot].concat());
    // The inner dual moves along the curve, and time with it.
    let t = S::Dual::from_parts(node.t, S::one());
    let t = SecondDual::<S>::from_parts(t, S::Dual::zero());
    let [gradient, rate] = gradient_and_rate(&y, &along, |x, xdot| value(t, x, xdot))?;
    let m = node.x.len();
    Ok(Variation {
        by_x: gradient.rows(0, m).into_owned(),
        by_xdot: gradient.rows(m, m).into_owned(),
        momentum_rate: rate.rows(m, m).into_owned(),
    })
}

/// Computes the variation of the Lagrangian (5).
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn variation_of_effort<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<Variation<S>> {
    let data = || Data::new(at.model);
    variation(at.node, |_, x, xdot| lagrangian(at.model, &mut data(), x, xdot, at.k))
}

/// Computes $\Omega$ by its definition (7), $G^{-1} \left( \frac{d}{dt} \frac{\partial L}{\partial \dot x} -
/// \frac{\partial L}{\partial x} \right)$ with the Lagrangian (5) and the metric (11).
///
/// # Errors
/// A part of the node does not have `2 N` entries.
pub fn omega_by_definition<C: Scalar, S: DifferentiableOver<C>>(at: &At<'_, C, S>) -> Result<DVector<S>> {
    let variation = variation_of_effort(at)?;
    let mut omega = variation.momentum_rate - variation.by_x;
    let mut ldlt = Ldlt::new(at.model.dof());
    ldlt.factorise(&mass(at.model, at.node.x_p1())?);
    let (upper, lower) = omega.as_mut_slice().split_at_mut(at.model.dof());
    upper.iter_mut().for_each(|o| *o = o.scale(C::one() / at.k));
    ldlt.solve(lower);
    ldlt.solve(lower);
    Ok(omega)
}
