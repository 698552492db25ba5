//! The notes on loading a robot, except for those on its limits.

use crate::elements::{massless, one_joint, unlimited};
use aghf::urdf::LoadNote::{self, ImpossibleInertia, Independent, LeftOut, Merged};
use aghf::urdf::{parse_urdf, summarised};

fn left_out(attribute: &'static str) -> LoadNote {
    LeftOut { joint: "body_joint".to_owned(), attribute }
}

#[test]
fn damping_and_friction_that_are_left_out_are_told() {
    let (damping, friction) = (left_out("damping"), left_out("friction"));
    for (dynamics, losses) in [
        ("<dynamics/>", vec![]),
        (r#"<dynamics damping="0.0" friction=" -0 "/>"#, vec![]),
        (r#"<dynamics damping="0.5"/>"#, vec![damping.clone()]),
        (r#"<dynamics friction="1e-9" damping="0"/>"#, vec![friction.clone()]),
        (r#"<dynamics damping="much" friction="1"/>"#, vec![damping, friction]),
    ] {
        let (_, report) = one_joint("continuous", dynamics);
        assert_eq!(report, [vec![massless("base")], losses].concat(), "{dynamics}");
    }
    let words = "joint 'body_joint': damping is not counted, as losses are not asked for";
    assert_eq!(left_out("damping").to_string(), words);
}

#[test]
fn a_summary_has_a_line_a_kind_of_what_bears_on_motions() {
    let merged = Merged { link: "l".to_owned(), joint: "j".to_owned(), into: None };
    let impossible =
        |link: &str, condition: &str| ImpossibleInertia { link: link.to_owned(), condition: condition.to_owned() };
    let independent = Independent { joint: "a".to_owned(), mimics: "b".to_owned() };
    assert!(summarised(&[massless("base"), merged.clone()]).is_empty());
    let mut report = vec![massless("base"), independent, impossible("x", "odd"), impossible("y", "odder"), merged];
    report.extend(["1", "2", "3", "4", "5"].map(unlimited));
    assert_eq!(
        summarised(&report),
        [
            "joint 'a': mimics 'b', independent here",
            "links 'x', 'y': no body can have such an inertia",
            "joints '1', '2', '3' and 2 more: no limits",
        ]
    );
}

/// Exporters leave rounding errors in place of zeros; a moment below a mass times (1e-8 m)^2 counts as zero.
#[test]
fn a_moment_of_rounding_is_not_impossible() {
    let notes = |ixz: &str| {
        let text = format!(
            "<robot name='r'><link name='base'/><link name='body'><inertial><origin xyz='0 0 -0.5'/>\
            <mass value='1.33687'/>
               <inertia ixx='0' ixy='0' ixz='{ixz}' iyy='0' iyz='0' izz='0'/></inertial></link>
             <joint name='j' type='continuous'><parent link='base'/><child link='body'/>\
             <axis xyz='0 1 0'/></joint></robot>"
        );
        let (_, report) = parse_urdf(&text, "r.urdf").expect("it swings");
        report.len() - 1
    };
    assert_eq!([notes("2.40741e-35"), notes("1e-19"), notes("1e-15")], [0, 0, 1]);
}
