//! Linear algebra that the dynamics and the solvers share: factors and products of dense matrices, block-tridiagonal systems and
//! tensors of third and fourth order.

mod block_tridiagonal;
mod ldlt;
mod matmul;
mod tensor;

pub use block_tridiagonal::BlockTridiagonal;
pub use ldlt::Ldlt;
pub use matmul::multiply;
pub use tensor::{Tensor3, Tensor4};
