//! The limits of joints in URDFs, and the notes on missing ones.

use crate::elements::{massless, one_joint, unlimited};
use aghf::model::Limits;
use aghf::urdf::LoadNote::ZeroLimit;

#[test]
fn missing_limits_are_told_and_mean_none() {
    for (kind, notes) in [
        ("revolute", vec![massless("base"), unlimited("body_joint")]),
        ("prismatic", vec![massless("base"), unlimited("body_joint")]),
        ("continuous", vec![massless("base")]),
    ] {
        let (model, report) = one_joint(kind, "");
        assert_eq!(report, notes, "{kind}");
        assert_eq!(*model.joints()[0].limits(), Limits::NONE, "{kind}");
    }
    assert!(unlimited("j").to_string().contains("joint 'j': no limits"));
}

/// Exporters write zero for an unknown limit, with or without a range.
#[test]
fn velocity_and_effort_of_zero_are_told_and_mean_none() {
    let zero = |attribute: &'static str| ZeroLimit {
        joint: "body_joint".to_owned(),
        attribute,
    };
    let endless = f64::INFINITY;
    for (kind, velocity, effort) in [
        ("revolute", "0", "4"),
        ("revolute", "3", "0"),
        ("prismatic", "0.0", "-0"),
        ("continuous", "0", "4"),
        ("continuous", "3", "0"),
    ] {
        let limit =
            format!(r#"<limit lower="-1" upper="2" velocity="{velocity}" effort="{effort}"/>"#);
        let (model, report) = one_joint(kind, &limit);
        let ranged = kind != "continuous";
        let [v, u] = [velocity, effort].map(|x| x.parse::<f64>().expect("a number"));
        let kept = |x: f64| if x == 0.0 { endless } else { x };
        let expected = Limits {
            lower: if ranged { -1.0 } else { -endless },
            upper: if ranged { 2.0 } else { endless },
            velocity: kept(v),
            effort: kept(u),
        };
        assert_eq!(*model.joints()[0].limits(), expected, "{kind}: {limit}");
        let mut notes = vec![massless("base")];
        notes.extend((v == 0.0).then(|| zero("velocity")));
        notes.extend((u == 0.0).then(|| zero("effort")));
        assert_eq!(report, notes, "{kind}: {limit}");
    }
    // A range of length zero counts if another limit is nonzero.
    let (model, report) = one_joint("revolute", r#"<limit velocity="0" effort="4"/>"#);
    let limits = model.joints()[0].limits();
    assert_eq!(
        [limits.lower, limits.upper, limits.velocity],
        [0.0, 0.0, endless]
    );
    assert_eq!(report, [massless("base"), zero("velocity")]);
    let words = "joint 'body_joint': its effort limit of 0 counts as unknown";
    assert!(zero("effort").to_string().starts_with(words));
}

#[test]
fn limits_are_kept_and_continuous_joints_have_none_on_position() {
    let limit = r#"<limit lower="-1" upper="2" velocity="3" effort="4"/>"#;
    let kept = Limits {
        lower: -1.0,
        upper: 2.0,
        velocity: 3.0,
        effort: 4.0,
    };
    let endless = Limits {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        ..kept
    };
    for (kind, expected) in [
        ("revolute", kept),
        ("prismatic", kept),
        ("continuous", endless),
    ] {
        let (model, report) = one_joint(kind, limit);
        assert_eq!(*model.joints()[0].limits(), expected, "{kind}");
        assert_eq!(report, [massless("base")], "{kind}");
    }
}
