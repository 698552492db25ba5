//! What Theorem B4 differentiates, over any scalar, and its derivatives by a second level of duals.

use aghf::dynamics::{Data, aba, bias, crba};
use aghf::flow::{Node, TheoremB3};
use aghf::model::Model;
use aghf::scalar::{AlgebraOver, Scalar};
use nalgebra::{DMatrix, DVector};
use num_dual::{Dual, Dual64, DualNum};

/// A scalar that dual numbers can be made of.
pub trait Base: DualNum + Copy {}
impl<S: DualNum + Copy> Base for S {}

/// `x`, `xdot` and `xddot`.
pub type Parts<S> = [Vec<S>; 3];

pub fn node<S>(parts: &Parts<S>) -> Node<'_, S> {
    Node {
        x: &parts[0],
        xdot: &parts[1],
        xddot: &parts[2],
    }
}

pub fn zeros<S: Scalar>(n: usize) -> Vec<S> {
    vec![S::zero(); n]
}

pub fn vector<S: Scalar>(x: &[S]) -> DVector<S> {
    DVector::from_column_slice(x)
}

pub fn mass<S: AlgebraOver<f64>>(model: &Model, q: &[S]) -> DMatrix<S> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h).expect("lengths agree");
    h
}

pub fn bias_force<S: AlgebraOver<f64>>(model: &Model, q: &[S], v: &[S]) -> DVector<S> {
    let mut c = DVector::zeros(model.dof());
    bias(model, &mut Data::new(model), q, v, c.as_mut_slice()).expect("lengths agree");
    c
}

/// $FD_0$.
pub fn drift<S: AlgebraOver<f64>>(model: &Model, q: &[S], v: &[S]) -> DVector<S> {
    let mut a = DVector::zeros(model.dof());
    let zero: Vec<S> = zeros(model.dof());
    aba(model, &mut Data::new(model), q, v, &zero, a.as_mut_slice()).expect("lengths agree");
    a
}

pub fn lift<S: Base>(x: &[S]) -> Vec<Dual<S>> {
    x.iter()
        .map(|x| Dual::new(*x, <S as Scalar>::from_f64(0.0)))
        .collect()
}

/// The rate of `f` at `x` along `direction`.
pub fn rate<S: Base>(f: impl Fn(&[Dual<S>]) -> Vec<Dual<S>>, x: &[S], direction: &[S]) -> Vec<S> {
    let input: Vec<Dual<S>> = x
        .iter()
        .zip(direction)
        .map(|(x, d)| Dual::new(*x, *d))
        .collect();
    f(&input).iter().map(|y| y.eps).collect()
}

/// The derivatives of `f` at `x`, a column for each entry of `x`.
pub fn columns<S: Base>(f: impl Fn(&[Dual<S>]) -> Vec<Dual<S>>, x: &[S]) -> Vec<Vec<S>> {
    let unit = |k: usize| -> Vec<S> {
        let entry = |i| <S as Scalar>::from_f64(f64::from(u8::from(i == k)));
        (0..x.len()).map(entry).collect()
    };
    (0..x.len()).map(|k| rate(&f, x, &unit(k))).collect()
}

pub fn matrix<S: Base>(columns: &[Vec<S>]) -> DMatrix<S> {
    let rows = columns.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i])
}

/// What the blocks of Theorem B4 are derivatives of.
#[derive(Clone, Copy, Debug)]
pub enum Of {
    Gamma,
    Alpha1,
    Alpha2,
    CapitalGamma,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
}

/// Theorem B3 with every quantity from duals of the dynamics.
pub fn theorem_b3<S: Base>(model: &Model, parts: &Parts<S>) -> TheoremB3<S> {
    let n = model.dof();
    let (q, v) = parts[0].split_at(n);
    let (qdot, vdot) = parts[1].split_at(n);
    let entries = |q: &[Dual<S>]| mass(model, q).as_slice().to_vec();
    let state_bias = |x: &[Dual<S>]| bias_force(model, &x[..n], &x[n..]).as_slice().to_vec();
    let (cq, cv) = (lift(q), lift(v));
    let mut t = TheoremB3::new(n);
    t.h = mass(model, q);
    t.hdot = DMatrix::from_vec(n, n, rate(entries, q, qdot));
    t.c = bias_force(model, q, v);
    t.cdot = DVector::from_vec(rate(state_bias, &parts[0], &parts[1]));
    t.fd0 = drift(model, q, v);
    t.dfd0_dq = matrix(&columns(|q| drift(model, q, &cv).as_slice().to_vec(), q));
    t.dfd0_dv = matrix(&columns(|v| drift(model, &cq, v).as_slice().to_vec(), v));
    let w = vector(&lift((vector(vdot) - &t.fd0).as_slice()));
    t.dh_dq_w = matrix(&columns(|q| (mass(model, q) * &w).as_slice().to_vec(), q));
    t
}

