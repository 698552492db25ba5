//! `aghf reproduce`.

use super::output::OutArgs;
use super::{print, tell};
use crate::reproduce::{Comparison, Reproduction, Settings, VariantSettings, compare, reproduce};
use aghf::error::Result;
use clap::Args;
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// The interval of progress lines if no terminal shows a bar.
const LINE_EVERY: Duration = Duration::from_secs(60);

/// Run the paper's experiments and print a report in Markdown.
///
/// First searches the grids of Tables IX to XIII for the best sets of parameters, on all cores: 10 to 170 core hours,
/// estimated from a sample of one set in 41 to 503. Tables IX and X take minutes, XI to XIII up to 20, 45 and 105
/// hours, almost entirely in solves that reach the time limit of 300 s. An interrupted search is resumed; `aghf sweep`
/// has the same results, so that its --shard distributes a table over machines. --quick uses the paper's best sets and
/// our own instead.
///
/// Then solves every scenario, built-in or generated, with the best sets, and times the right-hand side of the flow and
/// its Jacobian at random configurations of robots of 2 to 22 joints (Figures 4 and 5). A new folder, out/reproduce or
/// out/reproduce-2 and so on, gets report.md, which is also printed, solves.csv, scaling.csv, fits.csv, figure_4.svg,
/// figure_5.svg and report.html, a page with all of these.
///
/// With --variants, compares instead the published flow, the flow to rest, with duals and in two phases, and the
/// relaxation from the same guess, on pendulums, Kinova, Digit and robots with passive joints. A new folder,
/// out/variants or out/variants-2 and so on, gets variants.md, which is also printed, variants.csv, variants.svg, the
/// action during each flow, and report.html, a page with these.
#[derive(Debug, Args)]
pub(super) struct Reproduce {
    /// Skip the grid searches and measure less: takes about a minute. With --variants: two scenarios of each family, 10
    /// s for each solve instead of 60.
    #[arg(long)]
    quick: bool,
    /// Compare the variants of the flow and the relaxation instead.
    #[arg(
        long,
        conflicts_with_all = ["grid", "sweeps", "repetitions", "configurations", "seed"]
    )]
    variants: bool,
    /// Search this sweep instead, built in or a TOML file; may be repeated [default: the five tables, quick: none].
    #[arg(long, value_name = "SWEEP")]
    grid: Vec<String>,
    /// Folder with one folder of results per sweep.
    #[arg(long, value_name = "FOLDER", default_value_os_t = Settings::full().sweeps)]
    sweeps: PathBuf,
    /// Number of timed runs per solve [default: 25, quick: 9].
    #[arg(long)]
    repetitions: Option<usize>,
    /// Number of random configurations at which a call is timed [default: 1000, quick: 200].
    #[arg(long)]
    configurations: Option<usize>,
    /// Seed of the configurations.
    #[arg(long, default_value_t = Settings::full().seed)]
    seed: u64,
    /// Only systems, robots and scenarios whose names begin with this, such as kinova.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "",
        hide_default_value = true
    )]
    only: String,
    #[command(flatten)]
    out: OutArgs,
}

impl Reproduce {
    pub(super) fn run(self) -> Result<ExitCode> {
        if self.variants {
            return self.run_variants();
        }
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
            grids: if self.grid.is_empty() {
                usual.grids
            } else {
                self.grid
            },
            sweeps: self.sweeps,
        };
        // Better to learn now than in the end that it cannot be written.
        let folder = self
            .out
            .folder(Path::new("out/reproduce"), &Reproduction::FILES)?;
        let reproduction = told(|progress| reproduce(&settings, progress))?;
        reproduction.write(folder.path())?;
        print(reproduction.markdown().trim_end())?;
        Ok(ExitCode::SUCCESS)
    }

    fn run_variants(self) -> Result<ExitCode> {
        let settings = VariantSettings::builtin(self.quick, &self.only)?;
        let folder = self
            .out
            .folder(Path::new("out/variants"), &Comparison::FILES)?;
        let comparison = told(|progress| compare(&settings, progress))?;
        comparison.write(folder.path())?;
        print(comparison.markdown().trim_end())?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Runs `work` and shows its progress.
fn told<T>(work: impl FnOnce(&mut (dyn FnMut(&str) + Send)) -> Result<T>) -> Result<T> {
    let progress = ProgressBar::new_spinner();
    let watched = std::io::stderr().is_terminal();
    let mut told = Instant::now();
    let done = work(&mut |what| {
        progress.set_message(what.to_owned());
        progress.tick();
        if !watched && told.elapsed() >= LINE_EVERY {
            told = Instant::now();
            tell(what);
        }
    })?;
    progress.finish_and_clear();
    Ok(done)
}
