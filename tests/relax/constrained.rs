//! The relaxation within constraints: the derivatives of what it minimises, optima that are known, and what it says where there is none.

use crate::common::assert_refused;
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, Evaluator, HalfSpace,
    HalfSpaceClearance, Side, Sphere, SphereClearance, TorqueLimits,
};
use aghf::dynamics::{Data, rnea};
use aghf::model::{JointKind, JointSpec, Limits, Model, random_tree};
use aghf::motion::{Problem, sample};
use aghf::relax::{
    Augmented, Point, PointCost, PointDerivatives, RelaxSettings, RelaxSolution, relax,
    relax_constrained,
};
use aghf::scalar::{AlgebraOver, Jet};
use aghf::scenario::{Scenario, SolveOptions, solve};
use aghf::spatial::{Inertia, Placement};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Kept = Constraints<Vec<AnyConstraint>>;

/// A point of mass one on sliders along these axes, without gravity: $u = \ddot q$.
fn point_mass(axes: &[Vector3<f64>]) -> Model {
    let slider = |(i, axis): (usize, &Vector3<f64>)| JointSpec {
        name: format!("slider_{i}"),
        kind: JointKind::Prismatic,
        parent: i.checked_sub(1),
        origin: Placement::identity(),
        axis: *axis,
        inertia: if i + 1 == axes.len() {
            Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity())
        } else {
            Inertia::from_com(0.0, Vector3::zeros(), Matrix3::zeros())
        },
        limits: Limits::NONE,
    };
    let specs = axes.iter().enumerate().map(slider).collect();
    Model::from_joints("point mass", specs).expect("it is a tree")
}

fn state(constraint: AnyConstraint) -> Kept {
    Constraints {
        state: vec![constraint],
        torque: TorqueLimits(Vec::new()),
    }
}

