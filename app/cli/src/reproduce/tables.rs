//! The measurements as comma-separated values, for other programs.

use super::{Reproduction, Series, SystemResult, VariantResult};
use aghf_scenario::Limit;
use std::io::{Error, Result};

/// Formats a table as comma-separated values.
fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Result<String> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(header)?;
    for row in rows {
        csv.write_record(row)?;
    }
    let bytes = csv.into_inner().map_err(|e| Error::other(e.to_string()))?;
    String::from_utf8(bytes).map_err(Error::other)
}

/// All digits of a number; empty for `None`.
fn all(x: impl Into<Option<f64>>) -> String {
    x.into().map_or_else(String::new, |x| format!("{x:?}"))
}

/// One row per solve.
pub(super) fn solves(systems: &[SystemResult]) -> Result<String> {
    let header = [
        "system",
        "set",
        "scenario",
        "p",
        "k",
        "s_max",
        "guess",
        "k_cons",
        "c_cons",
        "tolerance",
        "horizon_s",
        "kp",
        "kv",
        "success_threshold",
        "success",
        "failure",
        "solve_s",
        "control_effort",
        "action",
        "open_loop_error_inf",
        "final_error_inf",
        "smallest_clearance_m",
        "joints_beyond_position",
        "joints_beyond_velocity",
        "joints_beyond_torque",
    ];
    let rows = systems.iter().flat_map(|system| {
        system.results.iter().map(|r| {
            let flow = r.file.flow;
            let constrained = r.constrained();
            let beyond = |limit| r.joints_beyond(limit).to_string();
            vec![
                system.system.title.to_owned(),
                system.origins(),
                r.scenario.clone(),
                flow.p.to_string(),
                all(flow.k),
                all(flow.s_max),
                flow.guess.to_string(),
                all(constrained.then_some(flow.k_cons)),
                all(constrained.then_some(flow.c_cons)),
                all(r.tolerance),
                all(r.file.horizon_s),
                all(r.file.feedback.kp),
                all(r.file.feedback.kv),
                all(r.file.success_threshold),
                r.success.to_string(),
                r.failure.clone().unwrap_or_default(),
                all(r.solve_seconds),
                all(r.effort),
                all(r.action),
                all(r.open_loop_error),
                all(r.feedback_error),
                all(r.feasibility.smallest_clearance_m),
                beyond(Limit::Position),
                beyond(Limit::Velocity),
                beyond(Limit::Torque),
            ]
        })
    });
    table(&header, rows)
}

/// One row per quantity and robot.
pub(super) fn scaling(reproduction: &Reproduction) -> Result<String> {
    let header = [
        "figure",
        "quantity",
        "robot",
        "n",
        "configurations",
        "mean_us",
        "deviation_us",
        "median_us",
    ];
    let rows = reproduction.series.iter().flat_map(|series| {
        series.points.iter().map(|(robot, n, times)| {
            vec![
                series.quantity.figure().to_string(),
                series.quantity.name().to_owned(),
                robot.clone(),
                n.to_string(),
                reproduction.settings.configurations.to_string(),
                all(1e6 * times.mean),
                all(1e6 * times.deviation),
                all(1e6 * times.median),
            ]
        })
    });
    table(&header, rows)
}

/// One row per quantity; undetermined values are empty.
pub(super) fn fits(series: &[Series]) -> Result<String> {
    let header = [
        "figure",
        "quantity",
        "c0_us",
        "c1_us",
        "c2_us",
        "c3_us",
        "c4_us",
        "factor_us",
        "exponent",
    ];
    let rows = series.iter().map(|series| {
        let coefficients = series.polynomial().unwrap_or_default();
        let power = series.power_law();
        let numbers = (0..5).map(|j| coefficients.get(j).copied());
        let numbers = numbers.chain([power.map(|p| p.0), power.map(|p| p.1)]);
        [
            series.quantity.figure().to_string(),
            series.quantity.name().to_owned(),
        ]
        .into_iter()
        .chain(numbers.map(all))
        .collect()
    });
    table(&header, rows)
}

/// One row per scenario and variant.
pub(super) fn variants(results: &[VariantResult]) -> Result<String> {
    let header = [
        "scenario",
        "variant",
        "success",
        "control_effort",
        "final_error_inf",
        "solve_s",
        "steps",
        "failure",
    ];
    let rows = results.iter().map(|r| {
        vec![
            r.scenario.clone(),
            r.variant.to_owned(),
            r.success.to_string(),
            all(r.effort),
            all(r.final_error),
            all(r.seconds),
            r.steps.to_string(),
            r.failure.clone().unwrap_or_default(),
        ]
    });
    table(&header, rows)
}
