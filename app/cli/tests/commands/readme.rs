//! The commands that the README and the guide show.

use crate::command::{aghf, empty_folder};
use std::path::{Path, PathBuf};

fn text_of(path: &str) -> String {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The arguments of `aghf` between backticks or on lines of their own, in order.
fn commands(text: &str) -> Vec<Vec<String>> {
    let parts = text.split(['`', '\n']);
    let own = parts.filter_map(|part| {
        let part = part.split(" #").next().unwrap_or_default().trim();
        let behind = |prefix| part.strip_prefix(prefix);
        behind("cargo run --release -- ").or_else(|| behind("aghf "))
    });
    let words = own.map(|command| command.split_whitespace().map(str::to_owned).collect());
    words.filter(|words: &Vec<String>| words[0].chars().all(|c| c.is_ascii_lowercase())).collect()
}

/// The page of help of a command.
fn help_of(folder: &Path, command: &[String]) -> String {
    let names = command.iter().take_while(|word| word.chars().all(|c| c.is_ascii_lowercase()));
    let words: Vec<&str> = names.map(String::as_str).chain(["--help"]).collect();
    let help = aghf(folder, &words);
    assert_eq!(help.code, Some(0), "{command:?}: {}", help.stderr);
    help.stdout
}

/// The pages of the guides.
fn pages() -> Vec<PathBuf> {
    let guides = ["src/guide", "app/scenario/src/guide", "app/cli/src/guide"];
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let files = guides.map(|guide| std::fs::read_dir(root.join(guide)).expect("it is there"));
    let paths = files.into_iter().flatten().map(|file| file.expect("it can be read").path());
    paths.filter(|path| path.extension().is_some_and(|kind| kind == "md")).collect()
}

/// Every command of the table has a page of help, and every option that stands in its row is on it.
#[test]
fn the_table_of_commands_names_options_that_are_there() {
    let folder = empty_folder("readme_table");
    let table = text_of("app/cli/src/guide/command_line.md");
    let mut seen = 0;
    // Rows that begin with an option are those of `solve`.
    let table = table.replace("\n| `--", "\n| `aghf solve --");
    for row in table.lines().filter(|line| line.starts_with("| `aghf ")) {
        let command = &commands(row)[0];
        let help = help_of(&folder, command);
        let pieces = row.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
        for option in pieces.filter(|piece| piece.starts_with("--") && piece.len() > 2) {
            assert!(help.contains(option), "{command:?} has no {option}");
            seen += 1;
        }
    }
    assert!(seen > 15, "{seen} options");
}

/// Every command in a page of the guides has a page of help, with the options that it has there.
#[test]
fn the_commands_of_all_pages_have_their_options() {
    let folder = empty_folder("page_options");
    let mut seen = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("it is text");
        for command in commands(&text) {
            let help = help_of(&folder, &command);
            let ends = |c: char| c.is_whitespace() || "=,.[]()<`".contains(c);
            let known: Vec<&str> = help.split(ends).collect();
            for option in command.iter().filter(|word| word.starts_with("--")) {
                let is_known = known.contains(&option.as_str());
                assert!(is_known, "{}: {command:?} has no {option}", page.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 30, "{seen} options");
}

/// The commands of the README and of the page of figures, on a robot and a scenario where they leave the choice; those
/// that open a browser or take long only exist.
#[test]
fn the_commands_of_the_readme_run() {
    let folder = empty_folder("readme_commands");
    let solved = aghf(&folder, &["solve", "pendulum_2_swingup", "--out", "out"]);
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let mut run = 0;
    let pages = ["README.md", "benches/README.md"].map(text_of);
    for words in pages.iter().flat_map(|text| commands(text)) {
        if ["view", "benchmark"].contains(&words[0].as_str()) {
            let help = aghf(&folder, &[&words[0], "--help"]);
            assert_eq!(help.code, Some(0), "{words:?}");
            continue;
        }
        let words = words.iter().map(|word| match word.as_str() {
            "ROBOT" => "pendulum_2",
            "SCENARIO" => "pendulum_2_swingup",
            "TRAJECTORY.csv" => "out/trajectory.csv",
            "RUN" => "out",
            other => other,
        });
        let words: Vec<&str> = words.collect();
        let output = aghf(&folder, &words);
        assert_eq!(output.code, Some(0), "{words:?}: {}", output.stderr);
        run += 1;
    }
    assert!(run >= 5, "{run} commands");
}

/// The scenario of the guide's first motion, through all commands that it names.
#[test]
fn the_first_motion_goes_from_a_scenario_to_a_table() {
    let folder = empty_folder("first_motion");
    let guide = text_of("app/scenario/src/guide/first_motion.md");
    let scenario = guide.split("let text = r#\"").nth(1).expect("a scenario");
    let scenario = scenario.split("\"#;").next().expect("its end");
    std::fs::write(folder.join("reach.json"), scenario).expect("writable");
    for words in [
        "robots kinova_gen3 --urdf robot.urdf",
        "robots robot.urdf",
        "check robot.urdf --samples 1",
        "solve reach.json --out out",
        "sample out/summary.json --rate 1000 --out at_1000_hz.csv",
        "judge reach.json out/trajectory.csv",
    ] {
        let words: Vec<&str> = words.split(' ').collect();
        let output = aghf(&folder, &words);
        assert_eq!(output.code, Some(0), "{words:?}: {}{}", output.stdout, output.stderr);
    }
    for command in commands(&guide) {
        let help = aghf(&folder, &[&command[0], "--help"]);
        assert_eq!(help.code, Some(0), "{command:?}");
    }
}
