//! Reproduction of the experiments of the paper's supplement: the grid searches of Tables IX to XIII, the solves of
//! section C with the best sets, and the times of Figures 4 and 5; and a comparison of the variants of the flow on the
//! same scenarios.

pub mod fit;
mod format;
mod markdown;
mod page;
mod plot;
mod searches;
mod solves;
mod systems;
mod tables;
mod timing;
mod variants;

pub use searches::{BestSet, Search};
pub use solves::{Origin, ScenarioResult, SystemResult};
pub use systems::{PaperSet, SCALING_ROBOTS, SYSTEMS, System};
pub use timing::{Quantity, Series, Times};
pub use variants::{ActionPath, Comparison, VARIANTS, VariantResult, VariantSettings, compare};

use crate::output::write_whole;
use aghf::error::{Error, Result, check_count};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The extent of the experiments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The number of timed runs per solve.
    pub repetitions: usize,
    /// The number of random configurations at which the right-hand side and its Jacobian are timed.
    pub configurations: usize,
    /// The seed of the configurations.
    pub seed: u64,
    /// The prefix of the names of systems and robots; empty for all.
    pub only: String,
    /// Built-in sweeps, or paths of TOML files: the best sets of a system are searched in the first one that has all
    /// its scenarios.
    pub grids: Vec<String>,
    /// The folder with one folder of results per sweep.
    pub sweeps: PathBuf,
}

/// The sweeps of the paper's Tables IX to XIII.
pub const GRIDS: [&str; 5] = [
    "table_09_pendulums",
    "table_10_kinova",
    "table_11_digit",
    "table_12_kinova_obstacles",
    "table_13_digit_obstacles",
];

/// The largest number of repetitions: all solves of `--quick` once take about two seconds, this many six hours.
const MOST_REPETITIONS: usize = 10_000;
/// The largest number of configurations: this many states of Digit take 100 MB.
const MOST_CONFIGURATIONS: usize = 100_000;

impl Settings {
    /// The paper's grids and its number of configurations.
    #[must_use]
    pub fn full() -> Self {
        Self {
            repetitions: 25,
            configurations: 1000,
            seed: 1,
            only: String::new(),
            grids: GRIDS.map(str::to_owned).into(),
            sweeps: "out/sweeps".into(),
        }
    }

    /// No search: the paper's best sets and our own, in about a minute.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            repetitions: 9,
            configurations: 200,
            grids: Vec::new(),
            ..Self::full()
        }
    }

    /// Returns true if a system or robot of this name is selected.
    fn chooses(&self, name: &str) -> bool {
        name.starts_with(&self.only)
    }

    /// # Errors
    /// A count is out of range, or nothing is selected.
    fn check(&self) -> Result<()> {
        check_count("repetitions", self.repetitions, 1..=MOST_REPETITIONS)?;
        check_count(
            "configurations",
            self.configurations,
            1..=MOST_CONFIGURATIONS,
        )?;
        let mut names = (SYSTEMS.iter().map(|s| s.prefix)).chain(SCALING_ROBOTS);
        if !names.any(|name| self.chooses(name)) {
            let condition = format!("no system begins with '{}'", self.only);
            return Err(Error::input("settings", "only", condition));
        }
        Ok(())
    }
}

/// The results of the experiments.
#[derive(Clone, Debug)]
pub struct Reproduction {
    /// The settings.
    pub settings: Settings,
    /// The grid searches, one per system with a grid.
    pub searches: Vec<Search>,
    /// The solves.
    pub systems: Vec<SystemResult>,
    /// The times at a node; one series per entry of [`Quantity::ALL`].
    pub series: Vec<Series>,
    /// The total wall time, s.
    pub seconds: f64,
}

/// Runs the experiments: grids on all cores, resumed if they were interrupted, and all timed solves one after the other
/// on one core. `progress` is called with the next step.
///
/// # Errors
/// Nothing is selected, a sweep cannot be loaded, or its results cannot be read or written.
pub fn reproduce(
    settings: &Settings,
    progress: &mut (dyn FnMut(&str) + Send),
) -> Result<Reproduction> {
    settings.check()?;
    let started = Instant::now();
    let (searches, systems) = solves::solves(settings, progress)?;
    let series = timing::scaling(settings, progress)?;
    Ok(Reproduction {
        settings: settings.clone(),
        searches,
        systems,
        series,
        seconds: started.elapsed().as_secs_f64(),
    })
}

impl Reproduction {
    /// The names of the output files.
    pub const FILES: [&'static str; 7] = [
        "report.md",
        "report.html",
        "solves.csv",
        "scaling.csv",
        "fits.csv",
        "figure_4.svg",
        "figure_5.svg",
    ];

    /// Returns true if a robot of Figures 4 and 5 was selected.
    fn has_times(&self) -> bool {
        self.series.iter().any(|s| !s.points.is_empty())
    }

    /// The report in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        markdown::report(self)
    }

    /// Writes `report.md`, its page `report.html`, `solves.csv`, `scaling.csv`, `fits.csv` and, if there are times,
    /// `figure_4.svg` and `figure_5.svg` into `folder`, which is created if necessary, and returns their paths.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        let [report, page, solves, scaling, fits, figure_4, figure_5] = Self::FILES;
        let mut contents = vec![
            (report, Ok(self.markdown())),
            (page, Ok(page::reproduction(self)?.html()?)),
            (solves, tables::solves(&self.systems)),
            (scaling, tables::scaling(self)),
            (fits, tables::fits(&self.series)),
        ];
        if self.has_times() {
            contents.push((figure_4, plot::figure(4, &self.series)));
            contents.push((figure_5, plot::figure(5, &self.series)));
        }
        let mut files = Vec::new();
        for (name, text) in contents {
            let path = folder.join(name);
            let text = text.map_err(|e| Error::io(&path, e))?;
            write_whole(&path, |file| file.write_all(text.as_bytes()))?;
            files.push(path);
        }
        Ok(files)
    }
}
