//! Linear algebra of the dynamics and the solvers: factorisations and products of dense matrices, block-tridiagonal
//! systems and tensors of third and fourth order.

#[cfg(feature = "solvers")]
mod block_indefinite;
#[cfg(feature = "solvers")]
mod block_tridiagonal;
#[cfg(feature = "solvers")]
mod gram;
#[cfg(feature = "solvers")]
mod indefinite;
mod ldlt;
#[cfg(feature = "solvers")]
mod matmul;
#[cfg(feature = "solvers")]
mod positive_part;
mod tensor;
mod tiled;

#[cfg(feature = "solvers")]
pub use block_indefinite::BlockIndefinite;
#[cfg(feature = "solvers")]
pub use block_tridiagonal::{BlockTridiagonal, Scratch};
#[cfg(feature = "solvers")]
pub(crate) use gram::{ROWS, weighted_gram};
#[cfg(feature = "solvers")]
pub use indefinite::Indefinite;
pub use ldlt::Ldlt;
#[cfg(feature = "solvers")]
pub use matmul::multiply;
#[cfg(feature = "solvers")]
pub(crate) use positive_part::positive_part;
pub use tensor::{Tensor3, Tensor4};
pub(crate) use tiled::{TILE, Tiled};

/// A matrix as a list of its rows, the form in files.
pub fn rows(matrix: &nalgebra::DMatrix<f64>) -> Vec<Vec<f64>> {
    let rows = matrix.row_iter();
    rows.map(|row| row.iter().copied().collect()).collect()
}

/// Copies a matrix or a vector into the memory of another, unless that has another shape.
#[cfg(feature = "solvers")]
pub(crate) fn assign<C: nalgebra::Dim>(
    to: &mut nalgebra::OMatrix<f64, nalgebra::Dyn, C>,
    from: &nalgebra::OMatrix<f64, nalgebra::Dyn, C>,
) where
    nalgebra::DefaultAllocator: nalgebra::allocator::Allocator<nalgebra::Dyn, C>,
{
    if to.shape() == from.shape() {
        to.copy_from(from);
    } else {
        to.clone_from(from);
    }
}
