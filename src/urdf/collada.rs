//! The triangles of COLLADA files, the meshes of ROS.
//!
//! Coordinates are in the unit of the file and with the transforms of its visual scene. Its `up_axis` is not applied,
//! as in RViz and MoveIt: in files for robots, whatever it says, coordinates are in the frame of the link.

use super::elements::Read;
use crate::geometry::Triangle;
use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::str::FromStr;

/// The most triangles that are read: more than the largest STL has that is read, with 50 bytes for each. Many nodes may
/// show one geometry.
const MAX_TRIANGLES: usize = 1 << 21;

/// Reads the triangles of all geometries in the visual scene of a COLLADA file, in m. Polygons are divided into fans
/// from their first corner.
///
/// # Errors
/// Names the element and its line.
pub(super) fn read_collada(text: &str) -> Read<Vec<Triangle>> {
    let document = Document::parse(text).map_err(|e| format!("not a valid COLLADA file: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(refuse(root, "it is not 'COLLADA'"));
    }
    let ids = root.descendants().filter(Node::is_element);
    let ids = Ids(ids.filter_map(|n| Some((n.attribute("id")?, n))).collect());
    let shown = required(required(root, "scene")?, "instance_visual_scene")?;
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let metre = match unit.and_then(|unit| Some((unit, unit.attribute("meter")?))) {
        Some((unit, metre)) => parse(unit, metre)?,
        None => 1.0,
    };
    let mut triangles = Vec::new();
    let mut pending = vec![(ids.named(shown, "url")?, Matrix4::new_scaling(metre))];
    while let Some((node, mut transform)) = pending.pop() {
        for element in node.children().filter(Node::is_element) {
            match element.tag_name().name() {
                "node" => pending.push((element, transform)),
                "instance_geometry" => {
                    let own = read_geometry(ids.named(element, "url")?, &ids)?;
                    if triangles.len() + own.len() > MAX_TRIANGLES {
                        let condition = format!("with it there are over {MAX_TRIANGLES} triangles");
                        return Err(refuse(element, &condition));
                    }
                    let place = |p: Vector3<f64>| transform.transform_point(&Point3::from(p)).coords;
                    triangles.extend(own.into_iter().map(|triangle| triangle.map(place)));
                }
                "instance_node" | "instance_controller" => {
                    return Err(refuse(element, "it is not supported"));
                }
                // Transforms come before the elements that they place, in the schema of the format.
                _ => transform *= read_transform(element)?,
            }
        }
    }
    Ok(triangles)
}

/// The elements by their identifiers.
struct Ids<'a, 'input>(HashMap<&'a str, Node<'a, 'input>>);

impl<'a, 'input> Ids<'a, 'input> {
    /// The element of this file that an attribute names.
    fn named(&self, node: Node<'a, 'input>, attribute: &str) -> Read<Node<'a, 'input>> {
        let id = node.attribute(attribute).unwrap_or_default();
        let found = id.strip_prefix('#').and_then(|id| self.0.get(id));
        (found.copied()).ok_or_else(|| refuse(node, &format!("its {attribute} '{id}' is not in this file")))
    }
}

/// A transform of a node; the identity for elements that are none.
fn read_transform(element: Node<'_, '_>) -> Read<Matrix4<f64>> {
    Ok(match element.tag_name().name() {
        "matrix" => Matrix4::from_row_slice(&exactly::<16>(element)?),
        "translate" => Matrix4::new_translation(&Vector3::from(exactly::<3>(element)?)),
        "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from(exactly::<3>(element)?)),
        "rotate" => {
            let [x, y, z, degrees] = exactly::<4>(element)?;
            let axis = Unit::try_new(Vector3::new(x, y, z), 0.0).ok_or_else(|| refuse(element, "its axis is zero"))?;
            Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
        }
        "lookat" | "skew" => return Err(refuse(element, "it is not supported")),
        _ => Matrix4::identity(),
    })
}

/// The triangles of a geometry in its own frame.
fn read_geometry(geometry: Node<'_, '_>, ids: &Ids<'_, '_>) -> Read<Vec<Triangle>> {
    let mut triangles = Vec::new();
    for faces in required(geometry, "mesh")?.children() {
        match faces.tag_name().name() {
            "triangles" | "polylist" | "polygons" => read_faces(faces, ids, &mut triangles)?,
            "trifans" | "tristrips" => return Err(refuse(faces, "it is not supported")),
            // Sources, vertices and lines.
            _ => {}
        }
    }
    Ok(triangles)
}

/// Adds the faces of an element `triangles`, `polylist` or `polygons`.
fn read_faces(faces: Node<'_, '_>, ids: &Ids<'_, '_>, triangles: &mut Vec<Triangle>) -> Read<()> {
    let (mut stride, mut vertex) = (0, None);
    for input in faces.children().filter(|c| c.has_tag_name("input")) {
        let offset = parse::<usize>(input, input.attribute("offset").unwrap_or("0"))?;
        stride = stride.max(offset.saturating_add(1));
        if input.attribute("semantic") == Some("VERTEX") {
            vertex = Some((input, offset));
        }
    }
    let (input, offset) = vertex.ok_or_else(|| refuse(faces, "it has no input of vertices"))?;
    let points = read_points(input, ids)?;
    let lists = faces.children().filter(|c| c.has_tag_name("p"));
    let counts = match faces.tag_name().name() {
        "polylist" => Some(list::<usize>(required(faces, "vcount")?)?),
        _ => None,
    };
    if let Some(holes) = child(faces, "ph") {
        return Err(refuse(holes, "polygons with holes are not supported"));
    }
    for p in lists {
        let indices = list::<usize>(p)?;
        let whole = indices.len().is_multiple_of(stride);
        let corners = indices.chunks(stride).map(|corner| corner.get(offset).and_then(|i| points.get(*i)).copied());
        let corners = corners.collect::<Option<Vec<_>>>();
        let corners = corners.ok_or_else(|| refuse(p, "it names a corner that is not there"))?;
        let own = match (&counts, faces.tag_name().name()) {
            (Some(counts), _) => counts.clone(),
            (None, "triangles") => vec![3; corners.len().div_ceil(3)],
            _ => vec![corners.len()],
        };
        let sum = own.iter().try_fold(0_usize, |sum, n| sum.checked_add(*n));
        if !whole || sum != Some(corners.len()) {
            return Err(refuse(p, "its length is not that of its faces"));
        }
        let mut rest = corners.as_slice();
        for count in own {
            let (polygon, after) = rest.split_at(count);
            rest = after;
            if let [first, others @ ..] = polygon {
                triangles.extend(others.windows(2).map(|edge| [*first, edge[0], edge[1]]));
            }
        }
    }
    Ok(())
}

/// The positions that an input of vertices names.
fn read_points(input: Node<'_, '_>, ids: &Ids<'_, '_>) -> Read<Vec<Vector3<f64>>> {
    let vertices = ids.named(input, "source")?;
    let position = |c: &Node<'_, '_>| c.attribute("semantic") == Some("POSITION");
    let position = vertices.children().find(position);
    let position = position.ok_or_else(|| refuse(vertices, "it has no input of positions"))?;
    let source = ids.named(position, "source")?;
    let accessor = required(required(source, "technique_common")?, "accessor")?;
    let number = |name, default| parse::<usize>(accessor, accessor.attribute(name).unwrap_or(default));
    let (stride, first) = (number("stride", "1")?, number("offset", "0")?);
    if stride < 3 {
        return Err(refuse(accessor, "its stride is below 3"));
    }
    let numbers = list::<f64>(required(source, "float_array")?)?;
    let points = numbers.get(first..).unwrap_or_default().chunks(stride);
    Ok(points.filter_map(|p| Some(Vector3::from_column_slice(p.get(..3)?))).collect())
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|c| c.has_tag_name(name))
}

fn required<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Read<Node<'a, 'input>> {
    child(node, name).ok_or_else(|| refuse(node, &format!("it has no element '{name}'")))
}

/// The numbers in the text of an element.
fn list<T: FromStr>(node: Node<'_, '_>) -> Read<Vec<T>> {
    let words = node.text().unwrap_or_default().split_ascii_whitespace();
    words.map(|word| parse(node, word)).collect()
}

fn exactly<const N: usize>(node: Node<'_, '_>) -> Read<[f64; N]> {
    let numbers = list::<f64>(node)?;
    numbers.try_into().map_err(|_| refuse(node, &format!("it does not have {N} numbers")))
}

fn parse<T: FromStr>(node: Node<'_, '_>, word: &str) -> Read<T> {
    word.parse().map_err(|_| refuse(node, &format!("'{word}' is not such a number")))
}

/// A fault of an element, with its identifier and line.
fn refuse(node: Node<'_, '_>, condition: &str) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    let id = node.attribute("id").map_or_else(String::new, |id| format!(" '{id}'"));
    format!("{}{id} at line {line}: {condition}", node.tag_name().name())
}
