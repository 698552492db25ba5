//! The numerical options of the search: what is refused, and that they are used.

use crate::common::direct::degree;
use crate::common::{assert_refused, robot};
use aghf::direct::{Direct, DirectSettings};
use aghf::motion::Problem;

#[test]
fn options_out_of_range_are_errors() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let cases: [(Change, &str); 7] = [
        (|s| s.search.batch = 0, "batch: it is 0 and must be at least 1"),
        (|s| s.search.more_starts = 0, "more_starts: it is 0"),
        (|s| s.search.points = 1e9, "points: it is 1000000000 and must be at most 1024"),
        (|s| s.search.horizon_growth = 1.0, "horizon_growth: it is 1 and must be more than 1"),
        (|s| s.search.drop_ratio[1] = -1.0, "drop_ratio: it is -1"),
        (|s| s.search.planned_degree = 3, "planned_degree: it is 3 and must be at least 4"),
        (|s| s.nlp.backtracking = 0.0, "nlp: backtracking: it is 0"),
    ];
    for (change, words) in cases {
        let mut settings = degree(6);
        change(&mut settings);
        assert_refused(settings.check(&problem), words);
    }
}

/// A change of the settings.
type Change = fn(&mut DirectSettings);

/// Options reach the minimisation: more points, and a penalty and a step of one's own.
#[test]
fn options_are_used() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.5, 0.5, 0.0, 0.0], 1.0).expect("valid");
    let solved = |change: fn(&mut DirectSettings)| {
        let mut settings = DirectSettings { starts: 1, ..degree(8) };
        change(&mut settings);
        let direct = Direct::new(&problem).settings(settings);
        direct.solve().expect("valid")
    };
    let usual = solved(|_| ());
    let finer = solved(|s| s.search.points = 7.0);
    let slower = solved(|s| s.nlp.longest_step = 0.1);
    assert_eq!([usual.points, finer.points], [32, 60]);
    assert!(slower.iterations.len() > usual.iterations.len());
    for other in [finer, slower] {
        assert!(other.converged && (other.cost / usual.cost - 1.0).abs() < 1e-6);
    }
}
