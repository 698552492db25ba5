//! Results: the report on a motion, its feasibility and its files.

pub(crate) mod curve_file;
pub(crate) mod feasibility;
pub(crate) mod joint_trajectory;
pub(crate) mod provenance;
pub(crate) mod report;
pub(crate) mod summary;
