//! The checker, the prover and the pages in `proofs/`.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod check;
mod check_flow;
mod errata;
mod ledger;
mod literal;
mod prover;
mod wrong;
