//! The interior-point method on small dense programs.

#[macro_use]
#[path = "../common/mod.rs"]
mod common;

mod barrier;
mod dense;
mod filter;
mod iterate;
mod kkt;
mod leave_saddle;
mod line_search;
mod options;
mod problems;
mod saddle;
mod smooth;
mod state;
mod warm_start;
