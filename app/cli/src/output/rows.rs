//! Rows of tables as comma-separated values.

use super::table::short;
use aghf::error::{Error, Result};
use aghf_scenario::{Details, Method, Preset, Summary};
use serde::Serialize;
use serde_json::Value;

/// Formats flat objects as comma-separated values, with their keys as a header if asked. Null is an empty cell, and so
/// is a number that is not finite.
///
/// # Errors
/// A row is no object.
pub fn csv_of<'r, T: Serialize + 'r>(rows: impl IntoIterator<Item = &'r T>, header: bool) -> Result<Vec<u8>> {
    let refuse = |e: String| Error::input("table", "row", format!("it is no CSV: {e}"));
    let mut csv = csv::Writer::from_writer(Vec::new());
    let mut first = header;
    for row in rows {
        let row = serde_json::to_value(row).map_err(|e| refuse(e.to_string()))?;
        let Value::Object(row) = row else {
            return Err(refuse(row.to_string()));
        };
        if std::mem::take(&mut first) {
            csv.write_record(row.keys()).map_err(|e| refuse(e.to_string()))?;
        }
        csv.write_record(row.values().map(csv_cell)).map_err(|e| refuse(e.to_string()))?;
    }
    csv.into_inner().map_err(|e| refuse(e.to_string()))
}

/// A value as a cell.
pub(crate) fn csv_cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A text without line breaks, because a row is one line of its file.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The quantity that a solve minimises: with least time the horizon, s.
pub(crate) fn minimised(summary: &Summary) -> f64 {
    match &summary.details {
        Details::Flow(flow) => flow.action,
        Details::Rest(rest) => rest.action,
        Details::Direct(direct) if is_least_time(summary) => direct.horizon_s,
        Details::Direct(direct) => direct.cost,
    }
}

fn is_least_time(summary: &Summary) -> bool {
    let objective = &summary.provenance.scenario.objective;
    summary.method == Method::Direct && objective.preset() == Some(Preset::LeastTime)
}

/// The minimised quantity, with the objective of a direct solve.
pub(crate) fn cost_of(summary: &Summary) -> String {
    let mut cost = short(minimised(summary));
    if is_least_time(summary) {
        cost += " s, the horizon";
    }
    let objective = serde_json::to_value(&summary.provenance.scenario.objective);
    let given = |(_, weight): &(&String, &Value)| weight.as_f64() != Some(0.0);
    let objective = match objective {
        Ok(Value::Object(terms)) if summary.method == Method::Direct => {
            let terms = terms.iter().filter(given);
            let terms = terms.map(|(term, weight)| format!("{term} {}", csv_cell(weight)));
            terms.collect::<Vec<_>>().join(", ")
        }
        Ok(Value::String(preset)) if summary.method == Method::Direct => preset,
        _ => return cost,
    };
    format!("{cost}; objective: {objective}")
}
