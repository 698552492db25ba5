//! Scalars, linear algebra, spatial algebra and rigid-body dynamics.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod allocation;
mod derivatives;
mod fast_paths;
mod identities;
mod locked;
mod prime_field;
mod rnea_weighted;
mod scalar;
mod second_derivatives;
mod spatial;
mod tensor;
