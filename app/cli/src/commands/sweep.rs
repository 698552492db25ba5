//! `aghf sweep`.

use super::{print, tell};
use crate::sweep::{
    Motions, Results, Row, RowOutcome, Shard, Sweep as Grid, merge, ranking, ranking_table, run, shard_files,
    sweep_page, write_ranking, write_rows,
};
use aghf::error::Result;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The interval of progress lines if no terminal shows a bar.
const LINE_EVERY: Duration = Duration::from_secs(60);

/// Solves scenarios with every combination of parameters of a grid, on all cores, and ranks the parameters.
///
/// Built in: table_09_pendulums, table_10_kinova, table_11_digit, table_12_kinova_obstacles, table_13_digit_obstacles,
/// table_09_quick, table_10_quick, direct_quick, direct_limits_quick. The tables are the paper's, for the flow; the
/// last two are for the direct method. An interrupted sweep is resumed.
#[derive(Debug, Args)]
pub(super) struct Sweep {
    /// A built-in sweep, the path of a TOML file, "-" for the standard input, or a folder, all of whose scenarios are
    /// solved by the direct method.
    sweep: String,
    /// Number of parallel solves [default: number of cores].
    #[arg(long)]
    jobs: Option<usize>,
    /// Solves only one part of several, such as 2/8, to distribute a sweep over machines.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Joins the results of shards instead of solving.
    #[arg(long, conflicts_with_all = ["jobs", "shard"])]
    merge: bool,
    /// Files to join [default: all results.shard-*.csv in the folder].
    #[arg(requires = "merge")]
    files: Vec<PathBuf>,
    /// Writes the files of each motion, too, as `aghf solve` does, into a folder of its own in FOLDER/motions.
    #[arg(long, conflicts_with = "merge")]
    motions: bool,
    /// Folder for results.csv, results.json, ranking.csv and report.html, a page with them [default: out/sweeps/NAME].
    #[arg(long, short)]
    out: Option<PathBuf>,
}

impl Sweep {
    pub(super) fn run(self) -> Result<ExitCode> {
        let began = Instant::now();
        let mut sweep = Grid::load(&self.sweep)?;
        super::tell_notes_of(sweep.scenarios());
        let folder = (self.out).unwrap_or_else(|| PathBuf::from("out/sweeps").join(&sweep.name));
        let motions = Motions { folder: folder.join("motions"), sampling: None, with_page: true };
        sweep.motions = self.motions.then_some(motions);
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        let (rows, path) = if self.merge {
            let files = if self.files.is_empty() { shard_files(&folder)? } else { self.files };
            merge(&sweep, &files, &folder)?
        } else {
            solve_missing(&sweep, shard, &folder, self.jobs)?
        };
        let mut files = vec![path];
        if shard == Shard::WHOLE {
            let ranking = ranking(&sweep, &rows);
            print(&ranking_table(&ranking))?;
            let names = ["results.json", "ranking.csv", "report.html"];
            let [table, ranked, page] = names.map(|name| folder.join(name));
            write_rows(&rows, &table)?;
            write_ranking(&ranking, &ranked)?;
            sweep_page(&sweep, &rows, &ranking)?.write(&page)?;
            files.extend([table, ranked, page]);
        }
        for file in files {
            print(&format!("wrote {}", file.display()))?;
        }
        print(&summary(&rows, began.elapsed(), &folder))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Solves the sets that have no row in the folder yet, with their progress; returns all rows and their file.
pub(super) fn solve_missing(
    sweep: &Grid,
    shard: Shard,
    folder: &Path,
    jobs: Option<usize>,
) -> Result<(Vec<Row>, PathBuf)> {
    let results = Results::open(sweep, shard, folder)?;
    let progress = Progress::new(&results);
    run(sweep, &results.missing(), jobs, &|row| {
        let outcome = row.outcome;
        results.append(row)?;
        progress.advance(outcome);
        Ok(())
    })?;
    progress.bar.finish_and_clear();
    results.finish()
}

/// The last line: the numbers of solves by outcome, the time, and the folder of the results.
pub(super) fn summary(rows: &[Row], time: Duration, folder: &Path) -> String {
    let count = |outcome| rows.iter().filter(|row| row.outcome == outcome).count();
    let mut ends = format!("{} of {} sets solved", count(RowOutcome::Success), rows.len());
    for outcome in RowOutcome::ALL {
        if outcome != RowOutcome::Success && count(outcome) > 0 {
            ends += &format!(", {} {}", count(outcome), outcome.name());
        }
    }
    let (seconds, folder) = (time.as_secs_f64(), folder.display());
    format!("{ends}; {seconds:.1} s; results in {folder}")
}

/// A bar on a terminal, otherwise lines at intervals.
struct Progress {
    bar: ProgressBar,
    /// `None` if there is a bar.
    lines: Option<Mutex<Lines>>,
}

/// The state of the lines.
struct Lines {
    /// The time of the last line.
    printed: Instant,
    solved: usize,
}

impl Progress {
    fn new(results: &Results<'_>) -> Self {
        let rows = results.rows();
        let all = rows.len() + results.missing().len();
        let style = "{elapsed:>4} {bar:30} {pos} of {len} sets, {eta} left";
        let style = ProgressStyle::with_template(style);
        let bar = ProgressBar::new(all as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            .with_position(rows.len() as u64);
        bar.reset_eta();
        let watched = std::io::stderr().is_terminal();
        let good = |row: &&Row| row.outcome == RowOutcome::Success;
        let lines = Lines { printed: Instant::now(), solved: rows.iter().filter(good).count() };
        Self { bar, lines: (!watched).then_some(Mutex::new(lines)) }
    }

    fn advance(&self, outcome: RowOutcome) {
        self.bar.inc(1);
        let Some(Ok(mut lines)) = self.lines.as_ref().map(Mutex::lock) else {
            return;
        };
        lines.solved += usize::from(outcome == RowOutcome::Success);
        if lines.printed.elapsed() >= LINE_EVERY {
            lines.printed = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let left = indicatif::HumanDuration(self.bar.eta());
            let solved = lines.solved;
            tell(&format!("{done} of {all} sets tried, {solved} solved, {left} left"));
        }
    }
}
