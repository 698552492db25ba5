//! `aghf reproduce`.

use super::print;
use crate::error::{Error, Result};
use crate::report::reproduce::{Settings, reproduce};
use clap::Args;
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run the paper's experiments and print a report in Markdown.
///
/// Solves every built-in scenario with the best sets of parameters, and times the right-hand side of the flow and its Jacobian
/// at random configurations of robots of 2 to 22 joints (Figures 4 and 5). The folder gets report.md, which is what is printed,
/// solves.csv, scaling.csv, fits.csv, figure_4.svg and figure_5.svg.
#[derive(Debug, Args)]
pub(super) struct Reproduce {
    /// Measure less: takes less than a minute.
    #[arg(long)]
    quick: bool,
    /// How often every solve is timed [default: 25, quick: 9].
    #[arg(long)]
    repetitions: Option<usize>,
    /// At how many random configurations a call is timed [default: 1000, quick: 200].
    #[arg(long)]
    configurations: Option<usize>,
    /// The seed of the configurations.
    #[arg(long, default_value_t = Settings::full().seed)]
    seed: u64,
    /// Only systems and robots whose names begin with this, such as kinova.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "",
        hide_default_value = true
    )]
    only: String,
    /// The folder for the files.
    #[arg(long, default_value = "out/reproduce")]
    out: PathBuf,
}

impl Reproduce {
    pub(super) fn run(self) -> Result<ExitCode> {
        let usual = if self.quick {
            Settings::quick()
        } else {
            Settings::full()
        };
        let settings = Settings {
            repetitions: self.repetitions.unwrap_or(usual.repetitions),
            configurations: self.configurations.unwrap_or(usual.configurations),
            seed: self.seed,
            only: self.only,
        };
        // Better to learn now than in the end that it cannot be written.
        std::fs::create_dir_all(&self.out).map_err(|e| Error::io(&self.out, e))?;
        let progress = ProgressBar::new_spinner();
        let reproduction = reproduce(&settings, &mut |what| {
            progress.set_message(what.to_owned());
            progress.tick();
        })?;
        progress.finish_and_clear();
        reproduction.write(&self.out)?;
        print(reproduction.markdown().trim_end())?;
        Ok(ExitCode::SUCCESS)
    }
}