fn solved(problem: &Problem<'_>, kept: &Kept) -> RelaxSolution {
    let settings = RelaxSettings::constrained();
    relax_constrained(problem, &settings, kept, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

/// The cost by its formula, with the rows counted in that are active.
fn by_formula<S: AlgebraOver<f64>>(
    model: &Model,
    kept: &Kept,
    rho: f64,
    [multipliers, margins, active]: [&[f64]; 3],
    z: &[S],
) -> S {
    let n = model.dof();
    let mut u = vec![S::zero(); n];
    let (q, rest) = z.split_at(n);
    let (v, a) = rest.split_at(n);
    rnea(model, &mut Data::new(model), q, v, a, &mut u).expect("sizes agree");
    let mut h = vec![S::zero(); kept.dim()];
    let states = kept.state.dim();
    let mut evaluator = Evaluator::new(model);
    let placed = evaluator.at(&z[..2 * n]).expect("sizes agree");
    placed
        .value(&kept.state, &mut h[..states])
        .expect("sizes agree");
    kept.torque
        .value(&u, &mut h[states..])
        .expect("sizes agree");
    let mut slopes = vec![1.0; states];
    kept.state.row_scales(&mut slopes);
    slopes.extend(kept.torque.0.iter().flatten().flat_map(|limit| [*limit; 2]));
    let mut cost = u.iter().fold(S::zero(), |sum, u| sum + *u * *u);
    for (j, h) in h.into_iter().enumerate() {
        let h = h.scale(1.0 / slopes[j]) + S::from_f64(margins[j]);
        let t = S::from_f64(multipliers[j]) + h.scale(rho);
        cost += (t * t).scale(active[j] / (2.0 * rho));
    }
    cost
}

/// All kinds of constraints at once, rows active and not, against numbers that move twice.
#[test]
fn derivatives_are_those_of_duals() {
    type Twice = Jet<Jet<f64, 1>, 1>;
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (n, seed) in [(3, 1), (4, 2), (5, 7)] {
        let model = random_tree(n, seed).expect("n > 0");
        let mut number = || rng.random_range(-1.0..1.0);
        let mut vector = || Vector3::from_fn(|_, _| number());
        let balls: Vec<CollisionSphere> = (0..n)
            .map(|body| CollisionSphere {
                body: Some(body),
                centre: vector(),
                radius: 0.1,
            })
            .collect();
        let spheres = (0..3).map(|_| Sphere {
            centre: vector(),
            radius: 1.0,
        });
        let spheres = spheres.collect();
        let bounds = (0..2 * n).flat_map(|entry| {
            [(Side::Lower, -0.2), (Side::Upper, 0.3)].map(|(side, value)| Bound {
                entry,
                side,
                value,
            })
        });
        let half_space = HalfSpace {
            normal: vector().normalize(),
            offset: 0.1,
        };
        let kept = Constraints {
            state: vec![
                AnyConstraint::Spheres(SphereClearance {
                    balls: balls.clone(),
                    spheres,
                }),
                AnyConstraint::HalfSpace(HalfSpaceClearance { balls, half_space }),
                AnyConstraint::Bounds(Bounds(bounds.collect())),
            ],
            torque: TorqueLimits((0..n).map(|i| (i > 0).then_some(0.5 * i as f64)).collect()),
        };
        let rho = 7.0;
        let mut cost = Augmented::new(&model, &kept, rho, 1).expect("sizes agree");
        let rows = kept.dim();
        cost.multipliers = (0..rows).map(|_| rng.random_range(-0.5..3.0)).collect();
        cost.margins = (0..rows).map(|_| rng.random_range(0.0..0.1)).collect();
        let z: Vec<f64> = (0..3 * n).map(|_| rng.random_range(-1.0..1.0)).collect();
        let point = Point {
            index: 0,
            time: 0.0,
            q: &z[..n],
            v: &z[n..2 * n],
            a: &z[2 * n..],
        };
        let mut out = PointDerivatives::new(n);
        let value = cost.derivatives(point, &mut out).expect("sizes agree");
        let again = cost.value(point).expect("sizes agree");
        assert!((value - again).abs() <= 1e-13 * value);

        // A row is active where its own share of the cost is not nothing.
        let none = vec![0.0; rows];
        let share = |j: usize| {
            let mut only = none.clone();
            only[j] = 1.0;
            let with = [&cost.multipliers[..], &cost.margins[..], &only[..]];
            let at = |z: &[f64]| by_formula(&model, &kept, rho, with, z);
            let effort = by_formula(&model, &kept, rho, [&none, &none, &none], &z);
            let squared = (at(&z) - effort) * 2.0 * rho;
            // Its sign: a larger multiplier makes an active row cost more.
            let mut more = cost.multipliers.clone();
            more[j] += 1e-6;
            let with = [&more[..], &cost.margins[..], &only[..]];
            let larger = by_formula(&model, &kept, rho, with, &z) - effort;
            f64::from(larger * 2.0 * rho > squared)
        };
        let active: Vec<f64> = (0..rows).map(share).collect();
        let count = active.iter().sum::<f64>() as usize;
        assert!((3..rows - 3).contains(&count), "{count} of {rows}");

        let with = [&cost.multipliers[..], &cost.margins[..], &active[..]];
        assert!((by_formula(&model, &kept, rho, with, &z) - value).abs() <= 1e-12 * value);
        let mut hessian = DMatrix::zeros(3 * n, 3 * n);
        let mut gradient = vec![0.0; 3 * n];
        for i in 0..3 * n {
            for j in 0..3 * n {
                let mut moved: Vec<Twice> = z
                    .iter()
                    .map(|z| <Twice as AlgebraOver<f64>>::lift(*z))
                    .collect();
                moved[i].re.eps[0] += 1.0;
                moved[j].eps[0].re += 1.0;
                let dual = by_formula(&model, &kept, rho, with, &moved);
                hessian[(i, j)] = dual.eps[0].eps[0];
                gradient[i] = dual.re.eps[0];
            }
        }
        // Sums of some hundred products in another order.
        assert_close!(&out.gradient, &gradient, 1e-12);
        assert_close!(&out.hessian, &hessian, 1e-12);
    }
}

/// A point that has to go around a ball: it touches it, pays for that, and a multiplier pulls nowhere else.
#[test]
fn a_point_goes_around_a_ball() {
    let model = point_mass(&[Vector3::x(), Vector3::y()]);
    let start = vec![0.0, 0.0, 0.0, 0.0];
    let problem = Problem::new(&model, start, vec![1.0, 0.0, 0.0, 0.0], 1.0).expect("valid");
    let (centre, radius) = (Vector3::new(0.5, 0.05, 0.0), 0.2);
    let ball = CollisionSphere {
        body: Some(1),
        centre: Vector3::zeros(),
        radius: 0.0,
    };
    let kept = state(AnyConstraint::Spheres(SphereClearance {
        balls: vec![ball],
        spheres: vec![Sphere { centre, radius }],
    }));
    let solution = solved(&problem, &kept);
    assert!(solution.converged && solution.smallest_curvature > 0.0);
    assert!(solution.gradient_norm <= 1e-6 && solution.largest_violation <= 1e-6);
    let samples = sample(&model, &solution.curve, 5000).expect("sizes agree");
    let distance = |q: &[f64]| (Vector3::new(q[0], q[1], 0.0) - centre).norm() - radius;
    let least = samples
        .iter()
        .map(|s| distance(&s.q))
        .fold(f64::INFINITY, f64::min);
    assert!((-1e-6..1e-5).contains(&least), "{least}");
    // Below, where the way is shorter, and nearly symmetric: the rows pull at the points of the quadrature beside the touch, here
    // 5 mm to one side, and not where it is.
    let (middle, _) = solution.curve.at(0.5);
    assert!(
        (middle[0] - 0.5).abs() < 1e-2 && (middle[1] + 0.15).abs() < 1e-3,
        "{middle} {least} {}",
        solution.cost
    );
    let free = relax(&problem, &RelaxSettings::default(), &mut |_| {}).expect("valid");
    assert!(solution.cost > free.cost + 0.1, "{}", solution.cost);
    let again = solved(&problem, &kept);
    assert_eq!(again.curve.x(), solution.curve.x());
}

/// The double integrator with a limit on its velocity: the velocity rises as a parabola to the limit, stays there and falls.
/// Without a limit it would reach 1.5 in the middle, and the cost would be 12.
#[test]
fn a_velocity_limit_is_kept_at_the_known_cost() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let limited = |value: f64| {
        let bound = Bound {
            entry: 1,
            side: Side::Upper,
            value,
        };
        solved(&problem, &state(AnyConstraint::Bounds(Bounds(vec![bound]))))
    };
    let solution = limited(1.2);
    assert!(
        solution.converged && solution.largest_violation <= 1e-6,
        "{solution:?}"
    );
    // It rises for 3 (v T - d) / 2 v, which is a quarter, and costs 8 v^2 / 3 times the inverse of that. A polynomial comes near.
    let exact = 8.0 * 1.44 / 3.0 / 0.25;
    let excess = solution.cost / exact - 1.0;
    assert!((0.0..0.02).contains(&excess), "{excess}");
    // The mean has to be one.
    let impossible = limited(0.9);
    assert!(!impossible.converged && impossible.largest_violation > 0.05);
    // No limit that binds: the cubic.
    let loose = limited(1.6);
    assert!(loose.converged && (loose.cost - 12.0).abs() < 1e-9);
}

#[test]
fn a_torque_limit_is_kept() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let kept = Constraints {
        state: Vec::new(),
        torque: TorqueLimits(vec![Some(5.0)]),
    };
    let solution = solved(&problem, &kept);
    assert!(
        solution.converged && solution.largest_violation <= 1e-6,
        "{solution:?}"
    );
    let samples = sample(&model, &solution.curve, 5000).expect("sizes agree");
    let most = samples.iter().map(|s| s.u[0].abs()).fold(0.0_f64, f64::max);
    assert!((5.0 - 1e-4..=5.0 + 1e-6).contains(&most), "{most}");
    // Without a limit the force is 6 at the ends and the cost 12.
    assert!(
        solution.cost > 12.0 && solution.cost < 13.0,
        "{}",
        solution.cost
    );
    // Four would do for the distance if it were forward for one half and backward for the other.
    let kept = Constraints {
        torque: TorqueLimits(vec![Some(3.9)]),
        ..kept
    };
    assert!(!solved(&problem, &kept).converged);
    let kept = Constraints {
        torque: TorqueLimits(vec![None; 2]),
        ..kept
    };
    let limits = Constraints {
        torque: TorqueLimits(vec![Some(1.0); 2]),
        ..kept
    };
    let settings = RelaxSettings::constrained();
    let of_another = relax_constrained(&problem, &settings, &limits, &mut |_| {});
    assert_refused(of_another, "torque limits: expected 1 entries, found 2");
}

