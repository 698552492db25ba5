//! Inverse kinematics by the rows of frames.

use crate::common::{assert_refused, robot};
use aghf::constraint::{Bounds, Constraint, Evaluator, FrameRows};
use aghf::dynamics::{forward_kinematics, frame_placement};
use aghf::model::{Frame, Model};
use aghf::plan::{InverseKinematics, nearest_turn};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

fn limits(model: &Model) -> Vec<[f64; 2]> {
    let joints = model.joints().iter();
    joints.map(|joint| [joint.limits().lower, joint.limits().upper]).collect()
}

fn pose(model: &Model, frame: &Frame<f64>, q: &[f64]) -> Placement<f64> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("its joints");
    frame_placement(frame, &placements).expect("its frame")
}

fn largest(rows: &impl Constraint, model: &Model, q: &[f64]) -> f64 {
    let x = [q, &vec![0.0; q.len()]].concat();
    let mut g = vec![0.0; rows.dim()];
    let mut evaluator = Evaluator::<f64>::new(model);
    evaluator.at(&x).and_then(|at| at.value(rows, &mut g)).expect("its rows");
    let rows = g.iter().enumerate();
    rows.map(|(i, g)| if rows_equal(i) { g.abs() } else { *g }).fold(f64::NEG_INFINITY, f64::max)
}

/// The last row of a pose excludes half a turn.
fn rows_equal(row: usize) -> bool {
    row < 6
}

/// Each of many reachable poses of arms of seven joints is found, within the limits, and from few first guesses; the
/// error is that of the placement itself.
#[test]
fn reachable_poses_are_found_within_the_limits() {
    for name in ["kinova_gen3", "panda"] {
        let (model, mut rng) = (robot(name), ChaCha8Rng::seed_from_u64(7));
        let tool = model.frames().last().expect("it has links").clone();
        let (mut guessed, mut at_bounds) = (0, 0);
        for _ in 0..60 {
            let drawn = model.random_configuration(&mut rng);
            let wanted = pose(&model, &tool, &drawn);
            let rows = FrameRows::new(&tool, Frame::new("goal", None, wanted)).at_origin().oriented();
            let mut search = InverseKinematics::new(&model, &rows, limits(&model)).expect("bounds");
            let start = model.random_configuration(&mut rng);
            let mut guesses = search.guesses(&start, 3).take(64);
            let found = guesses.find_map(|guess| {
                guessed += 1;
                let end = search.solve(&guess).expect("its joints");
                (end.violation <= 1e-9).then_some(end.q)
            });
            let q = found.expect("it is reachable");
            let there = pose(&model, &tool, &q);
            assert!((there.translation - wanted.translation).norm() < 1e-8);
            assert!((there.rotation - wanted.rotation).norm() < 1e-8);
            for (q, [lower, upper]) in q.iter().zip(limits(&model)) {
                assert!((lower..=upper).contains(q));
                at_bounds += usize::from(*q == lower || *q == upper);
            }
        }
        assert!(guessed < 60 * 6, "{name}: {guessed}");
        assert!(at_bounds > 0, "{name}");
    }
}

/// A position within a box beyond the reach ends as near as possible: the arm is stretched towards it.
#[test]
fn an_arm_stretches_towards_a_point_beyond_its_reach() {
    let model = robot("pendulum_3");
    // All links are alike.
    let link = model.joints()[2].origin().translation;
    let tip = Frame::new("tip", Some(2), Placement::new(Matrix3::identity(), link));
    let far = pose(&model, &tip, &[0.4, 0.0, 0.0]).translation * 2.0;
    let rows = FrameRows::new(&tip, Frame::new("goal", None, Placement::new(Matrix3::identity(), far)));
    let rows = rows.at_origin();
    let mut search = InverseKinematics::new(&model, &rows, vec![[-PI, PI]; 3]).expect("bounds");
    let end = search.solve(&[0.1, 0.3, -0.2]).expect("its joints");
    assert!((end.violation - 0.5 * far.norm()).abs() < 1e-5, "{}", end.violation);
    for (q, stretched) in end.q.iter().zip([0.4, 0.0, 0.0]) {
        assert!((q - stretched).abs() < 1e-2, "{:?}", end.q);
    }
}

