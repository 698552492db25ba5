//! Derivatives of functions of the distance of points on two bodies.

use crate::model::Model;
use crate::scalar::Scalar;
use crate::spatial::{Force, Motion, apply, apply_transpose, cross, cross_matrix, dot, outer};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// The sums over all pairs of points, by the pair of bodies that carry them.
///
/// With $d = p_1 - p_2$ and $s = |d|^2 / 2$, a function of `s` exerts $f = \varphi^{\prime} d$ on the first point and
/// $-f$ on the second one. As spatial forces at the origin these are opposite, $\pm F$, because
/// $p_1 \times d = p_2 \times d =: m$ is the moment of their line. With $L = (m, d)$ the stiffness between the two
/// bodies is
///
/// $$ F = \varphi^{\prime} L, \qquad
///    K = [-p_{1 \times}, I]^T (\varphi^{\prime} I + \varphi^{\prime\prime} d d^T) [-p_{2 \times}, I]
///      = \varphi^{\prime} [-p_{1 \times}, I]^T [-p_{2 \times}, I] + \varphi^{\prime\prime} L L^T . $$
///
/// Joints that carry both bodies change no distance. For joints that carry only one body, `i` before `j` on the first
/// side and `k` before `l` on the second,
///
/// $$ \frac{\partial^2}{\partial q_i \partial q_j} = S_i \cdot (K S_j + S_j \times^* F), \qquad
///    \frac{\partial^2}{\partial q_k \partial q_l} = S_k \cdot (K^T S_l - S_l \times^* F), \qquad
///    \frac{\partial^2}{\partial q_i \partial q_l} = -S_i \cdot K S_l . $$
///
/// The derivation is in `proofs/geometry.md`. Cost O(1) per pair of points, and the square of the depth of the tree per
/// pair of bodies.
#[derive(Clone, Debug)]
pub(super) struct PairLoads<S: Scalar> {
    loads: Vec<([Option<usize>; 2], PairLoad<S>)>,
    /// The joints that carry only one body of a pair, from the body on.
    sides: [Vec<usize>; 2],
    /// The forces on the first side due to the joints of the second one.
    felt: Vec<Force<S>>,
}

/// The sums over the pairs of points of two bodies.
#[derive(Clone, Copy, Debug)]
struct PairLoad<S: Scalar> {
    /// `F`, on the first body.
    force: Force<S>,
    /// The blocks of `K`: angular and linear of the first body by angular and linear of the second.
    coupling: [[Matrix3<S>; 2]; 2],
}

impl<S: Scalar> PairLoad<S> {
    fn zero() -> Self {
        Self { force: Force::zero(), coupling: [[Matrix3::zeros(); 2]; 2] }
    }

    /// $K S$.
    fn times(&self, axis: &Motion<S>) -> Force<S> {
        let [[aa, al], [la, ll]] = &self.coupling;
        Force::new(
            apply(aa, &axis.angular) + apply(al, &axis.linear),
            apply(la, &axis.angular) + apply(ll, &axis.linear),
        )
    }

    /// $K^T S$.
    fn transpose_times(&self, axis: &Motion<S>) -> Force<S> {
        let [[aa, al], [la, ll]] = &self.coupling;
        Force::new(
            apply_transpose(aa, &axis.angular) + apply_transpose(la, &axis.linear),
            apply_transpose(al, &axis.angular) + apply_transpose(ll, &axis.linear),
        )
    }
}

impl<S: Scalar> PairLoads<S> {
    /// Zero sums.
    pub(super) fn new() -> Self {
        Self { loads: Vec::new(), sides: [Vec::new(), Vec::new()], felt: Vec::new() }
    }

