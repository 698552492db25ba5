//! A start from the motion of another solve.

use crate::results::summary::{DirectDetails, LastSearch, Verdict};
use crate::solve::search::Search;
use crate::{Details, DirectOptions, Preset, Solved};
use aghf::direct::{DirectSettings, FreeHorizon, Multipliers, SequenceOptions};
use aghf::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The share of the largest multiplier below which others are not written: those of rows far from their bounds, which
/// are of the order of the barrier parameter.
const MIN_SHARE: f64 = 1e-10;

/// The multipliers of the rows of a direct solve in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultipliersFile {
    /// The normalised times.
    times: Vec<f64>,
    /// The number of rows.
    rows: usize,
    /// Time, row and value of those that are not negligible.
    entries: Vec<(usize, usize, f64)>,
    /// Those of the rows of a goal.
    of_points: Vec<f64>,
}

impl MultipliersFile {
    pub(crate) fn new(multipliers: &Multipliers) -> Option<Self> {
        let entries = multipliers.entries(MIN_SHARE);
        let finite = |z: &f64| z.is_finite();
        (entries.iter().all(|(.., z)| finite(z)) && multipliers.of_points().iter().all(finite)).then(|| Self {
            times: multipliers.times().to_vec(),
            rows: multipliers.rows(),
            entries,
            of_points: multipliers.of_points().to_vec(),
        })
    }
}

impl From<FreeHorizon> for LastSearch {
    fn from(free: FreeHorizon) -> Self {
        Self { shortest_s: free.shortest, longest_s: free.longest, weight: free.weight }
    }
}

/// Makes a search begin with the motion of another solve, and with its multipliers if the number of rows is the same.
/// Returns a note that says whether the multipliers were kept.
///
/// # Errors
/// The motion is that of other joints, or a multiplier is wrong.
pub(crate) fn start_from(start: &Solved, options: &DirectOptions, search: &mut Search<'_, '_>) -> Result<String> {
    let name = &start.scenario.name;
    let motion = format!("start: the motion of '{name}'");
    (start.summary.curve).check_joints(&search.scenario.model, &motion)?;
    search.settings.start = Some(start.curve.clone());
    let rows = search.constraints.dim();
    let details = match &start.summary.details {
        Details::Direct(details) => Some(details),
        Details::Flow(_) | Details::Rest(_) => None,
    };
    let kept = match details.and_then(|details| details.multipliers.as_ref()) {
        Some(of) if of.rows == rows => {
            let known = Multipliers::of_entries(of.times.clone(), rows, &of.entries, of.of_points.clone());
            let known = known.map_err(|e| Error::input("start", "multipliers", e.to_string()))?;
            search.settings.multipliers = Some(known);
            search.settings.start_is_minimum = true;
            "with its multipliers"
        }
        Some(_) => "without its multipliers, as the constraints are others",
        None => "without multipliers, as it has none",
    };
    if let Some(details) = details {
        begin_at_the_last_search(start, details, options, search);
    }
    Ok(format!("start: the search began with the motion of '{name}', {kept}"))
}

/// Makes a search begin in the basis of a motion, if that is finer than its own, and with the last search that led to
/// the motion if the scenario is the same; in others with a weight of time as in the last search for the least time.
fn begin_at_the_last_search(
    start: &Solved,
    details: &DirectDetails,
    options: &DirectOptions,
    search: &mut Search<'_, '_>,
) {
    let (degree, segments) = (start.curve.degree(), start.curve.segments());
    let settings = &mut search.settings;
    let is_finer = degree >= settings.degree && segments >= settings.segments;
    if is_finer
        && options.degree.is_none()
        && options.segments.is_none()
        && degree * segments <= DirectSettings::MAX_SIZE
    {
        (settings.degree, settings.segments) = (degree, segments);
    }
    let Some(LastSearch { shortest_s: shortest, longest_s: longest, weight }) = details.last_search.clone() else {
        return;
    };
    let is_same = search.scenario.placed_file() == start.summary.provenance.scenario;
    if is_same && start.summary.verdict == Verdict::Optimal {
        search.last = Some(FreeHorizon { shortest, longest, weight });
    } else if matches!(search.scenario.file.objective.preset(), Some(Preset::LeastTime | Preset::Balanced)) {
        let density = details.cost / details.horizon_s;
        let faster = weight.max(SequenceOptions::default().time_share * density);
        search.first_weight = Some(faster);
        let multipliers = &mut search.settings.multipliers;
        *multipliers = multipliers.take().map(|known| known.reweighted(density, [weight, faster]));
    }
}
