//! Collision data and groups of joints from an SRDF.

use super::elements::Read;
use super::group::{Group, GroupState, read_group, read_state};
use super::xml::{elements, mended, named, number, numbers};
use crate::error::{Error, Result, plain};
use crate::geometry::{Shape, Sphere};
use crate::input::read_text;
use crate::model::{Collision, CollisionShape, Model};
use crate::spatial::Placement;
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;
use std::path::Path;

/// An SRDF, MoveIt's companion of a URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Srdf {
    /// The pairs of links that are not checked for collisions: those of `disable_collisions`, and those of a link with
    /// `disable_default_collisions` and any other link, without those of `enable_collisions`.
    pub disabled: Vec<DisabledPair>,
    /// The links of further pairs that the robot lacks: SRDFs are often for several variants of a robot.
    pub unknown_links: BTreeSet<String>,
    /// Links with the spheres that represent their shapes, each in the frame of its link; an empty list for a link
    /// without a collision shape.
    pub spheres: Vec<(String, Vec<Sphere>)>,
    /// The groups of joints.
    pub groups: Vec<Group>,
    /// The named states of groups.
    pub states: Vec<GroupState>,
    /// The names of the joints between the world and the base, which do not move here.
    pub virtual_joints: Vec<String>,
}

/// Two links that are not checked for collisions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisabledPair {
    /// Their names.
    pub links: [String; 2],
    /// The reason, such as `Adjacent`; empty without one.
    pub reason: String,
}

impl Srdf {
    /// Loads the SRDF in the file at `path` for the robot `model`.
    ///
    /// # Errors
    /// The file cannot be read, or those of [`parse`](Self::parse).
    pub fn load(path: &Path, model: &Model) -> Result<Self> {
        Self::parse(&read_text(path)?, &path.display().to_string(), model)
    }

    /// Parses the SRDF in `text` for the robot `model`; `file` names it in errors. End effectors and passive joints are
    /// ignored; names in groups and states are looked up when these are used.
    ///
    /// # Errors
    /// Names the file and the element: text that is not an SRDF, a pair without a link, default collisions without one,
    /// spheres of a link that the robot lacks, an invalid number, a negative radius, two lists of spheres for one link,
    /// or a group or state without a name.
    pub fn parse(text: &str, file: &str, model: &Model) -> Result<Self> {
        let refuse = |condition: String| {
            let condition = format!("not a valid SRDF: {condition}");
            Err(Error::input(file, "robot", condition))
        };
        let (text, _) = mended(text);
        let document = match Document::parse(&text) {
            Ok(document) => document,
            Err(error) => return refuse(error.to_string()),
        };
        let root = document.root_element();
        let kind = root.tag_name().name();
        if kind != "robot" {
            return refuse(format!("the root element is '{kind}'"));
        }
        if named(root, "joint").next().is_some() {
            return refuse("it has joints, as a URDF".to_owned());
        }
        let (mut srdf, mut off, mut enabled) = (Self::default(), Vec::new(), Vec::new());
        for node in elements(root) {
            let kind = node.tag_name().name();
            let line = document.text_pos_at(node.range().start).row;
            let named = |condition: String| Error::input(file, format!("{kind} at line {line}"), condition);
            match kind {
                "disable_collisions" => {
                    if let Some(links) = srdf.known(node, ["link1", "link2"], model).map_err(named)? {
                        let reason = node.attribute("reason").unwrap_or_default().to_owned();
                        srdf.disabled.push(DisabledPair { links, reason });
                    }
                }
                "disable_default_collisions" => {
                    off.extend(srdf.known(node, ["link"], model).map_err(named)?);
                }
                "enable_collisions" => {
                    enabled.extend(srdf.known(node, ["link1", "link2"], model).map_err(named)?);
                }
                "link_sphere_approximation" => {
                    let link = link(node, "link", model).map_err(named)?;
                    if srdf.spheres.iter().any(|(other, _)| *other == link) {
                        return Err(named(format!("link '{link}' has spheres already")));
                    }
                    srdf.spheres.push((link, spheres(node).map_err(named)?));
                }
                "group" => srdf.groups.push(read_group(node).map_err(named)?),
                "group_state" => srdf.states.push(read_state(node).map_err(named)?),
                "virtual_joint" => {
                    let name = node.attribute("name").unwrap_or_default();
                    srdf.virtual_joints.push(name.to_owned());
                }
                _ => {}
            }
        }
        for [link] in off {
            srdf.disable_by_default(&link, &enabled, model);
        }
        Ok(srdf)
    }