    /// Removes all pairs and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.loads.clear();
    }

    /// Adds a pair of points; with `second`, its second derivatives too.
    #[inline]
    pub(super) fn add(
        &mut self,
        bodies: [Option<usize>; 2],
        [p, q]: [&Vector3<S>; 2],
        slope: S,
        curvature: S,
        second: bool,
    ) {
        let load = self.load(bodies);
        let (d, moment) = (p - q, cross(q, p));
        load.force += Force::new(moment, d) * slope;
        if second {
            let [[aa, al], [la, ll]] = &mut load.coupling;
            let (m, l) = (moment * curvature, d * curvature);
            let product = dot(p, q) * slope;
            *aa += outer(&m, &moment) - outer(q, &(p * slope));
            *al += outer(&m, &d) + cross_matrix(&(p * slope));
            *la += outer(&l, &moment) - cross_matrix(&(q * slope));
            *ll += outer(&l, &d);
            for i in 0..3 {
                aa[(i, i)] += product;
                ll[(i, i)] += slope;
            }
        }
    }

    /// Adds a row that is linear in the positions of points of the first body as seen from the second one, by the sum
    /// of its gradients `f` in these and their virial $Q = \sum p f^T$. As a spatial force it is `F` with the moment
    /// $\sum p \times f$; to `K` it adds $c\\, F F^T$, $w (Q^T - \mathrm{tr}\\, Q)$ between angular and angular, and
    /// $w \sum f_\times$ between linear and angular.
    pub(super) fn add_forces(
        &mut self,
        bodies: [Option<usize>; 2],
        f: &Vector3<S>,
        virial: &Matrix3<S>,
        w: S,
        c: Option<S>,
    ) {
        let off = |i: usize, j: usize| virial[(i, j)] - virial[(j, i)];
        let moment = Vector3::new(off(1, 2), off(2, 0), off(0, 1));
        let coupling = || {
            let turned = virial.transpose() - Matrix3::from_diagonal_element(virial.trace());
            [[turned, Matrix3::zeros()], [cross_matrix(f), Matrix3::zeros()]]
        };
        self.add_coupling(bodies, &Force::new(moment, *f), coupling, w, c);
    }

    /// Adds a row with this gradient in the motion of the first body as seen from the second one, and this coupling.
    pub(super) fn add_coupling(
        &mut self,
        bodies: [Option<usize>; 2],
        force: &Force<S>,
        coupling: impl FnOnce() -> [[Matrix3<S>; 2]; 2],
        w: S,
        c: Option<S>,
    ) {
        let load = self.load(bodies);
        load.force += *force * w;
        let Some(c) = c else { return };
        let lines = [force.angular, force.linear];
        for (i, row) in coupling().iter().enumerate() {
            for (j, block) in row.iter().enumerate() {
                load.coupling[i][j] += block * w + outer(&(lines[i] * c), &lines[j]);
            }
        }
    }

    /// The sums of two bodies, which are usually those of the previous pair.
    #[inline]
    fn load(&mut self, bodies: [Option<usize>; 2]) -> &mut PairLoad<S> {
        let known = self.loads.iter().rposition(|(known, _)| *known == bodies);
        let index = known.unwrap_or_else(|| {
            self.loads.push((bodies, PairLoad::zero()));
            self.loads.len() - 1
        });
        &mut self.loads[index].1
    }

    /// Projects the forces between the bodies on the joints.
    pub(super) fn collect<C: Scalar>(
        &mut self,
        model: &Model<C>,
        axes: &[Motion<S>],
        gradient: &mut DVector<S>,
        mut hessian: Option<&mut DMatrix<S>>,
    ) {
        for (bodies, load) in &self.loads {
            alone(model, *bodies, &mut self.sides);
            let [first, second] = &self.sides;
            for j in first {
                gradient[*j] += axes[*j].dot(&load.force);
            }
            for l in second {
                gradient[*l] -= axes[*l].dot(&load.force);
            }
            let Some(hessian) = hessian.as_deref_mut() else {
                continue;
            };
            let mut add = |i: usize, j: usize, entry: S| {
                hessian[(i, j)] += entry;
                if i != j {
                    hessian[(j, i)] += entry;
                }
            };
            for (at, j) in first.iter().enumerate() {
                let axis = &axes[*j];
                let felt = load.times(axis) + axis.cross_force(&load.force);
                for i in &first[at..] {
                    add(*i, *j, axes[*i].dot(&felt));
                }
            }
            for (at, l) in second.iter().enumerate() {
                let axis = &axes[*l];
                let felt = load.transpose_times(axis) - axis.cross_force(&load.force);
                for k in &second[at..] {
                    add(*k, *l, axes[*k].dot(&felt));
                }
            }
            self.felt.clear();
            let felt = second.iter().map(|l| load.times(&axes[*l]));
            self.felt.extend(felt);
            for i in first {
                for (l, felt) in second.iter().zip(&self.felt) {
                    add(*i, *l, -axes[*i].dot(felt));
                }
            }
        }
    }
}

/// The joints that carry one of two bodies and not the other, from the body to the base. Parents come before children,
/// so that the larger of two different indices carries only one body.
fn alone<C: Scalar>(model: &Model<C>, bodies: [Option<usize>; 2], sides: &mut [Vec<usize>; 2]) {
    let [first, second] = sides;
    first.clear();
    second.clear();
    let [mut a, mut b] = bodies;
    while a != b {
        // No body comes before all bodies.
        let (later, side) = if a > b { (&mut a, &mut *first) } else { (&mut b, &mut *second) };
        side.extend(*later);
        *later = later.and_then(|body| model.joints()[body].parent());
    }
}
