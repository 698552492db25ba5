//! What the dynamics and the Lagrangian are at a point, by duals: the side that identities are held against.

use super::instance::moving;
use super::{F, J, Point};
use crate::dynamics::{Data, aba, bias, crba, rnea};
use crate::error::Result;
use crate::flow::{TheoremB3, lagrangian};
use crate::linalg::Ldlt;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Jet, Scalar};
use nalgebra::{DMatrix, DVector};

/// Numbers with two tangents that do not know of each other.
pub(super) type JJ = Jet<J, 1>;

/// Two.
pub(super) fn two() -> F {
    F::new(2)
}

/// Numbers that do not move.
pub(super) fn still<S: Scalar>(x: &[S]) -> Vec<Jet<S, 1>> {
    x.iter().map(|x| Jet::constant(*x)).collect()
}

/// The vector of some numbers.
pub(super) fn vector<S: Scalar>(x: &[S]) -> DVector<S> {
    DVector::from_column_slice(x)
}

/// One vector on top of another.
pub(super) fn stack(top: &DVector<F>, bottom: &DVector<F>) -> DVector<F> {
    vector(&[top.as_slice(), bottom.as_slice()].concat())
}

/// Four blocks of one size.
pub(super) fn blocks(rows: [[&DMatrix<F>; 2]; 2]) -> DMatrix<F> {
    let n = rows[0][0].nrows();
    DMatrix::from_fn(2 * n, 2 * n, |i, j| rows[i / n][j / n][(i % n, j % n)])
}

/// The unit vector `i` of `n`.
pub(super) fn unit<S: Scalar>(n: usize, i: usize) -> Vec<S> {
    (0..n)
        .map(|j| if i == j { S::one() } else { S::zero() })
        .collect()
}

/// The rate of `f` at `x` along `direction`.
pub(super) fn rate<S: Scalar>(
    x: &[S],
    direction: &[S],
    f: impl Fn(&[Jet<S, 1>]) -> Result<Vec<Jet<S, 1>>>,
) -> Result<DVector<S>> {
    let moved = f(&moving(x, direction))?;
    Ok(DVector::from_iterator(
        moved.len(),
        moved.iter().map(|y| y.eps[0]),
    ))
}

/// The Jacobian of `f` at `x` by formal differentiation, one dual number a column.
pub(super) fn jacobian<S: Scalar>(
    x: &[S],
    f: impl Fn(&[Jet<S, 1>]) -> Result<Vec<Jet<S, 1>>>,
) -> Result<DMatrix<S>> {
    let columns: Result<Vec<_>> = (0..x.len())
        .map(|j| rate(x, &unit(x.len(), j), &f))
        .collect();
    Ok(DMatrix::from_columns(&columns?))
}

/// The gradient of a number, as a column.
pub(super) fn gradient(x: &[F], f: impl Fn(&[J]) -> Result<J>) -> Result<DVector<F>> {
    Ok(jacobian(x, |x| Ok(vec![f(x)?]))?.row(0).transpose())
}

/// `a^T T_i b` for every slice of a tensor: a vector.
pub(super) fn contract(a: &DVector<F>, slices: &[DMatrix<F>], b: &DVector<F>) -> DVector<F> {
    DVector::from_iterator(slices.len(), slices.iter().map(|slice| a.dot(&(slice * b))))
}

/// The mass matrix.
pub(super) fn mass<S: AlgebraOver<F>>(model: &Model<F>, q: &[S]) -> Result<DMatrix<S>> {
    let mut h = DMatrix::zeros(model.dof(), model.dof());
    crba(model, &mut Data::new(model), q, &mut h)?;
    Ok(h)
}

/// $C$ at $x$.
pub(super) fn bias_force<S: AlgebraOver<F>>(model: &Model<F>, x: &[S]) -> Result<Vec<S>> {
    let (q, v) = x.split_at(model.dof());
    let mut c = vec![S::zero(); q.len()];
    bias(model, &mut Data::new(model), q, v, &mut c)?;
    Ok(c)
}

/// $F_d = [x_{P2}; FD_0]$ at $x$, $FD_0$ by ABA.
pub(super) fn drift<S: AlgebraOver<F>>(model: &Model<F>, x: &[S]) -> Result<Vec<S>> {
    let (q, v) = x.split_at(model.dof());
    let zero = vec![S::zero(); q.len()];
    let mut fd = [v, &zero].concat();
    aba(
        model,
        &mut Data::new(model),
        q,
        v,
        &zero,
        &mut fd[q.len()..],
    )?;
    Ok(fd)
}

/// $H w = ID(q, v, w) - ID(q, v, 0)$ at $x$, without a mass matrix and with the velocity in it.
pub(super) fn inertia_force<S: AlgebraOver<F>>(
    model: &Model<F>,
    x: &[S],
    w: &[S],
) -> Result<DVector<S>> {
    let (q, v) = x.split_at(model.dof());
    let mut force = vec![S::zero(); q.len()];
    rnea(model, &mut Data::new(model), q, v, w, &mut force)?;
    Ok(vector(&force) - vector(&bias_force(model, x)?))
}

