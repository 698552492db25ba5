//! The pages of `proofs` as HTML.

use crate::html::Rendered;
use crate::math::mathml;
use crate::{files, read, write};
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, html::push_html};
use std::path::Path;

/// Writes each page of a folder as HTML into another one; returns the formulas and faults of all.
pub fn write_pages(from: &Path, to: &Path) -> Result<Rendered, String> {
    std::fs::create_dir_all(to).map_err(|error| format!("{}: {error}", to.display()))?;
    let mut all = Rendered::default();
    for path in files(from, "md")? {
        let page = page(&read(&path)?);
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let named = |fault: &String| format!("{}: {fault}", path.display());
        all.faults.extend(page.faults.iter().map(named));
        all.formulas += page.formulas;
        let name = if name == "README" { "index".into() } else { name };
        write(&to.join(format!("{name}.html")), &page.text)?;
    }
    Ok(all)
}

/// A page in Markdown as HTML with MathML.
pub fn page(markdown: &str) -> Rendered {
    let mut all = Rendered::default();
    let options = Options::ENABLE_MATH | Options::ENABLE_TABLES;
    let events: Vec<Event<'_>> = Parser::new_ext(markdown, options)
        .map(|event| match event {
            Event::InlineMath(latex) => formula(&latex, false, &mut all),
            Event::DisplayMath(latex) => formula(&latex, true, &mut all),
            // Links between pages.
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let dest_url = CowStr::from(target_of(&dest_url));
                Event::Start(Tag::Link { link_type, dest_url, title, id })
            }
            other => other,
        })
        .collect();
    let title = markdown.lines().next().unwrap_or_default().trim_start_matches('#').trim();
    let mut body = String::new();
    push_html(&mut body, events.into_iter());
    all.text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
        <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    );
    all
}

/// The target of a link among the pages: another page, or a source file as rustdoc shows it.
fn target_of(link: &str) -> String {
    match link.strip_prefix("../src/") {
        Some(source) if source.ends_with(".rs") => format!("../src/aghf/{source}.html"),
        _ => link.replace("README.md", "index.html").replace(".md", ".html"),
    }
}

/// A minimal readable style, light and dark.
const STYLE: &str = "\
:root { color-scheme: light dark; }
body { max-width: 50rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; }
table { border-collapse: collapse; display: block; overflow-x: auto; }
td, th { border: 1px solid #8886; padding: 0.3rem 0.6rem; text-align: left; }
math { font-family: \"Latin Modern Math\", \"STIX Two Math\", \"Cambria Math\", math; }
math[display=block] { overflow-x: auto; overflow-y: hidden; padding: 0.3rem 0; }
pre { overflow-x: auto; padding: 0.6rem; background: #8882; }
";

fn formula<'a>(latex: &str, display: bool, all: &mut Rendered) -> Event<'a> {
    match mathml(latex, display) {
        Ok(math) => {
            all.formulas += 1;
            Event::InlineHtml(math.into())
        }
        Err(fault) => {
            all.faults.push(fault);
            Event::Text(latex.to_owned().into())
        }
    }
}
