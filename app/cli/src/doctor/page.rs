//! The findings as text.

use super::{Diagnosis, Finding, Plannable, Severity, Shapes};
use crate::output::{short, table};
use comfy_table::CellAlignment;
use std::fmt::Write;

/// The number of names in a line.
const NAMED: usize = 4;

/// The findings as one page of text.
#[must_use]
pub fn page(diagnosis: &Diagnosis) -> String {
    let mut text = match diagnosis.plannable {
        Plannable::Yes => format!("{}: motions can be planned\n", diagnosis.robot),
        Plannable::WithKeys => format!(
            "{}: motions can be planned with the keys below\n",
            diagnosis.robot
        ),
        Plannable::No => format!(
            "{}: motions cannot be planned with this file\n",
            diagnosis.robot
        ),
    };
    let kinds: Vec<_> = (diagnosis.joints.iter())
        .map(|(kind, count)| format!("{count} {kind}"))
        .collect();
    text += &format!("  joints: {}; links: {}", kinds.join(", "), diagnosis.links);
    if let Some(mass) = diagnosis.mass_kg {
        text += &format!("; {} kg moving", short(mass));
    }
    text.push('\n');
    for (severity, title) in [
        (Severity::Refused, "In the way"),
        (Severity::NeedsKey, "Needs a key"),
        (Severity::Note, "To know"),
    ] {
        let of_severity = |finding: &&Finding| finding.severity == severity;
        let findings: Vec<_> = diagnosis.findings.iter().filter(of_severity).collect();
        if !findings.is_empty() {
            text += &format!("\n{title}\n");
        }
        for finding in findings {
            text += &in_words(finding);
        }
    }
    text += &of_shapes(&diagnosis.shapes);
    text += &of_states(diagnosis);
    text.trim_end().to_owned()
}

/// A finding in a line, and what mends it in the next.
fn in_words(finding: &Finding) -> String {
    let Finding {
        kind,
        names,
        condition,
        mend,
        ..
    } = finding;
    let mut shown: Vec<_> = names
        .iter()
        .take(NAMED)
        .map(|name| format!("'{name}'"))
        .collect();
    if let Some(more @ 1..) = names.len().checked_sub(NAMED) {
        shown.push(format!("{more} more"));
    }
    let mut text = format!("  {kind} {}: {condition}\n", shown.join(", "));
    if !mend.is_empty() {
        text += &format!("    mend: {mend}\n");
    }
    text
}

/// The table of the shapes, and the reasons why some cannot be read.
fn of_shapes(shapes: &Shapes) -> String {
    if shapes.shapes.is_empty() {
        return String::new();
    }
    let mut table = table();
    table.set_header(["link", "shape", "balls", "excess, mm"]);
    for shape in &shapes.shapes {
        let (balls, excess) = match &shape.unread {
            None => (
                shape.balls.to_string(),
                format!("{:.1}", 1e3 * shape.excess_m),
            ),
            Some(_) => ("not read".to_owned(), String::new()),
        };
        table.add_row([shape.link.clone(), shape.shape.clone(), balls, excess]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = format!(
        "\nCollision shapes, {} balls that extend beyond them by up to {:.1} mm\n{table}\n",
        shapes.balls,
        1e3 * shapes.excess_m
    );
    for reason in shapes
        .shapes
        .iter()
        .filter_map(|shape| shape.unread.as_ref())
    {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {reason}");
    }
    text
}

/// The links that overlap in each state.
fn of_states(diagnosis: &Diagnosis) -> String {
    if diagnosis.shapes.balls == 0 {
        return String::new();
    }
    let mut text = "\nOverlaps of links that are not always there, by the balls\n".to_owned();
    for state in &diagnosis.states {
        let contacts = state.contacts.iter().map(|contact| {
            let [a, b] = &contact.links;
            let [depth, excess] = [contact.depth_m, contact.excess_m].map(|x| 1e3 * x);
            format!("{a} and {b} by {depth:.1} mm (excess {excess:.1} mm)")
        });
        let contacts: Vec<_> = contacts.collect();
        let words = match contacts.as_slice() {
            [] => "none".to_owned(),
            contacts => contacts.join(", "),
        };
        text += &format!("  {}: {words}\n", state.name);
    }
    text
}