#[test]
fn an_arm_among_spheres_keeps_clear() {
    let scenario = Scenario::load("kinova_obstacles_01").expect("built in");
    let outcome = solve(&scenario, &SolveOptions::default(), &mut |_| {}).expect("valid");
    let summary = outcome.summary;
    assert!(summary.success, "{summary:?}");
    assert!(summary.control_effort < 29.0, "{summary:?}");
    let clearance = summary.feasibility.smallest_clearance_m;
    assert!(clearance.is_some_and(|m| m >= -1e-6), "{clearance:?}");
}

/// With these bends the first candidate stalls within the constraints, and the next one ends at a minimum. That the first stalled
/// shows in the degrees: another candidate goes on from a lower one only after that.
#[test]
fn what_converged_is_told_of_rather_than_what_stalled() {
    let scenario = Scenario::load("kinova_obstacles_04").expect("built in");
    let requirements = Constraints {
        state: scenario.state_constraints().expect("valid"),
        torque: scenario.torque_limits(),
    };
    let settings = RelaxSettings {
        start_amplitude: 1.25,
        ..SolveOptions::default().relax_settings(&scenario)
    };
    let problem = scenario.problem().expect("valid");
    let solution =
        relax_constrained(&problem, &settings, &requirements, &mut |_| {}).expect("valid");
    let degrees: Vec<_> = solution.iterations.iter().map(|i| i.degree).collect();
    let highest = settings.degree;
    let gave_up = |w: &[usize]| w[0] == highest && w[1] < highest;
    assert!(
        degrees.windows(2).any(gave_up),
        "the first candidate did not stall, find other bends: {degrees:?}"
    );
    assert!(solution.converged);
}

/// An end that is in a sphere cannot be helped, and it is said how deep it is.
#[test]
fn an_end_in_an_obstacle_is_a_failure() {
    let model = point_mass(&[Vector3::x()]);
    let problem = Problem::new(&model, vec![0.0; 2], vec![1.0, 0.0], 1.0).expect("valid");
    let bound = Bound {
        entry: 0,
        side: Side::Upper,
        value: 0.9,
    };
    let solution = solved(&problem, &state(AnyConstraint::Bounds(Bounds(vec![bound]))));
    assert!(!solution.converged && solution.largest_violation >= 0.1 - 1e-9);
}