/// Inequalities that hold do not move the configuration.
#[test]
fn a_guess_within_the_rows_is_the_end() {
    let model = robot("kinova_gen3");
    let tool = model.frames().last().expect("it has links");
    let q = [0.3, -0.4, 0.1, 1.0, 0.2, -0.3, 0.5];
    let here = pose(&model, tool, &q);
    let rows = FrameRows::new(tool, Frame::new("goal", None, here));
    let rows = rows.within_distance(0.1).and_then(|rows| rows.within_angle(0.2)).expect("bounds");
    let mut search = InverseKinematics::new(&model, &rows, limits(&model)).expect("bounds");
    let end = search.solve(&q).expect("its joints");
    assert_eq!((end.q, end.violation), (q.to_vec(), 0.0));
    let end = search.solve(&q.map(|q| q + 0.5)).expect("its joints");
    assert!(end.violation <= 1e-9 && largest(&rows, &model, &end.q) < 1e-9);
}

#[test]
fn guesses_are_within_the_bounds_and_those_of_the_seed() {
    let model = robot("kinova_gen3");
    let (none, bounds) = (Bounds::<f64>(Vec::new()), limits(&model));
    let search = InverseKinematics::new(&model, &none, bounds.clone()).expect("bounds");
    let near = vec![0.2; 7];
    let draw = |seed| search.guesses(&near, seed).take(40).collect::<Vec<_>>();
    let all = draw(1);
    assert_eq!(all[0], near);
    assert_eq!(all, draw(1));
    assert_ne!(all[1..], draw(2)[1..]);
    for guess in &all {
        for (q, [lower, upper]) in guess.iter().zip(&bounds) {
            assert!(lower <= q && q <= upper && (q - 0.2).abs() <= TAU);
        }
    }
    let apart = |guess: &[f64]| guess.iter().map(|q| (q - 0.2).abs()).fold(0.0, f64::max);
    assert!(apart(&all[1]) <= 0.5 && apart(&all[2]) > 0.5);
}

/// Whole turns are taken back towards a configuration where the bounds allow it.
#[test]
fn turns_are_taken_back() {
    let model = robot("kinova_gen3");
    let none = Bounds::<f64>(Vec::new());
    let mut bounds = vec![[f64::NEG_INFINITY, f64::INFINITY]; 7];
    bounds[1] = [-4.0, 4.0];
    let search = InverseKinematics::new(&model, &none, bounds).expect("bounds");
    let found = search.nearer(&[7.0, -3.5, 0.1, 0.0, 0.0, 0.0, 0.0], &[0.5, 3.0, 6.0, 0.0, 0.0, 0.0, 40.0]);
    let expected = [7.0 - TAU, TAU - 3.5, 0.1 + TAU, 0.0, 0.0, 0.0, 6.0 * TAU];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-14);
    }
}

/// By whole turns, within bounds even if a farther turn would be nearer.
#[test]
fn an_angle_is_the_nearest_of_its_turns() {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    for (q, near, bounds, turns) in [
        (-3.1, 3.1, free, 1.0),
        (0.1, 12.6, free, 2.0),
        (7.0, 0.5, free, -1.0),
        (0.5, 0.6, free, 0.0),
        (0.1, 12.6, [-1.0, 7.0], 1.0),
        (-3.1, 3.1, [-3.15, 3.15], 0.0),
    ] {
        assert_eq!(nearest_turn(q, near, bounds), q + TAU * turns);
    }
}

#[test]
fn bounds_that_nothing_is_between_are_refused() {
    let model = robot("pendulum_2");
    let none = Bounds::<f64>(Vec::new());
    for bad in [[1.0, 0.0], [f64::NAN, 1.0]] {
        let found = InverseKinematics::new(&model, &none, vec![[0.0, 1.0], bad]);
        assert_refused(found, "exceeds the upper bound");
    }
    assert_refused(InverseKinematics::new(&model, &none, Vec::new()), "expected 2 entries, found 0");
    let turned = Rotation3::from_euler_angles(0.0, 0.1, 0.0).into_inner();
    let frame = Frame::new("tool", Some(5), Placement::new(turned, Vector3::zeros()));
    let rows = FrameRows::new(&frame, Frame::new("goal", None, Placement::identity())).at_origin();
    let mut search = InverseKinematics::new(&model, &rows, vec![[0.0, 1.0]; 2]).expect("bounds");
    assert_refused(search.solve(&[0.0; 2]), "expected 6 entries, found 2");
    assert_refused(search.solve(&[0.0; 3]), "expected 2 entries, found 3");
}
