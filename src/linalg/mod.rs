//! Linear algebra that the dynamics and the solvers share: factors and products of dense matrices, block-tridiagonal systems and
//! tensors of third and fourth order.

#[cfg(feature = "solvers")]
mod block_tridiagonal;
mod ldlt;
#[cfg(feature = "solvers")]
mod matmul;
mod tensor;

#[cfg(feature = "solvers")]
pub use block_tridiagonal::BlockTridiagonal;
pub use ldlt::Ldlt;
#[cfg(feature = "solvers")]
pub use matmul::multiply;
pub use tensor::{Tensor3, Tensor4};
