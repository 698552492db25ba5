//! The motions of a sweep.

use super::{ParameterSet, Sweep};
use crate::output::{OutputFolder, REPORT_FILES, Sampling, write_report};
use crate::report::{Motion, page};
use aghf::error::Result;
use aghf_scenario::{Scenario, SolveReport};
use std::path::PathBuf;

/// The place and the form of the motions that a sweep keeps.
#[derive(Clone, Debug)]
pub struct Motions {
    /// The folder, which gets a folder for each motion.
    pub folder: PathBuf,
    /// The rows of their tables; by default as many as `aghf judge` needs.
    pub sampling: Option<Sampling>,
    /// True if each gets a page.
    pub with_page: bool,
}

impl Motions {
    /// Writes the files of a motion, over those of an interrupted process.
    pub(super) fn write(&self, name: &str, scenario: &Scenario, report: &SolveReport) -> Result<()> {
        let folder = OutputFolder::open(&self.folder.join(name), &REPORT_FILES, true)?;
        let page = if self.with_page { Some(page(&[Motion::of_report(scenario, report)])?) } else { None };
        write_report(scenario, report, page.as_deref(), &folder, self.sampling).map(drop)
    }
}

impl Sweep {
    /// The name of the folder of the motion of a set: the problem, and the set where a problem has several.
    #[must_use]
    pub fn motion_name(&self, set: &ParameterSet) -> String {
        let name = &self.problems[set.problem].name;
        if self.sets_a_scenario() == 1 { name.clone() } else { format!("{name}_{}", set.index) }
    }
}
