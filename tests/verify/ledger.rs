//! The ledger: the pages in `proofs/` and the identities that are proved say the same of every numbered equation.

use aghf::verify::field::{identities, prove};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// One entry of a page.
#[derive(Default)]
struct Entry {
    page: PathBuf,
    functions: Vec<(String, PathBuf)>,
    identities: Vec<String>,
    verdict: String,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("proofs")
}

/// The entries of all pages by label: a heading of the second level with a verdict below it.
fn entries() -> BTreeMap<String, Entry> {
    let mut all = BTreeMap::new();
    for file in std::fs::read_dir(folder()).expect("the folder is there") {
        let page = file.expect("it can be listed").path();
        if page.extension().is_none_or(|e| e != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&page).expect("it can be read");
        for section in text.split("\n## ").skip(1) {
            let (label, body) = section.split_once('\n').unwrap_or((section, ""));
            let entry = entry(&page, body);
            if entry.verdict.is_empty() && entry.identities.is_empty() {
                continue;
            }
            let twice = all.insert(label.trim().to_owned(), entry).is_some();
            assert!(!twice, "{label} has two entries");
        }
    }
    all
}

fn entry(page: &Path, body: &str) -> Entry {
    let mut entry = Entry {
        page: page.to_owned(),
        ..Entry::default()
    };
    for line in body.lines() {
        if let Some(rest) = line.strip_prefix("- function: ") {
            let link = rest
                .strip_prefix("[`")
                .and_then(|r| r.split_once("`]("))
                .and_then(|(path, r)| Some((path.to_owned(), r.strip_suffix(')')?.to_owned())));
            let (path, file) =
                link.unwrap_or_else(|| panic!("{}: no link in '{line}'", page.display()));
            entry.functions.push((path, folder().join(file)));
        } else if let Some(rest) = line.strip_prefix("- identity: ") {
            entry.identities.push(rest.trim_matches('`').to_owned());
        } else if let Some(rest) = line.strip_prefix("- verdict: ") {
            rest.clone_into(&mut entry.verdict);
        }
    }
    entry
}

/// Every label of the supplement and every line of its algorithms.
fn required() -> Vec<String> {
    let a = (1..=4).map(|i| format!("A{i}"));
    let b = (5..=80).map(|i| format!("B{i}"));
    let line = |algorithm: &'static str, lines: u32| {
        (1..=lines).map(move |i| format!("Algorithm {algorithm} line {i}"))
    };
    a.chain(b)
        .chain(line("B1", 11))
        .chain(line("B2", 11))
        .chain(line("B3", 3))
        .collect()
}

#[test]
fn every_equation_and_every_line_has_an_entry() {
    let entries = entries();
    let missing: Vec<_> = required()
        .into_iter()
        .filter(|label| !entries.contains_key(label))
        .collect();
    assert!(missing.is_empty(), "without an entry: {missing:?}");
}

#[test]
fn every_entry_names_functions_that_exist() {
    for (label, entry) in entries() {
        assert!(!entry.functions.is_empty(), "{label} names no function");
        for (path, file) in entry.functions {
            let name = path.rsplit("::").next().expect("a path has a last part");
            let text = std::fs::read_to_string(&file)
                .unwrap_or_else(|e| panic!("{label}: {}: {e}", file.display()));
            let defined = ["fn ", "struct ", "trait "].iter().any(|kind| {
                text.match_indices(&format!("{kind}{name}"))
                    .any(|(at, found)| {
                        !text[at + found.len()..]
                            .starts_with(|c: char| c.is_alphanumeric() || c == '_')
                    })
            });
            assert!(
                defined,
                "{label}: {} does not define {name}",
                file.display()
            );
        }
    }
}

#[test]
fn every_entry_has_an_identity_and_every_identity_an_entry() {
    let proved: BTreeSet<String> = identities().iter().map(|i| i.label.to_owned()).collect();
    let mut named = BTreeSet::new();
    for (label, entry) in entries() {
        assert!(!entry.identities.is_empty(), "{label} names no identity");
        for identity in entry.identities {
            assert!(
                proved.contains(&identity),
                "{label}: there is no identity '{identity}'"
            );
            named.insert(identity);
        }
    }
    let silent: Vec<_> = proved.difference(&named).collect();
    assert!(silent.is_empty(), "proved but on no page: {silent:?}");
    assert_eq!(proved.len(), identities().len(), "a label is used twice");
}

#[test]
fn every_entry_has_a_verdict() {
    for (label, entry) in entries() {
        let known = [
            "holds as printed",
            "holds under this convention: ",
            "erratum: ",
            "definition",
        ];
        let good = known.iter().any(|v| entry.verdict.starts_with(v));
        assert!(
            good,
            "{label} on {}: '{}'",
            entry.page.display(),
            entry.verdict
        );
    }
}

/// The errata that the pages have are those in the one table of the front page, and no others.
#[test]
fn the_table_of_errata_is_complete() {
    let front = std::fs::read_to_string(folder().join("README.md")).expect("the front page");
    let table = front
        .split("\n## Errata")
        .nth(1)
        .expect("it has a table of errata");
    let table = table.split("\n## ").next().expect("split gives one part");
    for (label, entry) in entries() {
        let listed = table
            .lines()
            .any(|line| line.starts_with(&format!("| {label} |")));
        assert_eq!(
            listed,
            entry.verdict.starts_with("erratum: "),
            "{label}: {}",
            entry.verdict
        );
    }
}

/// All identities hold, at a point that `aghf prove` does not use by default.
#[test]
fn every_identity_holds() {
    let points =
        std::env::var("AGHF_POINTS").map_or(1, |n| n.parse().expect("AGHF_POINTS is a number"));
    for verdict in prove(points, 20_261_121).expect("the identities can be evaluated") {
        assert_eq!(verdict.failure, None);
        assert!(verdict.entries > 0, "{} compares nothing", verdict.label);
        assert!(verdict.bound < 1e-13);
    }
}
