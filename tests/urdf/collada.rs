//! Meshes in COLLADA files.

use aghf::urdf::load_mesh;
use nalgebra::Vector3;
use std::path::Path;

/// A file in millimetres with a triangle and a square, whose texture coordinates come before the corners, on a node
/// that is turned by a quarter about `x` within one that is moved by a metre along `z`.
const FILE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"><asset>
  <unit meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
  <source id="s"><float_array id="f" count="12">0 0 0 1000 0 0 1000 1000 0 0 1000 0</float_array>
    <technique_common><accessor source="#f" count="4" stride="3"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
  <FACES>
    <input semantic="TEXCOORD" source="#s" offset="0"/><input semantic="VERTEX" source="#v" offset="1"/>
    LISTS
  </FACES></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><translate>0 0 1000</translate>
  <node><rotate>1 0 0 90</rotate><instance_geometry url="#g"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##;

fn load(name: &str, text: &str) -> Result<Vec<[Vector3<f64>; 3]>, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("collada");
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    std::fs::write(folder.join(name), text).expect("the folder is writable");
    load_mesh(name, &folder, &Vector3::new(1.0, 1.0, 2.0)).map_err(|e| e.to_string())
}

fn with(faces: &str, lists: &str) -> String {
    FILE.replace("FACES", faces).replace("LISTS", lists)
}

#[test]
fn faces_of_each_kind_are_placed_by_their_nodes_in_metres() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let corner = |i: usize| Vector3::new(corners[i][0], 0.0, 2.0 * (1.0 + corners[i][1]));
    let fan = [[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(corner));
    let (first, second) = ("3 0 2 1 1 2", "0 0 0 2 0 3");
    for (faces, lists) in [
        ("triangles", format!("<p>{first} {second}</p>")),
        ("polygons", format!("<p>{first} 0 3</p>")),
        ("polylist", format!("<vcount>4</vcount><p>{first} 0 3</p>")),
        ("polylist", format!("<vcount>3 3</vcount><p>{first} {second}</p>")),
    ] {
        let read = load("faces.dae", &with(faces, &lists)).expect(faces);
        assert_eq!(read.len(), 2, "{faces}");
        for (a, b) in read.as_flattened().iter().zip(fan.as_flattened()) {
            // The sine and cosine of a quarter turn are rounded.
            assert!((a - b).norm() < 1e-14, "{faces}: {read:?}");
        }
    }
}

#[test]
fn faults_are_named_with_the_element_and_its_line() {
    let good = with("triangles", "<p>0 0 0 1 0 2</p>");
    let changed = |from: &str, to: &str| good.replace(from, to);
    for (text, words) in [
        (changed("0 0 0 1 0 2", "0 0 0 1 0 9"), "p at line 9: it names a corner"),
        (changed("0 0 0 1 0 2", "0 0 0 1 0"), "p at line 9: "),
        (changed("0 0 0 1 0 2", "0 0 0 x"), "p at line 9: 'x' is not"),
        (with("polylist", "<vcount>4</vcount><p>0 0 0 1 0 2</p>"), "its length is not"),
        (with("trifans", ""), "trifans at line 7: it is not supported"),
        (changed("url=\"#g\"", "url=\"#h\""), "its url '#h' is not in this file"),
        (changed("0 0 1000</translate>", "0 0</translate>"), "translate at line 11: it does not have 3"),
        (changed("1 0 0 90", "0 0 0 90"), "rotate at line 12: its axis is zero"),
        (changed("stride=\"3\"", ""), "accessor at line 5: its stride"),
        (changed("semantic=\"VERTEX\"", ""), "it has no input of vertices"),
        (changed("instance_geometry", "instance_node"), "instance_node at line 12: it is not supported"),
        ("<html/>".to_owned(), "it is not 'COLLADA'"),
    ] {
        let error = load("bad.dae", &text).expect_err(words);
        assert!(error.contains("bad.dae: mesh: ") && error.contains(words), "{error}; {words}");
    }
}
