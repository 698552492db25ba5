//! Reading tables, and what is wrong with some.

use crate::robot::scenario;
use aghf_scenario::judge::Trajectory;
use serde_json::json;

#[test]
fn columns_are_found_by_name() {
    let scenario = scenario("columns", json!({}));
    let text = "# made elsewhere\nq_elbow, t ,q_slide,q_shoulder\n3,0,1,2\n\n6,0.5,4,5\n";
    let table = Trajectory::parse(text, "t.csv", &scenario.model).expect("it is good");
    assert_eq!(table.times, [0.0, 0.5]);
    assert_eq!(table.q, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert!([table.v, table.a, table.u].iter().all(Option::is_none));
}

#[test]
fn errors_name_line_and_column() {
    let scenario = scenario("errors", json!({}));
    let good = "t,q_slide,q_shoulder,q_elbow\n0,1,2,3\n1,4,5,6\n";
    let cases = [
        (good.replace("q_elbow", "q_wrist"), "line 1: column 'q_wrist'; the name of a joint"),
        (good.replace("q_elbow", "elbow"), "line 1: column 'elbow'"),
        (good.replace("q_elbow", "q_slide"), "line 1: column 'q_slide'; twice"),
        (good.replace(",q_elbow", ""), "column 'q_elbow'; missing"),
        (good.replace("q_elbow", "v_elbow"), "column 'q_elbow'; missing"),
        ("t,q_slide,q_shoulder,q_elbow,u_slide\n".to_owned(), "column 'u_shoulder'; missing"),
        (good.replace('t', "time"), "line 1: column 'time'"),
        (good.replace("t,", ""), "column 't'; missing"),
        (good.replace('5', "nan"), "line 3, column 'q_shoulder'; 'nan' is no finite number"),
        (good.replace('5', ""), "line 3, column 'q_shoulder'; '' is no finite number"),
        (good.replace('5', "five"), "line 3, column 'q_shoulder'"),
        (good.replace("1,4", "0,4"), "line 3, column 't'; does not come after"),
        (good.replace(",5", ""), "line 3; 3 fields; the header has 4"),
        (good.replace(",5", ",5,5"), "line 3; 5 fields"),
        (good.replace("1,4,5,6", ""), "1 samples are given"),
        (String::new(), "column 't'; missing"),
    ];
    for (text, words) in cases {
        let error = Trajectory::parse(&text, "t.csv", &scenario.model).expect_err(words);
        let error = error.to_string();
        let all = words.split("; ").all(|word| error.contains(word));
        assert!(error.starts_with("t.csv: ") && all, "{error}, want {words}");
    }
}

/// The error of samples that are given as numbers.
fn refused(times: &[f64], q: &[f64]) -> String {
    let rows = |numbers: &[f64]| Some(numbers.iter().map(|x| vec![*x; 3]).collect());
    let found = Trajectory::new(times.to_vec(), [rows(q), None, None, rows(q)]);
    found.map_or_else(|error| error.to_string(), |_| String::new())
}

#[test]
fn samples_in_numbers_are_checked() {
    assert_eq!(refused(&[0.0, 0.5, 1.0], &[1.0, 2.0, 3.0]), "");
    for (times, q, words) in [
        (&[0.0][..], &[1.0][..], "t: 1 samples are given"),
        (&[0.0, 0.5, 0.5], &[1.0, 2.0, 3.0], "t: 0.5 does not come after 0.5"),
        (&[0.0, f64::NAN], &[1.0, 2.0], "t: NaN is no finite number"),
        (&[0.0, 0.5], &[1.0, 2.0, 3.0], "q: it has 3 samples, t has 2"),
        (&[0.0, 0.5], &[1.0, f64::INFINITY], "q: inf is no finite number"),
    ] {
        let error = refused(times, q);
        assert!(error.contains(words), "{error}");
    }
    let rows = || Some(vec![vec![0.0; 3]; 2]);
    let error = Trajectory::new(vec![0.0, 1.0], [rows(), None, rows(), None]);
    assert!(error.is_err_and(|error| error.to_string().contains("accelerations: velocities are")));
    let error = Trajectory::new(vec![0.0, 1.0], [const { None }; 4]);
    assert!(error.is_err_and(|error| error.to_string().contains("q: it is missing")));
}
