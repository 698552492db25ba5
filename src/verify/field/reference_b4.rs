//! What Theorem B4 differentiates, over any number, from the plain dynamics and nested dual numbers alone.
//!
//! No analytic derivative and no tensor of the library is used here: only `crba`, `rnea`, `aba` and formal differentiation.
//! Every quantity is a function of `z`, which is $[x; \dot x; \ddot x]$ with `6 N` entries.

use super::instance::moving;
use super::reference::jacobian;
use super::{Equality, F, J, Point};
use crate::dynamics::{Data, aba, bias, crba, rnea};
use crate::error::Result;
use crate::flow::jacobian::TheoremB4;
use crate::flow::jacobian::theorem_b4::Quantities;
use crate::flow::{Node, TheoremB3};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar};
use nalgebra::{DMatrix, DVector};
use num_traits::One;
use std::ops::Range;

/// A function of the node over numbers with one tangent.
pub(super) type Of = fn(&Point, &[J]) -> Result<Vec<J>>;

/// What to differentiate in.
#[derive(Clone, Copy)]
pub(super) enum In {
    X,
    Xdot,
    Xddot,
    XP1,
    XP2,
    XdotP1,
    XdotP2,
    XddotP2,
}

impl In {
    /// The entries of `z` that are meant.
    fn range(self, n: usize) -> Range<usize> {
        let (first, count) = match self {
            Self::X => (0, 2),
            Self::Xdot => (2, 2),
            Self::Xddot => (4, 2),
            Self::XP1 => (0, 1),
            Self::XP2 => (1, 1),
            Self::XdotP1 => (2, 1),
            Self::XdotP2 => (3, 1),
            Self::XddotP2 => (5, 1),
        };
        first * n..(first + count) * n
    }
}

/// $[x; \dot x; \ddot x]$ at a point.
pub(super) fn all(p: &Point) -> Vec<F> {
    let node = p.node();
    [node.x, node.xdot, node.xddot].concat()
}

/// The quantities of Theorem B4 at a point, as Algorithm B2 gathers them.
pub(super) fn gathered(p: &Point) -> Result<Quantities<F>> {
    Ok(TheoremB4::new(&p.model).gather(p.node())?.clone())
}

/// The derivative of `f`, rows those of `f`.
pub(super) fn derivative(p: &Point, part: In, f: Of) -> Result<DMatrix<F>> {
    let (all, range) = (all(p), part.range(p.dof()));
    jacobian(&all[range.clone()], |moved| {
        let mut z = constant(&all);
        z[range.clone()].copy_from_slice(moved);
        f(p, &z)
    })
}

/// Our block against the derivative of what it differentiates.
pub(super) fn block(
    p: &Point,
    part: In,
    f: Of,
    ours: fn(&Quantities<F>, F) -> DMatrix<F>,
) -> Result<Vec<Equality>> {
    let left = ours(&gathered(p)?, p.k);
    Ok(vec![Equality::new("block", left, derivative(p, part, f)?)])
}

/// Numbers that do not move.
pub(super) fn constant<S: Scalar>(x: &[S]) -> Vec<Jet<S, 1>> {
    x.iter().map(|x| Jet::constant(*x)).collect()
}

/// The rate of `f` at `x` along `direction`.
pub(super) fn rate<S: Scalar>(
    x: &[S],
    direction: &[S],
    f: impl Fn(&[Jet<S, 1>]) -> Result<Vec<Jet<S, 1>>>,
) -> Result<Vec<S>> {
    let moved = f(&moving(x, direction))?;
    Ok(moved.iter().map(|y| y.eps[0]).collect())
}

/// A tensor as a matrix whose columns belong to its last index.
pub(super) fn unfold(n: usize, entries: &[F]) -> DMatrix<F> {
    DMatrix::from_column_slice(entries.len() / n, n, entries)
}

/// $H$.
pub(super) fn mass<S: AlgebraOver<F>>(model: &Model<F>, q: &[S]) -> Result<DMatrix<S>> {
    let mut h = DMatrix::zeros(q.len(), q.len());
    crba(model, &mut Data::new(model), q, &mut h)?;
    Ok(h)
}

/// $C$.
pub(super) fn bias_force<S: AlgebraOver<F>>(model: &Model<F>, q: &[S], v: &[S]) -> Result<Vec<S>> {
    let mut c = vec![S::zero(); q.len()];
    bias(model, &mut Data::new(model), q, v, &mut c)?;
    Ok(c)
}

