//! The quantities of Theorem B3 and its proof by dual numbers: the reference side of the identities.

use super::{Gf, Jet1, RandomInstance};
use crate::dynamics::Data;
use crate::error::Result;
use crate::flow::lagrangian;
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::AlgebraOver;
use crate::verify::reference::{
    Variation, bias_force, bias_rate, constant, entries, f_d, gradient, inverse_dynamics, jacobian, mass, mass_rate,
    omega_by_definition, rate, unit, variation_of_effort, vector,
};
use nalgebra::{DMatrix, DVector};

/// The number two.
pub(super) fn two() -> Gf {
    Gf::new(2)
}

/// Two vectors, concatenated.
pub(super) fn stack(top: &DVector<Gf>, bottom: &DVector<Gf>) -> DVector<Gf> {
    vector(&[top.as_slice(), bottom.as_slice()].concat())
}

/// Four blocks of one size.
pub(super) fn blocks(rows: [[&DMatrix<Gf>; 2]; 2]) -> DMatrix<Gf> {
    let n = rows[0][0].nrows();
    DMatrix::from_fn(2 * n, 2 * n, |i, j| rows[i / n][j / n][(i % n, j % n)])
}

/// `a^T T_i b` for every slice of a tensor: a vector.
pub(super) fn contract(a: &DVector<Gf>, slices: &[DMatrix<Gf>], b: &DVector<Gf>) -> DVector<Gf> {
    DVector::from_iterator(slices.len(), slices.iter().map(|slice| a.dot(&(slice * b))))
}

/// $H w = ID(q, v, w) - ID(q, v, 0)$ at $x$, without a mass matrix and with the velocity in it.
pub(super) fn inertia_force<S: AlgebraOver<Gf>>(model: &Model<Gf>, x: &[S], w: &[S]) -> Result<DVector<S>> {
    let (q, v) = x.split_at(model.dof());
    Ok(inverse_dynamics(model, q, v, w)? - bias_force(model, q, v)?)
}

/// The Lagrangian (5).
pub(super) fn effort<S: AlgebraOver<Gf>>(p: &RandomInstance, x: &[S], xdot: &[S]) -> Result<S> {
    lagrangian(&p.model, &mut Data::new(&p.model), x, xdot, p.k)
}

/// All quantities of Theorem B3, with derivatives only by dual numbers.
pub(super) struct Reference<'p> {
    pub p: &'p RandomInstance,
    /// The number of joints `N`.
    pub n: usize,
    pub h: DMatrix<Gf>,
    pub hdot: DMatrix<Gf>,
    pub c: DVector<Gf>,
    pub cdot: DVector<Gf>,
    /// $F_d$.
    pub fd: DVector<Gf>,
    /// $\partial F_d / \partial x$.
    pub dfd: DMatrix<Gf>,
    /// $\partial H / \partial x_i$ for the `2 N` entries of `x`.
    pub dh: Vec<DMatrix<Gf>>,
    /// $w = \dot x_{P2} - FD_0$.
    pub w: DVector<Gf>,
}

impl<'p> Reference<'p> {
    /// Computes the quantities at an instance.
    pub fn at(p: &'p RandomInstance) -> Result<Self> {
        let (n, node, m) = (p.dof(), p.node(), &p.model);
        let fd = f_d(m, node.x)?;
        let h_entries = |x: &[Jet1]| Ok(entries(&mass(m, &x[..n])?));
        let matrix = |v: DVector<Gf>| DMatrix::from_column_slice(n, n, v.as_slice());
        let dh: Result<Vec<_>> = (0..2 * n).map(|i| Ok(matrix(rate(node.x, &unit(2 * n, i), h_entries)?))).collect();
        Ok(Self {
            h: mass(m, node.x_p1())?,
            hdot: matrix(mass_rate(&p.at())?),
            c: bias_force(m, node.x_p1(), node.x_p2())?,
            cdot: bias_rate(&p.at())?,
            dfd: jacobian(node.x, |x| f_d(m, x))?,
            w: vector(node.xdot_p2()) - fd.rows(n, n),
            dh: dh?,
            fd,
            n,
            p,
        })
    }

    /// $FD_0$.
    pub fn fd0(&self) -> DVector<Gf> {
        self.fd.rows(self.n, self.n).into_owned()
    }

    /// $\partial FD_0 / \partial x_{P1}$ and $\partial FD_0 / \partial x_{P2}$.
    pub fn dfd0(&self) -> [DMatrix<Gf>; 2] {
        let n = self.n;
        [0, n].map(|column| self.dfd.view((n, column), (n, n)).into_owned())
    }

