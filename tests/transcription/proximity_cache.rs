//! Rows that are far and so not evaluated: searches are to the last bit those with all rows.

use crate::common::{constraint::in_bodies, direct::solved_within, robot};
use aghf::constraint::{
    AnyConstraint, Bounds, CollisionSphere, Constraints, Evaluator, SelfClearance, SolidClearance, Sphere,
    SphereClearance, TorqueLimits,
};
use aghf::direct::{DirectSettings, DirectSolution};
use aghf::geometry::{Shape, Solid};
use aghf::model::Model;
use aghf::motion::Problem;
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};

type Kept = Constraints<Vec<AnyConstraint>>;

/// An arm with balls that keep clear of each other, of a table and a post, and of a ball in its way.
fn crowded(model: &Model) -> Kept {
    let mut balls = CollisionSphere::joint_frames(model);
    for ball in &mut balls {
        ball.radius = 0.05;
    }
    let count = balls.len();
    // The hand is in the middle of the post half way of the shortest motion.
    let middle = [0.85, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0, 0., 0., 0., 0., 0., 0., 0.];
    let mut evaluator = Evaluator::new(model);
    let placed = evaluator.at(&middle).expect("valid");
    let hand = placed.state().placements[6].translation;
    let pairs = (0..count).flat_map(|i| (i + 3..count).map(move |j| [i, j]));
    let solid = |shape, [x, y, z]: [f64; 3]| Solid {
        placement: Placement::new(Matrix3::identity(), Vector3::new(x, y, z)),
        shape,
    };
    let table = Shape::Cuboid { half_extents: Vector3::new(0.3, 0.6, 0.02) };
    let post = Shape::Cylinder { radius: 0.06, half_length: 0.2 };
    let state = vec![
        AnyConstraint::Bounds(Bounds::velocities(model)),
        AnyConstraint::Solids(SolidClearance {
            balls: balls.clone(),
            solids: vec![solid(table, [hand.x, hand.y, hand.z - 0.5]), solid(post, hand.into())],
            names: Vec::new(),
        }),
        AnyConstraint::Spheres(SphereClearance {
            balls: balls.clone(),
            spheres: vec![Sphere { centre: Vector3::new(0.0, hand.y, hand.z + 0.3), radius: 0.1 }],
        }),
        AnyConstraint::SelfCollision(SelfClearance { balls, pairs: pairs.collect() }),
    ];
    Constraints { state, torque: TorqueLimits::of(model), stage: Default::default() }
}

/// A motion around the post, where all rows are evaluated as soon as a ball has moved by `moved` of the reach.
fn around_the_post(model: &Model, kept: &Kept, (segments, degree): (usize, usize), moved: f64) -> DirectSolution {
    let ends = [0.0, 1.7].map(|q| vec![q, 0.6, 0.0, 1.6, 0.0, 0.8, 0.0, 0., 0., 0., 0., 0., 0., 0.]);
    let [start, goal] = ends;
    let problem = Problem::new(model, start, goal, 2.5).expect("valid");
    let mut settings = DirectSettings { segments, degree, starts: 1, ..DirectSettings::constrained() };
    settings.search.moved = moved;
    solved_within(&problem, &settings, kept)
}

/// Asserts that two searches took the same iterations to the same motion.
fn assert_same(one: &DirectSolution, other: &DirectSolution) {
    assert_eq!(one.iterations, other.iterations);
    assert_eq!(one.largest_violation, other.largest_violation);
    assert_eq!(one.curve.at(0.7), other.curve.at(0.7));
}

/// With lists of rows that may be near, iterations, rows between the points and the end are those with all rows: no row
/// comes near unseen.
#[test]
fn rows_that_are_far_change_nothing() {
    let model = robot("kinova_gen3");
    let kept = crowded(&model);
    let default = DirectSettings::constrained().search.moved;
    for basis in [(1, 12), (3, 6)] {
        let all = around_the_post(&model, &kept, basis, 1e3);
        assert!(all.converged && all.iterations.len() > 20, "{all:?}");
        for moved in [default, 0.2 * default, 1e-6] {
            assert_same(&all, &around_the_post(&model, &kept, basis, moved));
        }
    }
    // The post is in the way of a motion whose effort is mostly that of holding the arm: it costs far more than the
    // tolerance of 1e-6.
    let mut free = kept.clone();
    free.state.truncate(1);
    let [near, free] = [&kept, &free].map(|kept| around_the_post(&model, kept, (1, 12), default));
    assert!(near.cost > 1.0005 * free.cost, "{} {}", near.cost, free.cost);
}

/// Lists of rows of convex bodies change no motion, whether they are made anew at each point or not.
#[test]
fn rows_of_bodies_that_are_far_change_nothing() {
    let model = robot("kinova_gen3");
    let mut kept = crowded(&model);
    let Some(AnyConstraint::Solids(of)) = kept.state.get(1) else { panic!("solids are the second") };
    let bodies = in_bodies(&model, of.solids.clone());
    kept.state[1] = AnyConstraint::Convex(bodies);
    kept.state.truncate(2);
    let default = DirectSettings::constrained().search.moved;
    let [lists, anew] = [default, 1e-6].map(|moved| around_the_post(&model, &kept, (1, 12), moved));
    for end in [&lists, &anew] {
        assert!(end.converged && end.largest_violation < 1e-6, "{end:?}");
    }
    assert!((lists.cost - anew.cost).abs() < 1e-6 * lists.cost, "{} {}", lists.cost, anew.cost);
    kept.state.truncate(1);
    let free = around_the_post(&model, &kept, (1, 12), default);
    assert!(lists.cost > 1.0001 * free.cost, "{} {}", lists.cost, free.cost);
}

/// An obstacle out of reach changes nothing.
#[test]
fn an_obstacle_out_of_reach_changes_nothing() {
    let model = robot("kinova_gen3");
    let (kept, mut more) = (crowded(&model), crowded(&model));
    let far = Sphere { centre: Vector3::new(0.0, 9.0, 9.0), radius: 0.3 };
    let Some(AnyConstraint::Spheres(clearance)) = more.state.get_mut(2) else { panic!("spheres are the third") };
    clearance.spheres.push(far);
    let moved = DirectSettings::constrained().search.moved;
    let [one, other] = [&kept, &more].map(|kept| around_the_post(&model, kept, (1, 12), moved));
    assert_same(&one, &other);
}
