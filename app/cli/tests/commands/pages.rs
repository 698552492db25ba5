//! The commands in the blocks of the guide's pages, run as a reader would.

use crate::command::{aghf, empty_folder};
use aghf_cli::sweep::Sweep;
use aghf_scenario::ScenarioFile;
use std::path::Path;

/// The pages by their packages. A block of JSON that is a whole scenario is in a file by the name of its page.
const PAGES: [(&str, &str); 8] = [
    ("scenario", "certificates"),
    ("scenario", "goals"),
    ("scenario", "limits"),
    ("scenario", "objectives"),
    ("scenario", "standing"),
    ("cli", "export"),
    ("cli", "real_robots"),
    ("cli", "upgrade"),
];

/// The texts of the blocks in such a language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let begin = format!("```{language}\n");
    let behind = page.split(begin.as_str()).skip(1);
    behind.filter_map(|block| block.split("```").next()).collect()
}

#[test]
fn the_commands_of_the_pages_run() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    for (package, page) in PAGES {
        let folder = empty_folder(&format!("page_{page}"));
        let path = root.join(format!("app/{package}/src/guide/{page}.md"));
        let text = std::fs::read_to_string(&path).expect("the page is there");
        std::os::unix::fs::symlink(root.join("robots"), folder.join("robots")).expect("writable");
        let urdf = "kinova_gen3.urdf";
        std::fs::copy(root.join("robots/kinova_gen3").join(urdf), folder.join(urdf)).expect("writable");
        for scenario in blocks(&text, "json") {
            if scenario.starts_with('{') {
                std::fs::write(folder.join(format!("{page}.json")), scenario).expect("writable");
            }
        }
        let mut run = 0;
        let lines = blocks(&text, "sh").into_iter().flat_map(str::lines);
        for line in lines.filter_map(|line| line.strip_prefix("aghf ")) {
            let (command, file) = match line.split_once(" > ") {
                Some((command, file)) => (command, Some(file)),
                None => (line, None),
            };
            let words: Vec<&str> = command.split_whitespace().collect();
            let output = aghf(&folder, &words);
            assert_eq!(output.code, Some(0), "{page}: {line}: {}{}", output.stdout, output.stderr);
            if let Some(file) = file {
                std::fs::write(folder.join(file), output.stdout).expect("writable");
            }
            run += 1;
        }
        assert!(run > 0, "{page} has no commands");
    }
}

/// The page of the commands explains each row of the summary of a solve by its name.
#[test]
fn the_rows_of_summaries_are_explained() {
    let folder = empty_folder("rows_of_summaries");
    let page = include_str!("../../src/guide/command_line.md");
    let mut known = vec!["scenario", "method", "solve time"];
    let rows = page.lines().filter_map(|line| line.strip_prefix("| "));
    for names in rows.filter_map(|row| row.split(" | ").next()) {
        known.extend(names.split("; ").flat_map(|some| some.split(", ")));
        known.push(names);
    }
    for arguments in [
        &["kinova_free_01"][..],
        &["kinova_table_01"],
        &["pendulum_1_swingup", "--method", "flow"],
        &["kinova_free_01", "--method", "rest"],
    ] {
        let words = [&["solve"], arguments, &["--no-report", "--force", "--verbose"]].concat();
        let output = aghf(&folder, &words);
        // The further lines of wrapped values begin with more than one space.
        let table = output.stdout.lines().filter(|line| line.contains("  ") && !line.starts_with("  "));
        let names: Vec<_> = table.filter_map(|line| line.trim().split("  ").next()).collect();
        assert!(names.len() > 8, "{}{}", output.stdout, output.stderr);
        for name in names {
            let short = name.split(" (").next().unwrap_or(name);
            let parts = short.split(", ").next().unwrap_or(short);
            assert!(known.contains(&short) || known.contains(&parts), "{name}");
        }
    }
}

/// Blocks that show some keys of a scenario, with the others that it needs.
#[test]
fn the_keys_of_the_pages_are_those_of_a_scenario() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let mut read = 0;
    for (package, page) in PAGES.into_iter().chain([("scenario", "asking_for_more")]) {
        let path = root.join(format!("app/{package}/src/guide/{page}.md"));
        let text = std::fs::read_to_string(&path).expect("the page is there");
        for keys in blocks(&text, "json") {
            if keys.starts_with('"') {
                let keys = keys.trim_end().trim_end_matches(',');
                let robot = if keys.starts_with("\"robot\"") { "" } else { "\"robot\": \"r\"," };
                let others = "\"horizon_s\": 1, \"q_start\": [], \"v_start\": []";
                let scenario = format!("{{{robot} {others}, {keys}}}");
                let file = serde_json::from_str::<ScenarioFile>(&scenario);
                assert!(file.is_ok(), "{page}: {keys}: {file:?}");
                read += 1;
            }
        }
    }
    assert!(read >= 5, "{read} blocks");
}

/// The sweep of its page, with a robot that is built in.
#[test]
fn the_sweep_of_its_page_is_read() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let text = std::fs::read_to_string(root.join("app/cli/src/guide/sweeps.md"));
    let text = text.expect("the page is there");
    let path = empty_folder("page_sweeps").join("grid.toml");
    let grid = blocks(&text, "toml")[0].replace("ur10.urdf", "kinova_gen3");
    std::fs::write(&path, grid).expect("writable");
    let sweep = Sweep::load(&path.to_string_lossy()).expect("it is right");
    assert_eq!(sweep.sets.len(), 10 * 2 * 2 * 3 * 3 * 3 * 2);
}
