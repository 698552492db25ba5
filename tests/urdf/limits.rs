//! The limits of joints in URDFs, and the notes on missing ones.

use crate::elements::{massless, one_joint, unlimited};
use aghf::model::Limits;
use aghf::urdf::LoadNote::{HugeLimit, SoftLimits, ZeroLimit};

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
    let zero = |attribute: &'static str| ZeroLimit { joint: "body_joint".to_owned(), attribute };
    let endless = f64::INFINITY;
    for (kind, velocity, effort) in [
        ("revolute", "0", "4"),
        ("revolute", "3", "0"),
        ("prismatic", "0.0", "-0"),
        ("continuous", "0", "4"),
        ("continuous", "3", "0"),
    ] {
        let limit = format!(r#"<limit lower="-1" upper="2" velocity="{velocity}" effort="{effort}"/>"#);
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
    assert_eq!([limits.lower, limits.upper, limits.velocity], [0.0, 0.0, endless]);
    assert_eq!(report, [massless("base"), zero("velocity")]);
    let words = "joint 'body_joint': its effort limit of 0 counts as unknown";
    assert!(zero("effort").to_string().starts_with(words));
}

#[test]
fn limits_are_kept_and_continuous_joints_have_none_on_position() {
    let limit = r#"<limit lower="-1" upper="2" velocity="3" effort="4"/>"#;
    let kept = Limits { lower: -1.0, upper: 2.0, velocity: 3.0, effort: 4.0 };
    let endless = Limits { lower: f64::NEG_INFINITY, upper: f64::INFINITY, ..kept };
    for (kind, expected) in [("revolute", kept), ("prismatic", kept), ("continuous", endless)] {
        let (model, report) = one_joint(kind, limit);
        assert_eq!(*model.joints()[0].limits(), expected, "{kind}");
        assert_eq!(report, [massless("base")], "{kind}");
    }
}

/// Exporters write the largest number for none.
#[test]
fn huge_limits_are_told_and_mean_none() {
    let huge = |limit| HugeLimit { joint: "body_joint".to_owned(), limit };
    let endless = f64::INFINITY;
    let all = ["position", "velocity", "effort"].map(huge);
    for most in ["1.7976931348623157e308", "1e10", "3.4e38"] {
        let limit = format!(r#"<limit lower="-{most}" upper="{most}" velocity="{most}" effort="{most}"/>"#);
        let (model, report) = one_joint("revolute", &limit);
        assert_eq!(*model.joints()[0].limits(), Limits::NONE, "{most}");
        assert_eq!(report, [&[massless("base")][..], &all].concat(), "{most}");
        let (model, report) = one_joint("continuous", &limit);
        assert_eq!(*model.joints()[0].limits(), Limits::NONE, "{most}");
        assert_eq!(report, [&[massless("base")][..], &all[1..]].concat());
    }
    let words = "joint 'body_joint': its effort limit of 1e10 or more counts as no limit";
    assert_eq!(huge("effort").to_string(), words);
    // Infinity says so itself, and the other end of a range is kept.
    let limit = r#"<limit lower="-1" upper="inf" velocity="9e9" effort="inf"/>"#;
    let (model, report) = one_joint("prismatic", limit);
    let limits = model.joints()[0].limits();
    let kept = [limits.lower, limits.upper, limits.velocity, limits.effort];
    assert_eq!(kept, [-1.0, endless, 9e9, endless]);
    assert_eq!(report, [massless("base")]);
}

#[test]
fn soft_limits_are_told_with_the_share_that_keeps_them() {
    let limit = r#"<limit lower="-3" upper="3" velocity="1" effort="1"/>"#;
    let soft = |limits: &str, share: Option<&str>| SoftLimits {
        joint: "body_joint".to_owned(),
        limits: limits.to_owned(),
        share: share.map(str::to_owned),
    };
    for (limit, safety, note) in [
        (limit, r#"soft_lower_limit="-0.5" soft_upper_limit="0.5""#, Some(soft("-0.5 to 0.5", Some("0.166")))),
        (limit, r#"soft_lower_limit="-1" soft_upper_limit="2.5""#, Some(soft("-1 to 2.5", Some("0.333")))),
        (limit, r#"soft_lower_limit="1" soft_upper_limit="2""#, Some(soft("1 to 2", None))),
        (limit, r#"soft_upper_limit="low""#, Some(soft("-inf to NaN", None))),
        (limit, r#"soft_lower_limit="-3" soft_upper_limit="4""#, None),
        (limit, r#"soft_lower_limit="0" soft_upper_limit="0""#, None),
        (limit, "", None),
    ] {
        let safety = format!("{limit}<safety_controller {safety} k_velocity=\"1\"/>");
        let (model, report) = one_joint("revolute", &safety);
        let expected: Vec<_> = [massless("base")].into_iter().chain(note).collect();
        assert_eq!(report, expected, "{safety}");
        assert_eq!(model.joints()[0].limits().upper, 3.0);
    }
    let words = "joint 'body_joint': its soft limits -0.5 to 0.5 are not kept; \"enforced_limits\": \
                 {\"position\": 0.166}";
    let noted = soft("-0.5 to 0.5", Some("0.166")).to_string();
    assert!(noted.starts_with(words), "{noted}");
}
