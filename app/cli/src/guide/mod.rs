//! The command line and sweeps. First motions are told in [`aghf_scenario::guide`], the mathematics in [`aghf::guide`].

#[doc = include_str!("command_line.md")]
pub mod command_line {}

#[doc = include_str!("sweeps.md")]
pub mod sweeps {}
