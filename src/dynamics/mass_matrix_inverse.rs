//! The inverse of the mass matrix from the articulated bodies, and products with it.

use super::{Data, path_to_base};
use crate::linalg::TILE;
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use nalgebra::DMatrix;

impl<S: Scalar> Data<S> {
    /// $H^{-1}$, both halves, into `h_inverse`, after [`accelerate`](Self::accelerate). Cost O(N^2 d) with d the depth
    /// of the tree.
    ///
    /// The articulated bodies hold the factors of $H = L^T D L$ (6.5 in Featherstone's book): eliminating joints from
    /// the tips to the base leaves $S_j^T I^A_i S_i$ in row `i`, so that $L_{ij} = S_j \cdot U_i / D_i$ for `j` before
    /// `i`. From $L H^{-1} = D^{-1} L^{-T}$, which is upper triangular with the diagonal $D^{-1}$, row `i` follows from
    /// the rows of the joints before `i` on its path.
    pub(super) fn invert_mass_matrix<C: Scalar>(&mut self, model: &Model<C>)
    where
        S: AlgebraOver<C>,
    {
        self.h_inverse.clear();
        for i in 0..model.dof() {
            let ratio = S::one() / self.scalar_scratch[i];
            let scaled = self.articulated_axes[i] * ratio;
            self.related.clear();
            // A loop, because `extend` would keep the state of the iterator in memory.
            for j in path_to_base(model, i).skip(1) {
                self.related.push(j);
            }
            let [row, _] = &mut self.factors;
            row.clear();
            row.extend(self.related.iter().map(|j| self.axes[*j].dot(&scaled)));
            for tile in 0..=i / TILE {
                let [sum] = self.h_inverse.minus_sum(&self.related, [&*row], tile);
                self.h_inverse.column_mut(i)[tile] = sum;
            }
            let mut diagonal = ratio;
            for (j, factor) in self.related.iter().zip(row) {
                diagonal -= *factor * self.h_inverse[(*j, i)];
            }
            self.h_inverse[(i, i)] = diagonal;
            for j in 0..i {
                self.h_inverse[(i, j)] = self.h_inverse[(j, i)];
            }
        }
    }

    /// $-H^{-1} A$ for two matrices `A` whose entries vanish unless both joints are on one path to the base, after
    /// [`invert_mass_matrix`](Self::invert_mass_matrix); all `N` by `N`. Cost O(N^2 d) where joints are numbered depth
    /// first; other numberings add products with zeros.
    pub(super) fn minus_h_inverse_times<C: Scalar>(
        &mut self,
        model: &Model<C>,
        a: [&DMatrix<S>; 2],
        out: [&mut DMatrix<S>; 2],
    ) {
        let n = model.dof();
        for i in 0..n {
            self.last_after[i] = i;
        }
        for (i, joint) in model.joints().iter().enumerate().rev() {
            if let Some(parent) = joint.parent() {
                self.last_after[parent] = self.last_after[parent].max(self.last_after[i]);
            }
        }
        let [first, second] = out.map(|matrix| matrix.as_mut_slice().chunks_exact_mut(n));
        for (j, (first, second)) in first.zip(second).enumerate() {
            self.related.clear();
            for k in path_to_base(model, j).skip(1) {
                self.related.push(k);
            }
            self.related.extend(j..=self.last_after[j]);
            for (factors, a) in self.factors.iter_mut().zip(a) {
                let column = &a.as_slice()[j * n..][..n];
                factors.clear();
                factors.extend(self.related.iter().map(|k| column[*k]));
            }
            let factors = self.factors.each_ref().map(Vec::as_slice);
            let tiles = first.chunks_mut(TILE).zip(second.chunks_mut(TILE));
            for (tile, (first, second)) in tiles.enumerate() {
                let [x, y] = self.h_inverse.minus_sum(&self.related, factors, tile);
                first.copy_from_slice(&x[..first.len()]);
                second.copy_from_slice(&y[..second.len()]);
            }
        }
    }
}
