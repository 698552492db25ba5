//! Factors of indefinite block-tridiagonal matrices.

use crate::common::{config, numbers};
use aghf::linalg::BlockIndefinite;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(128))]

    /// With blocks and a border inertia and solution are those of the dense matrix.
    #[test]
    fn blocks_and_border(sizes in prop::collection::vec(1..5_usize, 1..4), shared in 1..3_usize, border in 0..3_usize,
                         x in numbers(256), b in numbers(16)) {
        let rows: usize = sizes.iter().sum();
        let n = rows + border;
        let half = DMatrix::from_column_slice(n, n, &x[..n * n]);
        let full = &half + half.transpose();
        let mut dense = DMatrix::zeros(n, n);
        dense.view_mut((0, rows), (n, border)).copy_from(&full.columns(rows, border));
        dense.view_mut((rows, 0), (border, n)).copy_from(&full.rows(rows, border));
        let (mut diagonal, mut couplings, mut first) = (Vec::new(), Vec::new(), 0);
        for (e, size) in sizes.iter().copied().enumerate() {
            let own = full.view((first, first), (size, size)).into_owned();
            dense.view_mut((first, first), (size, size)).copy_from(&own);
            diagonal.push(own.lower_triangle());
            if let Some(next) = sizes.get(e + 1).copied() {
                // The last columns but one, if there are so many.
                let columns = size.saturating_sub(shared + 1)..size.max(2) - 1;
                let place = ((first + size, first + columns.start), (next, columns.len()));
                let coupling = full.view(place.0, place.1).into_owned();
                dense.view_mut(place.0, place.1).copy_from(&coupling);
                let (place, shape) = ((place.0.1, place.0.0), (place.1.1, place.1.0));
                dense.view_mut(place, shape).copy_from(&coupling.transpose());
                couplings.push((columns, coupling));
            }
            first += size;
        }
        let corner = full.view((rows, rows), (border, border)).into_owned();
        let columns = full.view((0, rows), (rows, border)).into_owned();
        let factor = BlockIndefinite::new(diagonal, &couplings, (columns, corner));
        let eigenvalues = dense.clone().symmetric_eigenvalues();
        prop_assume!(eigenvalues.iter().all(|value| value.abs() > 1e-3));
        let mut solution = DVector::from_column_slice(&b[..n]);
        factor.solve(&mut solution);
        let off = (&dense * &solution - DVector::from_column_slice(&b[..n])).amax();
        // A block may be singular by chance.
        prop_assume!(solution.amax() < 1e4 && off < 1e-3);
        let negative = eigenvalues.iter().filter(|value| **value < 0.0).count();
        prop_assert_eq!(factor.inertia(), [n - negative, negative, 0]);
        prop_assert!(off < 1e-7, "{}", off);
    }
}
