//! Collision elements: read, moved with their links, written.

use aghf::dynamics::forward_kinematics;
use aghf::geometry::Shape;
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::{UrdfOptions, load_mesh, parse_urdf, parse_urdf_with, read_visuals};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// `base` carries `arm`, to which `tool` is fixed, which carries `finger`: each with a shape, `tool` with two.
pub const ROBOT: &str = r#"<robot name="shapes">
  <link name="base"><collision><geometry><box size="0.2 0.4 0.6"/></geometry></collision></link>
  <link name="arm">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision name="shaft"><origin xyz="0 0 0.25" rpy="0.1 0.2 0.3"/>
      <geometry><cylinder radius="0.05" length="0.5"/></geometry></collision>
  </link>
  <link name="tool">
    <collision><origin xyz="0.01 0.02 0.03"/><geometry><sphere radius="0.07"/></geometry></collision>
    <collision><origin rpy="0 1.5707963267948966 0"/><geometry><capsule radius="0.02" length="0.1"/></geometry>
    </collision>
  </link>
  <link name="finger">
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <collision><geometry><mesh filename="package://hand/finger.stl" scale="1 -1 0.001"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute"><origin xyz="0 0 0.3" rpy="0.3 0 0"/><parent link="base"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="flange" type="fixed"><origin xyz="0 0.1 0.5" rpy="0 0 0.5"/><parent link="arm"/><child link="tool"/>
  </joint>
  <joint name="grip" type="revolute"><origin xyz="0.1 0 0" rpy="0 0.4 0"/><parent link="tool"/><child link="finger"/>
    <axis xyz="1 0 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>"#;

pub fn robot() -> Model {
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
        solid(Shape::Cuboid { half_extents: Vector3::new(0.1, 0.2, 0.3) }),
        solid(Shape::Cylinder { radius: 0.05, half_length: 0.25 }),
        solid(Shape::Sphere { radius: 0.07 }),
        solid(Shape::Capsule { radius: 0.02, half_length: 0.05 }),
        CollisionShape::Mesh { file: "package://hand/finger.stl".to_owned(), scale: Vector3::new(1.0, -1.0, 0.001) },
    ];
    assert_eq!(shapes, expected.iter().collect::<Vec<_>>());
    let bodies: Vec<_> = model.collisions().iter().map(|c| c.body).collect();
    assert_eq!(bodies, [None, Some(0), Some(0), Some(0), Some(1)]);
    // The tool is fixed to the arm: its sphere is in the body of the arm, at the product of both placements.
    let flange = Rotation3::from_euler_angles(0.0, 0.0, 0.5);
    let expected = flange * Vector3::new(0.01, 0.02, 0.03) + Vector3::new(0.0, 0.1, 0.5);
    assert_close!(&model.collisions()[2].placement.translation, &expected, 1e-15);
    let shaft = Rotation3::from_euler_angles(0.1, 0.2, 0.3).into_inner();
    assert_close!(&model.collisions()[1].placement.rotation, &shaft, 1e-15);
    let cast = model.cast::<f64>();
    assert_eq!(cast.collisions(), model.collisions());
}

#[test]
fn shapes_of_locked_joints_stay_where_they_were() {
    let model = robot();
    let all = placed(&model, &[0.7, -1.1]);
    let first = model.with_locked_joints(&[(0, 0.7)]).expect("in the limits");
    assert_same_places(&placed(&first, &[-1.1]), &all);
    assert!(first.collisions()[..4].iter().all(|c| c.body.is_none()));
    let second = model.with_locked_joints(&[(1, -1.1)]).expect("in the limits");
    assert_same_places(&placed(&second, &[0.7]), &all);
    assert_eq!(second.collisions()[4].body, Some(0));
}

#[test]
fn shapes_that_are_written_are_read_back() {
    let model = robot();
    let models = [
        model.with_locked_joints(&[(0, 0.7)]).expect("in the limits"),
        model.with_locked_joints(&[(1, -1.1)]).expect("in the limits"),
        model,
    ];
    for model in models {
        let text = model.to_urdf().expect("a URDF can say it");
        let (read, _) = parse_urdf(&text, "written.urdf").expect("it is good");
        let q = vec![0.4; model.dof()];
        assert_same_places(&placed(&read, &q), &placed(&model, &q));
        let shapes = |m: &Model| m.collisions().iter().map(|c| c.shape.clone()).collect::<Vec<_>>();
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
    for collision in [point, turned] {
        let model = model.clone().with_collisions(vec![collision]);
        let error = model.and_then(|m| m.to_urdf()).expect_err("it is bad").to_string();
        assert!(error.contains("link 'tool'") && error.contains("a shape of it cannot be said"), "{error}");
    }
    let mut elsewhere = model.collisions().to_vec();
    elsewhere[1].body = None;
    let error = model.with_collisions(elsewhere).expect_err("arm moves").to_string();
    assert!(error.contains("link 'arm'"), "{error}");
}

#[test]
fn files_in_packages_whose_folder_is_given_are_there_and_nowhere_else() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("given_packages");
    let given = folder.join("elsewhere");
    let above = folder.join("hand");
    for (package, x) in [(&given, 1.0), (&above, 2.0)] {
        std::fs::create_dir_all(package).expect("it is writable");
        let text = format!("v {x} 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
        std::fs::write(package.join("both.obj"), text).expect("it is writable");
    }
    std::fs::write(above.join("one.obj"), "").expect("it is writable");
    let packages = BTreeMap::from([("hand".to_owned(), given.clone())]);
    let read = |name: &str, packages: &BTreeMap<String, PathBuf>| {
        let text = ROBOT.replace("package://hand/finger.stl", name);
        let options = UrdfOptions { packages: packages.clone(), ..UrdfOptions::default() };
        let (model, _) = parse_urdf_with(&text, "shapes.urdf", options).expect("it is good");
        let (visuals, faults) = read_visuals(&text.replace("collision", "visual"), packages);
        assert!(faults.is_empty(), "{faults:?}");
        let last = &model.collisions().last().expect("it has four").shape;
        let visual = visuals.iter().find(|visual| visual.link == "finger");
        assert_eq!(&visual.expect("it has one").shape, last);
        match last {
            CollisionShape::Mesh { file, .. } => file.clone(),
            solid => panic!("{solid:?}"),
        }
    };
    let one = Vector3::repeat(1.0);
    for name in ["package://hand/both.obj", "package:///hand/both.obj"] {
        for (packages, x) in [(&packages, 1.0), (&BTreeMap::new(), 2.0)] {
            let file = read(name, packages);
            assert_eq!(load_mesh(&file, &folder, &one).expect(name)[0][0].x, x);
        }
    }
    let error = load_mesh(&read("package://hand/one.obj", &packages), &folder, &one);
    let error = error.expect_err("it is in the other one").to_string();
    let path = given.join("one.obj").display().to_string();
    assert!(error.contains("no such file") && error.contains(&path), "{error}");
    assert_eq!(read("package://arm/both.obj", &packages), "package://arm/both.obj");
    let error = load_mesh("package://arm/both.obj", &folder, &one).expect_err("nowhere");
    let words = "--package arm=FOLDER (in a scenario: \"packages\": {\"arm\": FOLDER}";
    assert!(error.to_string().contains(words), "{error}");
}
