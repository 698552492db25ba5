//! Paths: free everywhere, reproducible by their seed, and the results without a path.

use crate::common::constraint::Held;
use crate::common::scenario::Scenario;
use crate::common::{assert_refused, robot};
use crate::{across, outside, point, ring, wall, wall_with_a_gap};
use aghf::constraint::{AnyConstraint, Constraint, Evaluator, FrameRows};
use aghf::model::Frame;
use aghf::motion::Problem;
use aghf::plan::{Checker, InverseKinematics, Plan, PlanSettings, plan};
use aghf::scalar::Scalar;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;

fn planned(problem: &Problem<'_>, state: &[AnyConstraint], settings: &PlanSettings) -> Plan {
    plan(problem, state, settings, &|| false).expect("valid")
}

fn path(problem: &Problem<'_>, state: &[AnyConstraint], settings: &PlanSettings) -> Vec<Vec<f64>> {
    match planned(problem, state, settings) {
        Plan::Found(path) => path,
        other => panic!("{other:?}"),
    }
}

/// The largest row at rest along a path, evaluated one configuration at a time and far more densely than by the
/// planner.
fn worst<K: Constraint + ?Sized>(problem: &Problem<'_>, state: &K, path: &[Vec<f64>]) -> f64 {
    let model = problem.model();
    let mut evaluator = Evaluator::<f64, f64>::new(model);
    let (mut g, mut x) = (vec![0.0; state.dim()], vec![0.0; 2 * model.dof()]);
    let mut worst = f64::NEG_INFINITY;
    for edge in path.windows(2) {
        for k in 0..=100 {
            let share = f64::from(k) / 100.0;
            for (x, (a, b)) in x.iter_mut().zip(edge[0].iter().zip(&edge[1])) {
                *x = a + share * (b - a);
            }
            let placed = evaluator.at(&x).expect("same robot");
            placed.value(state, &mut g).expect("same robot");
            worst = g.iter().copied().fold(worst, f64::max);
        }
    }
    worst
}

fn length(path: &[Vec<f64>]) -> f64 {
    let edges = path.windows(2).map(|edge| {
        let squares = edge[0].iter().zip(&edge[1]).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    });
    edges.sum()
}

#[test]
fn it_finds_the_gap() {
    let (model, state) = (point(), wall_with_a_gap());
    let problem = across(&model);
    let line = [vec![0.0, 0.0], vec![1.0, 0.0]];
    let mut checker = Checker::new(&model, &state, 0.04).expect("same robot");
    assert!(!checker.is_line_free(&line[0], &line[1]).expect("two numbers"));
    assert!(worst(&problem, &state, &line) > 0.0);
    for number in 0..8 {
        let settings = PlanSettings { number, resolution: 0.01, ..PlanSettings::default() };
        let found = path(&problem, &state, &settings);
        assert_eq!([&found[0], &found[found.len() - 1]], [&line[0], &line[1]]);
        let worst = worst(&problem, &state, &found);
        assert!(worst <= 0.0, "{number}: {worst}");
        // Twice the distance to the lower end of the gap is 2.147; without shortening the path is far longer.
        let length = length(&found);
        assert!(length > 2.147 && length < 2.5, "{number}: {length}");
    }
}

#[test]
fn an_arm_goes_around_what_is_in_its_way() {
    for name in ["kinova_obstacles_01", "kinova_obstacles_05"] {
        let scenario = Scenario::load(name);
        let problem = scenario.problem();
        let state = scenario.clearance();
        let found = path(&problem, &state, &PlanSettings::default());
        let worst = worst(&problem, &state, &found);
        assert!(worst <= 0.0, "{name}: {worst}");
    }
}

#[test]
fn a_seed_and_a_number_have_one_path() {
    let (model, state) = (point(), wall_with_a_gap());
    let problem = across(&model);
    let of = |seed, number| {
        let settings = PlanSettings { seed, number, ..PlanSettings::default() };
        path(&problem, &state, &settings)
    };
    assert_eq!(of(3, 2), of(3, 2));
    assert_ne!(of(3, 2), of(3, 3));
    assert_ne!(of(3, 2), of(4, 2));
}

/// With two gaps in a wall a single path goes through either; the shortest of several goes through the nearer one. A
/// path that is nearly straight is planned only once.
#[test]
fn of_several_paths_the_shortest_is_taken() {
    let model = point();
    let problem = across(&model);
    let lengths = |state: &[AnyConstraint], number| -> Vec<f64> {
        let of = |paths| {
            let settings = PlanSettings { number, paths, ..PlanSettings::default() };
            length(&path(&problem, state, &settings))
        };
        (1..=8).map(of).collect()
    };
    let (two_gaps, post) = (wall(&[[0.41, 0.79], [-0.99, -0.66]]), outside([[0.5, 0.0]], 0.1));
    let mut shorter = 0;
    for number in 0..12 {
        let found = lengths(&two_gaps, number);
        assert!(found.windows(2).all(|pair| pair[1] <= pair[0]), "{found:?}");
        assert!(found[7] < 1.7, "{found:?}");
        shorter += usize::from(found[0] > 1.75);
        let found = lengths(&post, number);
        assert!(found[0] < 1.25 && found.iter().all(|x| *x == found[0]), "{found:?}");
    }
    assert!(shorter > 1, "{shorter} of 12 take the farther gap");
}

