//! Curves as polynomials through their values at Chebyshev-Gauss-Lobatto nodes, equations (20) to (23).

mod chebyshev;
mod collocation;
mod curve;
mod legendre;

pub use chebyshev::Chebyshev;
pub use collocation::{Collocation, assemble_jacobian};
pub use curve::Curve;
pub use legendre::gauss_legendre;
pub(crate) use legendre::legendre;
