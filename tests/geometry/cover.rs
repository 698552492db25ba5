//! Balls that cover shapes and meshes.

use aghf::geometry::{Cover, Shape, Solid, Triangle, cover_triangles};
use aghf::spatial::Placement;
use aghf::urdf::load_mesh;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// A point inside a shape, often on its surface.
fn point(shape: &Shape, rng: &mut ChaCha8Rng) -> Vector3<f64> {
    // Both ends of the range are frequent.
    let mut unit = || (rng.random_range(-1.5..1.5_f64)).clamp(-1.0, 1.0);
    let (a, b, c) = (unit(), unit(), unit());
    let around = |radius: f64| {
        let (sin, cos) = (TAU * 0.5 * a).sin_cos();
        Vector3::new(cos, sin, 0.0) * (radius * b.abs().sqrt())
    };
    match *shape {
        Shape::Sphere { radius } => Vector3::new(a, b, c).cap_magnitude(1.0) * radius,
        Shape::Cuboid { half_extents } => Vector3::new(a, b, c).component_mul(&half_extents),
        Shape::Cylinder { radius, half_length } => around(radius) + Vector3::z() * (half_length * c),
        Shape::Capsule { radius, half_length } => {
            let ball = Vector3::new(a, b, c).cap_magnitude(1.0) * radius;
            ball + Vector3::z() * (half_length * if c < 0.0 { -1.0 } else { b })
        }
        _ => unreachable!("it has no cover"),
    }
}

fn shapes() -> [Shape; 6] {
    [
        Shape::Sphere { radius: 0.1 },
        Shape::Cuboid { half_extents: Vector3::new(0.2, 0.07, 0.001) },
        Shape::Cuboid { half_extents: Vector3::new(0.1, 0.1, 0.3) },
        Shape::Cylinder { radius: 0.04, half_length: 0.2 },
        Shape::Cylinder { radius: 0.23, half_length: 0.06 },
        Shape::Capsule { radius: 0.03, half_length: 0.2 },
    ]
}

/// The largest distance of points of the balls from a shape: the samples include the point of each ball farthest from
/// the centre of the shape.
fn sticks_out(cover: &Cover, shape: &Shape, rng: &mut ChaCha8Rng) -> f64 {
    let mut largest = 0.0_f64;
    for ball in &cover.balls {
        for _ in 0..200 {
            let mut draw = || rng.random_range(-1.0..1.0_f64);
            let Some(way) = Vector3::new(draw(), draw(), draw()).try_normalize(1e-3) else {
                continue;
            };
            largest = largest.max(shape.distance(&(ball.centre + way * ball.radius)));
        }
        for way in [Vector3::x(), Vector3::y(), Vector3::z()] {
            for way in [way, -way] {
                largest = largest.max(shape.distance(&(ball.centre + way * ball.radius)));
            }
        }
    }
    largest
}

#[test]
fn every_point_of_a_shape_is_in_a_ball_and_no_ball_sticks_out_further_than_is_said() {
    let rng = &mut ChaCha8Rng::seed_from_u64(3);
    for shape in shapes() {
        for excess in [0.1, 0.03, 0.01] {
            let cover = shape.cover(excess).expect("sensible numbers");
            for _ in 0..3000 {
                let p = point(&shape, rng);
                assert!(shape.distance(&p) < 1e-12, "the test draws points inside");
                assert!(is_covered(&cover, &p), "{shape:?}, {excess}: {p:?}");
            }
            let found = sticks_out(&cover, &shape, rng);
            assert!(cover.excess <= excess, "{shape:?}, {excess}");
            // Up to rounding of radii.
            assert!(found <= cover.excess + 1e-8, "{shape:?}, {excess}: {found}");
            assert!(found >= 0.75 * cover.excess, "it is no loose bound: {found}, {}", cover.excess);
        }
    }
}

#[test]
fn a_cover_needs_few_balls() {
    let count = |i: usize, excess: f64| shapes()[i].cover(excess).expect("sensible").balls.len();
    assert_eq!(count(0, 0.01), 1);
    // Balls on the axis touch a cylinder all around; its rims need balls of their own.
    assert!((15..60).contains(&count(3, 0.01)), "{}", count(3, 0.01));
    assert!(count(3, 0.03) < 25, "{}", count(3, 0.03));
    // At most 2 sqrt(0.01 (2 * 0.03 + 0.01)) apart on 0.4 m.
    assert_eq!(count(5, 0.01), 9);
}

/// Returns true if a point is in a ball, up to rounding.
fn is_covered(cover: &Cover, p: &Vector3<f64>) -> bool {
    let mut balls = cover.balls.iter();
    balls.any(|b| (p - b.centre).norm() <= b.radius + 1e-12)
}

