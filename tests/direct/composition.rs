//! Constraints in lists, tuples and boxes.

use crate::common::direct::solved_within;
use crate::common::robot;
use aghf::constraint::{
    AnyConstraint, Bound, Bounds, CollisionSphere, Constraint, Constraints, DynConstraint, PlacedState, Side,
    SolidClearance, Sphere, SphereClearance, TorqueLimits,
};
use aghf::direct::{DirectSettings, DirectSolution};
use aghf::geometry::Solid;
use aghf::motion::Problem;
use aghf::scalar::AlgebraOver;
use nalgebra::Vector3;

/// The first joint is no faster than that. It can be neither cloned nor printed.
struct Below(f64);

impl Constraint for Below {
    fn dim(&self) -> usize {
        1
    }

    fn value<S: AlgebraOver<f64>>(&self, at: &PlacedState<'_, f64, S>, g: &mut [S]) -> aghf::Result<()> {
        g[0] = at.x[2] - S::from_f64(self.0);
        Ok(())
    }
}

/// Three constraints that bind, in whatever holds them, lead to the same motion, to the last bit; and by several
/// threads.
#[test]
fn what_holds_constraints_does_not_matter() {
    let model = robot("pendulum_2");
    let problem = Problem::new(&model, vec![0.0; 4], vec![1.0, 0.5, 0.0, 0.0], 1.0).expect("valid");
    let tip = CollisionSphere { body: Some(1), centre: Vector3::zeros(), radius: 0.0 };
    let spheres = SphereClearance {
        balls: vec![tip],
        spheres: vec![Sphere { centre: Vector3::new(5.0, 0.0, 0.0), radius: 0.1 }],
    };
    let half_space =
        SolidClearance { balls: vec![tip], solids: vec![Solid::half_space(&Vector3::z(), -5.0)], names: Vec::new() };
    let upper = |entry, value| Bound { entry, side: Side::Upper, value };
    let slow = Bounds(vec![upper(2, 1.6), upper(3, 1.2)]);
    let tuple = within(&problem, (&spheres, &half_space, &slow));
    assert!(tuple.converged && tuple.largest_violation <= DirectSettings::FEASIBLE);
    let free = within(&problem, ());
    assert!(tuple.cost > 1.01 * free.cost, "{} {}", tuple.cost, free.cost);
    let any = vec![
        AnyConstraint::Spheres(spheres.clone()),
        AnyConstraint::Solids(half_space.clone()),
        AnyConstraint::Bounds(slow.clone()),
    ];
    let boxed: [Box<dyn DynConstraint>; 3] =
        [Box::new(spheres.clone()), Box::new(half_space.clone()), Box::new(slow.clone())];
    for list in [
        within(&problem, any.as_slice().iter().collect::<Vec<_>>()),
        within(&problem, any),
        within(&problem, boxed),
        within(&problem, ((spheres, half_space), slow.clone())),
    ] {
        assert_eq!(list.curve.x(), tuple.curve.x());
        assert_eq!(list.iterations.len(), tuple.iterations.len());
    }
    // One of a user's own, by its value alone, is as good as the bound that it is.
    let ours = within(&problem, (Below(1.6), Bounds(vec![upper(3, 1.2)])));
    let theirs = within(&problem, slow);
    assert_close!(ours.curve.x(), theirs.curve.x(), 1e-6);
}

fn within<K: Constraint + Send + Sync>(problem: &Problem<'_>, state: K) -> DirectSolution {
    let settings = DirectSettings { degree: 9, starts: 3, threads: 2, ..DirectSettings::constrained() };
    let torque = TorqueLimits(Vec::new());
    solved_within(problem, &settings, &Constraints { state, torque, stage: Default::default() })
}