    /// $\dot x_{P1}$, $\dot x_{P2}$, $\ddot x_{P1}$ and $\ddot x_{P2}$.
    pub fn rates(&self) -> [DVector<Gf>; 4] {
        let node = self.p.node();
        [node.xdot_p1(), node.xdot_p2(), node.xddot_p1(), node.xddot_p2()].map(vector)
    }

    /// $x_{P2}$.
    pub fn x_p2(&self) -> DVector<Gf> {
        vector(self.p.node().x_p2())
    }

    /// $\dot x - F_d$.
    pub fn slip(&self) -> DVector<Gf> {
        &self.p.xdot - &self.fd
    }

    /// $H^T H$.
    pub fn hth(&self) -> DMatrix<Gf> {
        self.h.transpose() * &self.h
    }

    /// The metric $G$ of (11).
    pub fn metric(&self) -> DMatrix<Gf> {
        let zero = DMatrix::zeros(self.n, self.n);
        let top = DMatrix::identity(self.n, self.n) * self.p.k;
        blocks([[&top, &zero], [&zero, &self.hth()]])
    }

    /// Computes $G^{-1}$ times a force, by a factorisation of the full $G$.
    pub fn raise(&self, force: &DVector<Gf>) -> DVector<Gf> {
        let mut ldlt = Ldlt::new(2 * self.n);
        ldlt.factorise(&self.metric());
        let mut raised = force.clone();
        ldlt.solve(raised.as_mut_slice());
        raised
    }

    /// Computes $(H^T H)^{-1}$ times a force.
    pub fn solve_hth(&self, force: &DVector<Gf>) -> DVector<Gf> {
        let mut ldlt = Ldlt::new(self.n);
        ldlt.factorise(&self.hth());
        let mut solved = force.clone();
        ldlt.solve(solved.as_mut_slice());
        solved
    }

    /// $\partial (H^T H) / \partial x_i$ for the `2 N` entries of `x`, by duals of the product.
    pub fn dhth(&self) -> Result<Vec<DMatrix<Gf>>> {
        let n = self.n;
        let product = |x: &[Jet1]| {
            let h = mass(&self.p.model, &x[..n])?;
            Ok(entries(&(h.transpose() * h)))
        };
        let slice = |i| rate(self.p.x.as_slice(), &unit(2 * n, i), product);
        (0..2 * n).map(|i| Ok(DMatrix::from_column_slice(n, n, slice(i)?.as_slice()))).collect()
    }

    /// $\partial G / \partial x_i$ for the `2 N` entries of `x`.
    pub fn dmetric(&self) -> Result<Vec<DMatrix<Gf>>> {
        let zero = DMatrix::zeros(self.n, self.n);
        let slices = self.dhth()?;
        let whole = |slice| blocks([[&zero, &zero], [&zero, slice]]);
        Ok(slices.iter().map(whole).collect())
    }

    /// $[\partial H / \partial x_{P1}\\, w]\_{ij} = \sum_k \partial H_{ik} / \partial q_j\\, w_k$.
    pub fn dh_dq_w(&self) -> DMatrix<Gf> {
        let columns: Vec<_> = self.dh[..self.n].iter().map(|dh| dh * &self.w).collect();
        DMatrix::from_columns(&columns)
    }

    /// The gradient of a function of $F_d$ in `x`.
    pub fn by_f_d(&self, value: impl Fn(&DVector<Jet1>) -> Jet1) -> Result<DVector<Gf>> {
        gradient(self.p.x.as_slice(), |x| Ok(value(&f_d(&self.p.model, x)?)))
    }

    /// The gradient of $(\dot x - F_d)^T G(x) (\dot x - F_d)$ at constant $\dot x - F_d$.
    pub fn by_metric(&self) -> Result<DVector<Gf>> {
        let slip = self.slip().rows(0, self.n).into_owned();
        let top = Jet1::constant(slip.dot(&slip) * self.p.k);
        gradient(self.p.x.as_slice(), |x| {
            let force = inertia_force(&self.p.model, x, &constant(self.w.as_slice()))?;
            Ok(top + force.dot(&force))
        })
    }

    /// The variation of the Lagrangian (5).
    pub fn variation(&self) -> Result<Variation<Gf>> {
        variation_of_effort(&self.p.at())
    }

    /// $\Omega$ by its definition (7).
    pub fn omega(&self) -> Result<DVector<Gf>> {
        omega_by_definition(&self.p.at())
    }
}