/// No obstacle as large as the resolution is missed, wherever it is, and none beside the line is in the way.
#[test]
fn a_line_is_looked_at_everywhere() {
    let model = point();
    for steps in 1..=40 {
        let resolution = 1.0 / f64::from(steps);
        let radius = 0.5 * resolution + 1e-9;
        for blocked in 0..=60 {
            let at = radius + (1.0 - radius) * f64::from(blocked) / 60.0;
            let state = outside([[at, 0.0], [0.5, 3.0]], radius);
            let mut checker = Checker::new(&model, &state, resolution).expect("same robot");
            let free = checker.is_line_free(&[0.0, 0.0], &[1.0, 0.0]);
            assert!(!free.expect("two numbers"), "{blocked} of {steps}");
            let beside = radius + 1e-6;
            let free = checker.is_line_free(&[0.0, beside], &[1.0, beside]);
            assert!(free.expect("two numbers"), "{blocked} of {steps}");
        }
    }
}

/// With a margin that is kept at the checked configurations nothing is missed between them, however small it is.
#[test]
fn a_margin_proves_a_line() {
    let model = point();
    let line: [&[f64]; 2] = [&[0.0, 0.0], &[1.0, 0.0]];
    for k in 0..200 {
        let at = 0.01 + 0.98 * f64::from(k) / 200.0;
        let state = outside([[at, 0.0]], 1e-6);
        let mut checker = Checker::new(&model, &state, 0.009).expect("same robot");
        checker.keep(0.005, line).expect("two numbers");
        let free = checker.is_line_free(line[0], line[1]);
        assert!(!free.expect("two numbers"), "{at}");
    }
}

/// The steps of a line are as wide as what is around permits.
#[test]
fn far_from_everything_a_line_takes_four_configurations() {
    let model = point();
    let checks = |y: f64| {
        let state = outside([[0.5, y]], 0.1);
        let mut checker = Checker::new(&model, &state, 1e-3).expect("same robot");
        let free = checker.is_line_free(&[0.0, 0.0], &[1.0, 0.0]);
        assert!(free.expect("two numbers"));
        checker.checks()
    };
    assert_eq!(checks(1.0), 4);
    let near = checks(0.101);
    assert!((20..400).contains(&near), "{near}");
}

/// Rows keep the margin, or the distance at the ends if that is smaller.
#[test]
fn a_margin_is_no_more_than_the_ends_have() {
    let model = point();
    let state = outside([[0.0, -0.11], [0.5, 0.0]], 0.1);
    let mut checker = Checker::new(&model, &state, 0.04).expect("same robot");
    let ends: [&[f64]; 2] = [&[0.0, 0.0], &[1.0, 0.0]];
    checker.keep(0.05, ends).expect("two numbers");
    let mut free = |q: [f64; 2]| checker.is_free(&q).expect("two numbers");
    assert!(free([0.0, 0.0]) && free([1.0, 0.0]));
    assert!(!free([0.0, -0.005]) && free([0.0, 0.005]));
    assert!(!free([0.5, 0.14]) && free([0.5, 0.16]));
}

#[test]
fn what_cannot_be_ends_by_its_budget() {
    let model = point();
    let problem = across(&model);
    let settings = PlanSettings { most_checks: 5000, ..PlanSettings::default() };
    let Plan::OutOfBudget { checks } = planned(&problem, &ring(), &settings) else {
        panic!("there is no way through");
    };
    assert!((5000..6000).contains(&checks), "{checks}");
    let inside = planned(&problem, &outside([[1.0, 0.05], [2.0, 0.0]], 0.1), &settings);
    let Plan::EndBlocked { goal, row, by } = inside else {
        panic!("{inside:?}");
    };
    assert!(goal && row == 0, "{row}");
    assert!((by - (0.01 - 0.0025) / 0.2).abs() < 1e-12, "{by}");
}

/// Neither one line nor the steps of a tree take many more configurations than are allowed, so that ends far apart end.
#[test]
fn long_lines_end_by_the_budget() {
    let model = point();
    let problem = across(&model);
    let checks = |state: &[AnyConstraint], range| {
        let settings = PlanSettings { most_checks: 100, margin: 0.0, range, ..PlanSettings::default() };
        match planned(&problem, state, &settings) {
            Plan::OutOfBudget { checks } => checks,
            other => panic!("{other:?}"),
        }
    };
    let along = (0..=100).map(|k| [0.01 * f64::from(k), 0.1001]);
    let beside = checks(&outside(along, 0.1), 0.5);
    assert!((100..120).contains(&beside), "{beside}");
    let blocked = checks(&outside([[0.7, 0.0]], 0.1), 1e-4);
    assert!((100..120).contains(&blocked), "{blocked}");
}

