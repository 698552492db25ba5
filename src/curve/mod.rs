//! Curves as piecewise polynomials: through their values at Chebyshev-Gauss-Lobatto nodes, equations (20) to (23), and
//! in a basis that meets the boundary conditions.

mod basis;
mod bracket;
mod chebyshev;
mod fit;
mod hermite;
mod legendre;
mod piecewise;

pub(crate) use basis::Functions;
pub use basis::{Basis, Continuity};
pub(crate) use bracket::{Bracket, bound, maxima};
pub use chebyshev::Chebyshev;
pub(crate) use fit::{Fit, Local};
pub use legendre::{gauss_legendre, gauss_lobatto};
pub use piecewise::Curve;
