//! The moving bodies of a URDF and the balls that keep clear, inverse dynamics and kinematics.

use crate::Checked;
use crate::arithmetic::{Matrix, Tm, Vector, about, add, apply, cross, dot, product, times, transpose, unit, vector};
use crate::grammar::{Grammar, Item};
use crate::joint::Joint;
use crate::json::{list, number, number_or, option, require, text, three};
use crate::mesh::Piece;
use crate::shape::{Solid, shape_of, solid_of};
use roxmltree::{Document, Node};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A placement: rotation and translation.
pub(crate) type Pose = (Matrix, Vector);

pub(crate) fn identity() -> Pose {
    let one = |i: usize, j: usize| Tm::new(if i == j { 1.0 } else { 0.0 });
    (std::array::from_fn(|i| std::array::from_fn(|j| one(i, j))), vector([0.0; 3]))
}

pub(crate) fn compose(a: &Pose, b: &Pose) -> Pose {
    (product(a.0, b.0), add(apply(a.0, b.1), a.1))
}

fn inverse(pose: &Pose) -> Pose {
    let back = transpose(pose.0);
    (back, times(apply(back, pose.1), Tm::new(-1.0)))
}

/// A shape of a link.
pub(crate) struct Part {
    pub(crate) body: Option<usize>,
    pub(crate) link: String,
    pub(crate) solid: Solid,
    /// Those of a piece of a mesh, about its centre.
    pub(crate) corners: Vec<[f64; 3]>,
}

/// The body that carries a link, and the placement of the link in it.
type Place = (Option<usize>, Pose);

/// The largest number of balls along links.
const BALLS: f64 = 1e4;

type Links = BTreeMap<String, Place>;

pub(crate) struct Robot {
    pub(crate) joints: Vec<Joint>,
    /// The mass and the first moment of the bodies that are fixed to the base.
    base: (Tm, Vector),
    gravity: [f64; 3],
    pub(crate) links: Links,
    pub(crate) parts: Vec<Part>,
    /// True if all shapes are balls.
    pub(crate) has_balls: bool,
    /// False if the robot consists of balls and its load does not: then no clearance is certified.
    pub(crate) is_known: bool,
    /// True if the shapes are those of links, which keep clear of each other.
    pub(crate) has_links: bool,
    /// The names of the files of meshes, and the scales of their axes, in the order of the shapes.
    pub(crate) meshes: Vec<(String, [f64; 3])>,
}

/// Decimal numbers between white space.
pub(crate) fn numbers(text: &str) -> Checked<Vec<f64>> {
    let is_decimal = |word: &&str| word.bytes().all(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
    let number = |word: &str| Some(word).filter(is_decimal)?.parse::<f64>().ok().filter(|x| x.is_finite());
    let all: Option<Vec<f64>> = text.split_ascii_whitespace().map(number).collect();
    all.ok_or_else(|| format!("'{text}' has something that is no finite number"))
}

pub(crate) fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.has_tag_name(name))
}

pub(crate) fn scalar(node: Option<Node>, name: &str) -> Checked<f64> {
    let text = node.and_then(|n| n.attribute(name));
    text.map_or(Ok(0.0), |text| numbers(text)?.first().copied().ok_or("a number is missing".to_owned()))
}

pub(crate) fn triple(node: Option<Node>, name: &str, default: [f64; 3]) -> Checked<[f64; 3]> {
    let text = node.and_then(|n| n.attribute(name));
    text.map_or(Ok(default), |t| numbers(t)?.try_into().map_err(|_| format!("'{t}' has no three numbers")))
}

pub(crate) fn pose(node: Option<Node>) -> Checked<Pose> {
    let angles = triple(node, "rpy", [0.0; 3])?;
    let axes = identity().0;
    let [x, y, z] = [0, 1, 2].map(|i| about(axes[i], Tm::new(angles[i]).sin_cos()));
    Ok((product(z, product(y, x)), vector(triple(node, "xyz", [0.0; 3])?)))
}

/// The placement of a pose.
pub(crate) fn pose_of(pose: &Value) -> Checked<Pose> {
    Ok((quaternion(option(pose, "orientation_xyzw"))?, vector(three(&pose["position_m"]))))
}

