//! The rows of a standing foot: by hand, and their names. Their derivatives are checked for all robots in
//! `derivatives`.

use crate::common::{assert_refused, point_mass};
use aghf::constraint::{Constraints, RateLimit, StageConstraints, StandingFoot, TorqueLimits};
use aghf::dynamics::{Data, root_wrench};
use aghf::model::Model;
use aghf::spatial::{Inertia, Placement};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A mass of 1 kg on three sliders along the axes, on a base of 2 kg with the centre at (0.1, 0, 0).
fn standing() -> Model {
    let base = Inertia::from_com(2.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::identity());
    let model = point_mass(&[Vector3::x(), Vector3::y(), Vector3::z()]);
    model.with_gravity(Vector3::new(0.0, 0.0, -10.0)).with_base_inertia(base)
}

fn foot() -> StandingFoot {
    // The length of the sole is along y of the base, its middle at (0.3, 0.2, -0.1).
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    StandingFoot {
        name: "left".to_owned(),
        sole: Placement::new(turn.into_inner(), Vector3::new(0.3, 0.2, -0.1)),
        half_length: 0.4,
        half_width: 0.5,
        friction: 0.6,
        torsion: Some(0.05),
        weight: 30.0,
    }
}

#[test]
fn rows_and_contact_are_those_by_hand() {
    let (model, foot) = (standing(), foot());
    let (q, still) = ([0.7, 0.5, 1.0], [0.0; 3]);
    let a = [6.0, -3.0, 5.0];
    let data = &mut Data::new(&model);
    let wrench = root_wrench(&model, data, &q, &still, &a).expect("its joints");
    // The weight of the base is 20 N, the force on the mass is (6, -3, 15) N.
    assert_eq!(wrench.linear, Vector3::new(6.0, -3.0, 35.0));
    let moment = Vector3::new(0.7, 0.5, 1.0).cross(&Vector3::new(6.0, -3.0, 15.0))
        + Vector3::new(0.1, 0.0, 0.0).cross(&Vector3::new(0.0, 0.0, 20.0));
    assert_close!(&wrench.angular, &moment, 1e-15);
    // Along the line of the force through each of the two, the pressure moves by the height of the mass above the sole.
    let on_sole =
        |of_mass: f64, of_base: f64, push: f64| (15.0 * (of_mass - push / 15.0 * 1.1) + 20.0 * of_base) / 35.0;
    let (x, y) = (on_sole(0.7, 0.1, 6.0), on_sole(0.5, 0.0, -3.0));
    let contact = foot.contact(&wrench);
    // y of the base is along the sole, -x across it.
    let centre = contact.centre_of_pressure;
    assert!((centre[0] - (y - 0.2)).abs() < 1e-12, "{centre:?}");
    assert!((centre[1] + (x - 0.3)).abs() < 1e-12, "{centre:?}");
    assert!((contact.friction - 6.0_f64.hypot(3.0) / 35.0).abs() < 1e-15);
    assert_close!(&Vector3::from(contact.force), &Vector3::new(-3.0, -6.0, 35.0), 1e-12);
    let turning = (0.4 * -3.0 - 0.3 * 6.0) / 35.0;
    assert!((contact.torsion - turning).abs() < 1e-12, "{contact:?}");

    let mut g = [0.0; 8];
    foot.value(&model, data, [&q, &still, &a], &mut g).expect("eight rows");
    let load = 35.0 / 30.0;
    let expected = [
        -load,
        load * (centre[0] - 0.4),
        load * (-centre[0] - 0.4),
        load * (centre[1] - 0.5),
        load * (-centre[1] - 0.5),
        load * (-turning - 0.05),
        load * (turning - 0.05),
        load * load * (contact.friction.powi(2) - 0.36) / 1.2,
    ];
    for (g, expected) in g.iter().zip(expected) {
        assert!((g - expected).abs() < 1e-12, "{g} {expected}");
    }
    // The torsion is the largest row of this foot, the friction that of a foot that slips.
    for friction in [foot.friction, 0.01] {
        let foot = StandingFoot { friction, ..foot.clone() };
        foot.rows(&wrench, &mut g).expect("eight rows");
        let largest = g.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let excess = foot.contact(&wrench).excess;
        assert!((excess - largest).abs() < 1e-12, "{excess} {largest}");
    }
}

#[test]
fn rows_have_names_and_units() {
    let (model, foot) = (standing(), foot());
    let rows = |foot| Constraints {
        state: (),
        torque: TorqueLimits(Vec::new()),
        stage: StageConstraints {
            rates: RateLimit::both(2, 0, 1.0).to_vec(),
            foot: Some(foot),
            ..StageConstraints::default()
        },
    };
    let all = rows(foot.clone());
    assert_eq!(all.dim(), 10);
    let name = |row| {
        let label = all.label(row, &model);
        (label.name, label.unit)
    };
    let of = |what: &str| format!("{what} of foot 'left'");
    assert_eq!(name(2), (of("normal force"), "of the weight"));
    assert_eq!(name(3), (of("front edge"), "m"));
    assert_eq!(name(6), (of("right edge"), "m"));
    assert_eq!(name(8), (of("torsion"), "m"));
    assert_eq!(name(9), (of("friction"), ""));
    let slippery = rows(StandingFoot { torsion: None, ..foot.clone() });
    assert_eq!(slippery.dim(), 8);
    assert_eq!(slippery.label(7, &model).name, of("friction"));
    let refused = rows(StandingFoot { friction: -0.5, ..foot });
    let words = "foot 'left': friction: it is -0.5 and must be a positive number";
    assert_refused(refused.check(&model), words);
}
