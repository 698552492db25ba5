//! Clearances and violated limits of a motion.

use aghf::curve::{Chebyshev, Curve};
use aghf_scenario::{
    Enforced, EnforcedLimits, Feasibility, HorizonBounds, LimitViolation, Quantity, RateLimits, Scenario,
};
use nalgebra::DMatrix;

/// A motion of 2 s that does not exist: Kinova upright, with these positions and velocities of joint 0 over time.
fn motion(q: impl Fn(f64) -> f64, v: impl Fn(f64) -> f64) -> Curve {
    let chebyshev = Chebyshev::new(4, 2.0).expect("a good degree");
    let times = chebyshev.times().to_vec();
    let x = DMatrix::from_fn(14, 5, |i, k| match i {
        0 => q(times[k]),
        7 => v(times[k]),
        _ => 0.0,
    });
    Curve::new(chebyshev, x).expect("sizes agree")
}

fn of(scenario: &Scenario, curve: &Curve) -> Feasibility {
    Feasibility::of(scenario, curve).expect("of this robot")
}

fn only(feasibility: &Feasibility) -> &LimitViolation {
    let [one] = &feasibility.limit_violations[..] else {
        panic!("{feasibility:?}");
    };
    one
}

#[test]
fn violations_are_reported_with_digits_that_show_them() {
    let mut violation = LimitViolation {
        joint: None,
        limit: Quantity::Other,
        name: "it".to_owned(),
        by: 1e-6,
        unit: "m".to_owned(),
        at_s: 0.0,
        enforced: true,
    };
    for (by, at_s, words) in [
        (1e-6, 0.0, "it by 1.00e-6 m at 0.000 s"),
        (0.0123, 0.01234, "it by 0.0123 m at 0.0123 s"),
        (12.34, 1.23456, "it by 12.3 m at 1.235 s"),
        (1e300, 1.2e-6, "it by 1.00e300 m at 1.20e-6 s"),
    ] {
        (violation.by, violation.at_s) = (by, at_s);
        assert_eq!(violation.to_string(), words);
    }
}

/// A scenario of Kinova without enforced limits.
fn free() -> Scenario {
    let mut scenario = Scenario::load("kinova_free_01").expect("built in");
    scenario.file.enforced_limits = EnforcedLimits::NONE;
    scenario
}

#[test]
fn broken_limits_of_the_position_are_reported() {
    let scenario = free();
    let joint = &scenario.model.joints()[0];
    let upper = joint.limits().upper;
    // Upright the arm turns about the vertical, and nothing but this joint has anything to do.
    let far = motion(|t| upper + 0.5 - (t - 1.0003).powi(2), |_| 0.0);
    let found = of(&scenario, &far);
    assert_eq!(found.smallest_clearance_m, None, "no obstacles");
    assert_eq!(found.nearest, None);
    let limit = only(&found);
    assert_eq!(limit.limit, Quantity::Position);
    assert_eq!(limit.joint.as_deref(), Some(joint.name()));
    assert_eq!(limit.name, format!("upper position limit of joint '{}'", joint.name()));
    assert_eq!((limit.unit.as_str(), limit.enforced), ("rad", false));
    assert!((limit.by - 0.5).abs() < 1e-12 && (limit.at_s - 1.0003).abs() < 1e-6);
    assert!(found.holds(0.0) && found.reason(0.0).is_none(), "none is enforced");
}

/// Too fast both ways: the error has the worse of the two.
#[test]
fn broken_limits_of_the_velocity_are_reported_and_enforced_ones_matter() {
    let mut scenario = free();
    let joint = &scenario.model.joints()[0];
    let (name, limit) = (joint.name(), joint.limits().velocity);
    let fast = motion(|_| 0.0, |t| (t - 1.2) * (limit + 0.0123) / 0.8);
    let found = of(&scenario, &fast);
    let speeds = found.limit_violations.iter();
    let speeds: Vec<_> = speeds.filter(|v| v.limit == Quantity::Velocity).collect();
    assert_eq!(speeds.len(), 1, "{found:?}");
    let speed = speeds[0];
    assert_eq!((speed.enforced, speed.unit.as_str()), (false, "rad/s"));
    assert_eq!(speed.name, format!("lower velocity limit of joint '{name}'"));
    let most = 1.5 * (limit + 0.0123) - limit;
    assert!((speed.by - most).abs() < 1e-12 && speed.at_s == 0.0);
    assert!(found.holds(0.0));
    let largest = found.unlimited_acceleration.expect("it is not limited");
    assert_eq!((&*largest.joint, &*largest.unit), (name, "rad/s^2"));
    assert!((largest.value - (limit + 0.0123) / 0.8).abs() < 1e-9, "{largest}");
    scenario.file.enforced_limits.acceleration = Some(RateLimits::Same(5.0));
    assert_eq!(of(&scenario, &fast).unlimited_acceleration, None);
    scenario.file.enforced_limits.acceleration = None;
    assert_eq!(of(&scenario, &fast).limit_shares, []);
    scenario.file.enforced_limits.velocity = Enforced::default();
    let found = of(&scenario, &fast);
    let shares: Vec<_> = found.limit_shares.iter().map(|share| (share.limit, share.joint.as_str())).collect();
    assert_eq!(shares, [(Quantity::Velocity, name)]);
    assert!((found.limit_shares[0].share - (limit + most) / limit).abs() < 1e-9, "{found:?}");
    assert!(!found.holds(0.0) && !found.holds(most - 1e-9) && found.holds(most + 1e-9));
}