/// The largest deviation of the square of the norm of a quaternion from one.
const NOT_UNIT: f64 = 2e-3;

/// The rotation of a quaternion `x y z w`, normalised.
pub(crate) fn quaternion(value: Option<&Value>) -> Checked<Matrix> {
    let Some(value) = value else { return Ok(identity().0) };
    let q = [0, 1, 2, 3].map(|i| number(&value[i]));
    let off = (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs();
    require(off <= NOT_UNIT, "an orientation is no unit quaternion")?;
    let [x, y, z, w] = q.map(Tm::new);
    let norm = (x * x + y * y + z * z + w * w).inverse_sqrt();
    let [x, y, z, w] = [x, y, z, w].map(|a| a * norm);
    let (two, one) = (Tm::new(2.0), Tm::new(1.0));
    Ok([
        [one - two * (y * y + z * z), two * (x * y - z * w), two * (x * z + y * w)],
        [two * (x * y + z * w), one - two * (x * x + z * z), two * (y * z - x * w)],
        [two * (x * z - y * w), two * (y * z + x * w), one - two * (x * x + y * y)],
    ])
}

/// The link of a load, its place, and the centre of the load in it.
fn place_of<'a>(load: &'a Value, placed: &'a Links) -> Checked<(&'a str, &'a Place, Pose)> {
    let link = text(&load["link"]);
    let place = placed.get(link).filter(|place| place.0.is_some()).ok_or("the payload is on no link that moves")?;
    let center = option(load, "center_m").map_or([0.0; 3], three);
    Ok((link, place, (identity().0, vector(center))))
}

