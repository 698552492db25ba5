//! The pages of the experiments.

use super::{Comparison, Reproduction, Series, markdown, plot, tables};
use crate::report::{Part, Plot, Table, TablePage};
use aghf::error::{Error, Result};
use std::io;

/// Builds the page of a reproduction: the tables of its report, Figures 4 and 5, and the rows of its files.
pub(super) fn reproduction(of: &Reproduction) -> Result<TablePage> {
    let [_, _, solves, scaling, fits, ..] = Reproduction::FILES;
    let mut parts = Vec::new();
    if of.has_times() {
        parts.push(Part::Plots {
            title: "Times at a node".to_owned(),
            plots: vec![figure(4, &of.series)?, figure(5, &of.series)?],
        });
    }
    if !of.searches.is_empty() {
        parts.push(shown("Grid searches", &markdown::searches(&of.searches)));
        parts.push(note(markdown::SEARCHED));
    }
    if !of.systems.is_empty() {
        parts.push(shown("Solves by system", &markdown::solves(&of.systems)));
        parts.push(note(&markdown::solve_settings(of)));
        let results: Vec<_> = of.systems.iter().flat_map(|s| &s.results).collect();
        parts.push(Part::Table(Table::of_csv(
            "All solves",
            solves,
            csv(solves, tables::solves(&of.systems))?.as_bytes(),
            |i| results.get(i).is_some_and(|result| !result.success),
        )?));
    }
    if of.has_times() {
        parts.push(shown(
            "Times by number of joints, microseconds a call",
            &markdown::times(&of.series),
        ));
        parts.push(shown(
            "Growth with the number of joints",
            &markdown::fits(&of.series),
        ));
        parts.push(note(&markdown::time_settings(of)));
        let files = [
            ("Times of all robots", scaling, tables::scaling(of)),
            ("Coefficients of the fits", fits, tables::fits(&of.series)),
        ];
        for (title, file, text) in files {
            let text = csv(file, text)?;
            let table = Table::of_csv(title, file, text.as_bytes(), |_| false)?;
            parts.push(Part::Table(table));
        }
    }
    parts.push(note(&markdown::machine(of.seconds)));
    let results = || of.systems.iter().flat_map(|s| &s.results);
    let solved = results().filter(|result| result.success).count();
    Ok(TablePage {
        title: "The paper's experiments".to_owned(),
        about: "run anew".to_owned(),
        figures: vec![
            ["systems".to_owned(), of.systems.len().to_string()],
            [
                "solved".to_owned(),
                format!("{solved} of {}", results().count()),
            ],
        ],
        parts,
    })
}

/// Builds the page of a comparison of variants: its table, the action during the flows, and the rows of its file.
pub(super) fn comparison(of: &Comparison) -> Result<TablePage> {
    let [_, results, picture, _] = Comparison::FILES;
    let svg = plot::actions(&of.settings.drawn, &of.paths).map_err(|e| Error::io(picture, e))?;
    let drawn = Plot::Picture {
        title: format!("Action on the way, {}", of.settings.drawn),
        svg,
        circles: Vec::new(),
    };
    let rows = Table::of_csv(
        "All solves",
        results,
        csv(results, tables::variants(&of.results))?.as_bytes(),
        |i| of.results.get(i).is_some_and(|result| !result.success),
    )?;
    let solved = of.results.iter().filter(|result| result.success).count();
    Ok(TablePage {
        title: "Variants of the flow".to_owned(),
        about: "and the relaxation".to_owned(),
        figures: vec![[
            "solved".to_owned(),
            format!("{solved} of {}", of.results.len()),
        ]],
        parts: vec![
            shown(
                "Solved of tried, median effort and median time of those solved",
                &of.table(),
            ),
            Part::Plots {
                title: "Action on the way".to_owned(),
                plots: vec![drawn],
            },
            Part::Table(rows),
            note(&markdown::machine(of.seconds)),
        ],
    })
}

/// A figure in which each circle is the mean of a robot.
fn figure(number: usize, series: &[Series]) -> Result<Plot> {
    let svg = plot::figure(number, series);
    let svg = svg.map_err(|e| Error::io(format!("figure_{number}.svg"), e))?;
    let shown = series.iter().filter(|s| s.quantity.figure() == number);
    let circles = shown.flat_map(|series| {
        series.points.iter().map(|(robot, n, times)| {
            let [mean, deviation] = [times.mean, times.deviation].map(|x| 1e6 * x);
            let name = series.quantity.name();
            format!("{robot}, {n} joints\n{name}: {mean:.3} ± {deviation:.3} µs")
        })
    });
    Ok(Plot::Picture {
        title: format!("Figure {number}"),
        svg,
        circles: circles.collect(),
    })
}

fn shown(title: &str, table: &markdown::Table) -> Part {
    Part::Table(Table::new(title, &table.header, &table.rows))
}

fn note(text: &str) -> Part {
    Part::Note {
        text: text.trim_end().to_owned(),
    }
}

fn csv(file: &str, text: io::Result<String>) -> Result<String> {
    text.map_err(|e| Error::io(file, e))
}
