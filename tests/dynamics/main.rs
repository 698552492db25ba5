//! Scalars, linear algebra, spatial algebra, rigid-body dynamics and bounds on motions.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod allocation;
mod derivatives;
mod identities;
mod rnea_weighted;
mod root_wrench;
mod second_derivatives;

#[path = "../certify"]
mod certify {
    mod bernstein;
    mod motion;
}

#[path = "../linalg"]
mod linalg {
    mod block_indefinite;
    mod indefinite;
    mod ldlt;
    mod matmul;
    mod tensor;
}

#[path = "../scalar"]
mod scalar {
    pub mod double;
    mod lanes;
    mod numeric;
    mod prime_field;
    mod taylor_model;
}

#[path = "../spatial"]
mod spatial {
    mod products;
}
