//! The command line, robots of one's own, exports and sweeps. [`aghf_scenario::guide`] has first motions and all keys
//! of a scenario, [`aghf::guide`] the mathematics.

#[doc = include_str!("command_line.md")]
pub mod command_line {}

#[doc = include_str!("real_robots.md")]
pub mod real_robots {}

#[doc = include_str!("export.md")]
pub mod export {}

#[doc = include_str!("sweeps.md")]
pub mod sweeps {}

#[doc = include_str!("upgrade.md")]
pub mod upgrade {}