#[test]
fn it_stops_when_told() {
    let model = point();
    let problem = across(&model);
    let left = Cell::new(10);
    let stopped = || {
        left.set(left.get() - 1);
        left.get() == 0
    };
    let found = plan(&problem, &ring(), &PlanSettings::default(), &stopped);
    assert_eq!(found.expect("valid"), Plan::Stopped);
}

/// The first path is the result from the moment that it is found, and gets shorter until the end.
#[test]
fn a_path_that_is_found_remains_when_it_is_stopped() {
    let model = point();
    let (problem, state) = (across(&model), wall_with_a_gap());
    let after = |calls: usize| {
        let left = Cell::new(calls);
        let stopped = || left.replace(left.get().saturating_sub(1)) == 0;
        let found = plan(&problem, &state, &PlanSettings::default(), &stopped);
        match found.expect("valid") {
            Plan::Found(path) => Some(path),
            other => {
                assert_eq!(other, Plan::Stopped);
                None
            }
        }
    };
    let first = (0..).find(|calls| after(*calls).is_some());
    let first = first.expect("there is one");
    let paths = [first, first + 20, usize::MAX].map(|calls| after(calls).expect("it is found"));
    for path in &paths {
        assert!(worst(&problem, &state, path) <= 0.0);
    }
    let lengths = paths.map(|path| length(&path));
    assert!(lengths[0] > lengths[1] && lengths[1] > lengths[2], "{lengths:?}");
}

#[test]
fn what_it_cannot_do_is_refused() {
    let model = point();
    let problem = across(&model);
    let go = |settings: PlanSettings| plan(&problem, &ring(), &settings, &|| false);
    let default = PlanSettings::default;
    assert_refused(go(PlanSettings { resolution: 0.0, ..default() }), "resolution");
    assert_refused(go(PlanSettings { range: f64::NAN, ..default() }), "range");
    assert_refused(go(PlanSettings { margin: -1.0, ..default() }), "margin");
    assert_refused(go(PlanSettings { paths: 0, ..default() }), "paths");
    assert_refused(go(PlanSettings { most_checks: 0, ..default() }), "most_checks");
    assert_refused(plan(&problem, &Held(0.0), &default(), &|| false), "equality");
    // Bodies that the robot does not have.
    let other = robot("pendulum_1");
    let swing = Problem::new(&other, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    assert!(plan(&swing, &ring(), &default(), &|| false).is_err());
    let zero = f64::from_f64(0.0);
    let mut checker = Checker::new(&model, &Held(0.0), 0.1).expect("same robot");
    assert!(checker.is_free(&[zero]).is_err());
}

/// With a set of poses with equalities every configuration of a path is in it, and neighbours are near each other.
#[test]
fn paths_stay_in_a_plane() {
    let model = robot("kinova_gen3");
    let mut frames = model.frames().iter();
    let tool = frames.find(|frame| frame.name == "end_effector_link");
    let at = Placement::new(Matrix3::identity(), Vector3::new(0.0, 0.0, 0.4));
    let plane = FrameRows::new(tool.expect("a link"), Frame::new("plane", None, at));
    let [low, high] = [-1.0, 1.0].map(|sign| {
        let all = sign * f64::INFINITY;
        Vector3::new(all, all, 0.0)
    });
    let plane = plane.in_box(&low, &high).expect("bounds");
    let bounds = vec![[-2.2, 2.2]; 7];
    let mut search = InverseKinematics::new(&model, &plane, bounds).expect("seven joints");
    let ends = [[0.0, 0.5, 0.0, 1.6, 0.0, 1.0, 0.0], [1.4, 0.9, 0.0, 1.9, 0.0, 0.9, 0.0]];
    let ends = ends.map(|q| search.solve(&q).expect("seven joints").q);
    let [start, goal] = ends.clone().map(|q| [q, vec![0.0; 7]].concat());
    let problem = Problem::new(&model, start, goal, 1.0).expect("valid");
    let state = [AnyConstraint::Frame(plane)];
    let settings = PlanSettings::default();
    let found = path(&problem, &state, &settings);
    assert_eq!([&found[0], &found[found.len() - 1]], [&ends[0], &ends[1]]);
    assert!(found.len() > 2);
    for edge in found.windows(2) {
        let off = worst(&problem, &state, &[edge[1].clone(), edge[1].clone()]);
        assert!(off.abs() < 1e-8, "{off}");
        assert!(length(edge) <= 2.0 * settings.range);
    }
}