impl Robot {
    pub(crate) fn read(
        urdf: &str,
        grammar: &Grammar,
        (scenario, pieces): (&Value, &[Vec<Piece>]),
        names: &[String],
    ) -> Checked<Self> {
        let declared = urdf.strip_prefix("<?xml ").and_then(|text| text.split_once("?>"));
        let urdf = declared.map_or(urdf, |(_, text)| text);
        require(!urdf.contains("&#"), "the robot has a reference to a number")?;
        let document = Document::parse(urdf).map_err(|e| e.to_string())?;
        let is_plain = !urdf.starts_with('\u{feff}') && !document.descendants().any(|node| node.is_pi());
        require(is_plain, "the robot has a byte order mark or a processing instruction")?;
        let root = document.root_element();
        let tag = root.tag_name();
        require(tag.name() == "robot" && tag.namespace().is_none_or(str::is_empty), "it is no 'robot'")?;
        grammar.check(Item::Element(root), "robot")?;
        let all = |tag: &'static str| root.children().filter(move |n| n.has_tag_name(tag));
        let name = |n: Node| n.attribute("name").unwrap_or_default().to_owned();
        let links: BTreeMap<String, Node> = all("link").map(|n| (name(n), n)).collect();
        let moved: BTreeSet<String> = all("joint").map(name).collect();
        let unique = links.len() == all("link").count() && moved.len() == all("joint").count();
        require(unique, "two links or two joints have the same name")?;
        let of = |n: Node, tag| child(n, tag).and_then(|c| c.attribute("link")).unwrap_or_default().to_owned();
        let carried: BTreeSet<String> = all("joint").map(|j| of(j, "child")).collect();
        let known = all("joint").all(|j| links.contains_key(&of(j, "parent")) && links.contains_key(&of(j, "child")));
        require(known && carried.len() == moved.len(), "a joint has an unknown link, or a link has two parents")?;
        let base = links.keys().find(|link| !carried.contains(*link)).ok_or("no link is the base")?;
        require(links.len() == moved.len() + 1, "the robot has several roots")?;
        let mut joints: Vec<Option<Joint>> = names.iter().map(|_| None).collect();
        let mut placed = Links::new();
        let base = option(scenario, "root").map_or(base.clone(), |root| text(root).to_owned());
        require(links.contains_key(&base), "the robot has no such root")?;
        let mount = option(scenario, "mount").map_or(Ok(identity()), pose_of)?;
        let mut open = vec![(base, None, mount, None)];
        while let Some((link, body, at, from)) = open.pop() {
            for j in all("joint").filter(|j| Some(*j) != from) {
                // From a new root some joints are traversed from the other side: first the inverse motion, then the
                // inverse of the origin.
                let (step, turned) = (pose(child(j, "origin"))?, of(j, "child") == link);
                if !turned && of(j, "parent") != link {
                    continue;
                }
                let (origin, then, next) = if turned {
                    (at, inverse(&step), of(j, "parent"))
                } else {
                    (compose(&at, &step), identity(), of(j, "child"))
                };
                let kind = j.attribute("type").unwrap_or_default();
                let axis = unit(triple(child(j, "axis"), "xyz", [1.0, 0.0, 0.0])?);
                let axis = if turned { times(axis, Tm::new(-1.0)) } else { axis };
                let mut joint = Joint::new(name(j), body, origin, axis, kind == "prismatic");
                let locked = scenario["locked_joints"].get(&joint.name);
                if kind == "fixed" {
                    open.push((next, body, compose(&origin, &then), Some(j)));
                } else if let Some(q) = locked {
                    open.push((next, body, compose(&joint.placement(Tm::new(number(q))), &then), Some(j)));
                } else {
                    let i = names.iter().position(|n| *n == joint.name);
                    let i = i.ok_or_else(|| format!("joint '{}' has no motion", joint.name))?;
                    joint.read(j, kind, scenario)?;
                    require(joints[i].replace(joint).is_none(), "a joint is there twice")?;
                    open.push((next, Some(i), then, Some(j)));
                }
            }
            require(placed.insert(link, (body, at)).is_none(), "links form a loop")?;
        }
        require(placed.len() == links.len(), "links form a loop")?;
        let mut locked = scenario["locked_joints"].as_object().into_iter().flatten();
        let is_known = |joint: &String| moved.contains(joint) && !names.contains(joint);
        require(locked.all(|(joint, _)| is_known(joint)), "a locked joint is unknown, or moves")?;
        let missing = || "the motion has a joint that the robot has not".to_owned();
        let joints: Option<Vec<Joint>> = joints.into_iter().collect();
        let (joints, base) = (joints.ok_or_else(missing)?, (Tm::new(0.0), vector([0.0; 3])));
        let (links_of, parts) = (BTreeMap::new(), Vec::new());
        let (has_links, meshes) = (false, Vec::new());
        let gravity = option(scenario, "gravity").map_or([0.0, 0.0, -9.81], three);
        let (has_balls, is_known) = (true, true);
        let mut robot = Self { joints, base, gravity, links: links_of, parts, has_balls, is_known, has_links, meshes };
        let early = |(i, j): (usize, &Joint)| j.parent.is_none_or(|p| p < i);
        require(robot.joints.iter().enumerate().all(early), "a joint is before its parent")?;
        robot.add_masses(scenario, &links, &placed)?;
        robot.add_parts((scenario, pieces), &links, &placed)?;
        robot.links = placed;
        Ok(robot)
    }

    /// Adds the masses of the links and of the payload.
    fn add_masses(&mut self, scenario: &Value, links: &BTreeMap<String, Node>, placed: &Links) -> Checked<()> {
        for (link, (body, at)) in placed {
            if let Some(inertial) = links.get(link).and_then(|n| child(*n, "inertial")) {
                let entry = |name| scalar(child(inertial, "inertia"), name);
                let six = [entry("ixx")?, entry("ixy")?, entry("ixz")?, entry("iyy")?, entry("iyz")?, entry("izz")?];
                let mass = scalar(child(inertial, "mass"), "value")?;
                self.add_mass(*body, &compose(at, &pose(child(inertial, "origin"))?), mass, six);
            }
        }
        if let Some(load) = option(scenario, "payload") {
            let (_, (body, at), center) = place_of(load, placed)?;
            let six = option(load, "inertia_kg_m2").map(list).and_then(|six| six.try_into().ok());
            self.add_mass(*body, &compose(at, &center), number(&load["mass_kg"]), six.unwrap_or_default());
        }
        Ok(())
    }

