//! Pages of tables: their rows are those of the files, their points those of the rows, and no text in them is more than
//! text.

use crate::folder;
use aghf_cli::report::{Bar, Group, Part, Plot, Scatter, Table, TablePage};
use aghf_cli::sweep::{Row, RowOutcome, Sweep, ranking, sweep_page};
use serde_json::{Value, json};

const EVIL: &str =
    "</script><script>window.bad = 1</script><!-- <img src=x onerror=alert(1)> \"'&😀 {{TITLE}} {{DATA}}";

/// The text of a page and its data.
fn page_of(page: &TablePage) -> (String, Value) {
    let text = page.html().expect("it can be written");
    let begin = "<script type=\"application/json\" id=\"data\">";
    let (_, after) = text.split_once(begin).expect("it has data");
    let (data, _) = after.split_once("</script>").expect("they end");
    let data = serde_json::from_str(data).expect("they are JSON");
    (text, data)
}

/// The parts of a page that are tables.
fn tables(data: &Value) -> Vec<&Value> {
    let parts = data["parts"].as_array().expect("a list");
    parts.iter().filter(|part| part["kind"] == "table").collect()
}

fn plots(data: &Value) -> Vec<&Value> {
    let parts = data["parts"].as_array().expect("a list");
    let plots = parts.iter().filter_map(|part| part["plots"].as_array());
    plots.flatten().collect()
}

/// A sweep of twelve sets of two scenarios, and made-up rows: those of degree 7 fail at the goal, number 3 before there
/// is a motion.
fn swept(test: &str) -> (Sweep, Vec<Row>) {
    let text = "method = \"flow\"\nscenarios = [\"pendulum_1_swingup\", \"pendulum_2_swingup\"]\ntime_limit_s = 1.0\n\
        degree = [5, 7]\nk = [1e5, 1e6, 1e7]\ns_max = [0.1]";
    let file = folder(test).join("s.toml");
    std::fs::write(&file, text).expect("writable");
    let sweep = Sweep::load(&file.to_string_lossy()).expect("it is right");
    let rows = sweep.sets.iter().map(|set| {
        let seconds = 0.001 * (1 + set.index) as f64;
        let mut row = Row::failed(&sweep, set, "it missed", seconds);
        let p = row.parameters["degree"].as_u64().expect("it is a number");
        match set.index {
            3 => row,
            _ => {
                let effort = json!(100.0 + set.index as f64);
                row.results.insert("control_effort".to_owned(), effort);
                Row {
                    outcome: if p == 7 { RowOutcome::GoalMissed } else { RowOutcome::Success },
                    reason: (p == 7).then(|| EVIL.to_owned()),
                    ..row
                }
            }
        }
    });
    let rows: Vec<Row> = rows.collect();
    (sweep, rows)
}

#[test]
fn a_sweep_has_a_point_for_each_motion_and_a_bar_for_each_value() {
    let (sweep, rows) = swept("sweep");
    let page = sweep_page(&sweep, &rows, &ranking(&sweep, &rows)).expect("it can be made");
    let (_, data) = page_of(&page);
    let plots = plots(&data);
    let groups = plots[0]["groups"].as_array().expect("a list");
    let counts = groups.iter().map(|group| {
        let points = group["points"].as_array().expect("a list");
        (group["name"].clone(), group["failed"].clone(), points.len())
    });
    let counts: Vec<_> = counts.collect();
    assert_eq!(counts, [(json!("success"), json!(false), 6), (json!("goal_missed"), json!(true), 5)]);
    let first = &groups[0]["points"][0];
    assert_eq!((&first[0], &first[1]), (&json!(1.0), &json!(100.0)));
    let name = first[2].as_str().expect("it is text");
    assert!(name.contains("set 0: pendulum_1_swingup") && name.contains("degree 5"), "{name}");
    let bars = |title: &str| {
        let plot = plots.iter().find(|plot| plot["title"] == title);
        plot.map(|plot| plot["bars"].clone())
    };
    let bar = |name: &str, good: usize, all: usize| json!({"name": name, "good": good, "all": all});
    assert_eq!(bars("degree"), Some(json!([bar("5", 6, 6), bar("7", 0, 6)])));
    let thirds = ["1e5", "1e6", "1e7"].map(|k| bar(k, 2, 4));
    assert_eq!(bars("k"), Some(json!(thirds)));
    assert_eq!(bars("s_max"), None, "it has one value");
    let tables = tables(&data);
    assert_eq!(tables.len(), 2);
    assert_eq!(tables[0]["failed"].as_array().map(Vec::len), Some(9));
    assert_eq!(tables[1]["failed"], json!([3, 4, 5, 9, 10, 11]));
    let columns = tables[1]["columns"].as_array().expect("a list");
    let at = |name: &str| columns.iter().position(|c| c == name);
    assert_eq!(at("k_cons"), None, "no row has one");
    let row = &tables[1]["rows"][4];
    let cell = |name: &str| &row[at(name).expect("it is there")];
    assert_eq!(cell("reason"), &json!(EVIL));
    assert_eq!(cell("control_effort"), &json!(104.0));
    assert_eq!(cell("set"), &json!(4));
}