/// $ID$.
pub(super) fn inverse_dynamics<S: AlgebraOver<F>>(
    model: &Model<F>,
    q: &[S],
    v: &[S],
    a: &[S],
) -> Result<Vec<S>> {
    let mut tau = vec![S::zero(); q.len()];
    rnea(model, &mut Data::new(model), q, v, a, &mut tau)?;
    Ok(tau)
}

/// $FD_0$.
pub(super) fn drift<S: AlgebraOver<F>>(model: &Model<F>, q: &[S], v: &[S]) -> Result<Vec<S>> {
    let (mut a, zero) = (vec![S::zero(); q.len()], vec![S::zero(); q.len()]);
    aba(model, &mut Data::new(model), q, v, &zero, &mut a)?;
    Ok(a)
}

/// A vector of the entries of a slice.
pub(super) fn vector<S: Scalar>(x: &[S]) -> DVector<S> {
    DVector::from_column_slice(x)
}

/// The node that `z` is.
pub(super) fn node<S: Scalar>(z: &[S]) -> Node<'_, S> {
    let m = z.len() / 3;
    Node {
        x: &z[..m],
        xdot: &z[m..2 * m],
        xddot: &z[2 * m..],
    }
}

/// $\dot H$ along $\dot x_{P1}$, its entries in columns.
pub(super) fn mass_rate<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let node = node(z);
    rate(node.x_p1(), node.xdot_p1(), |q| {
        Ok(mass(&p.model, q)?.as_slice().to_vec())
    })
}

/// $\dot C$ along $\dot x$.
pub(super) fn bias_rate<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let (node, n) = (node(z), p.dof());
    rate(node.x, node.xdot, |x| {
        bias_force(&p.model, &x[..n], &x[n..])
    })
}

/// $\gamma$, the rate of $H (H \dot x_{P2} + C)$ along the curve.
pub(super) fn gamma<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let (node, n) = (node(z), p.dof());
    let at = [node.x, node.xdot_p2()].concat();
    let along = [node.xdot, node.xddot_p2()].concat();
    rate(&at, &along, |y| {
        let h = mass(&p.model, &y[..n])?;
        let force =
            &h * vector(&y[2 * n..]) + vector(&bias_force(&p.model, &y[..n], &y[n..2 * n])?);
        Ok((h * force).as_slice().to_vec())
    })
}

/// $2 H (H \dot x_{P2} + C)$ as a constant.
fn twice_h_force<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<DVector<Jet<S, 1>>> {
    let node = node(z);
    let h = mass(&p.model, node.x_p1())?;
    let c = vector(&bias_force(&p.model, node.x_p1(), node.x_p2())?);
    let force = &h * (&h * vector(node.xdot_p2()) + c) * S::from_f64(2.0);
    Ok(vector(&constant(force.as_slice())))
}

/// $\alpha_1$, the gradient in $x_{P1}$ of $-FD_0$ times a vector held fixed.
pub(super) fn alpha_1<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let (fixed, v) = (twice_h_force(p, z)?, constant(node(z).x_p2()));
    let row = jacobian(node(z).x_p1(), |q| {
        Ok(vec![-vector(&drift(&p.model, q, &v)?).dot(&fixed)])
    })?;
    Ok(row.as_slice().to_vec())
}

/// $\alpha_2$, the same gradient in $x_{P2}$.
pub(super) fn alpha_2<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let (fixed, q) = (twice_h_force(p, z)?, constant(node(z).x_p1()));
    let row = jacobian(node(z).x_p2(), |v| {
        Ok(vec![-vector(&drift(&p.model, &q, v)?).dot(&fixed)])
    })?;
    Ok(row.as_slice().to_vec())
}

/// $\dot x_{P2} - FD_0$.
fn miss<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<DVector<S>> {
    let node = node(z);
    Ok(vector(node.xdot_p2()) - vector(&drift(&p.model, node.x_p1(), node.x_p2())?))
}