    pub(crate) fn add_mass(&mut self, body: Option<usize>, at: &Pose, mass: f64, six: [f64; 6]) {
        let (c, mass) = (at.1, Tm::new(mass));
        let Some(joint) = body.map(|body| &mut self.joints[body]) else {
            self.base = (self.base.0 + mass, add(self.base.1, times(c, mass)));
            return;
        };
        let [xx, xy, xz, yy, yz, zz] = six.map(Tm::new);
        let own = product(product(at.0, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), transpose(at.0));
        joint.mass = joint.mass + mass;
        joint.first = add(joint.first, times(c, mass));
        for i in 0..3 {
            for j in 0..3 {
                let square = if i == j { dot(c, c) } else { Tm::new(0.0) };
                joint.inertia[i][j] = joint.inertia[i][j] + own[i][j] + mass * (square - c[i] * c[j]);
            }
        }
    }

    /// Adds the shapes of the robot, those of meshes as their pieces.
    fn add_parts(
        &mut self,
        (scenario, pieces): (&Value, &[Vec<Piece>]),
        links: &BTreeMap<String, Node>,
        placed: &Links,
    ) -> Checked<()> {
        let is_shaped = links.values().any(|n| child(*n, "collision").is_some());
        let default = Value::from(if is_shaped { "collision" } else { "joint_frames" });
        let shape = option(scenario, "robot_shape").unwrap_or(&default);
        let by_shapes = shape == "collision" || shape.get("collision").is_some();
        self.has_links = by_shapes;
        if shape == "joint_frames" {
            for body in 0..self.joints.len() {
                self.add_ball(Some(body), "", vector([0.0; 3]), 0.0);
            }
        } else if let Some(swept) = shape.get("swept_links") {
            let radius = number(&swept["radius_m"]);
            let spacing = number_or(swept, "spacing_m", 0.05);
            for body in 0..self.joints.len() {
                let ends = self.joints.iter().filter(|j| j.parent == Some(body)).map(|j| j.origin.1);
                let frames = placed.values().filter(|(of, _)| *of == Some(body)).map(|(_, at)| at.1);
                let mut ends: Vec<Vector> = ends.chain(frames).filter(|e| dot(*e, *e).c[0] > 0.0).collect();
                if ends.is_empty() {
                    ends.push(vector([0.0; 3]));
                }
                for end in ends {
                    let length = dot(end, end).c[0].sqrt();
                    let pieces = (length / spacing).ceil().max(1.0);
                    let is_small = self.parts.len() as f64 + pieces < BALLS;
                    require(is_small, format!("the robot has more than {BALLS} balls"))?;
                    let radius = radius.hypot(0.5 * length / pieces);
                    for i in 0..=pieces as u32 {
                        let centre = times(end, Tm::new(f64::from(i)).over(pieces));
                        self.add_ball(Some(body), "", centre, radius);
                    }
                }
            }
        } else {
            for (link, (body, at)) in placed {
                let Some(node) = links.get(link) else { continue };
                for collision in node.children().filter(|n| n.has_tag_name("collision")) {
                    let at = compose(at, &pose(child(collision, "origin"))?);
                    if let Some((kind, size)) = shape_of(collision)? {
                        self.add_part(*body, link, Solid { at, kind, size });
                        continue;
                    }
                    let mesh = child(collision, "geometry").and_then(|g| child(g, "mesh"));
                    let own = pieces.get(self.meshes.len()).filter(|own| !own.is_empty());
                    for piece in own.ok_or_else(|| format!("a mesh of link '{link}' has no pieces"))? {
                        let middle = piece.middle();
                        let at = compose(&at, &(identity().0, vector(middle)));
                        self.add_part(*body, link, Solid { at, kind: "piece", size: [piece.radius(middle), 0.0, 0.0] });
                        self.parts.last_mut().into_iter().for_each(|part| part.corners = piece.about(middle));
                    }
                    let name = mesh.and_then(|mesh| mesh.attribute("filename")).unwrap_or_default();
                    self.meshes.push((name.to_owned(), triple(mesh, "scale", [1.0; 3])?));
                }
            }
        }
        let load = &scenario["payload"];
        if let Some(shape) = option(load, "shape") {
            let (link, (body, at), center) = place_of(load, placed)?;
            let own = option(load, "shape_pose").map_or(Ok(center), pose_of)?;
            let (kind, size) = solid_of(shape)?;
            self.is_known &= by_shapes || kind == "sphere";
            self.add_part(*body, link, Solid { at: compose(at, &own), kind, size });
        }
        require(self.meshes.len() == pieces.len(), "there are pieces of more meshes than the robot has")?;
        self.has_balls = self.is_known && self.parts.iter().all(|part| part.solid.kind == "sphere");
        Ok(())
    }