#[test]
fn the_cover_of_a_placed_shape_is_placed() {
    let shape = shapes()[4];
    let rotation = Rotation3::from_euler_angles(0.3, 1.0, -0.7).into_inner();
    let placement = Placement::new(rotation, Vector3::new(1.0, 2.0, 3.0));
    let (own, placed) = (shape.cover(0.05), Solid { placement, shape }.cover(0.05));
    let (own, placed) = (own.expect("sensible"), placed.expect("sensible"));
    assert_eq!(own.excess, placed.excess);
    for (own, placed) in own.balls.iter().zip(&placed.balls) {
        let expected = rotation * own.centre + placement.translation;
        assert_close!(&placed.centre, &expected, 1e-15);
        assert_eq!(own.radius, placed.radius);
    }
}

#[test]
fn senseless_numbers_are_refused() {
    for (excess, words) in
        [(0.0, "excess: it is 0"), (f64::NAN, "excess: it is NaN"), (1e-6, "cut into more than 100000000 cells")]
    {
        for shape in [shapes()[2], shapes()[4]] {
            let error = shape.cover(excess).expect_err("senseless").to_string();
            assert!(error.contains(words), "{error}");
        }
        let error = cover_triangles(&tetrahedron(), excess).expect_err("senseless");
        assert!(error.to_string().contains(words), "{error}");
    }
    let refused = |shape: Shape, excess, words: &str| {
        let error = shape.cover(excess).expect_err("senseless").to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(Shape::Sphere { radius: f64::NAN }, 0.1, "length");
    refused(Shape::HalfSpace, 0.1, "length");
    refused(shapes()[5], 1e-12, "balls for a capsule");
    let error = cover_triangles(&[], 0.1).expect_err("senseless");
    assert!(error.to_string().contains("there are none"), "{error}");
    let mut triangles = tetrahedron();
    for (far, words) in [(f64::INFINITY, "not a finite number"), (1e300, "cells")] {
        triangles[1][2].y = far;
        let error = cover_triangles(&triangles, 0.1).expect_err("senseless");
        assert!(error.to_string().contains(words), "{error}");
    }
}

/// The faces of a tetrahedron with corners at the origin and on the axes.
fn tetrahedron() -> Vec<Triangle> {
    let corners = [Vector3::zeros(), Vector3::x(), Vector3::y() * 0.5, Vector3::z() * 0.25];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    faces.map(|face| face.map(|i| corners[i])).to_vec()
}

/// A point of a triangle.
fn point_of([a, b, c]: &Triangle, rng: &mut ChaCha8Rng) -> Vector3<f64> {
    let (mut s, mut t) = (rng.random::<f64>(), rng.random::<f64>());
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    a + (b - a) * s + (c - a) * t
}

#[test]
fn every_point_of_a_surface_and_of_what_it_encloses_is_in_a_ball() {
    let rng = &mut ChaCha8Rng::seed_from_u64(5);
    let closed = tetrahedron();
    for excess in [1.0, 0.1, 0.02] {
        // Without one face it encloses nothing, so that no ball may be further from it than the excess.
        for triangles in [&closed[..], &closed[1..], &closed[3..]] {
            let cover = cover_triangles(triangles, excess).expect("sensible numbers");
            assert_eq!(cover.excess, excess);
            for triangle in triangles {
                for _ in 0..2000 {
                    let p = point_of(triangle, rng);
                    assert!(is_covered(&cover, &p), "{excess}: {p:?}");
                }
            }
            let largest = cover.balls.iter().map(|b| b.radius).fold(0.0, f64::max);
            assert_eq!(largest > excess, triangles.len() == 4 && excess < 0.5);
        }
        let cover = cover_triangles(&closed, excess).expect("sensible numbers");
        for _ in 0..2000 {
            let p = Vector3::repeat(0.0).map(|_: f64| rng.random::<f64>());
            // In the corner at the origin, under the slanted face.
            let p = p.component_mul(&Vector3::new(1.0, 0.5, 0.25));
            if p.x + p.y / 0.5 + p.z / 0.25 <= 1.0 {
                assert!(is_covered(&cover, &p), "{excess}: {p:?}");
            }
        }
    }
}

#[test]
fn a_gap_or_an_inner_wall_changes_little() {
    let half_extents = Vector3::new(0.1, 0.08, 0.05);
    let shape = Shape::Cuboid { half_extents };
    let excess = 0.01;
    let whole = shape.cover(excess).expect("sensible").balls.len();
    let rng = &mut ChaCha8Rng::seed_from_u64(6);
    let face = |z: f64, x: [f64; 2]| {
        let at = |x: f64, y: f64| Vector3::new(x, y, z);
        let [a, b, c, d] = [at(x[0], -0.08), at(x[1], -0.08), at(x[1], 0.08), at(x[0], 0.08)];
        [[a, b, c], [a, c, d]]
    };
    let walls = |h: [f64; 2]| {
        [[h[0], -h[1], h[0], h[1]], [-h[0], h[1], h[0], h[1]]].into_iter().flat_map(|[a, b, c, d]| {
            let at = move |side: f64, z: f64, first: bool| {
                if first { Vector3::new(side * a, side * b, z) } else { Vector3::new(side * c, side * d, z) }
            };
            [-1.0, 1.0].into_iter().flat_map(move |side| {
                let [p, q] = [at(side, -0.05, true), at(side, -0.05, false)];
                let [r, s] = [at(side, 0.05, true), at(side, 0.05, false)];
                [[p, q, s], [p, s, r]]
            })
        })
    };
    // A box with a slit of 2 mm in its lid, less than a cell, and a floor inside.
    let mut triangles: Vec<Triangle> = walls([0.1, 0.08]).collect();
    triangles.extend(face(-0.05, [-0.1, 0.1]));
    triangles.extend(face(0.05, [-0.1, 0.0]));
    triangles.extend(face(0.05, [0.002, 0.1]));
    triangles.extend(face(0.01, [-0.08, 0.08]));
    let cover = cover_triangles(&triangles, excess).expect("sensible");
    assert!(cover.balls.len() < 2 * whole, "{}, {whole}", cover.balls.len());
    assert!(sticks_out(&cover, &shape, rng) <= excess + 1e-8);
    for _ in 0..3000 {
        assert!(is_covered(&cover, &point(&shape, rng)));
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("meshes").join(name);
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    folder
}

const OBJ: &str = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\nf 1 3 4\n";
const STL: &str = "solid two\n\
    facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\nendloop\nendfacet\n\
    facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 2 0\nvertex 0 0 3\nendloop\nendfacet\nendsolid two\n";

/// The two triangles of the texts above as a binary STL.
fn binary() -> Vec<u8> {
    let mut bytes = vec![0_u8; 80];
    bytes.extend(2_u32.to_le_bytes());
    for triangle in [[[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 0, 0], [0, 2, 0], [0, 0, 3]]] {
        bytes.extend([0_u8; 12]);
        for x in triangle.as_flattened() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0_u8; 2]);
    }
    bytes
}

