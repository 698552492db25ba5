//! Meshes of collision shapes.

use aghf::urdf::load_mesh;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

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
