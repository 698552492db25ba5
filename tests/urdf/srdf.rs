//! Pairs of links and spheres of links in an SRDF.

use crate::shapes::robot;
use aghf::geometry::Shape;
use aghf::model::CollisionShape;
use aghf::urdf::Srdf;
use nalgebra::{Rotation3, Vector3};
use std::collections::BTreeSet;

pub const SRDF: &str = r#"<robot name="shapes">
  <group name="all"><chain base_link="base" tip_link="nowhere"/></group>
  <disable_collisions link1="base" link2="arm" reason="Adjacent"/>
  <disable_collisions link1="finger" link2="base"/>
  <link_sphere_approximation link="tool"><sphere center="0.1 0 0" radius="0.2"/>
  <sphere center="0 0.1 0" radius="0.3"/></link_sphere_approximation>
  <link_sphere_approximation link="finger"><sphere center="0 0 0" radius="0"/></link_sphere_approximation>
  <disable_collisions link1="wheel" link2="base" reason="Never"/>
</robot>"#;

#[test]
fn pairs_and_spheres_of_an_srdf_are_read() {
    let model = robot();
    let srdf = Srdf::parse(SRDF, "shapes.srdf", &model).expect("it is good");
    let pairs: Vec<_> = srdf.disabled.iter().map(|p| (p.links.join(" "), p.reason.as_str())).collect();
    let expected = [("base arm".to_owned(), "Adjacent"), ("finger base".to_owned(), "")];
    assert_eq!(pairs, expected);
    // The robot has no wheels.
    assert_eq!(srdf.unknown_links, BTreeSet::from(["wheel".to_owned()]));
    let with = srdf.with_spheres(model.clone()).expect("the links are there");
    let links: Vec<_> = with.collisions().iter().map(|c| c.link.as_str()).collect();
    assert_eq!(links, ["base", "arm", "tool", "tool"], "the finger has none");
    let flange = Rotation3::from_euler_angles(0.0, 0.0, 0.5);
    let centre = flange * Vector3::new(0.1, 0.0, 0.0) + Vector3::new(0.0, 0.1, 0.5);
    assert_close!(&with.collisions()[2].placement.translation, &centre, 1e-15);
    assert_eq!(with.collisions()[2].shape, CollisionShape::Solid(Shape::Sphere { radius: 0.2 }));
}

/// As in MoveIt: collisions of a link are off by default, single pairs on again, and those that are disabled stay off.
#[test]
fn collisions_of_a_link_are_disabled_by_default() {
    let model = robot();
    let text = r#"<robot name="shapes"><disable_collisions link1="arm" link2="base" reason="Adjacent"/>
      <enable_collisions link1="base" link2="tool"/><enable_collisions link1="arm" link2="base"/>
      <enable_collisions link1="finger" link2="tool"/><enable_collisions link1="tail" link2="base"/>
      <disable_default_collisions link="base"/><disable_default_collisions link="finger"/>
      <disable_default_collisions link="wheel"/></robot>"#;
    let srdf = Srdf::parse(text, "shapes.srdf", &model).expect("it is good");
    let pairs = srdf.disabled.iter().map(|p| p.links.join(" "));
    let pairs: Vec<_> = pairs.collect();
    assert_eq!(pairs, ["arm base", "base finger", "finger arm"]);
    let unknown = ["tail", "wheel"].map(str::to_owned);
    assert_eq!(srdf.unknown_links, BTreeSet::from(unknown));
}
