//! `aghf sweep`.

use super::print;
use crate::error::Result;
use crate::experiments::sweep::{
    Results, Row, RowOutcome, Shard, Sweep as Grid, merge, ranking, ranking_table, run,
    shard_files, write_ranking, write_rows,
};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// How often a line tells of the progress where nobody watches a bar.
const LINE_EVERY: Duration = Duration::from_secs(60);

/// Solve scenarios with every combination of parameters of a grid, on all cores, and rank the parameters.
///
/// Built in: table_09_pendulums, table_10_kinova, table_11_digit, table_12_kinova_obstacles, table_13_digit_obstacles,
/// table_09_quick, table_10_quick. The tables are the paper's. A sweep that was interrupted goes on where it was.
#[derive(Debug, Args)]
pub(super) struct Sweep {
    /// A sweep that is built in, or the path of a TOML file.
    sweep: String,
    /// How many solves run at a time [default: as many as there are cores].
    #[arg(long)]
    jobs: Option<usize>,
    /// Solve one part of several only, such as 2/8, to spread a sweep over machines.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Join the results of shards instead of solving.
    #[arg(long, conflicts_with_all = ["jobs", "shard"])]
    merge: bool,
    /// The files to join [default: all results.shard-*.csv in the folder].
    #[arg(requires = "merge")]
    files: Vec<PathBuf>,
    /// The folder for results.csv, results.json and ranking.csv [default: out/sweeps/NAME].
    #[arg(long)]
    out: Option<PathBuf>,
}

impl Sweep {
    pub(super) fn run(self) -> Result<ExitCode> {
        let sweep = Grid::load(&self.sweep)?;
        let folder = (self.out).unwrap_or_else(|| PathBuf::from("out/sweeps").join(&sweep.name));
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        let (rows, path) = if self.merge {
            let files = match self.files.is_empty() {
                true => shard_files(&folder)?,
                false => self.files,
            };
            merge(&sweep, &files, &folder)?
        } else {
            let results = Results::open(&sweep, shard, &folder)?;
            let missing = results.missing();
            let all = (sweep.sets.iter())
                .filter(|set| shard.has(set.index))
                .count();
            let progress = Progress::new(all, missing.len());
            run(&sweep, &missing, self.jobs, &|row| {
                results.append(row)?;
                progress.advance();
                Ok(())
            })?;
            progress.bar.finish_and_clear();
            results.finish()?
        };
        print(&outcomes(&rows))?;
        let mut files = vec![path];
        if shard == Shard::WHOLE {
            let ranking = ranking(&sweep, &rows);
            print(&ranking_table(&ranking))?;
            let (table, ranked) = (folder.join("results.json"), folder.join("ranking.csv"));
            write_rows(&rows, &table)?;
            write_ranking(&ranking, &ranked)?;
            files.extend([table, ranked]);
        }
        for file in files {
            print(&format!("wrote {}", file.display()))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// How many solves ended in which way.
fn outcomes(rows: &[Row]) -> String {
    let count = |outcome| rows.iter().filter(|row| row.outcome == outcome).count();
    let counts = RowOutcome::ALL.map(|outcome| format!("{} {}", count(outcome), outcome.name()));
    format!("{} sets: {}", rows.len(), counts.join(", "))
}

/// A bar where somebody watches, and a line now and then where nobody does.
struct Progress {
    bar: ProgressBar,
    /// When the last line was told; `None` where there is a bar.
    told: Option<Mutex<Instant>>,
}

impl Progress {
    fn new(all: usize, missing: usize) -> Self {
        let style = "{elapsed:>4} {bar:30} {pos} of {len} sets, {eta} left";
        let style = ProgressStyle::with_template(style);
        let bar = ProgressBar::new(all as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            .with_position((all - missing) as u64);
        bar.reset_eta();
        let watched = std::io::stderr().is_terminal();
        Self {
            bar,
            told: (!watched).then(|| Mutex::new(Instant::now())),
        }
    }

    fn advance(&self) {
        self.bar.inc(1);
        let Some(Ok(mut told)) = self.told.as_ref().map(Mutex::lock) else {
            return;
        };
        if told.elapsed() >= LINE_EVERY {
            *told = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let left = indicatif::HumanDuration(self.bar.eta());
            eprintln!("{done} of {all} sets, {left} left");
        }
    }
}
