//! Plots of the convergence of a search.

use super::data::iterations_of;
use super::plots::{Axes, Line, Plot, colours, css, plot};
use aghf::error::Result;
use aghf_scenario::{Record, SolveReport};
use plotters::style::RGBColor;

/// The lower limit of numbers on a logarithmic axis, for example of violations that are zero.
const MIN_SHOWN: f64 = 1e-12;

/// A named sequence of numbers by iteration.
struct Series {
    name: &'static str,
    points: Vec<(f64, f64)>,
}

/// Plots of cost, gradient norm and violation by iteration, or of the action of a flow.
pub(super) fn plots_of_search(outcome: &SolveReport) -> Result<Vec<Plot>> {
    let (mut costs, mut gradients, mut violations) = (Vec::new(), Vec::new(), Vec::new());
    let mut cost_name = "cost";
    for (i, record) in iterations_of(outcome).enumerate() {
        let i = i as f64;
        match record {
            Record::Direct(iteration) => {
                costs.push((i, iteration.cost));
                gradients.push((i, iteration.gradient_norm));
                violations.push((i, iteration.violation));
            }
            Record::Rest(record) => {
                cost_name = "action";
                costs.push((i, record.action));
                gradients.push((i, record.gradient_norm));
            }
            Record::Flow(record) => {
                cost_name = "action";
                costs.push((i, record.action_at_nodes));
            }
        }
    }
    if violations.iter().all(|(_, violation)| *violation == 0.0) {
        violations.clear();
    }
    let what = match outcome.history.first() {
        Some(Record::Flow(_)) => "Action, by record",
        Some(Record::Rest(_)) => "Action, by step",
        _ => "Cost, by iteration",
    };
    let colours = colours(3);
    let mut plots = Vec::new();
    let cost = Series { name: cost_name, points: costs };
    plots.extend(logarithmic(what, vec![(cost, colours[0])])?);
    let norms = vec![
        (Series { name: "gradient norm", points: gradients }, colours[1]),
        (Series { name: "largest violation", points: violations }, colours[2]),
    ];
    plots.extend(logarithmic("Convergence", norms)?);
    Ok(plots)
}

/// A plot with a logarithmic axis; `None` with fewer than two points.
fn logarithmic(title: &str, series: Vec<(Series, RGBColor)>) -> Result<Option<Plot>> {
    let (mut lines, mut legend) = (Vec::new(), Vec::new());
    for (Series { name, points }, colour) in series {
        let points = points.into_iter().filter(|(_, y)| y.is_finite());
        let points: Vec<_> = points.map(|(x, y)| (x, y.max(MIN_SHOWN).log10())).collect();
        if points.len() > 1 {
            legend.push([name.to_owned(), css(colour)]);
            lines.push(Line { points, colour, bounds: f64::NEG_INFINITY..f64::INFINITY });
        }
    }
    if lines.is_empty() {
        return Ok(None);
    }
    let axes = Axes { title: title.to_owned(), unit: "", time: false, logarithmic: true, per_joint: false, legend };
    plot(axes, &lines).map(Some)
}
