//! Findings about what the reader of a URDF completed or left out.

use super::{Finding, Severity};
use aghf::urdf::LoadNote;

/// The findings of those notes that the elements do not show by themselves; one for all elements with the same words.
pub(super) fn of_notes(notes: &[LoadNote]) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for note in notes {
        let Some([condition, remedy]) = in_words(note) else {
            continue;
        };
        let (kind, name) = note.element();
        let same = |f: &&mut Finding| (&f.condition, &f.remedy) == (&condition, &remedy);
        match findings.iter_mut().find(same) {
            Some(finding) => finding.names.push(name.to_owned()),
            None => findings.push(Finding {
                severity: Severity::Note,
                kind,
                names: vec![name.to_owned()],
                condition,
                remedy,
            }),
        }
    }
    findings
}

/// The condition and the remedy of a note; `None` if the findings about elements have it.
fn in_words(note: &LoadNote) -> Option<[String; 2]> {
    let of_kind = |remedy: &str| Some([note.kind(), remedy.to_owned()]);
    match note {
        LoadNote::ImpossibleInertia { condition, .. } => Some([
            condition.clone(),
            "the inertia of the link in the file has to be changed; it is used as it is".to_owned(),
        ]),
        LoadNote::SoftLimits { limits, share, .. } => Some([
            format!("the soft limits {limits} of its safety controller are not kept"),
            match share {
                Some(share) => format!(
                    "\"enforced_limits\": {{\"position\": {share}}}, which keeps all joints within this share of their \
                     ranges"
                ),
                None => "lower and upper of its limit element in the file".to_owned(),
            },
        ]),
        LoadNote::HugeLimit { .. } => {
            of_kind("nothing is needed if there is none, otherwise the limit element in the file")
        }
        LoadNote::SeveralAxes { .. } => of_kind("a single axis element in the file"),
        LoadNote::PointMass { .. } => of_kind("an inertia element in the file, kg m^2"),
        LoadNote::NoExtent { .. } => {
            of_kind("nothing is needed if the link has no such shape, otherwise its size in the file")
        }
        LoadNote::UndeclaredPrefix { prefix } => {
            of_kind(&format!("nothing is needed; xmlns:{prefix}=\"...\" in the robot element declares it"))
        }
        LoadNote::BeforeDeclaration => of_kind("nothing is needed, or the file without them"),
        _ => None,
    }
}
