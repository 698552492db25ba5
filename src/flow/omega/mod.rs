//! Three ways to compute $\Omega$: as the supplement states it (Theorem B3), as it computes it (Algorithm B1), and in control form.

mod algorithm_b1;
mod control_form;
mod theorem_b3;

pub use algorithm_b1::AlgorithmB1;
pub use control_form::ControlForm;
pub use theorem_b3::TheoremB3;
