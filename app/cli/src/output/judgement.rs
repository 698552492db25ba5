//! The table of a judgement.

use super::table::{short, table};
use aghf_scenario::judge::{Judgement, Outcome, Row, Verdict, Worst};

/// Formats a judgement as a table with one line per kind of check.
#[must_use]
pub fn judgement_table(judgement: &Judgement) -> String {
    let mut table = table();
    table.add_row(["check", "outcome", "worst", "bound", "at", "where"]);
    for row in &judgement.checks {
        let Row { note, .. } = row;
        let outcome = match row.outcome {
            Outcome::Pass => "pass",
            Outcome::Fail => "FAIL",
            Outcome::Undecided => "UNDECIDED",
            Outcome::NotChecked => "not checked",
            Outcome::NotApplicable => "-",
        };
        let note = note.clone().unwrap_or_default();
        let [worst, bound, at, place] = match &row.worst {
            None => [String::new(), String::new(), String::new(), note],
            Some(worst) => {
                let place = worst.place.clone().unwrap_or_default();
                [
                    format!("{} {}", short(worst.value), worst.unit),
                    bound(worst, row.tolerance),
                    format!("{:.4} s", worst.at_s),
                    [place, note].join(" ").trim().to_owned(),
                ]
            }
        };
        table.add_row([row.check.name(), outcome, &worst, &bound, &at, &place]);
    }
    let Judgement { samples, duration_s, between_samples, .. } = judgement;
    let text = format!(
        "{table}\n{}: {samples} samples over {} s; between them {between_samples}",
        judgement.scenario,
        short(*duration_s)
    );
    format!("{text}\n{}", verdict(judgement))
}

/// The verdict in words, with the worst row of a motion that is not valid, or the checks that are not made.
pub fn verdict(judgement: &Judgement) -> String {
    let Some(row) = judgement.worst() else {
        let rows = judgement.checks.iter();
        let left_out = rows.filter(|row| row.outcome == Outcome::NotChecked);
        let names: Vec<_> = left_out.map(|row| row.check.name()).collect();
        return match judgement.verdict {
            Verdict::ValidInPart => {
                format!("{}; not checked: {}", judgement.verdict, names.join(", "))
            }
            verdict => verdict.to_string(),
        };
    };
    let name = row.check.name();
    let undecided = match row.outcome {
        Outcome::Undecided => " undecided",
        _ => "",
    };
    let worst = row.worst.as_ref().map_or_else(String::new, |worst| {
        let (value, bound) = (short(worst.value), bound(worst, row.tolerance));
        let place = worst.place.as_deref().unwrap_or_default();
        let Worst { unit, at_s, .. } = worst;
        format!(": {place} has {value} {unit} at {at_s:.4} s, {bound} is accepted")
    });
    format!("{}: {name}{undecided}{worst}", judgement.verdict)
}

/// Formats a bound with its tolerance.
fn bound(worst: &Worst, tolerance: f64) -> String {
    let tolerance = short(tolerance);
    match (worst.at_least, worst.at_most) {
        (Some(least), Some(most)) if least == most => {
            format!("{} +- {tolerance}", short(least))
        }
        (Some(least), Some(most)) => {
            format!("{} to {} +- {tolerance}", short(least), short(most))
        }
        (Some(least), None) => format!("at least {} - {tolerance}", short(least)),
        (None, Some(most)) => format!("at most {} + {tolerance}", short(most)),
        (None, None) => String::new(),
    }
}
