//! The ledger: the pages in `proofs/` and the proved identities agree on every numbered equation.

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
    let mut entry = Entry { page: page.to_owned(), ..Entry::default() };
    for line in body.lines() {
        if let Some(rest) = line.strip_prefix("- function: ") {
            let link = rest
                .strip_prefix("[`")
                .and_then(|r| r.split_once("`]("))
                .and_then(|(path, r)| Some((path.to_owned(), r.strip_suffix(')')?.to_owned())));
            let (path, file) = link.unwrap_or_else(|| panic!("{}: no link in '{line}'", page.display()));
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
    let line =
        |algorithm: &'static str, lines: u32| (1..=lines).map(move |i| format!("Algorithm {algorithm} line {i}"));
    a.chain(b).chain(line("B1", 11)).chain(line("B2", 11)).chain(line("B3", 3)).collect()
}

#[test]
fn every_equation_and_every_line_has_an_entry() {
    let entries = entries();
    let missing: Vec<_> = required().into_iter().filter(|label| !entries.contains_key(label)).collect();
    assert!(missing.is_empty(), "without an entry: {missing:?}");
}

/// Returns true if `text` has the word `name` directly after one of `keywords`.
fn has(text: &str, keywords: &[&str], name: &str) -> bool {
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    keywords.iter().any(|keyword| {
        let words = format!("{keyword} {name}");
        let mut found = text.match_indices(&words);
        found.any(|(at, words)| ends(&text[at + words.len()..]))
    })
}

/// The items of a formatted file: each begins in the first column, unlike its body.
fn items(text: &str) -> Vec<String> {
    let mut items = Vec::<String>::new();
    for line in text.lines() {
        let inside = line.starts_with([' ', '{', '}', ')', '>']) || line.starts_with("where");
        match items.last_mut() {
            Some(item) if inside || line.is_empty() => item.extend([line, "\n"]),
            _ => items.push(format!("{line}\n")),
        }
    }
    items
}

/// Returns true if an item is an `impl` for a type, or the definition of a trait.
fn is_of(item: &str, owner: &str) -> bool {
    let header = item.split('{').next().unwrap_or_default();
    if !header.starts_with("impl") {
        return has(header, &["trait"], owner);
    }
    // The type follows the generic parameters and the trait, and may have parameters of its own.
    let mut depth = 0;
    let header: String = (header["impl".len()..].replace("->", "").chars())
        .filter(|c| {
            depth += i32::from(*c == '<');
            let outside = depth == 0;
            depth -= i32::from(*c == '>');
            outside
        })
        .collect();
    let owned = header.split(" for ").last().unwrap_or_default();
    owned.split_whitespace().next() == Some(owner)
}

/// Checks that a file with this text, at `file` under the root, contains the item of `path`: `aghf::module::function`,
/// `aghf::module::Type` or `aghf::module::Type::function`.
fn holds(text: &str, file: &str, path: &str) -> Result<(), String> {
    let parts: Vec<&str> = path.split("::").collect();
    let is_type = |part: &&str| part.starts_with(char::is_uppercase);
    let names = parts.iter().position(is_type).unwrap_or(parts.len() - 1);
    let (modules, names) = parts.split_at(names);
    let folder = format!("src/{}", modules[1..].join("/"));
    if modules[0] != "aghf" || !file.starts_with(&folder) {
        return Err(format!("{file} is not in {folder}"));
    }
    let items = items(text);
    let defined = |kinds: &[&str], name| {
        items.iter().any(|item| {
            let item = item.trim_start_matches("pub(crate) ");
            let header = item.split(['{', '(', ';']).next().unwrap_or_default();
            !header.starts_with("//") && has(header, kinds, name)
        })
    };
    match names {
        [name] if is_type(name) => defined(&["struct", "enum", "trait"], name),
        [name] => defined(&["fn"], name),
        [owner, name] => items.iter().any(|i| is_of(i, owner) && has(i, &["fn"], name)),
        _ => false,
    }
    .then_some(())
    .ok_or_else(|| format!("{file} does not define {}", names.join("::")))
}

#[test]
fn every_entry_names_functions_that_exist() {
    let root = folder().join("..").canonicalize().expect("it is there");
    for (label, entry) in entries() {
        assert!(!entry.functions.is_empty(), "{label} names no function");
        for (path, file) in entry.functions {
            let file = file.canonicalize().unwrap_or_else(|e| panic!("{label}: {}: {e}", file.display()));
            let text = std::fs::read_to_string(&file).expect("it can be read");
            let file = file.strip_prefix(&root).expect("it is in the repository");
            holds(&text, &file.to_string_lossy(), &path).unwrap_or_else(|e| panic!("{label}: {e}"));
        }
    }
}

/// A link is accepted only with a completely correct path.
#[test]
fn a_stale_link_is_found() {
    let text = "pub fn free<S>(x: S) {\n    fn inner() {}\n}\n\npub struct Square<S> {\n    x: S,\n}\n
impl<C, S: Over<C>> Cost<S> for Square<S>\nwhere\n    S: Copy,\n{\n    fn value(&self) {}\n}\n
impl Other {\n    fn derivatives(&self) -> Square<f64> {}\n}\n\npub trait Cost<S> {\n    fn value(&self);\n}\n";
    let good = |path| holds(text, "src/direct/cost.rs", path).is_ok();
    for path in [
        "aghf::direct::free",
        "aghf::direct::Square",
        "aghf::direct::cost::Square::value",
        "aghf::direct::Cost::value",
        "aghf::direct::Other::derivatives",
    ] {
        assert!(good(path), "{path}");
    }
    for path in [
        "aghf::direct::inner",
        "aghf::direct::fre",
        "aghf::direct::value",
        "aghf::flow::free",
        "aghf::direct::Square::derivatives",
        "aghf::direct::Cost::derivatives",
        "aghf::direct::Squar::value",
        "other::direct::free",
    ] {
        assert!(!good(path), "{path}");
    }
}

#[test]
fn every_entry_has_an_identity_and_every_identity_an_entry() {
    let proved: BTreeSet<String> = identities().iter().map(|i| i.label.to_owned()).collect();
    let mut named = BTreeSet::new();
    for (label, entry) in entries() {
        assert!(!entry.identities.is_empty(), "{label} names no identity");
        for identity in entry.identities {
            assert!(proved.contains(&identity), "{label}: there is no identity '{identity}'");
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
        let known = ["holds as printed", "holds under this convention: ", "erratum: ", "definition"];
        let good = known.iter().any(|v| entry.verdict.starts_with(v));
        assert!(good, "{label} on {}: '{}'", entry.page.display(), entry.verdict);
    }
}

/// The errata of the pages are exactly those in the table of the front page.
#[test]
fn the_table_of_errata_is_complete() {
    let front = std::fs::read_to_string(folder().join("README.md")).expect("the front page");
    let table = front.split("\n## Errata").nth(1).expect("it has a table of errata");
    let table = table.split("\n## ").next().expect("split gives one part");
    for (label, entry) in entries() {
        let listed = table.lines().any(|line| line.starts_with(&format!("| {label} |")));
        assert_eq!(listed, entry.verdict.starts_with("erratum: "), "{label}: {}", entry.verdict);
    }
}

/// All identities hold, at a point that `aghf prove` does not use by default.
#[test]
fn every_identity_holds() {
    let points = std::env::var("AGHF_POINTS").map_or(1, |n| n.parse().expect("AGHF_POINTS is a number"));
    for verdict in prove(points, 20_261_121).expect("the identities can be evaluated") {
        assert_eq!(verdict.failure, None);
        assert!(verdict.entries > 0, "{} compares nothing", verdict.label);
        assert!(verdict.bound < 1e-13);
    }
}
