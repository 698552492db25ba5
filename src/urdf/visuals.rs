//! The `<visual>` elements of a URDF.

use super::build::convert_pose;
use super::elements::{Read, read_geometry, read_origin};
use super::shapes::convert_shape;
use super::xml::{mended, named, numbers};
use crate::model::CollisionShape;
use crate::spatial::Placement;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A visual shape of a link.
#[derive(Clone, Debug)]
pub struct Visual {
    /// The name of the link.
    pub link: String,
    /// The placement of the shape in the frame of the link.
    pub placement: Placement<f64>,
    /// The shape.
    pub shape: CollisionShape,
    /// Red, green and blue from 0 to 1, if a material gives them.
    pub color: Option<[f64; 3]>,
}

/// Reads the visual elements of all links in the text of a URDF, in their order, and returns the faults of omitted ones
/// in words: no motion depends on them. `packages` are those of [`UrdfOptions`](super::UrdfOptions).
pub fn read_visuals(text: &str, packages: &BTreeMap<String, PathBuf>) -> (Vec<Visual>, Vec<String>) {
    let (mut visuals, mut faults) = (Vec::new(), Vec::new());
    let (text, _) = mended(text);
    let Ok(document) = Document::parse(&text) else {
        return (visuals, vec!["the text is no XML".to_owned()]);
    };
    let root = document.root_element();
    for link in named(root, "link") {
        let name = link.attribute("name").unwrap_or_default();
        for (i, visual) in named(link, "visual").enumerate() {
            match read_visual(root, name, visual, packages) {
                Ok(visual) => visuals.push(visual),
                Err(fault) => faults.push(format!("link '{name}': visual {}: {fault}", i + 1)),
            }
        }
    }
    (visuals, faults)
}

fn read_visual(
    robot: Node<'_, '_>,
    link: &str,
    visual: Node<'_, '_>,
    packages: &BTreeMap<String, PathBuf>,
) -> Read<Visual> {
    Ok(Visual {
        link: link.to_owned(),
        placement: convert_pose(&read_origin(visual)?)?,
        shape: convert_shape(&read_geometry(visual)?, packages)?,
        color: color(robot, visual)?,
    })
}

/// The colour of the material, its own or that of the robot's material of the same name.
fn color(robot: Node<'_, '_>, visual: Node<'_, '_>) -> Read<Option<[f64; 3]>> {
    let Some(own) = named(visual, "material").next() else {
        return Ok(None);
    };
    let name = own.attribute("name");
    let same = |node: &Node<'_, '_>| node.attribute("name") == name;
    let shared = || named(robot, "material").find(same).and_then(colored);
    let Some(color) = colored(own).or_else(shared) else {
        return Ok(None);
    };
    let [red, green, blue, _] = numbers::<4>(color, "rgba")?;
    Ok(Some([red, green, blue].map(|x| x.clamp(0.0, 1.0))))
}

fn colored<'a, 'input>(material: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
    named(material, "color").next()
}
