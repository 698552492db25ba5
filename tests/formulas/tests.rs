//! Every formula in the sources parses, and pages are rendered correctly.

use crate::html::with_mathml;
use crate::math::mathml;
use crate::proofs::page;
use crate::{files, read, root};

/// The prose of a Rust file: its doc comments, with an empty line in place of code.
fn doc_comments(source: &str) -> String {
    let prose = source.lines().map(|line| {
        let line = line.trim_start();
        let comment = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
        comment.map_or("", |text| text.strip_prefix(' ').unwrap_or(text))
    });
    prose.collect::<Vec<_>>().join("\n")
}

/// The prose as HTML by Markdown without formulas, as in rustdoc.
fn as_rustdoc_does(markdown: &str) -> String {
    let mut html = String::new();
    pulldown_cmark::html::push_html(&mut html, pulldown_cmark::Parser::new(markdown));
    html
}

#[test]
fn every_formula_of_the_documentation_parses() {
    let (mut formulas, mut faults) = (0, Vec::new());
    let sources = ["rs", "md"].map(|kind| files(&root().join("src"), kind).expect("it is there"));
    for path in sources.concat() {
        let mut prose = read(&path).expect("it is text");
        if path.extension().is_some_and(|kind| kind == "rs") {
            prose = doc_comments(&prose);
        }
        let found = with_mathml(&as_rustdoc_does(&prose));
        formulas += found.formulas;
        let lost = lost_backslashes(&prose).chain(broken_rows(&prose));
        let own = found.faults.into_iter().chain(lost.map(str::to_owned));
        faults.extend(own.map(|fault| format!("{}: {fault}", path.display())));
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
    assert!(formulas > 500, "{formulas} formulas");
}

/// Lines with a single backslash before punctuation, which Markdown removes.
fn lost_backslashes(prose: &str) -> impl Iterator<Item = &str> {
    prose.lines().filter(|line| {
        let mut characters = line.chars().peekable();
        let mut in_formula = false;
        while let Some(c) = characters.next() {
            match c {
                '$' => in_formula = !in_formula,
                '\\' if in_formula => match characters.peek() {
                    // An escape against emphasis in Markdown should be removed.
                    Some('\\' | '_' | '*') => {
                        characters.next();
                    }
                    Some(next) if next.is_ascii_punctuation() => return true,
                    _ => {}
                },
                _ => {}
            }
        }
        false
    })
}

/// Table rows that continue on the next line, where Markdown ends the table.
fn broken_rows(prose: &str) -> impl Iterator<Item = &str> {
    let mut in_code = false;
    prose.lines().filter(move |line| {
        in_code ^= line.starts_with("```");
        !in_code && line.starts_with("| ") && !line.trim_end().ends_with('|')
    })
}

#[test]
fn every_formula_of_the_proofs_parses() {
    let mut formulas = 0;
    for path in files(&root().join("proofs"), "md").expect("it is there") {
        let page = page(&read(&path).expect("it is text"));
        assert!(page.faults.is_empty(), "{}: {:#?}", path.display(), page.faults);
        formulas += page.formulas;
    }
    assert!(formulas > 100, "{formulas} formulas");
}

#[test]
fn formulas_in_prose_are_rendered_and_code_is_not() {
    let page = "<p>Of $x &lt; \\frac12$ and <code>$y$</code>: $$\\sum_i q_i’$$</p><script>a = '$b$ < $c$';</script>";
    let found = with_mathml(page);
    assert_eq!((found.formulas, found.faults.len()), (2, 0));
    assert!(found.text.contains("<math"), "{}", found.text);
    assert!(found.text.contains("<mfrac>") && found.text.contains("display=\"block\""), "{}", found.text);
    assert!(found.text.contains("<code>$y$</code>") && found.text.contains("'$b$ < $c$'"));
    assert_eq!(with_mathml(&found.text).formulas, 0, "a page is rendered once");
}

#[test]
fn what_does_not_parse_is_a_fault_that_names_it() {
    for bad in ["<p>$\\frac{1}$</p>", "<p>$a {b$</p>", "<p>costs 5 $ a piece</p>", "<p>$\\nosuchthing$</p>"] {
        let found = with_mathml(bad);
        assert_eq!(found.faults.len(), 1, "{bad}");
        assert_eq!((found.formulas, found.text.as_str()), (0, bad));
    }
    assert!(mathml("x^2_i", false).is_ok());
    let fault = page("# P\n\n$$\\left( a$$\n").faults;
    assert!(fault.len() == 1 && fault[0].contains("\\left( a"), "{fault:?}");
}

#[test]
fn links_of_a_page_lead_to_pages_and_sources() {
    let page = page("# P\n\n[a](theorem_b4.md#b6) [b](README.md) [c](../src/flow/mod.rs) [d](https://example.org/x)\n");
    for link in ["theorem_b4.html#b6", "index.html", "../src/aghf/flow/mod.rs.html", "https://example.org/x"] {
        assert!(page.text.contains(&format!("href=\"{link}\"")), "{link} in {}", page.text);
    }
}
