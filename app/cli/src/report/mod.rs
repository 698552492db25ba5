//! Reports as self-contained HTML pages. The page of a motion shows the moving robot with plots; others have tables and
//! plots.
//!
//! Kinematics, clearances and plots of a motion are computed here; the page, `page/`, holds arrays, a renderer and a
//! clock. The data of a page are JSON in which `<` is written as an escape, and its script inserts names only as text,
//! so that a name cannot be interpreted as markup.

mod convergence;
mod data;
mod encode;
mod facts;
mod foot;
mod links;
mod mesh;
mod plots;
mod scene;
mod tables;
mod track;
mod tradeoff;

pub use data::Motion;
pub use tables::{Bar, Group, Part, Plot, Scatter, Table, TablePage};
pub use tradeoff::tradeoff_page;

use crate::output::write_text;
use aghf::error::Result;
use data::MotionData;
use serde::Serialize;
use std::path::Path;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = concat!(include_str!("page/style.css"), include_str!("page/tables.css"));
/// The parts of the script, each of which uses only those before it.
const SCRIPT: [&str; 9] = [
    include_str!("page/elements.js"),
    include_str!("page/numbers.js"),
    include_str!("page/solids.js"),
    include_str!("page/shaders.js"),
    include_str!("page/renderer.js"),
    include_str!("page/view.js"),
    include_str!("page/plots.js"),
    include_str!("page/panels.js"),
    include_str!("page/main.js"),
];

/// Builds the page of one or several motions side by side in time.
///
/// # Errors
/// A curve has another number of joints than its scenario, or the shape of the robot cannot be covered.
pub fn page(motions: &[Motion<'_>]) -> Result<String> {
    let data: Vec<MotionData> = motions.iter().map(MotionData::new).collect::<Result<_>>()?;
    let names: Vec<&str> = motions.iter().map(|m| m.scenario.name.as_str()).collect();
    filled(&data, &SCRIPT, &escaped(&names.join(" and ")))
}

/// Builds a page from these data, this script and a title, which is escaped.
fn filled(data: &impl Serialize, script: &[&str], title: &str) -> Result<String> {
    let json = serde_json::to_string(data).map_err(|e| aghf::error::Error::input("report", "data", e.to_string()))?;
    // Each placeholder is replaced once; user data come last, so that placeholders inside them are not expanded.
    let parts = [
        ("/* STYLE */", STYLE),
        ("/* SCRIPT */", &script.concat()),
        ("{{DATA}}", &json.replace('<', "\\u003c")),
        ("{{TITLE}}", title),
    ];
    let fill = |page: String, (place, part): (&str, &str)| page.replacen(place, part, 1);
    Ok(parts.into_iter().fold(PAGE.to_owned(), fill))
}

/// Writes the page of motions to the file at `path`.
///
/// # Errors
/// Those of [`page`], or the file cannot be written.
pub fn write_page(motions: &[Motion<'_>], path: &Path) -> Result<()> {
    write_text(&page(motions)?, path)
}

/// Escapes text for an element of HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
