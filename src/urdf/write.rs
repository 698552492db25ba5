//! Writing of models as URDF files.

use super::parse_urdf;
use super::write_shapes::write_collision;
use crate::error::{Error, Result};
use crate::model::{CollisionShape, Frame, Joint, JointKind, Limits, Model};
use crate::spatial::{Inertia, Placement, cross_matrix};
use nalgebra::{Matrix3, Vector3};
use quick_xml::Writer;
use std::io;

/// The relative rounding error allowed when poses and inertias that were converted are read back.
const ROUNDING: f64 = 1e-9;

/// A shape and its placement in the frame of its link.
type PlacedShape<'a> = (Placement<f64>, &'a CollisionShape);

/// The limits that a URDF has for an unlimited joint: other readers require the element for joints that are not
/// continuous.
const PLACEHOLDER: Limits = Limits { lower: 0.0, upper: 0.0, velocity: 0.0, effort: 0.0 };

pub(super) type Xml = Writer<Vec<u8>>;

impl Model<f64> {
    /// Writes the model as the text of a URDF file, which [`parse_urdf`] reads as the same model.
    ///
    /// Every frame is written as a link, on the joint that carried it, so that the names of links and joints, the order
    /// of the joints and the shapes are those of the original file. The inertia of a body is written in the link of its
    /// joint, and that of the base in its first link; links on fixed joints are massless. Numbers are the
    /// shortest that read back to the same bits. Missing velocity or effort limits, and missing limits altogether, are
    /// written as zeros, which [`parse_urdf`] reads as no limit. A model made in code gets a link `base`; its
    /// joints are read back in the order in which the tree is visited.
    ///
    /// # Errors
    /// The model has a property that a URDF cannot express: another gravity than $(0, 0, -9.81)$, limits on the
    /// position of a continuous joint, limits of velocity or effort of zero (which mean none), a joint held at zero by
    /// its position limits alone, a first moment without mass, drives, or an invalid rotation; or [`parse_urdf`]
    /// refuses it. The text is read back as a check.
    pub fn to_urdf(&self) -> Result<String> {
        let fail = |what: String| Error::input(self.name(), "robot", what);
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        let robot = xml.create_element("robot");
        robot
            .with_attribute(("name", self.name()))
            .write_inner_content(|xml| self.write_links(xml))
            .map_err(|e| fail(e.to_string()))?;
        let text = String::from_utf8(xml.into_inner()).map_err(|e| fail(e.to_string()))?;
        let (read, _) = parse_urdf(&text, self.name())?;
        match self.difference(&read) {
            Some((element, what)) => {
                let condition = format!("{what} cannot be said in a URDF");
                Err(Error::input(self.name(), element, condition))
            }
            None => Ok(text),
        }
    }

    fn write_links(&self, xml: &mut Xml) -> io::Result<()> {
        let mut base = "base".to_owned();
        while self.frames().iter().any(|f| f.name == base) {
            base.push('_');
        }
        if self.frames().iter().all(|f| f.carrier.is_some()) {
            write_link(xml, &base, self.base_inertia(), &[])?;
        }
        for frame in self.frames() {
            let shapes = self.shapes_of(frame);
            let Some(carrier) = &frame.carrier else {
                write_link(xml, &frame.name, self.base_inertia(), &shapes)?;
                continue;
            };
            let parent = carrier.parent.map(|p| &self.frames()[p]);
            let ends = [parent.map_or(&base, |p| &p.name), &frame.name];
            let within_parent = |p: &Placement<f64>| parent.map_or(*p, |f| relative(p, f));
            match self.joints().iter().position(|j| j.name() == carrier.joint) {
                Some(i) => {
                    write_link(xml, &frame.name, &self.inertias()[i], &shapes)?;
                    let joint = &self.joints()[i];
                    let kind = joint.kind().name();
                    let origin = within_parent(joint.origin());
                    write_joint(xml, (&carrier.joint, kind), ends, &origin, Some(joint))?;
                }
                None => {
                    write_link(xml, &frame.name, &Inertia::zero(), &shapes)?;
                    let origin = within_parent(&frame.placement);
                    write_joint(xml, (&carrier.joint, "fixed"), ends, &origin, None)?;
                }
            }
        }
        Ok(())
    }

