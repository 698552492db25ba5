//! A start from the motion of another solve.

use crate::solve::search::Search;
use crate::{Details, Solved};
use aghf::direct::Multipliers;
use aghf::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The share of the largest multiplier below which others are not written: those of rows far from their bounds, which
/// are of the order of the barrier parameter.
const MIN_SHARE: f64 = 1e-7;

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

/// Makes a search begin with the motion of another solve, and with its multipliers if the number of rows is the same.
/// Returns a note that says whether the multipliers were kept.
///
/// # Errors
/// The motion is that of other joints, or a multiplier is wrong.
pub(crate) fn start_from(start: &Solved, search: &mut Search<'_, '_>) -> Result<String> {
    let name = &start.scenario.name;
    let motion = format!("start: the motion of '{name}'");
    (start.summary.curve).check_joints(&search.scenario.model, &motion)?;
    search.settings.start = Some(start.curve.clone());
    let rows = search.constraints.dim();
    let known = match &start.summary.details {
        Details::Direct(details) => details.multipliers.as_ref(),
        Details::Flow(_) | Details::Rest(_) => None,
    };
    let kept = match known {
        Some(of) if of.rows == rows => {
            let times = of.times.clone();
            let known = Multipliers::of_entries(times, rows, &of.entries, of.of_points.clone());
            search.settings.multipliers = Some(known.map_err(|e| Error::input("start", "multipliers", e.to_string()))?);
            "with its multipliers"
        }
        Some(_) => "without its multipliers, as the constraints are others",
        None => "without multipliers, as it has none",
    };
    Ok(format!("start: the search began with the motion of '{name}', {kept}"))
}
