//! `aghf tradeoff`: its table, its files and its page.

use crate::command::{aghf, assert_bad_input, empty_folder};
use serde_json::Value;

#[test]
fn the_curve_is_a_table_and_a_page() {
    let folder = empty_folder("tradeoff");
    let arguments = ["tradeoff", "limits_01", "--points", "3", "--threads", "1", "--out", "curve"];
    let run = aghf(&folder, &arguments);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = std::fs::read_to_string(folder.join("curve/tradeoff.csv")).expect("it is there");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "motion,duration_s,control_effort,verdict,iterations,solve_seconds");
    assert_eq!(lines.len(), 4, "{table}");
    let number = |line: &str, column: usize| -> f64 {
        let cell = line.split(',').nth(column).expect("it has one");
        cell.parse().expect("a number")
    };
    assert!(number(lines[1], 1) < number(lines[2], 1));
    assert!(number(lines[1], 2) > number(lines[3], 2));

    let page = std::fs::read_to_string(folder.join("curve/report.html")).expect("it is there");
    let (_, after) = page.split_once("id=\"data\">").expect("it has data");
    let (data, _) = after.split_once("</script>").expect("they end");
    let data: Value = serde_json::from_str(data).expect("they are JSON");
    assert_eq!(data["motions"].as_array().map(Vec::len), Some(3));
    let points = &data["plot"]["groups"][0]["points"];
    for (i, line) in lines[1..].iter().enumerate() {
        assert_eq!(points[i][0], data["motions"][i]["horizon"]);
        assert_eq!(points[i][0].as_f64(), Some(number(line, 1)));
    }

    // A motion is a summary as of any solve.
    let sampled = aghf(&folder, &["sample", "curve/summary_02.json", "--rate", "100", "--out", "two.csv"]);
    assert_eq!(sampled.code, Some(0), "{}", sampled.stderr);
    assert_bad_input(&folder, &arguments, "tradeoff.csv; exists already; --force");
}

#[test]
fn what_it_cannot_do_is_told() {
    let folder = empty_folder("tradeoff_refused");
    for (arguments, words) in [
        (&["--points", "1"][..], "points; it is 1 and must be at least 2"),
        (&["--method", "flow"][..], "tradeoff; supported by the method 'direct' only, not by 'flow'"),
    ] {
        let all = [&["tradeoff", "limits_01"][..], arguments].concat();
        assert_bad_input(&folder, &all, words);
    }
    assert_bad_input(&folder, &["tradeoff", "kinova_free_01"], "objective; without limits");
}