    /// The shapes of the link of `frame`, each with its placement in that frame.
    fn shapes_of(&self, frame: &Frame<f64>) -> Vec<PlacedShape<'_>> {
        let all = self.collisions().iter();
        all.filter(|collision| collision.link == frame.name)
            .map(|collision| (relative(&collision.placement, frame), &collision.shape))
            .collect()
    }

    /// The first difference between this model and `read`, with its element.
    fn difference(&self, read: &Self) -> Option<(String, &'static str)> {
        if self.gravity() != read.gravity() {
            return Some(("robot".to_owned(), "its gravity"));
        }
        let [a, b] = [self, read].map(|model| model.base_inertia().to_matrix());
        if !close(&a, &b) {
            return Some(("robot".to_owned(), "the inertia of its base"));
        }
        let carrier = |model: &Self, joint: &Joint<f64>| joint.parent().map(|p| model.joints()[p].name().to_owned());
        if !self.drives().is_empty() {
            return Some(("robot".to_owned(), "the drives of its joints"));
        }
        for (joint, inertia) in self.joints().iter().zip(self.inertias()) {
            let differs = |what| Some((format!("joint '{}'", joint.name()), what));
            let Some(i) = read.joints().iter().position(|j| j.name() == joint.name()) else {
                return differs("its name");
            };
            let same = &read.joints()[i];
            if joint.kind() != same.kind() || carrier(self, joint) != carrier(read, same) {
                return differs("its kind or parent");
            }
            if joint.limits() != same.limits() {
                return differs("a limit of it");
            }
            let [a, b] = [joint, same].map(Joint::origin);
            if !(close(&a.rotation, &b.rotation) && close(&a.translation, &b.translation)) {
                return differs("its origin");
            }
            if !close(joint.axis(), same.axis()) {
                return differs("its axis");
            }
            if !close(&inertia.to_matrix(), &read.inertias()[i].to_matrix()) {
                return differs("the inertia that it moves");
            }
        }
        self.frames().iter().find_map(|frame| {
            let same = read.frames().iter().find(|f| f.name == frame.name);
            let read = same.map(|f| read.shapes_of(f)).unwrap_or_default();
            let shapes = self.shapes_of(frame);
            let differs = shapes.len() != read.len()
                || shapes.iter().zip(&read).any(|((a, shape), (b, same))| {
                    shape != same || !close(&a.rotation, &b.rotation) || !close(&a.translation, &b.translation)
                });
            differs.then(|| (format!("link '{}'", frame.name), "a shape of it"))
        })
    }
}

/// Returns true if two matrices are equal up to rounding.
fn close<R: nalgebra::Dim, C: nalgebra::Dim, T: nalgebra::RawStorage<f64, R, C>>(
    a: &nalgebra::Matrix<f64, R, C, T>,
    b: &nalgebra::Matrix<f64, R, C, T>,
) -> bool {
    let bound = ROUNDING * a.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= bound)
}

/// The placement of `p` relative to `frame`, both given in one body.
fn relative(p: &Placement<f64>, frame: &Frame<f64>) -> Placement<f64> {
    let Placement { rotation, translation } = &frame.placement;
    Placement::new(rotation.tr_mul(&p.rotation), rotation.tr_mul(&(p.translation - translation)))
}