#[test]
fn cells_are_numbers_where_they_are_and_long_tables_are_cut() {
    let column = ["a".to_owned()];
    let cells = ["12", "1.5e-3", "0.1234567891", "", "12x", "NaN", "inf", "18446744073709551615", "9007199254740993"];
    let rows = cells.map(|cell| vec![cell.to_owned()]);
    let table = serde_json::to_value(Table::new("t", &column, &rows)).expect("JSON");
    let expected = json!([
        [12],
        [0.0015],
        [0.1234568],
        [null],
        ["12x"],
        ["NaN"],
        ["inf"],
        ["18446744073709551615"],
        ["9007199254740993"]
    ]);
    assert_eq!(table["rows"], expected);
    let many: Vec<usize> = (0..6000).collect();
    let rows: Vec<(usize, usize)> = many.iter().map(|i| (*i, 2 * i)).collect();
    let text: String = rows.iter().map(|(a, b)| format!("{a},{b}\n")).collect();
    let table = Table::of_csv("t", "f.csv", format!("a,b\n{text}").as_bytes(), |i| i > 4997);
    let table = serde_json::to_value(table.expect("it is a table")).expect("JSON");
    assert_eq!(table["all"], 6000);
    assert_eq!(table["rows"].as_array().map(Vec::len), Some(5000));
    assert_eq!(table["failed"], json!([4998, 4999]));
    let uneven = Table::of_csv("t", "f.csv", b"a,b\n1\n", |_| false);
    assert!(uneven.is_err_and(|e| e.to_string().contains("f.csv")));
}

#[test]
fn points_that_are_no_numbers_are_left_out_and_too_many_are_thinned() {
    let point = |y: f64| (1.0, y, String::new());
    let plot = |points| Scatter {
        title: "t".to_owned(),
        x: "x".to_owned(),
        y: "y".to_owned(),
        groups: vec![Group::new("g".to_owned(), 0, false, points)],
    };
    let count = |scatter: Scatter| {
        let page = TablePage {
            title: "t".to_owned(),
            about: String::new(),
            figures: Vec::new(),
            parts: vec![Part::Plots { title: "t".to_owned(), plots: vec![Plot::Scatter(scatter)] }],
        };
        let (_, data) = page_of(&page);
        let plot = plots(&data)[0].clone();
        (plot["groups"][0]["points"].as_array().map(Vec::len), plot["title"].clone())
    };
    let few = plot(vec![point(1.0), point(f64::NAN), point(f64::INFINITY), point(2.0)]);
    assert_eq!(count(few), (Some(2), json!("t")));
    let (points, title) = count(plot((0..50_001).map(|i| point(f64::from(i))).collect()));
    assert_eq!((points, title), (Some(16_667), json!("t (one point of 3)")));
}

#[test]
fn hostile_text_is_text_everywhere() {
    let evil = || EVIL.to_owned();
    let bars = vec![Bar { name: evil(), good: 1, all: 2 }];
    let group = Group::new(evil(), 0, true, vec![(1.0, 2.0, evil())]);
    let scatter = Scatter { title: evil(), x: evil(), y: evil(), groups: vec![group] };
    let page = TablePage {
        title: evil(),
        about: evil(),
        figures: vec![[evil(), evil()]],
        parts: vec![
            Part::Plots { title: evil(), plots: vec![Plot::Scatter(scatter), Plot::Bars { title: evil(), bars }] },
            Part::Table(Table::new(EVIL, &[evil()], &[vec![evil()]])),
        ],
    };
    let (text, data) = page_of(&page);
    assert_eq!(data["title"], EVIL);
    assert_eq!(data["parts"][1]["rows"][0][0], EVIL);
    assert_eq!(text.matches("<script").count(), 2);
    assert_eq!(text.matches("</script").count(), 2);
    assert!(!text.contains("<img") && !text.contains("<!--"));
}
