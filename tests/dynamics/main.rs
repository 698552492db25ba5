//! Scalars, linear algebra, spatial algebra and rigid-body dynamics.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod allocation;
mod derivatives;
mod identities;
mod rnea_weighted;
mod root_wrench;
mod second_derivatives;

#[path = "../linalg"]
mod linalg {
    mod ldlt;
    mod matmul;
    mod tensor;
}

#[path = "../scalar"]
mod scalar {
    mod lanes;
    mod numeric;
    mod prime_field;
}

#[path = "../spatial"]
mod spatial {
    mod products;
}
