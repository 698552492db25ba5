//! Renders the formulas of the documentation.
//!
//! `cargo doc --no-deps && cargo run -p formulas` replaces the formulas in `target/doc`, which `cargo doc` copies
//! verbatim from the comments, by MathML, and writes the pages of `proofs` to `target/doc/proofs`, readable without
//! scripts or a network. On docs.rs, where nothing runs after `cargo doc`, the header `formulas.html` does the same in
//! the browser.
//!
//! The tests pass every formula in the sources through the parser.

mod html;
mod math;
mod proofs;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(summary) => {
            println!("{summary}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("formulas: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<String, String> {
    let root = root();
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    let pages = target.join("doc/aghf");
    let mut rendered = 0;
    let mut faults = Vec::new();
    for page in files(&pages, "html")? {
        let text = read(&page)?;
        let found = html::with_mathml(&text);
        faults.extend(found.faults.iter().map(|fault| format!("{}: {fault}", page.display())));
        if found.formulas > 0 {
            rendered += found.formulas;
            write(&page, &found.text)?;
        }
    }
    let proofs = proofs::write_pages(&root.join("proofs"), &target.join("doc/proofs"))?;
    faults.extend(proofs.faults);
    if !faults.is_empty() {
        return Err(faults.join("\n"));
    }
    Ok(format!("{} formulas rendered below {}", rendered + proofs.formulas, target.join("doc").display()))
}

/// The folder of the repository.
fn root() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.ancestors().nth(2).unwrap_or(folder).to_owned()
}

/// The files below a folder with this ending, sorted.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("{}: {error}; `cargo doc --no-deps` makes it", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|error| format!("{}: {error}", folder.display()))?.path();
        if path.is_dir() {
            found.extend(files(&path, ending)?);
        } else if path.extension().is_some_and(|own| own == ending) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests;
