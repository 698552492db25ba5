//! The checker, the prover and the pages in `proofs/`.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod duals;
mod errata;
mod field;
mod ledger;
mod literal;
mod wrong;