/// $\Gamma$, the gradient in $x_{P1}$ of $|H w|^2 / 2$ with `w` held fixed.
pub(super) fn capital_gamma<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let w = vector(&constant(miss(p, z)?.as_slice()));
    let row = jacobian(node(z).x_p1(), |q| {
        let force = mass(&p.model, q)? * &w;
        Ok(vec![force.dot(&force) * Jet::from_f64(0.5)])
    })?;
    Ok(row.as_slice().to_vec())
}

/// Theorem B3 with every quantity by duals of the dynamics.
fn theorem_b3<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<TheoremB3<S>> {
    let (node, n, model) = (node(z), p.dof(), &p.model);
    let (q, v) = (node.x_p1(), node.x_p2());
    let (fixed_q, fixed_v) = (constant(q), constant(v));
    let w = vector(&constant(miss(p, z)?.as_slice()));
    let mut t = TheoremB3::new(n);
    t.h = mass(model, q)?;
    t.hdot = DMatrix::from_vec(n, n, mass_rate(p, z)?);
    t.c = vector(&bias_force(model, q, v)?);
    t.cdot = vector(&bias_rate(p, z)?);
    t.fd0 = vector(&drift(model, q, v)?);
    t.dfd0_dq = jacobian(q, |q| drift(model, q, &fixed_v))?;
    t.dfd0_dv = jacobian(v, |v| drift(model, &fixed_q, v))?;
    t.dh_dq_w = jacobian(q, |q| Ok((mass(model, q)? * &w).as_slice().to_vec()))?;
    Ok(t)
}

/// $\Omega_1$ (B6).
pub(super) fn omega_1<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let mut omega = DVector::zeros(2 * p.dof());
    theorem_b3(p, z)?.omega_1(node(z), &mut omega);
    Ok(omega.as_slice().to_vec())
}

/// $\Omega_2$ (B7).
pub(super) fn omega_2<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let mut omega = DVector::zeros(2 * p.dof());
    theorem_b3(p, z)?.omega_2(node(z), p.k, &mut omega);
    Ok(omega.as_slice().to_vec())
}

/// $\Omega_3$ (B8).
pub(super) fn omega_3<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let mut omega = DVector::zeros(2 * p.dof());
    theorem_b3(p, z)?.omega_3(node(z), p.k, &mut omega);
    Ok(omega.as_slice().to_vec())
}

/// $\Omega_4$ (B9).
pub(super) fn omega_4<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let mut omega = DVector::zeros(2 * p.dof());
    theorem_b3(p, z)?.omega_4(node(z), p.k, &mut omega);
    Ok(omega.as_slice().to_vec())
}

/// $\Omega_1 - (\Omega_2 - \Omega_3 + \Omega_4)$.
pub(super) fn sum<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let mut omega = vec![S::zero(); 2 * p.dof()];
    theorem_b3(p, z)?.omega(node(z), p.k, &mut omega)?;
    Ok(omega)
}

/// $L = k |\dot x_{P1} - x_{P2}|^2 + |u|^2$ at $[x; \dot x]$.
fn lagrangian<S: AlgebraOver<F>>(p: &Point, y: &[S]) -> Result<S> {
    let n = p.dof();
    let (q, v, qdot, vdot) = (&y[..n], &y[n..2 * n], &y[2 * n..3 * n], &y[3 * n..]);
    let slip = vector(qdot) - vector(v);
    let u = vector(&inverse_dynamics(&p.model, q, v, vdot)?);
    Ok(slip.dot(&slip).scale(p.k) + u.dot(&u))
}

/// The heat flow (7) of that Lagrangian in the metric (11), by nested duals: the definition of $\Omega$.
pub(super) fn flow<S: AlgebraOver<F>>(p: &Point, z: &[S]) -> Result<Vec<S>> {
    let (m, node) = (2 * p.dof(), node(z));
    let y = moving(&z[..2 * m], &z[m..]);
    let gradient = jacobian(&y, |y| Ok(vec![lagrangian(p, y)?]))?;
    let entry = |i: usize| gradient[m + i].eps[0] - gradient[i].re;
    let mut omega: Vec<S> = (0..m).map(entry).collect();
    let mut ldlt = Ldlt::new(p.dof());
    ldlt.factorise(&mass(&p.model, node.x_p1())?);
    let (upper, lower) = omega.split_at_mut(p.dof());
    upper.iter_mut().for_each(|o| *o = o.scale(F::one() / p.k));
    ldlt.solve(lower);
    ldlt.solve(lower);
    Ok(omega)
}