    fn add_ball(&mut self, body: Option<usize>, link: &str, centre: Vector, radius: f64) {
        self.add_part(body, link, Solid { at: (identity().0, centre), kind: "sphere", size: [radius, 0.0, 0.0] });
    }

    fn add_part(&mut self, body: Option<usize>, link: &str, solid: Solid) {
        self.parts.push(Part { body, link: link.to_owned(), solid, corners: Vec::new() });
    }

    /// The weight, N.
    pub(crate) fn weight(&self) -> f64 {
        let norm = self.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
        norm * self.joints.iter().fold(self.base.0, |sum, joint| sum + joint.mass).c[0]
    }

    /// The torques, by the recursive Newton-Euler algorithm in the frames of the joints, and the force on the base and
    /// its moment.
    pub(crate) fn torques(&self, q: &[Tm], v: &[Tm], a: &[Tm]) -> (Vec<Tm>, [Vector; 2]) {
        let zero = vector([0.0; 3]);
        let gravity = vector(self.gravity.map(|x| -x));
        let mut ground = [times(gravity, self.base.0), cross(self.base.1, gravity)];
        let mut places: Vec<Pose> = Vec::new();
        // Angular velocity and acceleration, acceleration of the origin.
        let mut moving: Vec<[Vector; 3]> = Vec::new();
        let mut loads: Vec<[Vector; 2]> = Vec::new();
        for (i, joint) in self.joints.iter().enumerate() {
            let place = joint.placement(q[i]);
            let [spin, turning, speeding] = joint.parent.map_or([zero, zero, gravity], |p| moving[p]);
            let inverse = transpose(place.0);
            let at = add(cross(turning, place.1), cross(spin, cross(spin, place.1)));
            let [mut spin, mut turning, mut speeding] = [spin, turning, add(speeding, at)].map(|x| apply(inverse, x));
            let (rate, second) = (times(joint.axis, v[i]), times(joint.axis, a[i]));
            if joint.slides {
                let coriolis = times(cross(spin, rate), Tm::new(2.0));
                speeding = add(speeding, add(second, coriolis));
            } else {
                turning = add(turning, add(second, cross(spin, rate)));
                spin = add(spin, rate);
            }
            let (h, momentum) = (joint.first, apply(joint.inertia, spin));
            let force = add(times(speeding, joint.mass), add(cross(turning, h), cross(spin, cross(spin, h))));
            let moment = add(apply(joint.inertia, turning), add(cross(spin, momentum), cross(h, speeding)));
            places.push(place);
            moving.push([spin, turning, speeding]);
            loads.push([force, moment]);
        }
        let mut torques = vec![Tm::new(0.0); self.joints.len()];
        for (i, joint) in self.joints.iter().enumerate().rev() {
            let [force, moment] = loads[i];
            let [damping, friction, per_width, armature] = joint.drive;
            let x = v[i] * per_width;
            torques[i] = dot(joint.axis, if joint.slides { force } else { moment }) + damping * v[i] + armature * a[i];
            if friction.c[0] > 0.0 {
                torques[i] = torques[i] + friction * x * (Tm::new(1.0) + x * x).inverse_sqrt();
            }
            let force = apply(places[i].0, force);
            let moment = add(apply(places[i].0, moment), cross(places[i].1, force));
            let below = joint.parent.map_or(&mut ground, |parent| &mut loads[parent]);
            *below = [add(below[0], force), add(below[1], moment)];
        }
        (torques, ground)
    }

    /// The placements of the bodies in the base frame.
    pub(crate) fn places(&self, q: &[Tm]) -> Vec<Pose> {
        let mut places: Vec<Pose> = Vec::new();
        for (joint, q) in self.joints.iter().zip(q) {
            let own = joint.placement(*q);
            places.push(joint.parent.map_or(own, |p| compose(&places[p], &own)));
        }
        places
    }

    /// The placements of the shapes in the base frame.
    pub(crate) fn placed(&self, places: &[Pose]) -> Vec<Pose> {
        self.parts.iter().map(|part| part.body.map_or(part.solid.at, |b| compose(&places[b], &part.solid.at))).collect()
    }
}
