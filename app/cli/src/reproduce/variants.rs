//! The variants of the flow and the relaxation on the same scenarios, one after the other.

use super::format::figures;
use super::markdown::{Table, machine};
use super::timing::median;
use super::{page, plot, tables};
use crate::output::write_whole;
use aghf::error::{Error, Result};
use aghf::motion::Interrupt;
use aghf::names::Named;
use aghf_scenario::{
    Details, FlowVariant, Method, Record, Scenario, SolveOptions, builtin_scenarios,
    generated_scenarios, solve,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The names of the variants, in the order of the table; the last one is the relaxation, which is not a flow.
pub const VARIANTS: [&str; 5] = ["published", "rest", "duals", "two-phases", "relax"];

/// The families of [`VariantSettings::builtin`] and the prefixes of the names of their scenarios.
const FAMILIES: [(&str, &[&str]); 9] = [
    ("pendulums", &["pendulum_"]),
    ("Kinova", &["kinova_free_"]),
    ("Kinova, obstacles", &["kinova_obstacles_"]),
    ("Digit", &["digit_free_"]),
    ("Kinova, cross", &["kinova_cross_"]),
    ("Kinova, gap", &["kinova_gap_"]),
    ("Kinova, floor", &["kinova_floor_"]),
    ("Digit, box", &["digit_box_"]),
    (
        "underactuated",
        &["acrobot_", "pendubot_", "cart_pole_", "rotorcraft_"],
    ),
];

/// The settings of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariantSettings {
    /// The title of each family and the names of its scenarios, or paths of their files.
    pub families: Vec<(String, Vec<String>)>,
    /// The wall time after which a solve stops.
    pub time_limit: Duration,
    /// The scenario whose action is drawn against `s`: one of the scenarios of the families.
    pub drawn: String,
}

impl VariantSettings {
    /// All scenarios of the built-in families, with 60 s per solve; if `quick`, the first two of each with 10 s. Only
    /// those whose names begin with `only` are used; the action is drawn for `kinova_free_01`, or for the first
    /// scenario if that is not among them.
    ///
    /// # Errors
    /// No scenario has a name that begins with `only`.
    pub fn builtin(quick: bool, only: &str) -> Result<Self> {
        let most = if quick { 2 } else { usize::MAX };
        let mut families = Vec::new();
        for (title, prefixes) in FAMILIES {
            let all = builtin_scenarios().map(str::to_owned);
            let of_family = all.chain(generated_scenarios()).filter(|name| {
                let has_prefix = prefixes.iter().any(|prefix| name.starts_with(prefix));
                has_prefix && name.starts_with(only)
            });
            let names: Vec<String> = of_family.take(most).collect();
            if !names.is_empty() {
                families.push((title.to_owned(), names));
            }
        }
        let names = || families.iter().flat_map(|(_, names)| names);
        let usual = names().find(|name| *name == "kinova_free_01");
        let Some(drawn) = usual.or_else(|| names().next()).cloned() else {
            let condition = format!("no scenario of the families begins with '{only}'");
            return Err(Error::input("settings", "only", condition));
        };
        Ok(Self {
            families,
            time_limit: Duration::from_secs(if quick { 10 } else { 60 }),
            drawn,
        })
    }
}

/// The result of one scenario by one variant.
#[derive(Clone, Debug)]
pub struct VariantResult {
    /// The title of the family.
    pub family: String,
    /// The name of the scenario.
    pub scenario: String,
    /// One of [`VARIANTS`].
    pub variant: &'static str,
    /// [`Summary::success`](aghf_scenario::Summary::success).
    pub success: bool,
    /// $\int |u|^2 dt$.
    pub effort: f64,
    /// The final error of the simulation with feedback; `None` if it stopped early.
    pub final_error: Option<f64>,
    /// Wall time of the method, s.
    pub seconds: f64,
    /// Accepted steps in `s`, or iterations of the relaxation.
    pub steps: usize,
    /// The reasons of a failure; `None` for a success.
    pub failure: Option<String>,
}

/// The action during the flow of one variant.
#[derive(Clone, Debug)]
pub struct ActionPath {
    /// One of [`VARIANTS`].
    pub variant: &'static str,
    /// `s` and the action, in the order in which they were reached.
    pub points: Vec<(f64, f64)>,
}

/// The results of all variants.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The settings.
    pub settings: VariantSettings,
    /// One result per scenario and variant, except the published flow for robots with passive joints, for which it is
    /// not defined.
    pub results: Vec<VariantResult>,
    /// The actions of the flows on the drawn scenario.
    pub paths: Vec<ActionPath>,
    /// The total wall time, s.
    pub seconds: f64,
}