fn write_link(xml: &mut Xml, name: &str, inertia: &Inertia<f64>, shapes: &[PlacedShape<'_>]) -> io::Result<()> {
    let link = xml.create_element("link").with_attribute(("name", name));
    let massless = *inertia == Inertia::zero();
    if massless && shapes.is_empty() {
        link.write_empty()?;
        return Ok(());
    }
    link.write_inner_content(|xml| {
        if !massless {
            write_inertial(xml, inertia)?;
        }
        (shapes.iter()).try_for_each(|(origin, shape)| write_collision(xml, origin, shape))
    })?;
    Ok(())
}

fn write_inertial(xml: &mut Xml, inertia: &Inertia<f64>) -> io::Result<()> {
    let mass = inertia.mass;
    let com = if mass == 0.0 { Vector3::zeros() } else { inertia.first_moment / mass };
    let cross = cross_matrix(&com);
    let i = inertia.rotational + cross * cross * mass;
    xml.create_element("inertial").write_inner_content(|xml| {
        empty(xml, "origin", &[("xyz", numbers(&com))])?;
        empty(xml, "mass", &[("value", numbers([&mass]))])?;
        let moments = [("ixx", i.m11), ("ixy", i.m12), ("ixz", i.m13), ("iyy", i.m22), ("iyz", i.m23), ("izz", i.m33)];
        empty(xml, "inertia", &moments.map(|(key, moment)| (key, numbers([&moment]))))
    })?;
    Ok(())
}

/// Writes a joint of this name and kind between two links; `moving` has the data of moving joints.
fn write_joint(
    xml: &mut Xml,
    (name, kind): (&str, &str),
    [parent, child]: [&String; 2],
    origin: &Placement<f64>,
    moving: Option<&Joint<f64>>,
) -> io::Result<()> {
    let joint = xml.create_element("joint").with_attribute(("name", name));
    joint.with_attribute(("type", kind)).write_inner_content(|xml| {
        let pose = [("xyz", numbers(&origin.translation)), ("rpy", numbers(&roll_pitch_yaw(&origin.rotation)))];
        empty(xml, "origin", &pose)?;
        empty(xml, "parent", &[("link", parent.clone())])?;
        empty(xml, "child", &[("link", child.clone())])?;
        let Some(joint) = moving else { return Ok(()) };
        empty(xml, "axis", &[("xyz", numbers(joint.axis()))])?;
        let continuous = joint.kind() == JointKind::Continuous;
        let limits = match joint.limits() {
            limits if *limits != Limits::NONE => limits,
            _ if continuous => return Ok(()),
            _ => &PLACEHOLDER,
        };
        let mut attributes =
            vec![("effort", numbers([&or_zero(limits.effort)])), ("velocity", numbers([&or_zero(limits.velocity)]))];
        if !continuous {
            attributes.push(("lower", numbers([&limits.lower])));
            attributes.push(("upper", numbers([&limits.upper])));
        }
        empty(xml, "limit", &attributes)
    })?;
    Ok(())
}

/// An element without content.
pub(super) fn empty(xml: &mut Xml, name: &str, attributes: &[(&str, String)]) -> io::Result<()> {
    let attributes = attributes.iter().map(|(key, value)| (*key, value.as_str()));
    let element = xml.create_element(name).with_attributes(attributes);
    element.write_empty()?;
    Ok(())
}

/// A limit of velocity or effort in the form of a URDF: zero without a limit, because other readers refuse an infinite
/// one.
fn or_zero(limit: f64) -> f64 {
    if limit == f64::INFINITY { 0.0 } else { limit }
}

/// Formats numbers so that they read back to the same bits, zeros without a sign.
pub(super) fn numbers<'a>(x: impl IntoIterator<Item = &'a f64>) -> String {
    let words: Vec<_> = x.into_iter().map(|x| format!("{:?}", x + 0.0)).collect();
    words.join(" ")
}

/// The angles of a rotation about the fixed axes x, y, z, in this order.
///
/// Near a pitch of a quarter turn only the sum or the difference of the other two angles is determined. Roll is
/// therefore computed from the rotation with yaw removed, and compensates for any error of yaw there.
pub(super) fn roll_pitch_yaw(r: &Matrix3<f64>) -> [f64; 3] {
    let yaw = r.m21.atan2(r.m11);
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r.m31).atan2(cos * r.m11 + sin * r.m21);
    let roll = (sin * r.m13 - cos * r.m23).atan2(cos * r.m22 - sin * r.m12);
    [roll, pitch, yaw]
}
