//! Formulas in pages written by rustdoc.

use crate::math::mathml;

/// A page with its formulas rendered.
#[derive(Debug, Default)]
pub struct Rendered {
    /// The page.
    pub text: String,
    /// The number of formulas.
    pub formulas: usize,
    /// The faults of the formulas that were left as they are.
    pub faults: Vec<String>,
}

/// Elements with text that is not prose.
const RAW: [&str; 6] = ["code", "pre", "script", "style", "title", "math"];

/// Padding for parts above and below the line, which would get a scroll bar in rustdoc's style, and fonts with
/// stretchable brackets.
const STYLE: &str = "<style>math { font-family: \"Latin Modern Math\", \"STIX Two Math\", \"Cambria Math\", math; } \
    .docblock p:has(math), .docblock li:has(math), .item-table :has(math) { overflow-y: hidden; \
        padding-block: 0.2em; } \
    math[display=block] { margin-block: 0.5em; padding-block: 0.3em; }</style>";

/// Renders the formulas between dollars in the prose of a page as MathML.
pub fn with_mathml(page: &str) -> Rendered {
    let mut out = Rendered::default();
    let mut rest = page;
    // The element of [`RAW`] that is open.
    let mut raw: Option<&str> = None;
    while !rest.is_empty() {
        let (text, tag_on) = rest.split_at(rest.find('<').unwrap_or(rest.len()));
        match raw {
            Some(_) => out.text += text,
            None => prose(text, &mut out),
        }
        let (tag, after) = tag_on.split_at(tag_on.find('>').map_or(tag_on.len(), |end| end + 1));
        let name = |tag: &str, prefix: &str| {
            let inside = tag.strip_prefix(prefix)?;
            let end = inside.find(|c: char| !c.is_ascii_alphanumeric())?;
            RAW.into_iter().find(|raw| *raw == &inside[..end])
        };
        match raw {
            None => raw = name(tag, "<"),
            Some(open) if name(tag, "</") == Some(open) => raw = None,
            Some(_) => {}
        }
        if tag == "</head>" {
            out.text += STYLE;
        }
        out.text += tag;
        rest = after;
    }
    out
}

/// Renders text without tags.
fn prose(text: &str, out: &mut Rendered) {
    let mut rest = text;
    while let Some(begin) = rest.find('$') {
        let (before, formula) = rest.split_at(begin);
        out.text += before;
        let delimiter = if formula.starts_with("$$") { "$$" } else { "$" };
        let inside = &formula[delimiter.len()..];
        let Some(end) = inside.find(delimiter) else {
            out.faults.push(format!("a dollar without another: '{formula}'"));
            out.text += formula;
            return;
        };
        match mathml(&unescaped(&inside[..end]), delimiter == "$$") {
            Ok(formula) => {
                out.formulas += 1;
                out.text += &formula;
            }
            Err(fault) => {
                out.faults.push(fault);
                out.text += &formula[..2 * delimiter.len() + end];
            }
        }
        rest = &inside[end + delimiter.len()..];
    }
    out.text += rest;
}

/// The text before rustdoc escaped it and replaced quotation marks and dashes.
fn unescaped(text: &str) -> String {
    let pairs = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&#39;", "'"),
        ("’", "'"),
        ("‘", "'"),
        ("–", "--"),
        ("…", "..."),
        ("&amp;", "&"),
    ];
    pairs.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}
