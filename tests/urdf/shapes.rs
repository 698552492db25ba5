//! Collision elements: read, moved with their links and written; and the data of an SRDF.

use aghf::dynamics::forward_kinematics;
use aghf::geometry::Shape;
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::{Srdf, parse_urdf};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A robot of `base`, `arm`, `tool`, which is fixed to `arm`, and `finger`: each has a shape, `tool` two.
const ROBOT: &str = r#"<robot name="shapes">
  <link name="base"><collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision></link>
  <link name="arm">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision name="shaft"><origin xyz="0 0 0.25" rpy="0.1 0.2 0.3"/>
      <geometry><cylinder radius="0.05" length="0.5"/></geometry></collision>
  </link>
  <link name="tool">
    <collision><origin xyz="0.01 0.02 0.03"/><geometry><sphere radius="0.07"/></geometry></collision>
    <collision><origin rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.02" length="0.1"/></geometry></collision>
  </link>
  <link name="finger">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><mesh filename="package://hand/finger.stl" scale="1 -1 0.001"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute"><origin xyz="0 0 0.3" rpy="0.3 0 0"/><parent link="base"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="flange" type="fixed"><origin xyz="0 0.1 0.5" rpy="0 0 0.5"/><parent link="arm"/><child link="tool"/></joint>
  <joint name="grip" type="revolute"><origin xyz="0.1 0 0" rpy="0 0.4 0"/><parent link="tool"/><child link="finger"/>
    <axis xyz="1 0 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>"#;

fn robot() -> Model {
    parse_urdf(ROBOT, "shapes.urdf").expect("it is good").0
}

/// The placements of the shapes in the base frame, with their links.
fn placed(model: &Model, q: &[f64]) -> Vec<(String, Placement<f64>)> {
    let mut placements = vec![Placement::identity(); model.dof()];
    forward_kinematics(model, q, &mut placements).expect("lengths agree");
    let all = model.collisions().iter().map(|c| {
        let body = c.body.map_or(Placement::identity(), |b| placements[b]);
        (c.link.clone(), body.compose(&c.placement))
    });
    all.collect()
}

fn assert_same_places(a: &[(String, Placement<f64>)], b: &[(String, Placement<f64>)]) {
    assert_eq!(a.len(), b.len());
    for ((link, a), (other, b)) in a.iter().zip(b) {
        assert_eq!(link, other);
        assert_close!(&a.translation, &b.translation, 1e-14);
        assert_close!(&a.rotation, &b.rotation, 1e-14);
    }
}

#[test]
fn shapes_are_those_of_the_elements_in_the_bodies_of_their_links() {
    let model = robot();
    let shapes: Vec<_> = model.collisions().iter().map(|c| &c.shape).collect();
    let solid = |shape| CollisionShape::Solid(shape);
    let expected = [
        solid(Shape::Cuboid {
            half_extents: Vector3::new(0.1, 0.2, 0.3),
        }),
        solid(Shape::Cylinder {
            radius: 0.05,
            half_length: 0.25,
        }),
        solid(Shape::Sphere { radius: 0.07 }),
        solid(Shape::Capsule {
            radius: 0.02,
            half_length: 0.05,
        }),
        CollisionShape::Mesh {
            file: "package://hand/finger.stl".to_owned(),
            scale: Vector3::new(1.0, -1.0, 0.001),
        },
    ];
    assert_eq!(shapes, expected.iter().collect::<Vec<_>>());
    let bodies: Vec<_> = model.collisions().iter().map(|c| c.body).collect();
    assert_eq!(bodies, [None, Some(0), Some(0), Some(0), Some(1)]);
    // The tool is fixed to the arm: its sphere is in the body of the arm, at the product of both placements.
    let flange = Rotation3::from_euler_angles(0.0, 0.0, 0.5);
    let expected = flange * Vector3::new(0.01, 0.02, 0.03) + Vector3::new(0.0, 0.1, 0.5);
    assert_close!(
        &model.collisions()[2].placement.translation,
        &expected,
        1e-15
    );
    let shaft = Rotation3::from_euler_angles(0.1, 0.2, 0.3).into_inner();
    assert_close!(&model.collisions()[1].placement.rotation, &shaft, 1e-15);
    let cast = model.cast::<f64>();
    assert_eq!(cast.collisions(), model.collisions());
}

