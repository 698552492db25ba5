//! Files of results that are interrupted.

use crate::command::empty_folder;
use aghf_cli::output::ResultsFile;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A row with everything that a line has to quote.
fn row(problem: usize) -> Value {
    let reason = if problem.is_multiple_of(20) { json!("\"q_goal\", at 3,5 rad: größer") } else { Value::Null };
    json!({ "problem": problem, "seconds": 0.25 * problem as f64, "reason": reason })
}

/// The problems in lines.
fn problems(lines: &[csv::StringRecord]) -> Vec<usize> {
    lines.iter().map(|line| line[0].parse().expect("a whole number")).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// However often a run is interrupted, at whatever byte of the file: what has a complete line stays, is not done
    /// again, and all is there in the end.
    #[test]
    fn an_interruption_at_any_byte_loses_only_its_own_line(
        cuts in prop::collection::vec((0.0f64..1.0, 1usize..30), 0..5),
    ) {
        let path = empty_folder("interrupted").join("results.csv");
        let mut done = BTreeSet::new();
        for (share, count) in cuts.into_iter().chain([(1.0, 60)]) {
            let (mut file, lines) = ResultsFile::open(&path, &row(0)).expect("good");
            let found = problems(&lines);
            prop_assert!(found.iter().copied().eq(done.iter().copied()), "{found:?}, want {done:?}");
            for problem in (0..60).filter(|problem| !done.contains(problem)).take(count) {
                file.append(&row(problem)).expect("writable");
            }
            drop(file);
            let text = std::fs::read(&path).expect("it is there");
            let cut = (share * text.len() as f64).ceil() as usize;
            std::fs::write(&path, &text[..cut]).expect("writable");
            // The header has no problem.
            let lines = text[..cut].iter().filter(|byte| **byte == b'\n').count();
            done = (0..lines.saturating_sub(1)).collect();
        }
        let (_, lines) = ResultsFile::open(&path, &row(0)).expect("good");
        prop_assert!(problems(&lines).into_iter().eq(0..60));
        for (i, line) in lines.iter().enumerate() {
            let row = row(i);
            prop_assert_eq!(&line[2], row["reason"].as_str().unwrap_or_default());
        }
    }
}

#[test]
fn another_header_and_a_second_process_are_refused() {
    let path = empty_folder("results_file").join("results.csv");
    let (held, _) = ResultsFile::open(&path, &row(0)).expect("good");
    let refused = |row: &Value, words: &str| {
        let error = ResultsFile::open(&path, row).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(&row(0), "results.csv: results: another process is at work on it");
    drop(held);
    refused(&json!({ "set": 1 }), "results.csv: line 1: it is not the header that this version writes");
    std::fs::write(&path, "problem,seconds,reason\n1,2\n").expect("writable");
    refused(&row(0), "results.csv: line 2: ");
}