#[test]
fn meshes_are_found_and_read_in_each_format() {
    let root = folder("robots");
    let urdf = root.join("hand/urdf");
    for folder in [root.join("hand/meshes"), urdf.clone()] {
        std::fs::create_dir_all(folder).expect("the folder is writable");
    }
    let meshes = root.join("hand/meshes");
    // Exporters write the first word of a text into the header of binary files.
    let mut solid = binary();
    solid[..12].copy_from_slice(b"solid facet ");
    for (name, bytes) in [("a.obj", OBJ.into()), ("a.stl", STL.into()), ("b.STL", binary()), ("solid.stl", solid)] {
        std::fs::write(meshes.join(name), bytes).expect("the folder is writable");
    }
    let expected = [
        [Vector3::zeros(), Vector3::x() * 2.0, Vector3::y() * -2.0],
        [Vector3::zeros(), Vector3::y() * -2.0, Vector3::z() * 1.5],
    ];
    let scale = Vector3::new(2.0, -1.0, 0.5);
    for file in [
        "package://hand/meshes/a.obj",
        "package:///hand/meshes/a.obj",
        "../meshes/solid.stl",
        "../meshes/a.stl",
        "../meshes/b.STL",
    ] {
        let read = load_mesh(file, &urdf, &scale).expect(file);
        assert_eq!(read, expected, "{file}");
    }
    // The package may also be a parent folder with another name.
    assert!(load_mesh("package://meshes/a.obj", &root.join("hand"), &scale).is_ok());
}

#[test]
fn meshes_that_cannot_be_read_are_refused_by_name() {
    let folder = folder("bad");
    let one = Vector3::repeat(1.0);
    let cut = &binary()[..120];
    for (name, bytes, words) in [
        ("a.ply", "", "only STL, OBJ and COLLADA;convert it"),
        ("a.dae", "", "a.dae: mesh: not a valid COLLADA file"),
        ("cut.stl", "solid two\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nver", "cut.stl: mesh: "),
        ("empty.obj", "v 0 0 0\n", "no triangles"),
        ("face.obj", "v 0 0 0\nf 1 2 3\n", "face.obj: mesh: "),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "nan.obj: mesh: "),
    ] {
        std::fs::write(folder.join(name), bytes).expect("the folder is writable");
        let error = load_mesh(name, &folder, &one).expect_err(name).to_string();
        assert!(words.split(';').all(|w| error.contains(w)), "{error}; {words}");
    }
    std::fs::write(folder.join("binary.stl"), cut).expect("the folder is writable");
    assert!(load_mesh("binary.stl", &folder, &one).is_err());
    let error = load_mesh("package://none/a.stl", &folder, &one).expect_err("none").to_string();
    assert!(error.contains("package://none/a.stl") && error.contains("no such file"), "{error}");
}
