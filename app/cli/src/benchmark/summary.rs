//! The summary of a benchmark.

use super::{End, Row};

/// The results of a family in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Its name.
    pub name: String,
    /// The number of problems.
    pub problems: usize,
    /// The number of problems with a valid motion.
    pub valid: usize,
    /// The number of problems that are known to be infeasible.
    pub impossible: usize,
    /// The number of optimal motions.
    pub optimal: usize,
    /// The median, the 90th and the 99th percentile and the largest of the solve times, s.
    pub seconds: [f64; 4],
    /// The median effort, N^2 m^2 s.
    pub effort: f64,
    /// The median duration, s.
    pub duration: f64,
    /// The least clearance, m.
    pub clearance: Option<f64>,
}

/// Summarises the rows of each family, in the order of their first rows, and of all together.
#[must_use]
pub fn families(rows: &[Row]) -> Vec<Family> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.family.as_str()) {
            names.push(&row.family);
        }
    }
    let of = |name: &&str| {
        let own = rows.iter().filter(|row| row.family == *name);
        family(name, own)
    };
    let mut found: Vec<_> = names.iter().map(of).collect();
    found.push(family("all", rows.iter()));
    found
}

fn family<'r>(name: &str, rows: impl Iterator<Item = &'r Row>) -> Family {
    let rows: Vec<&Row> = rows.collect();
    let valid: Vec<&&Row> = rows.iter().filter(|row| row.end.is_valid()).collect();
    let sorted = |value: &dyn Fn(&Row) -> Option<f64>| {
        let mut values: Vec<f64> = valid.iter().filter_map(|row| value(row)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let seconds = sorted(&|row| Some(row.solve_seconds));
    let clearances = valid.iter().filter_map(|row| row.least_clearance_m);
    Family {
        name: name.to_owned(),
        problems: rows.len(),
        valid: valid.len(),
        impossible: rows.iter().filter(|row| row.end == End::Impossible).count(),
        optimal: valid.iter().filter(|row| row.end == End::Optimal).count(),
        seconds: [0.5, 0.9, 0.99, 1.0].map(|share| percentile(&seconds, share)),
        effort: percentile(&sorted(&|row| row.control_effort), 0.5),
        duration: percentile(&sorted(&|row| row.duration_s), 0.5),
        clearance: clearances.reduce(f64::min),
    }
}

/// The least of ascending values that is at or above this fraction of them; NaN if there is none.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    let found = sorted.get(rank.saturating_sub(1));
    found.copied().unwrap_or(f64::NAN)
}

/// Formats the families as a table in Markdown.
#[must_use]
pub fn table(families: &[Family]) -> String {
    let mut text = String::from(
        "| family | problems | valid | no solution | optimal | median ms | 90 % | 99 % | worst | effort N²m²s | \
        duration s | least clearance mm |\n\
         | --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |\n",
    );
    for family in families {
        let [median, ninety, ninety_nine, worst] = family.seconds.map(|s| 1e3 * s);
        let clearance = family.clearance.map_or_else(String::new, |m| format!("{:.2}", 1e3 * m));
        text += &format!(
            "| {} | {} | {} | {} | {} | {median:.0} | {ninety:.0} | {ninety_nine:.0} | {worst:.0} | {:.0} | {:.2} | \
            {clearance} |\n",
            family.name,
            family.problems,
            family.valid,
            family.impossible,
            family.optimal,
            family.effort,
            family.duration,
        );
    }
    text
}
