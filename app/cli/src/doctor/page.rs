//! The findings as text.

use super::{Diagnosis, Finding, LinkShape, Plannable, Severity, Shapes};
use crate::output::{short, table};
use comfy_table::CellAlignment;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Display, Write};

/// The number of names in a line.
const NAMED: usize = 4;

/// The findings as one page of text.
#[must_use]
pub fn page(diagnosis: &Diagnosis) -> String {
    let mut text = match diagnosis.plannable {
        Plannable::Yes => format!("{}: motions can be planned\n", diagnosis.robot),
        Plannable::WithKeys => format!("{}: motions can be planned with the keys below\n", diagnosis.robot),
        Plannable::No => format!("{}: motions cannot be planned with this file\n", diagnosis.robot),
    };
    let kinds: Vec<_> = (diagnosis.joints.iter()).map(|(kind, count)| format!("{count} {kind}")).collect();
    text += &format!("  joints: {}; links: {}", kinds.join(", "), diagnosis.links);
    if let Some(mass) = diagnosis.mass_kg {
        text += &format!("; {} kg moving", short(mass));
    }
    text += &format!("\n  kept clear by default: {}\n", diagnosis.kept_clear);
    for (severity, title) in
        [(Severity::Refused, "In the way"), (Severity::NeedsKey, "Needs a key"), (Severity::Note, "To know")]
    {
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

/// A finding in a line, and its remedy in the next.
fn in_words(finding: &Finding) -> String {
    let Finding { kind, names, condition, remedy, .. } = finding;
    let mut text = format!("  {}: {condition}\n", listed(kind, names));
    if !remedy.is_empty() {
        text += &format!("    remedy: {remedy}\n");
    }
    text
}

/// The first names of elements of a kind, and the number of the others.
fn listed(kind: &str, names: &[impl Display]) -> String {
    let shown = names.iter().take(NAMED);
    let mut shown: Vec<_> = shown.map(|name| format!("'{name}'")).collect();
    if let Some(more @ 1..) = names.len().checked_sub(NAMED) {
        shown.push(format!("{more} more"));
    }
    let plural = if names.len() > 1 { "s" } else { "" };
    format!("{kind}{plural} {}", shown.join(", "))
}

/// The table of the shapes, and the reasons why some cannot be read.
fn of_shapes(shapes: &Shapes) -> String {
    if shapes.shapes.is_empty() {
        return String::new();
    }
    let mut table = table();
    table.set_header(["link", "shapes", "pieces", "corners", "excess, mm"]);
    for of_link in shapes.shapes.chunk_by(|a, b| a.link == b.link) {
        table.add_row(row(of_link));
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let mut text = format!(
        "\nCollision shapes, {} convex pieces that extend beyond them by up to {:.1} mm\n{table}\n",
        shapes.pieces,
        1e3 * shapes.excess_m
    );
    let mut unread = BTreeMap::<&str, BTreeSet<&str>>::new();
    for shape in &shapes.shapes {
        if let Some(reason) = &shape.unread {
            unread.entry(reason).or_default().insert(&shape.shape);
        }
    }
    for (reason, files) in unread {
        let (count, files) = (files.len(), Vec::from_iter(files));
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {count} not read, {}: {reason}", listed("shape", &files));
    }
    text
}

/// The row of a link: the kinds of its shapes, and the names of its meshes without their folders.
fn row(shapes: &[LinkShape]) -> [String; 5] {
    let mut kinds: Vec<(String, usize)> = Vec::new();
    for shape in shapes {
        let name = if shape.mesh {
            format!("mesh {}", shape.shape.rsplit('/').next().unwrap_or_default())
        } else {
            shape.shape.clone()
        };
        match kinds.iter_mut().find(|(kind, _)| *kind == name) {
            Some((_, count)) => *count += 1,
            None => kinds.push((name, 1)),
        }
    }
    let kinds = kinds.into_iter().map(|(kind, count)| match count {
        1 => kind,
        _ => format!("{count} x {kind}"),
    });
    let unread = shapes.iter().filter(|shape| shape.unread.is_some()).count();
    let pieces: usize = shapes.iter().map(|shape| shape.pieces).sum();
    let excess = shapes.iter().map(|shape| shape.excess_m).fold(0.0, f64::max);
    [
        shapes[0].link.clone(),
        kinds.collect::<Vec<_>>().join(", "),
        match unread {
            0 => pieces.to_string(),
            unread => format!("{pieces}, {unread} not read"),
        },
        shapes.iter().map(|shape| shape.corners).sum::<usize>().to_string(),
        format!("{:.1}", 1e3 * excess),
    ]
}

/// The links that overlap in each state.
fn of_states(diagnosis: &Diagnosis) -> String {
    if diagnosis.shapes.pieces == 0 {
        return String::new();
    }
    let mut text = "\nOverlaps of links that are not always there, by the pieces\n".to_owned();
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