/// The gradient of $L(x, \dot x)$ in `at` $= [x; \dot x]$ and the rate of that gradient along `along`.
pub(super) fn gradient_and_rate(
    at: &[F],
    along: &[F],
    value: impl Fn(&[JJ], &[JJ]) -> Result<JJ>,
) -> Result<[DVector<F>; 2]> {
    let mut both = [DVector::zeros(at.len()), DVector::zeros(at.len())];
    for i in 0..at.len() {
        let input = moving(&moving(at, along), &still(&unit(at.len(), i)));
        let (x, xdot) = input.split_at(at.len() / 2);
        let by_i = value(x, xdot)?.eps[0];
        both[0][i] = by_i.re;
        both[1][i] = by_i.eps[0];
    }
    Ok(both)
}

/// What the heat flow of a Lagrangian is made of.
pub(super) struct Variation {
    /// $\partial L / \partial x$.
    pub by_x: DVector<F>,
    /// $\partial L / \partial \dot x$.
    pub by_xdot: DVector<F>,
    /// $\frac{d}{dt} \partial L / \partial \dot x$ along the curve.
    pub momentum_rate: DVector<F>,
}

/// The variation of a Lagrangian by nested duals.
pub(super) fn variation(
    p: &Point,
    value: impl Fn(&[JJ], &[JJ]) -> Result<JJ>,
) -> Result<Variation> {
    let (at, along) = (stack(&p.x, &p.xdot), stack(&p.xdot, &p.xddot));
    let [gradient, rate] = gradient_and_rate(at.as_slice(), along.as_slice(), value)?;
    let m = p.x.len();
    Ok(Variation {
        by_x: gradient.rows(0, m).into_owned(),
        by_xdot: gradient.rows(m, m).into_owned(),
        momentum_rate: rate.rows(m, m).into_owned(),
    })
}

/// The Lagrangian (5).
pub(super) fn effort<S: AlgebraOver<F>>(p: &Point, x: &[S], xdot: &[S]) -> Result<S> {
    lagrangian(&p.model, &mut Data::new(&p.model), x, xdot, p.k)
}

/// Every quantity that Theorem B3 is written in, its derivatives by duals and nothing by an analytic derivative.
pub(super) struct Reference<'p> {
    pub p: &'p Point,
    /// `N`.
    pub n: usize,
    pub h: DMatrix<F>,
    pub hdot: DMatrix<F>,
    pub c: DVector<F>,
    pub cdot: DVector<F>,
    /// $F_d$.
    pub fd: DVector<F>,
    /// $\partial F_d / \partial x$.
    pub dfd: DMatrix<F>,
    /// $\partial H / \partial x_i$ for the `2 N` entries of `x`.
    pub dh: Vec<DMatrix<F>>,
    /// $w = \dot x_{P2} - FD_0$.
    pub w: DVector<F>,
}

impl<'p> Reference<'p> {
    /// At a point.
    pub fn at(p: &'p Point) -> Result<Self> {
        let (n, node, m) = (p.dof(), p.node(), &p.model);
        let fd = vector(&drift(m, node.x)?);
        let h_entries = |x: &[J]| Ok(mass(m, &x[..n])?.as_slice().to_vec());
        let matrix = |v: DVector<F>| DMatrix::from_column_slice(n, n, v.as_slice());
        let dh: Result<Vec<_>> = (0..2 * n)
            .map(|i| Ok(matrix(rate(node.x, &unit(2 * n, i), h_entries)?)))
            .collect();
        Ok(Self {
            h: mass(m, node.x_p1())?,
            hdot: matrix(rate(node.x, node.xdot, h_entries)?),
            c: vector(&bias_force(m, node.x)?),
            cdot: rate(node.x, node.xdot, |x| bias_force(m, x))?,
            dfd: jacobian(node.x, |x| drift(m, x))?,
            w: vector(node.xdot_p2()) - fd.rows(n, n),
            dh: dh?,
            fd,
            n,
            p,
        })
    }

    /// $FD_0$.
    pub fn fd0(&self) -> DVector<F> {
        self.fd.rows(self.n, self.n).into_owned()
    }

    /// $\partial FD_0 / \partial x_{P1}$ and $\partial FD_0 / \partial x_{P2}$.
    pub fn dfd0(&self) -> [DMatrix<F>; 2] {
        let n = self.n;
        [0, n].map(|column| self.dfd.view((n, column), (n, n)).into_owned())
    }

