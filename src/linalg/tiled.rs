//! Sums of columns in tiles of a few rows.

use crate::scalar::Scalar;
use std::ops::{Index, IndexMut};

/// The number of rows that stay in registers together.
pub(crate) const TILE: usize = 4;

/// A square matrix by columns, padded with zeros to whole tiles of rows.
#[derive(Clone, Debug)]
pub(crate) struct Tiled<S: Scalar> {
    /// The number of tiles per column.
    tiles: usize,
    entries: Vec<[S; TILE]>,
}

impl<S: Scalar> Tiled<S> {
    /// The zero matrix of order `n`.
    pub(crate) fn new(n: usize) -> Self {
        let tiles = n.div_ceil(TILE);
        Self { tiles, entries: vec![[S::zero(); TILE]; tiles * n] }
    }

    /// Sets every entry to zero.
    pub(crate) fn clear(&mut self) {
        self.entries.fill([S::zero(); TILE]);
    }

    /// The tiles of a column.
    pub(crate) fn column_mut(&mut self, j: usize) -> &mut [[S; TILE]] {
        &mut self.entries[j * self.tiles..][..self.tiles]
    }

    /// All columns in order.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &[[S; TILE]]> {
        self.entries.chunks_exact(self.tiles.max(1))
    }

    /// Computes one tile of $-\sum_j f_j x_j$ for the listed columns $x_j$ and each of `M` lists of factors $f_j$.
    #[inline]
    pub(crate) fn minus_sum<const M: usize>(
        &self,
        columns: &[usize],
        factors: [&[S]; M],
        tile: usize,
    ) -> [[S; TILE]; M] {
        let mut sums = [[S::zero(); TILE]; M];
        let factors = factors.map(|factors| &factors[..columns.len()]);
        for (at, j) in columns.iter().enumerate() {
            let column = &self.entries[j * self.tiles + tile];
            for m in 0..M {
                for row in 0..TILE {
                    sums[m][row] -= column[row] * factors[m][at];
                }
            }
        }
        sums
    }
}

impl<S: Scalar> Index<(usize, usize)> for Tiled<S> {
    type Output = S;
    #[inline]
    fn index(&self, (i, j): (usize, usize)) -> &S {
        &self.entries[j * self.tiles + i / TILE][i % TILE]
    }
}

impl<S: Scalar> IndexMut<(usize, usize)> for Tiled<S> {
    #[inline]
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut S {
        &mut self.entries[j * self.tiles + i / TILE][i % TILE]
    }
}