/// Every quantity at a node, in the order of [`Of`]. The first four come from what they mean, not from Theorem B3:
/// $\gamma$ is a rate (B15), $\alpha_1$, $\alpha_2$ and $\Gamma$ are gradients of numbers with something held fixed.
pub fn quantities<S: Base>(model: &Model, parts: &Parts<S>, k: f64) -> [DVector<S>; 8] {
    let n = model.dof();
    let (q, v) = parts[0].split_at(n);
    let vdot = &parts[1][n..];
    let two = <S as Scalar>::from_f64(2.0);
    let momentum = |z: &[Dual<S>]| {
        let h = mass(model, &z[..n]);
        let force = &h * vector(&z[2 * n..]) + bias_force(model, &z[..n], &z[n..2 * n]);
        (h * force).as_slice().to_vec()
    };
    let along = [&parts[1][..n], vdot, &parts[2][n..]].concat();
    let gamma = rate(momentum, &[q, v, vdot].concat(), &along);

    let h = mass(model, q);
    let fixed = &h * (&h * vector(vdot) + bias_force(model, q, v)) * two;
    let fixed = vector(&lift(fixed.as_slice()));
    let (cq, cv) = (lift(q), lift(v));
    let alpha_1 = columns(|q| vec![-drift(model, q, &cv).dot(&fixed)], q).concat();
    let alpha_2 = columns(|v| vec![-drift(model, &cq, v).dot(&fixed)], v).concat();
    let w = vector(&lift((vector(vdot) - drift(model, q, v)).as_slice()));
    let half_square = |q: &[Dual<S>]| {
        let force = mass(model, q) * &w;
        vec![force.dot(&force) * <Dual<S> as Scalar>::from_f64(0.5)]
    };
    let capital_gamma = columns(half_square, q).concat();

    let mut t = theorem_b3(model, parts);
    let mut omegas: [DVector<S>; 4] = std::array::from_fn(|_| DVector::zeros(2 * n));
    t.omega_1(node(parts), &mut omegas[0]);
    t.omega_2(node(parts), k, &mut omegas[1]);
    t.omega_3(node(parts), k, &mut omegas[2]);
    t.omega_4(node(parts), k, &mut omegas[3]);
    let [o1, o2, o3, o4] = omegas;
    let [gamma, alpha_1, alpha_2, capital_gamma] =
        [gamma, alpha_1, alpha_2, capital_gamma].map(DVector::from_vec);
    [gamma, alpha_1, alpha_2, capital_gamma, o1, o2, o3, o4]
}

/// The derivatives of all quantities in all entries of the node, by a second level of duals.
pub struct Truth {
    pub n: usize,
    values: [DVector<f64>; 8],
    /// A column for each entry of `[x; xdot; xddot]`.
    derivatives: [DMatrix<f64>; 8],
}

impl Truth {
    pub fn new(model: &Model, parts: &Parts<f64>, k: f64) -> Self {
        let (n, m) = (model.dof(), 2 * model.dof());
        let by = |j: usize| {
            let seeded: Parts<Dual64> = std::array::from_fn(|part| {
                let tangent = |i| f64::from(u8::from(part * m + i == j));
                let entry = |i| Dual64::new(parts[part][i], tangent(i));
                (0..m).map(entry).collect()
            });
            quantities(model, &seeded, k)
        };
        let all: Vec<[DVector<Dual64>; 8]> = (0..3 * m).map(by).collect();
        Self {
            n,
            values: quantities(model, parts, k),
            derivatives: std::array::from_fn(|which| {
                DMatrix::from_fn(all[0][which].len(), 3 * m, |i, j| all[j][which][i].eps)
            }),
        }
    }

    pub fn value(&self, of: Of) -> &DVector<f64> {
        &self.values[of as usize]
    }

    /// The derivative in half `half` of part `part` of the node.
    pub fn derivative(&self, of: Of, part: usize, half: usize) -> DMatrix<f64> {
        let from = (2 * part + half) * self.n;
        self.derivatives[of as usize]
            .columns(from, self.n)
            .into_owned()
    }

    /// The derivative in part `part` of the node.
    pub fn block(&self, of: Of, part: usize) -> DMatrix<f64> {
        let from = 2 * part * self.n;
        self.derivatives[of as usize]
            .columns(from, 2 * self.n)
            .into_owned()
    }
}