    /// $\dot x_{P1}$, $\dot x_{P2}$, $\ddot x_{P1}$ and $\ddot x_{P2}$.
    pub fn rates(&self) -> [DVector<F>; 4] {
        let node = self.p.node();
        [
            node.xdot_p1(),
            node.xdot_p2(),
            node.xddot_p1(),
            node.xddot_p2(),
        ]
        .map(vector)
    }

    /// $x_{P2}$.
    pub fn x_p2(&self) -> DVector<F> {
        vector(self.p.node().x_p2())
    }

    /// $\dot x - F_d$.
    pub fn slip(&self) -> DVector<F> {
        &self.p.xdot - &self.fd
    }

    /// $H^T H$.
    pub fn hth(&self) -> DMatrix<F> {
        self.h.transpose() * &self.h
    }

    /// $G$ of (11).
    pub fn metric(&self) -> DMatrix<F> {
        let zero = DMatrix::zeros(self.n, self.n);
        let top = DMatrix::identity(self.n, self.n) * self.p.k;
        blocks([[&top, &zero], [&zero, &self.hth()]])
    }

    /// $G^{-1}$ times a force, from factors of the whole of $G$.
    pub fn raise(&self, force: &DVector<F>) -> DVector<F> {
        let mut ldlt = Ldlt::new(2 * self.n);
        ldlt.factorise(&self.metric());
        let mut raised = force.clone();
        ldlt.solve(raised.as_mut_slice());
        raised
    }

    /// $(H^T H)^{-1}$ times a force.
    pub fn solve_hth(&self, force: &DVector<F>) -> DVector<F> {
        let mut ldlt = Ldlt::new(self.n);
        ldlt.factorise(&self.hth());
        let mut solved = force.clone();
        ldlt.solve(solved.as_mut_slice());
        solved
    }

    /// $\partial (H^T H) / \partial x_i$ for the `2 N` entries of `x`, by duals of the product.
    pub fn dhth(&self) -> Result<Vec<DMatrix<F>>> {
        let n = self.n;
        let product = |x: &[J]| {
            let h = mass(&self.p.model, &x[..n])?;
            Ok((h.transpose() * h).as_slice().to_vec())
        };
        let slice = |i| rate(self.p.x.as_slice(), &unit(2 * n, i), product);
        (0..2 * n)
            .map(|i| Ok(DMatrix::from_column_slice(n, n, slice(i)?.as_slice())))
            .collect()
    }

    /// $\partial G / \partial x_i$ for the `2 N` entries of `x`.
    pub fn dmetric(&self) -> Result<Vec<DMatrix<F>>> {
        let zero = DMatrix::zeros(self.n, self.n);
        let slices = self.dhth()?;
        let whole = |slice| blocks([[&zero, &zero], [&zero, slice]]);
        Ok(slices.iter().map(whole).collect())
    }

    /// $[\partial H / \partial x_{P1}\, w]_{ij} = \sum_k \partial H_{ik} / \partial q_j\, w_k$.
    pub fn dh_dq_w(&self) -> DMatrix<F> {
        let columns: Vec<_> = self.dh[..self.n].iter().map(|dh| dh * &self.w).collect();
        DMatrix::from_columns(&columns)
    }

    /// The gradient of a number that depends on `x` through $F_d$ alone.
    pub fn by_drift(&self, value: impl Fn(&DVector<J>) -> J) -> Result<DVector<F>> {
        gradient(self.p.x.as_slice(), |x| {
            Ok(value(&vector(&drift(&self.p.model, x)?)))
        })
    }

    /// The gradient of $(\dot x - F_d)^T G(x) (\dot x - F_d)$ with $\dot x - F_d$ held fixed.
    pub fn by_metric(&self) -> Result<DVector<F>> {
        let slip = self.slip().rows(0, self.n).into_owned();
        let top = J::constant(slip.dot(&slip) * self.p.k);
        gradient(self.p.x.as_slice(), |x| {
            let force = inertia_force(&self.p.model, x, &still(self.w.as_slice()))?;
            Ok(top + force.dot(&force))
        })
    }

    /// Theorem B3 with its quantities from here.
    pub fn theorem(&self) -> TheoremB3<F> {
        let mut t = TheoremB3::new(self.n);
        t.h.copy_from(&self.h);
        t.hdot.copy_from(&self.hdot);
        t.c.copy_from(&self.c);
        t.cdot.copy_from(&self.cdot);
        t.fd0.copy_from(&self.fd0());
        [t.dfd0_dq, t.dfd0_dv] = self.dfd0();
        t.dh_dq_w = self.dh_dq_w();
        t
    }

    /// The variation of the Lagrangian (5).
    pub fn variation(&self) -> Result<Variation> {
        variation(self.p, |x, xdot| effort(self.p, x, xdot))
    }

    /// $\Omega$ by its definition (7).
    pub fn omega(&self) -> Result<DVector<F>> {
        let v = self.variation()?;
        Ok(self.raise(&(v.momentum_rate - v.by_x)))
    }
}