/// Solves all scenarios by all variants, one after the other and each on one thread. `progress` is called with the next
/// step.
///
/// The relaxation has one start, so that it begins at the first guess of the flows to rest. With passive joints all of
/// them have their default number of starts instead.
///
/// # Errors
/// There is no scenario, a scenario cannot be loaded or has no solution for an obvious reason, or the drawn one is not
/// among them.
pub fn compare(
    settings: &VariantSettings,
    progress: &mut (dyn FnMut(&str) + Send),
) -> Result<Comparison> {
    let started = Instant::now();
    let mut names = settings.families.iter().flat_map(|(_, names)| names);
    if !names.any(|name| *name == settings.drawn) {
        let condition = format!("'{}' is none of the scenarios", settings.drawn);
        return Err(Error::input("settings", "drawn", condition));
    }
    let (mut results, mut paths) = (Vec::new(), Vec::new());
    for (family, names) in &settings.families {
        for name in names {
            let scenario = Scenario::load(name)?;
            for variant in VARIANTS {
                let Some(options) = options(variant, &scenario, settings.time_limit) else {
                    continue;
                };
                progress(&format!("{name}, {variant}"));
                let report = solve(&scenario, &options, &mut |_| {})?;
                if *name == settings.drawn && options.method == Method::Flow {
                    let points = report.history.iter().filter_map(point).collect();
                    paths.push(ActionPath { variant, points });
                }
                let summary = report.summary;
                results.push(VariantResult {
                    family: family.clone(),
                    scenario: scenario.name.clone(),
                    variant,
                    success: summary.success,
                    effort: summary.control_effort,
                    final_error: summary.final_error_inf,
                    seconds: summary.solve_seconds,
                    steps: match &summary.details {
                        Details::Flow(flow) => flow.steps,
                        Details::Rest(rest) => rest.steps,
                        Details::Relax(relax) => relax.iterations,
                    },
                    failure: summary.failure,
                });
            }
        }
    }
    Ok(Comparison {
        settings: settings.clone(),
        results,
        paths,
        seconds: started.elapsed().as_secs_f64(),
    })
}

/// The options of a variant; `None` if it is not defined.
fn options(variant: &str, scenario: &Scenario, time_limit: Duration) -> Option<SolveOptions> {
    let passive = !scenario.file.passive.is_empty();
    let mut flows = FlowVariant::ALL.iter();
    let flow = flows.find(|(_, name, _)| *name == variant);
    let Some(&(flow, ..)) = flow else {
        return Some(SolveOptions {
            method: Method::Relax,
            num_starts: (!passive).then_some(1),
            threads: Some(1),
            // With a time limit it would try starts until then.
            interrupt: Interrupt::after(time_limit),
            ..SolveOptions::default()
        });
    };
    let defined = flow != FlowVariant::Published || !passive;
    defined.then(|| SolveOptions {
        method: Method::Flow,
        variant: Some(flow),
        time_limit: Some(time_limit),
        ..SolveOptions::default()
    })
}

/// `s` and the action in a record of a flow.
fn point(record: &Record) -> Option<(f64, f64)> {
    match record {
        Record::Flow(flow) => Some((flow.s, flow.action_at_nodes)),
        Record::Rest(rest) => Some((rest.s, rest.action)),
        Record::Relax(_) => None,
    }
}

impl Comparison {
    /// The names of the output files.
    pub const FILES: [&'static str; 4] =
        ["variants.md", "variants.csv", "variants.svg", "report.html"];

    /// One row per family.
    pub(super) fn table(&self) -> Table {
        let header: Vec<&str> = std::iter::once("family").chain(VARIANTS).collect();
        let mut table = Table::new(&header);
        for (family, _) in &self.settings.families {
            let cells = VARIANTS.map(|variant| self.cell(family, variant));
            table.row(std::iter::once(family.clone()).chain(cells));
        }
        table
    }

    /// Formats the table in Markdown: one row per family.
    #[must_use]
    pub fn markdown(&self) -> String {
        format!(
            "# Variants of the flow\n\n{}\nSolved of tried, median effort and median time of those solved. Each solve once, with {} s at most; a \
            dash: not defined. `relax` has one start, with passive joints as many as its defaults.\n\n{}",
            self.table().text(),
            self.settings.time_limit.as_secs_f64(),
            machine(self.seconds)
        )
    }

    /// The results of a family by a variant.
    fn cell(&self, family: &str, variant: &str) -> String {
        let of_cell = |r: &&VariantResult| r.family == family && r.variant == variant;
        let tried: Vec<_> = self.results.iter().filter(of_cell).collect();
        if tried.is_empty() {
            return "-".to_owned();
        }
        let solved: Vec<_> = tried.iter().filter(|r| r.success).collect();
        let count = format!("{}/{}", solved.len(), tried.len());
        if solved.is_empty() {
            return count;
        }
        let mut efforts: Vec<f64> = solved.iter().map(|r| r.effort).collect();
        let mut seconds: Vec<f64> = solved.iter().map(|r| r.seconds).collect();
        let (effort, time) = (median(&mut efforts), 1e3 * median(&mut seconds));
        format!("{count}, {}, {} ms", figures(effort, 4), figures(time, 2))
    }

    /// Writes `variants.md`, `variants.csv`, `variants.svg` and the page `report.html` into `folder`, which is created
    /// if necessary, and returns their paths.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
        let [report, results, picture, page] = Self::FILES;
        let contents = [
            (report, Ok(self.markdown())),
            (results, tables::variants(&self.results)),
            (picture, plot::actions(&self.settings.drawn, &self.paths)),
            (page, Ok(page::comparison(self)?.html()?)),
        ];
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
