//! Moved goals, memory and deadlines.

use super::*;
use crate::common::constraint::in_bodies;

/// A goal that moves by about 1 cm at the tool has a safe plan after an eighth of the iterations of a new search.
#[test]
fn a_moved_goal_takes_an_eighth_of_the_iterations() {
    let model = robot("kinova_gen3");
    let mut rng = ChaCha8Rng::seed_from_u64(39);
    let mut counts = Vec::new();
    let mut options = options(12);
    options.settings.search.most_starts = 2;
    while counts.len() < 20 {
        let middle = reach(&model);
        let mut near =
            |q: &[f64], size: f64| -> Vec<f64> { q.iter().map(|q| q + rng.random_range(-size..size)).collect() };
        let (start, goal) = (near(&middle.start()[..7], 0.3), near(&middle.goal()[..7], 0.3));
        let target = near(&goal, 0.015);
        let problem = Problem::new(&model, at_rest(&start), at_rest(&goal), 2.0).expect("valid");
        let kept = kept(&model, [0.3, 0.4, 0.5]);
        let cost = ControlEffort::new(&model);
        let found = Tracker::new(&problem, kept.clone(), cost, options.clone());
        // There may be none between random ends, which a few starts show.
        let Ok(mut tracker) = found else { continue };
        let (mut x, mut now) = (problem.start().to_vec(), 0.0);
        for k in 0..150 {
            now = 0.004 * f64::from(k);
            let command = tracker.step(&x, now).expect("valid").command;
            x = [&command.q[..], &command.v].concat();
        }
        let left = 2.0 - now;
        tracker.set_goal(&target, left).expect("valid");
        let mut iterations = 0;
        loop {
            let step = tracker.step(&x, now).expect("valid");
            iterations += step.iterations;
            if step.replaced || iterations > 100 {
                break;
            }
        }
        let from = Problem::new(&model, x, at_rest(&target), left).expect("valid");
        let direct = Direct::new(&from).constraints(&kept);
        let cold = direct.settings(options.settings.clone()).solve().expect("valid");
        counts.push((iterations, cold.iterations.len()));
    }
    let [warm, cold] = [counts.iter().map(|(warm, _)| warm).sum::<usize>(), counts.iter().map(|(_, cold)| cold).sum()];
    assert!(8 * warm <= cold, "{counts:?}");
}

/// The limits of a robot, balls around its joints that keep clear of each other, and three obstacles that they and
/// convex bodies keep clear of.
fn crowded(model: &Model) -> Kept {
    let mut kept = kept(model, [0.3, 0.4, 0.5]);
    let mut balls = CollisionSphere::joint_frames(model);
    for ball in &mut balls {
        ball.radius = 0.04;
    }
    let count = balls.len();
    let apart = (0..count).flat_map(|i| (i + 3..count).map(move |j| [i, j]));
    let apart: Vec<_> = apart.collect();
    let solid =
        |shape, place: [f64; 3]| Solid { placement: Placement::new(Matrix3::identity(), Vector3::from(place)), shape };
    let half_extents = Vector3::new(0.25, 0.4, 0.02);
    let [half_length, radius] = [0.3, 0.05];
    let post = Shape::Cylinder { radius, half_length };
    let solids = vec![
        solid(Shape::Cuboid { half_extents }, [0.6, 0.0, 0.0]),
        solid(post, [-0.45, 0.3, 0.3]),
        solid(Shape::Sphere { radius: 0.1 }, [0.3, 0.4, 0.5]),
    ];
    let bodies = in_bodies(model, solids.clone());
    let beside = SolidClearance { balls: balls.clone(), solids, names: Vec::new() };
    kept.state.extend([
        AnyConstraint::SelfCollision(SelfClearance { balls, pairs: apart }),
        AnyConstraint::Solids(beside),
        AnyConstraint::Convex(bodies),
    ]);
    kept
}

/// After the first steps nothing is allocated: with looks and a goal that moves, among near obstacles, and where plans
/// take the place of others.
#[test]
fn steps_allocate_nothing() {
    let model = robot("kinova_gen3");
    assert!(allocating_steps(&model, crowded(&model)).0 > 150);
    let [_, replaced] = allocating_steps(&model, kept(&model, FAR)).into();
    assert!(replaced > 3, "{replaced}");
}

/// Takes 400 steps, and asserts that those after the first 100 allocate nothing; returns the numbers of their
/// iterations and of plans that took the place of others.
fn allocating_steps(model: &Model, kept: Kept) -> (usize, usize) {
    let problem = reach(model);
    let mut tracker = tracker(&problem, kept, options(16));
    let mut x = problem.start().to_vec();
    let mut goal = problem.goal()[..7].to_vec();
    let mut steps = |from: u32| {
        let (mut iterations, mut replaced) = (0, 0);
        for k in from..from + 100 {
            if k.is_multiple_of(10) {
                goal[0] += 0.002;
                tracker.set_goal(&goal, 1.0).expect("valid");
            }
            let deadline = (k.is_multiple_of(7)).then_some(Duration::ZERO);
            tracker.set_deadline(deadline);
            let step = tracker.step(&x, 0.002 * f64::from(k)).expect("valid");
            iterations += step.iterations;
            replaced += usize::from(step.replaced);
            x[..7].copy_from_slice(&step.command.q);
            x[7..].copy_from_slice(&step.command.v);
        }
        (iterations, replaced)
    };
    steps(0);
    let mut all = (0, 0);
    for from in [100, 200, 300] {
        let mut done = (0, 0);
        let of = allocation_counter::measure(|| done = steps(from));
        assert_eq!(of.count_total, 0, "{of:?}");
        all = (all.0 + done.0, all.1 + done.1);
    }
    all
}

/// Without time the command is that of the first plan, to its end.
#[test]
fn without_time_the_last_plan_is_followed() {
    let model = robot("kinova_gen3");
    let problem = reach(&model);
    let kept = || kept(&model, FAR);
    let options = TrackerOptions { deadline: Some(Duration::ZERO), ..options(9) };
    let mut tracker = tracker(&problem, kept(), options);
    let plan = tracker.rest().expect("a plan");
    tracker.step(problem.start(), 3.0).expect("valid");
    tracker.set_goal(&[0.1; 7], 1.0).expect("valid");
    for k in 0..=16 {
        let t = 0.1 * f64::from(k);
        let (x, xdot) = plan.at(t.min(plan.horizon()));
        let step = tracker.step(x.as_slice(), 3.0 + t).expect("valid");
        assert!(step.cut_off && step.iterations == 0 && !step.replaced);
        assert_eq!((step.outcome, step.safety), (Outcome::Working, Safety::Kept));
        assert!(step.deviation < 1e-9, "{}", step.deviation);
        if t < plan.horizon() {
            assert!(distance(&step.command.a, &xdot.as_slice()[7..]) < 1e-6);
        } else {
            assert_eq!(step.command.a, [0.0; 7]);
        }
        // The rest of a polynomial is the same polynomial.
        let rest = tracker.rest().expect("a plan");
        let end = plan.horizon();
        let middle = (rest.horizon() / 2.0, end - rest.horizon() / 2.0);
        let [(a, _), (b, _)] = [rest.at(middle.0), plan.at(middle.1)];
        assert!((a - b).amax() < 1e-9);
    }
    tracker.set_deadline(None);
    let step = tracker.step(&at_rest(&[0.1; 7]), 5.0).expect("valid");
    assert!(!step.cut_off && step.iterations > 0);
}