#[test]
fn shapes_of_locked_joints_stay_where_they_were() {
    let model = robot();
    let all = placed(&model, &[0.7, -1.1]);
    let first = model
        .with_locked_joints(&[(0, 0.7)])
        .expect("in the limits");
    assert_same_places(&placed(&first, &[-1.1]), &all);
    assert!(first.collisions()[..4].iter().all(|c| c.body.is_none()));
    let second = model
        .with_locked_joints(&[(1, -1.1)])
        .expect("in the limits");
    assert_same_places(&placed(&second, &[0.7]), &all);
    assert_eq!(second.collisions()[4].body, Some(0));
}

#[test]
fn shapes_that_are_written_are_read_back() {
    let model = robot();
    let models = [
        model
            .with_locked_joints(&[(0, 0.7)])
            .expect("in the limits"),
        model
            .with_locked_joints(&[(1, -1.1)])
            .expect("in the limits"),
        model,
    ];
    for model in models {
        let text = model.to_urdf().expect("a URDF can say it");
        let (read, _) = parse_urdf(&text, "written.urdf").expect("it is good");
        let q = vec![0.4; model.dof()];
        assert_same_places(&placed(&read, &q), &placed(&model, &q));
        let shapes = |m: &Model| {
            m.collisions()
                .iter()
                .map(|c| c.shape.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(shapes(&read), shapes(&model));
    }
}

#[test]
fn shapes_that_no_urdf_can_say_are_refused() {
    let model = robot();
    let point = CollisionShape::Solid(Shape::Sphere { radius: 0.0 });
    let at = Placement::identity();
    let point = Collision::at_link(&model, "tool", &at, point).expect("the link is there");
    let mirror = Placement::new(-Matrix3::identity(), Vector3::zeros());
    let ball = CollisionShape::Solid(Shape::Sphere { radius: 1.0 });
    let turned = Collision::at_link(&model, "tool", &mirror, ball).expect("the link is there");
    for (collision, words) in [(point, "radius"), (turned, "a shape of it cannot be said")] {
        let model = model.clone().with_collisions(vec![collision]);
        let error = model
            .and_then(|m| m.to_urdf())
            .expect_err("it is bad")
            .to_string();
        assert!(
            error.contains("link 'tool'") && error.contains(words),
            "{error}"
        );
    }
    let mut elsewhere = model.collisions().to_vec();
    elsewhere[1].body = None;
    let error = model
        .with_collisions(elsewhere)
        .expect_err("arm moves")
        .to_string();
    assert!(error.contains("link 'arm'"), "{error}");
}

#[test]
fn bad_collision_elements_are_refused_by_link_and_element() {
    for (good, bad, words) in [
        (
            r#"radius="0.07""#,
            r#"radius="0""#,
            "collision 1;radius of its sphere;positive",
        ),
        (
            r#"radius="0.07""#,
            r#"radius="NaN""#,
            "collision 1;radius of its sphere;positive",
        ),
        (
            r#"radius="0.07""#,
            r#"radius="big""#,
            "collision 1;radius of its sphere is 'big'",
        ),
        (
            r#"radius="0.07""#,
            "",
            "collision 1;its sphere has no radius",
        ),
        (
            r#"radius="0.02" length="0.1""#,
            r#"radius="0.02" length="-1""#,
            "collision 2;length of its capsule has -1",
        ),
        (
            r#"<sphere radius="0.07"/>"#,
            "",
            "collision 1;geometry is empty",
        ),
        (
            r#"<geometry><sphere radius="0.07"/></geometry>"#,
            "",
            "collision 1;no geometry element",
        ),
        (
            r#"<sphere radius="0.07"/>"#,
            "<torus/>",
            "collision 1;'torus', none of sphere",
        ),
        (
            r#"<sphere radius="0.07"/>"#,
            r#"<sphere radius="1"/><box size="1 1 1"/>"#,
            "collision 1;several shapes",
        ),
        (
            r#"xyz="0.01 0.02 0.03""#,
            r#"xyz="0.01 0.02""#,
            "collision 1;xyz of its origin",
        ),
        (
            r#"xyz="0.01 0.02 0.03""#,
            r#"xyz="0 inf 0""#,
            "collision 1;origin is not a finite number",
        ),
    ] {
        assert_eq!(ROBOT.matches(good).count(), 1, "{good}");
        let error = parse_urdf(&ROBOT.replace(good, bad), "shapes.urdf").expect_err(bad);
        let text = error.to_string();
        assert!(text.starts_with("shapes.urdf: link 'tool': "), "{text}");
        assert!(
            words.split(';').all(|w| text.contains(w)),
            "{text}; {words}"
        );
    }
    for (good, bad, words) in [
        (
            r#"size="0.2 0.4 0.6""#,
            r#"size="0.2 0.4 -0.6""#,
            "link 'base';size of its box has -0.6",
        ),
        (
            r#"size="0.2 0.4 0.6""#,
            r#"size="0.2 0.4""#,
            "link 'base';size of its box;3 numbers",
        ),
        (
            r#"radius="0.05" length"#,
            r#"radius="0.05" height"#,
            "link 'arm';collision 'shaft';no length",
        ),
        (
            r#"scale="1 -1 0.001""#,
            r#"scale="1 0 1""#,
            "link 'finger';scale of its mesh",
        ),
        (
            r#"filename="package://hand/finger.stl""#,
            "",
            "link 'finger';no filename",
        ),
    ] {
        let error = parse_urdf(&ROBOT.replace(good, bad), "shapes.urdf").expect_err(bad);
        let text = error.to_string();
        assert!(
            words.split(';').all(|w| text.contains(w)),
            "{text}; {words}"
        );
    }
}

const SRDF: &str = r#"<robot name="shapes">
  <group name="all"><chain base_link="base" tip_link="nowhere"/></group>
  <disable_collisions link1="base" link2="arm" reason="Adjacent"/>
  <disable_collisions link1="finger" link2="base"/>
  <link_sphere_approximation link="tool"><sphere center="0.1 0 0" radius="0.2"/><sphere center="0 0.1 0" radius="0.3"/></link_sphere_approximation>
  <link_sphere_approximation link="finger"><sphere center="0 0 0" radius="0"/></link_sphere_approximation>
</robot>"#;

#[test]
fn pairs_and_spheres_of_an_srdf_are_read() {
    let model = robot();
    let srdf = Srdf::parse(SRDF, "shapes.srdf", &model).expect("it is good");
    let pairs: Vec<_> = srdf
        .disabled
        .iter()
        .map(|p| (p.links.join(" "), p.reason.as_str()))
        .collect();
    let expected = [
        ("base arm".to_owned(), "Adjacent"),
        ("finger base".to_owned(), ""),
    ];
    assert_eq!(pairs, expected);
    let with = srdf
        .with_spheres(model.clone())
        .expect("the links are there");
    let links: Vec<_> = with.collisions().iter().map(|c| c.link.as_str()).collect();
    assert_eq!(
        links,
        ["base", "arm", "tool", "tool"],
        "the finger has none"
    );
    let flange = Rotation3::from_euler_angles(0.0, 0.0, 0.5);
    let centre = flange * Vector3::new(0.1, 0.0, 0.0) + Vector3::new(0.0, 0.1, 0.5);
    assert_close!(&with.collisions()[2].placement.translation, &centre, 1e-15);
    assert_eq!(
        with.collisions()[2].shape,
        CollisionShape::Solid(Shape::Sphere { radius: 0.2 })
    );
}

#[test]
fn bad_srdfs_are_refused_by_element() {
    let model = robot();
    for (good, bad, words) in [
        (
            r#"link2="arm""#,
            r#"link2="leg""#,
            "disable_collisions at line 3;link2;no link 'leg'",
        ),
        (
            r#" link2="arm""#,
            "",
            "disable_collisions at line 3;no link2",
        ),
        (
            r#"link="tool""#,
            r#"link="leg""#,
            "link_sphere_approximation at line 5;no link 'leg'",
        ),
        (
            r#"link="finger""#,
            r#"link="tool""#,
            "link_sphere_approximation at line 6;'tool' has spheres already",
        ),
        (r#"radius="0.2""#, r#"radius="-1""#, "line 5;radius -1"),
        (
            r#"radius="0.2""#,
            r#"radius="wide""#,
            "line 5;'wide', not a number",
        ),
        (
            r#"center="0.1 0 0""#,
            r#"center="0.1 0""#,
            "line 5;3 numbers",
        ),
        ("</robot>", "", "robot: ;not a valid SRDF"),
        ("<group", r#"<joint name="a"/><group"#, "robot: ;a URDF"),
    ] {
        assert_eq!(SRDF.matches(good).count(), 1, "{good}");
        let error = Srdf::parse(&SRDF.replace(good, bad), "shapes.srdf", &model).expect_err(bad);
        let text = error.to_string();
        assert!(text.starts_with("shapes.srdf: "), "{text}");
        assert!(
            words.split(';').all(|w| text.contains(w)),
            "{text}; {words}"
        );
    }
}