#[test]
fn a_slightly_broken_limit_is_reported_with_digits() {
    let mut scenario = free();
    scenario.file.enforced_limits.velocity = Enforced::default();
    let joint = &scenario.model.joints()[0];
    let (name, limit) = (joint.name(), joint.limits().velocity);
    let slightly = motion(|_| 0.0, |t| limit + 1.23456e-6 - 0.1 * t);
    let found = of(&scenario, &slightly);
    let words = format!("upper velocity limit of joint '{name}' by 1.23e-6 rad/s at 0.000 s");
    assert_eq!(only(&found).to_string(), words);
    assert_eq!(found.reason(1e-6), Some(format!("violated: {words}")));
    assert_eq!((found.reason(1.3e-6), found.holds(1.3e-6)), (None, true));
    for (by, words) in [(0.01234, "0.0123"), (1.5, "1.50"), (999.0, "999"), (1234.5, "1235"), (2e5, "2.00e5")] {
        let speed = LimitViolation { by, ..only(&found).clone() };
        assert!(speed.to_string().contains(&format!(" by {words} rad/s")), "{speed}");
    }
}

/// The torque is that of inverse dynamics, and is told whether it is enforced or not, once.
#[test]
fn a_torque_beyond_its_limit() {
    let mut scenario = Scenario::load("kinova_free_01").expect("built in");
    let effort = scenario.model.joints()[0].limits().effort;
    for enforced in [false, true] {
        scenario.file.enforced_limits = EnforcedLimits {
            torque: if enforced { Enforced::default() } else { Enforced::No },
            ..EnforcedLimits::NONE
        };
        // Hard enough whatever the inertia about the vertical is.
        let found = of(&scenario, &motion(|_| 0.0, |t| 1e3 * effort * (t - 1.0)));
        let torques = found.limit_violations.iter();
        let mut torques = torques.filter(|v| v.limit == Quantity::Torque);
        let torque = torques.next().expect("the first joint");
        assert_eq!((torque.unit.as_str(), torque.enforced), ("N m", enforced));
        let first = scenario.model.joints()[0].name();
        assert_eq!(torque.joint.as_deref(), Some(first));
        assert!(torques.all(|v| v.joint.as_deref() != Some(first)));
        assert_eq!(found.holds(1e-3), !enforced);
    }
}

#[test]
fn a_collision_is_reported() {
    let scenario = Scenario::load("kinova_gap_01").expect("it can be generated");
    let chebyshev = Chebyshev::new(2, 1.0).expect("a good degree");
    let line = |to: f64| {
        let x = DMatrix::from_fn(14, 3, |i, k| {
            let (file, t) = (&scenario.file, to * chebyshev.times()[k]);
            match i {
                0..7 => file.q_start[i] + (file.q_goal[i] - file.q_start[i]) * t,
                _ => 0.0,
            }
        });
        Curve::new(chebyshev.clone(), x).expect("sizes agree")
    };
    let start = of(&scenario, &line(0.0));
    assert!(start.smallest_clearance_m.is_some_and(|m| m > 0.02) && start.holds(0.0));
    let through = of(&scenario, &line(1.0));
    assert!(through.smallest_clearance_m.is_some_and(|m| m < -0.02) && !through.holds(1e-3));
    let nearest = through.nearest.as_ref().expect("it collides");
    let mut obstacles = scenario.scene.obstacles().iter();
    assert!(obstacles.any(|each| each.name == nearest.between[1]), "{nearest}");
    assert!(nearest.at_s > 0.0 && nearest.at_s < scenario.file.horizon_s, "{nearest}");
    let hit = through.limit_violations.iter();
    let hit: Vec<_> = hit.filter(|v| v.limit.is_clearance()).collect();
    assert!(hit.iter().all(|v| v.enforced && v.unit == "m" && v.joint.is_none()));
    let mut names: Vec<_> = hit.iter().map(|v| &v.name).collect();
    assert!(names[0].starts_with("distance of link '"), "{names:?}");
    names.dedup();
    assert_eq!(names.len(), hit.len(), "one for each link and obstacle");
    let reason = through.reason(1e-3).expect("it collides");
    assert!(reason.starts_with("violated: distance of link '"), "{reason}");
}

/// A motion is feasible only if it takes as long as the scenario allows.
#[test]
fn a_horizon_beyond_its_bounds_is_a_violation() {
    let mut scenario = free();
    scenario.file.free_horizon = Some(HorizonBounds { shortest_s: 0.5, longest_s: 3.0 });
    let lasting = |horizon: f64| {
        let chebyshev = Chebyshev::new(4, horizon).expect("a good degree");
        let curve = Curve::new(chebyshev, DMatrix::zeros(14, 5)).expect("sizes agree");
        of(&scenario, &curve)
    };
    for horizon in [0.5, 2.0, 3.0] {
        assert!(lasting(horizon).holds(1e-6), "{horizon}");
    }
    for (horizon, words) in [
        (0.1, "lower bound of the horizon by 0.400 s"),
        (0.4999, "lower bound of the horizon by 1.00e-4 s"),
        (3.001, "upper bound of the horizon by 0.001000 s"),
    ] {
        let found = lasting(horizon);
        let reason = found.reason(1e-6).expect("it is not kept");
        assert!(reason.contains(words), "{reason}");
    }
}
