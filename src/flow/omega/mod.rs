//! Three methods of computing $\Omega$: Theorem B3 as stated in the supplement, its Algorithm B1, and the control form.

mod algorithm_b1;
mod control_form;
mod theorem_b3;

pub use algorithm_b1::AlgorithmB1;
pub use control_form::ControlForm;
pub use theorem_b3::TheoremB3;