    /// The links that these attributes name if the robot has all of them; others are listed as unknown.
    fn known<const COUNT: usize>(
        &mut self,
        node: Node<'_, '_>,
        attributes: [&str; COUNT],
        model: &Model,
    ) -> Read<Option<[String; COUNT]>> {
        let links = attributes.map(|attribute| required(node, attribute).map(str::to_owned));
        let links = links.into_iter().collect::<Read<Vec<_>>>()?;
        let unknown = links.iter().filter(|link| !has_link(model, link));
        self.unknown_links.extend(unknown.cloned());
        let all_known = links.iter().all(|link| !self.unknown_links.contains(link));
        Ok(links.try_into().ok().filter(|_| all_known))
    }

    /// Disables the pairs of a link and each other one that are neither disabled yet nor enabled.
    fn disable_by_default(&mut self, link: &str, enabled: &[[String; 2]], model: &Model) {
        for other in model.frames().iter().map(|frame| frame.name.as_str()) {
            let is_pair = |[a, b]: &[String; 2]| [a.as_str(), b] == [link, other] || [a.as_str(), b] == [other, link];
            let disabled = self.disabled.iter().any(|pair| is_pair(&pair.links));
            if other != link && !disabled && !enabled.iter().any(is_pair) {
                self.disabled
                    .push(DisabledPair { links: [link, other].map(str::to_owned), reason: "by default".to_owned() });
            }
        }
    }

    /// Replaces the shapes of those links of the model for which this SRDF has spheres.
    ///
    /// # Errors
    /// The model has no link of such a name.
    pub fn with_spheres(&self, model: Model) -> Result<Model> {
        let own = |collision: &&Collision| self.spheres.iter().all(|(l, _)| *l != collision.link);
        let mut collisions: Vec<_> = model.collisions().iter().filter(own).cloned().collect();
        for (link, balls) in &self.spheres {
            for ball in balls {
                let at = Placement::new(Matrix3::identity(), ball.centre);
                let radius = ball.radius;
                let shape = CollisionShape::Solid(Shape::Sphere { radius });
                collisions.push(Collision::at_link(&model, link, &at, shape)?);
            }
        }
        model.with_collisions(collisions)
    }
}

/// The link named by an attribute.
fn link(node: Node<'_, '_>, attribute: &str, model: &Model) -> Read<String> {
    let name = required(node, attribute)?;
    if has_link(model, name) { Ok(name.to_owned()) } else { Err(format!("{attribute}: {}", model.no_link(name))) }
}

fn required<'a>(node: Node<'a, '_>, attribute: &str) -> Read<&'a str> {
    let found = node.attribute(attribute);
    found.ok_or_else(|| format!("it has no {attribute}"))
}

fn has_link(model: &Model, name: &str) -> bool {
    model.frames().iter().any(|frame| frame.name == name)
}

/// The spheres of a link. A single sphere of radius zero means none.
fn spheres(node: Node<'_, '_>) -> Read<Vec<Sphere>> {
    let mut balls = Vec::new();
    for sphere in named(node, "sphere") {
        let centre = Vector3::from(numbers::<3>(sphere, "center")?);
        let radius = number(sphere, "radius")?;
        if !(centre.iter().all(|x| x.is_finite()) && radius.is_finite() && radius >= 0.0) {
            return Err(format!(
                "a sphere has the radius {}, a finite centre and a radius that is not negative are needed",
                plain(radius)
            ));
        }
        if radius > 0.0 {
            balls.push(Sphere { centre, radius });
        }
    }
    Ok(balls)
}
