//! Robots of many links, and robots that are too large.

use aghf::model::{MAX_DOF, random_chain};
use aghf::spatial::Placement;
use aghf::urdf::{load_urdf, parse_urdf};
use nalgebra::Vector3;
use std::fmt::Write;

const LINKS: usize = 20_000;

/// A link of mass one at its origin, and a joint of this kind on the previous link, at a distance of 1 mm.
fn link(text: &mut String, i: usize, kind: &str) {
    let inertia = "<inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/>";
    write!(
        text,
        "<link name='l{i}'><inertial><mass value='1'/>{inertia}</inertial></link>
         <joint name='j{i}' type='{kind}'><origin xyz='0.001 0 0'/><parent link='l{}'/><child link='l{i}'/></joint>",
        i - 1
    )
    .expect("it is memory");
}

/// A chain of links on fixed joints after a revolute one, written from its end to its beginning.
#[test]
fn a_long_chain_of_fixed_links_becomes_one_body() {
    let mut links: Vec<String> = (1..=LINKS)
        .map(|i| {
            let mut text = String::new();
            link(&mut text, i, if i == 1 { "continuous" } else { "fixed" });
            text
        })
        .collect();
    links.reverse();
    let text = format!("<robot name='chain'>{}<link name='l0'/></robot>", links.concat());
    let (model, notes) = parse_urdf(&text, "chain.urdf").expect("it is a tree");
    assert_eq!((model.dof(), model.frames().len()), (1, LINKS + 1));
    assert_eq!(model.mass(), LINKS as f64);
    assert_eq!(notes.len(), LINKS, "the base is massless, all but two are merged");
    for (i, frame) in model.frames().iter().enumerate() {
        assert_eq!((frame.name.as_str(), frame.body), (format!("l{i}").as_str(), (i > 0).then_some(0)));
        let x = 1e-3 * (i as f64 - 1.0).max(0.0);
        let Placement { translation, .. } = frame.placement;
        assert!((translation - Vector3::x() * x).norm() < 1e-9 * LINKS as f64, "{i}: {translation}");
    }
    let written = model.to_urdf().expect("all of it can be said");
    let (read, _) = parse_urdf(&written, "written.urdf").expect("it was written");
    assert_eq!(read.frames().len(), LINKS + 1);
}

#[test]
fn elements_may_be_nested_deeply() {
    let nested = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    let mut text = format!("<robot name='deep'>{nested}<link name='l0'/>");
    link(&mut text, 1, "continuous");
    let (model, _) = parse_urdf(&(text + "</robot>"), "deep.urdf").expect("it is not about dynamics");
    assert_eq!(model.dof(), 1);
}

#[test]
fn there_is_a_largest_number_of_joints() {
    let chain = |n: usize| {
        let mut text = "<robot name='chain'><link name='l0'/>".to_owned();
        (1..=n).for_each(|i| link(&mut text, i, "prismatic"));
        text + "</robot>"
    };
    let error = parse_urdf(&chain(MAX_DOF + 1), "many.urdf").expect_err("too many");
    let words = "many.urdf: robot: has 257 moving joints, at most 256 are supported";
    assert_eq!(error.to_string(), words);
    assert!(random_chain(MAX_DOF, 1).is_ok() && random_chain(MAX_DOF + 1, 1).is_err());
}

#[test]
#[cfg(unix)]
fn a_file_without_end_is_no_urdf() {
    let error = load_urdf("/dev/zero".as_ref()).expect_err("it has no end");
    assert!(error.to_string().contains("more than 64 MiB"), "{error}");
}
