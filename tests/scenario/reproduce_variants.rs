//! `aghf reproduce --variants`: the variants of the flow and the relaxation in one table.

use crate::command::{aghf, assert_bad_input, empty_folder, files};
use aghf::experiments::reproduce::{Comparison, VARIANTS, VariantSettings, compare};
use std::collections::BTreeSet;
use std::time::Duration;

fn settings(families: &[(&str, &[&str])], drawn: &str) -> VariantSettings {
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    VariantSettings {
        families: (families.iter())
            .map(|(title, all)| ((*title).to_owned(), names(all)))
            .collect(),
        time_limit: Duration::from_secs(100),
        drawn: drawn.to_owned(),
    }
}

fn cells<'t>(table: &'t str, family: &str) -> Vec<&'t str> {
    let start = format!("| {family} |");
    let row = table.lines().find(|line| line.starts_with(&start));
    row.expect(table)
        .trim_matches('|')
        .split('|')
        .map(str::trim)
        .collect()
}

#[test]
fn all_variants_are_in_the_table_the_rows_and_the_picture() {
    let families: [(&str, &[&str]); 3] = [
        ("swinging", &["pendulum_1_swingup", "pendulum_2_swingup"]),
        ("passive", &["cart_pole_swingup"]),
        ("in the way", &["kinova_gap_01"]),
    ];
    let mut heard = Vec::new();
    let drawn = settings(&families, "pendulum_1_swingup");
    let found = compare(&drawn, &mut |what| heard.push(what.to_owned())).expect("valid");
    let expected: Vec<(&str, &str)> = (families.iter())
        .flat_map(|(_, names)| names.iter())
        .flat_map(|name| VARIANTS.map(|variant| (*name, variant)))
        .filter(|pair| *pair != ("cart_pole_swingup", "published"))
        .collect();
    let results = || found.results.iter();
    let pairs: Vec<_> = results()
        .map(|r| (r.scenario.as_str(), r.variant))
        .collect();
    assert_eq!(pairs, expected);
    let told = expected
        .iter()
        .map(|(name, variant)| format!("{name}, {variant}"));
    assert_eq!(heard, told.collect::<Vec<_>>());

    // From the same guess, straight or along the flow, to the same effort.
    let effort = |variant| {
        let of =
            results().find(|r| (r.scenario.as_str(), r.variant) == ("pendulum_1_swingup", variant));
        of.expect("it was solved").effort
    };
    let relaxed = effort("relax");
    assert!((effort("duals") / relaxed - 1.0).abs() < 1e-6);
    assert!(effort("published") > 1.01 * relaxed, "it stalls");

    let table = found.markdown();
    assert_eq!(cells(&table, "family")[1..], VARIANTS);
    let [swinging, passive] = ["swinging", "passive"].map(|family| cells(&table, family));
    assert!(
        swinging[1..].iter().all(|cell| cell.starts_with("2/2, ")),
        "{table}"
    );
    assert_eq!(passive[1], "-");
    assert!(passive[3].starts_with("1/1, "), "{table}");
    // The line collides, and the published flow stays near it.
    let in_the_way = cells(&table, "in the way");
    assert_eq!(in_the_way[1], "0/1");
    assert!(in_the_way[3].starts_with("1/1, "), "{table}");
    // The median of two is their mean.
    let [one, two] = ["pendulum_1_swingup", "pendulum_2_swingup"].map(|name| {
        let of = results().find(|r| r.scenario == name && r.variant == "duals");
        of.expect("it was solved").effort
    });
    let shown: f64 = swinging[3]
        .split(", ")
        .nth(1)
        .and_then(|x| x.parse().ok())
        .expect("an effort");
    assert!((shown / (0.5 * (one + two)) - 1.0).abs() < 1e-3, "{shown}");

    let folder = empty_folder("reproduce_variants");
    let written = found.write(&folder).expect("writable");
    assert_eq!(written, Comparison::FILES.map(|name| folder.join(name)));
    let read = |name| std::fs::read_to_string(folder.join(name)).expect("it is there");
    assert_eq!(read("variants.md"), table);
    let text = read("variants.csv");
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let rows: Vec<_> = rows.records().map(|r| r.expect("all columns")).collect();
    assert_eq!(rows.len(), expected.len());
    for (row, result) in rows.iter().zip(results()) {
        assert_eq!(
            (&row[0], &row[1]),
            (result.scenario.as_str(), result.variant)
        );
        assert_eq!(row[3].parse(), Ok(result.effort));
        assert_eq!(row[6].parse(), Ok(result.steps));
        assert!(result.steps > 0);
    }

    // The ways of the flows, each of which goes down in the end.
    let drawn: Vec<_> = found.paths.iter().map(|path| path.variant).collect();
    assert_eq!(drawn, VARIANTS[..4]);
    for path in &found.paths {
        let (first, last) = (path.points.first(), path.points.last());
        assert!(
            last.expect("points").1 < first.expect("points").1,
            "{path:?}"
        );
    }
    let text = read("variants.svg");
    let picture = roxmltree::Document::parse(&text).expect("it is XML");
    let labels: BTreeSet<&str> = (picture.descendants().filter(|n| n.has_tag_name("text")))
        .filter_map(|n| n.text().map(str::trim))
        .collect();
    assert!(
        VARIANTS[..4].iter().all(|v| labels.contains(v)),
        "{labels:?}"
    );
    assert!(!labels.contains("relax"));
}

#[test]
fn families_are_built_in_and_what_is_drawn_is_one_of_their_scenarios() {
    let quick = VariantSettings::builtin(true, "").expect("there are some");
    let full = VariantSettings::builtin(false, "").expect("there are some");
    assert_eq!(
        (quick.drawn.as_str(), full.drawn.as_str()),
        ("kinova_free_01", "kinova_free_01")
    );
    assert!(quick.families.iter().all(|(_, names)| names.len() == 2));
    let counts: Vec<usize> = full.families.iter().map(|(_, names)| names.len()).collect();
    assert_eq!(counts, [5, 5, 5, 2, 10, 10, 10, 10, 5]);

    let nowhere = settings(&[("free", &["pendulum_1_swingup"])], "kinova_free_01");
    let refused = compare(&nowhere, &mut |_| {}).expect_err("it is not solved");
    assert_eq!(
        refused.to_string(),
        "settings: drawn: 'kinova_free_01' is none of the scenarios"
    );
    let folder = empty_folder("reproduce_variants_bad");
    for (arguments, words) in [
        ("--variants --only submarine", "settings: only: ; submarine"),
        ("--variants --seed 3", "--seed"),
    ] {
        let arguments: Vec<&str> = std::iter::once("reproduce")
            .chain(arguments.split(' '))
            .collect();
        assert_bad_input(&folder, &arguments, words);
    }
}

#[test]
fn the_command_prints_the_table_that_it_writes() {
    let folder = empty_folder("reproduce_variants_command");
    let arguments = ["reproduce", "--variants", "--quick", "--only", "pendulum_1"];
    let run = aghf(&folder, &arguments);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let to = folder.join("out/variants");
    assert_eq!(files(&to), Comparison::FILES.map(str::to_owned).into());
    let written = std::fs::read_to_string(to.join("variants.md"));
    assert_eq!(run.stdout, written.expect("it is there"));
    assert_eq!(cells(&run.stdout, "pendulums").len(), 1 + VARIANTS.len());
}
