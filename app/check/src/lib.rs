//! A checker of certificates, in one file. It shares no code with the library that plans motions and writes
//! certificates: URDF, scenario, polynomials, inverse dynamics and distances are read and computed here once more, with
//! the errors of rounding. `proofs/certificate.md` has the statement and its proof.

use roxmltree::{Document, Node};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ops::{Add, Mul, Neg, Sub};

/// A result, or the reason of a refusal.
type Checked<T> = Result<T, String>;

const UNIT: f64 = f64::EPSILON / 2.0;
const UP: f64 = 1.0 + 1024.0 * UNIT;
const TINY: f64 = f64::MIN_POSITIVE;
/// The assumed error of the sine and the cosine of the platform.
const SIN_COS: f64 = 2.0 * f64::EPSILON;
/// The accepted shortfall of a reserve, and the accepted deviations of states and of accelerations.
const TOLERANCE: f64 = 1e-9;
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// The functions within `r` of the polynomial with the coefficients `c` in s, from -1 to 1.
#[derive(Clone, Copy, Debug)]
struct Enclosure<const N: usize> {
    c: [f64; N],
    r: f64,
}
type Ball = Enclosure<1>;
type Tm = Enclosure<10>;
type Vector = [Tm; 3];
type Matrix = [Vector; 3];

impl<const N: usize> Enclosure<N> {
    fn new(x: f64) -> Self {
        Self::within(x, 0.0)
    }
    fn within(x: f64, r: f64) -> Self {
        let mut c = [0.0; N];
        c[0] = x;
        Self { c, r }
    }
    fn size(&self) -> f64 {
        self.c.iter().map(|c| c.abs()).sum()
    }
    fn most(&self) -> f64 {
        (self.size() + self.r) * UP
    }
    fn widened(mut self, by: f64) -> Self {
        self.r = (self.r + by) * UP + TINY;
        self
    }
    fn over(mut self, x: f64) -> Self {
        self.c = self.c.map(|c| c / x);
        self.r /= x.abs();
        self.widened(UNIT * self.size())
    }
    fn turn(mut self) -> (f64, Self) {
        let first = self.c[0];
        self.c[0] = 0.0;
        (first, self)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (first, turn) = self.turn();
        let size = turn.most();
        if !(size <= 1.0 && first.is_finite()) {
            return (Self::within(0.0, 1.0), Self::within(0.0, 1.0));
        }
        let (square, one) = (turn * turn, Self::new(1.0));
        let nested = |odd: f64| {
            (1..=8).rev().fold(one, |sum, k| {
                let n = 2.0 * f64::from(k) + odd;
                one - (square * sum).over(n * (n - 1.0))
            })
        };
        let rest = size.powi(18) / 6e15;
        let (c, s) = (nested(0.0).widened(rest), (turn * nested(1.0)).widened(rest));
        let (sin, cos) = first.sin_cos();
        let (sin, cos) = (Self::within(sin, SIN_COS), Self::within(cos, SIN_COS));
        (sin * c + cos * s, cos * c - sin * s)
    }
    fn inverse_sqrt(self) -> Self {
        let (first, rest) = self.turn();
        let x = rest.over(first);
        let size = x.most();
        if !(size < 0.99 && first > 0.0) {
            return Self::within(0.0, f64::INFINITY);
        }
        let one = Self::new(1.0);
        let series = (1..=16).rev().fold(one, |sum, k| {
            let k = f64::from(k);
            one - (x * sum * Self::new(2.0 * k - 1.0)).over(2.0 * k)
        });
        let series = series.widened(1.01 * size.powi(17) / (1.0 - size));
        // The root is rounded, relative to values of the series of at most 10.
        series.over(first.sqrt()).widened(20.0 * UNIT / first.sqrt())
    }
}
impl<const N: usize> Add for Enclosure<N> {
    type Output = Self;
    fn add(mut self, b: Self) -> Self {
        self.c.iter_mut().zip(b.c).for_each(|(a, b)| *a += b);
        self.widened(b.r + UNIT * self.size())
    }
}
impl<const N: usize> Neg for Enclosure<N> {
    type Output = Self;
    fn neg(mut self) -> Self {
        self.c = self.c.map(|c| -c);
        self
    }
}
impl<const N: usize> Sub for Enclosure<N> {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}
impl<const N: usize> Mul for Enclosure<N> {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let (mut c, mut tail, mut cut) = ([0.0; N], 0.0, 0.0);
        for i in 0..N {
            for j in 0..N - i {
                c[i + j] += self.c[i] * b.c[j];
            }
            cut += self.c[i].abs() * tail;
            tail += b.c[N - 1 - i].abs();
        }
        let size = self.size();
        let errors = (N as f64 + 2.0) * UNIT * size * tail + size * b.r + self.r * (tail + b.r);
        Self { c, r: 0.0 }.widened(cut + errors)
    }
}

fn vector(x: [f64; 3]) -> Vector {
    x.map(Tm::new)
}
fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] + b[i])
}
fn times(a: Vector, k: Tm) -> Vector {
    a.map(|a| a * k)
}
fn dot(a: Vector, b: Vector) -> Tm {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}
fn apply(m: Matrix, x: Vector) -> Vector {
    m.map(|row| dot(row, x))
}
fn transpose(m: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}
fn product(a: Matrix, b: Matrix) -> Matrix {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}
/// The rotation about a unit vector by an angle with this sine and cosine.
fn about(a: Vector, (sin, cos): (Tm, Tm)) -> Matrix {
    let versine = Tm::new(1.0) - cos;
    let [x, y, z] = times(a, sin);
    let skew = [[Tm::new(0.0), -z, y], [z, Tm::new(0.0), -x], [-y, x, Tm::new(0.0)]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let one = if i == j { cos } else { Tm::new(0.0) };
            a[i] * a[j] * versine + skew[i][j] + one
        })
    })
}

/// A placement: rotation and translation.
type Pose = (Matrix, Vector);
fn identity() -> Pose {
    let one = |i: usize, j: usize| Tm::new(if i == j { 1.0 } else { 0.0 });
    (std::array::from_fn(|i| std::array::from_fn(|j| one(i, j))), vector([0.0; 3]))
}
fn compose(a: &Pose, b: &Pose) -> Pose {
    (product(a.0, b.0), add(apply(a.0, b.1), a.1))
}

/// A joint and its body, in the frame of the joint.
struct Joint {
    name: String,
    parent: Option<usize>,
    origin: Pose,
    axis: Vector,
    slides: bool,
    mass: Tm,
    first: Vector,
    inertia: Matrix,
    /// Damping, friction, the inverse of its width, armature.
    drive: [Tm; 4],
    /// Lower and upper position, velocity, effort.
    limits: [f64; 4],
}
impl Joint {
    fn placement(&self, q: Tm) -> Pose {
        match self.slides {
            true => (self.origin.0, add(self.origin.1, apply(self.origin.0, times(self.axis, q)))),
            false => (product(self.origin.0, about(self.axis, q.sin_cos())), self.origin.1),
        }
    }
}

/// A ball of a link.
struct Part {
    body: Option<usize>,
    link: String,
    centre: Vector,
    radius: f64,
}

struct Robot {
    joints: Vec<Joint>,
    parts: Vec<Part>,
    /// False if a shape is no ball: nothing is certified of clearances then.
    has_balls: bool,
}

fn numbers(text: &str) -> Checked<Vec<f64>> {
    let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
    let all: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    all.ok_or_else(|| format!("'{text}' has something that is no finite number"))
}
fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.has_tag_name(name))
}
fn scalar(node: Option<Node>, name: &str) -> Checked<f64> {
    let text = node.and_then(|n| n.attribute(name));
    text.map_or(Ok(0.0), |text| numbers(text)?.first().copied().ok_or("a number is missing".to_owned()))
}
fn triple(node: Option<Node>, name: &str, default: [f64; 3]) -> Checked<[f64; 3]> {
    let text = node.and_then(|n| n.attribute(name));
    text.map_or(Ok(default), |t| numbers(t)?.try_into().map_err(|_| format!("'{t}' has no three numbers")))
}
fn pose(node: Option<Node>) -> Checked<Pose> {
    let angles = triple(node, "rpy", [0.0; 3])?;
    let axes = identity().0;
    let [x, y, z] = [0, 1, 2].map(|i| about(axes[i], Tm::new(angles[i]).sin_cos()));
    Ok((product(z, product(y, x)), vector(triple(node, "xyz", [0.0; 3])?)))
}
fn unit(axis: [f64; 3]) -> Vector {
    let axis = vector(axis);
    times(axis, dot(axis, axis).inverse_sqrt())
}

fn get<'a>(value: &'a Value, key: &str) -> Checked<&'a Value> {
    value.get(key).filter(|v| !v.is_null()).ok_or_else(|| format!("'{key}' is missing"))
}
fn option<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    value.get(key).filter(|v| !v.is_null())
}
fn number(value: &Value) -> Checked<f64> {
    let x = value.as_f64().filter(|x| x.is_finite());
    x.ok_or_else(|| format!("{value} is no finite number"))
}
fn list(value: &Value) -> Checked<Vec<f64>> {
    array(value)?.iter().map(number).collect()
}
fn array(value: &Value) -> Checked<&Vec<Value>> {
    value.as_array().ok_or_else(|| "a list is missing".to_owned())
}
fn text(value: &Value) -> Checked<&str> {
    value.as_str().ok_or_else(|| format!("{value} is no text"))
}
fn three(value: &Value) -> Checked<[f64; 3]> {
    list(value)?.try_into().map_err(|_| "three numbers are needed".to_owned())
}
fn require(condition: bool, fault: impl Into<String>) -> Checked<()> {
    if condition { Ok(()) } else { Err(fault.into()) }
}

/// The rotation of a quaternion `x y z w`, normalised.
fn quaternion(value: Option<&Value>) -> Checked<Matrix> {
    let Some(value) = value else { return Ok(identity().0) };
    let q: [f64; 4] = list(value)?.try_into().map_err(|_| "an orientation needs four numbers".to_owned())?;
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

impl Robot {
    fn read(urdf: &str, scenario: &Value, names: &[String]) -> Checked<Self> {
        let document = Document::parse(urdf).map_err(|e| e.to_string())?;
        let root = document.root_element();
        let all = |tag: &'static str| root.children().filter(move |n| n.has_tag_name(tag));
        let name = |n: Node| n.attribute("name").unwrap_or_default().to_owned();
        let links: BTreeMap<String, Node> = all("link").map(|n| (name(n), n)).collect();
        let of = |n: Node, tag| child(n, tag).and_then(|c| c.attribute("link")).unwrap_or_default().to_owned();
        let carried = |link: &String| all("joint").any(|j| of(j, "child") == *link);
        let base = links.keys().find(|link| !carried(link)).ok_or("no link is the base")?;
        let mut joints: Vec<Option<Joint>> = names.iter().map(|_| None).collect();
        let mut placed: BTreeMap<String, (Option<usize>, Pose)> = BTreeMap::new();
        let mut open = vec![(base.clone(), None, identity())];
        while let Some((link, body, at)) = open.pop() {
            for j in all("joint").filter(|j| of(*j, "parent") == link) {
                let origin = compose(&at, &pose(child(j, "origin"))?);
                let kind = j.attribute("type").unwrap_or_default();
                let axis = unit(triple(child(j, "axis"), "xyz", [1.0, 0.0, 0.0])?);
                let mut joint = Joint::new(name(j), body, origin, axis, kind == "prismatic");
                let locked = option(scenario, "locked_joints").and_then(|l| l.get(&joint.name));
                if kind == "fixed" {
                    open.push((of(j, "child"), body, origin));
                } else if let Some(q) = locked {
                    open.push((of(j, "child"), body, joint.placement(Tm::new(number(q)?))));
                } else {
                    require(["revolute", "continuous", "prismatic"].contains(&kind), format!("joint type '{kind}'"))?;
                    let i = names.iter().position(|n| *n == joint.name);
                    let i = i.ok_or_else(|| format!("joint '{}' has no motion", joint.name))?;
                    joint.read(j, kind, scenario)?;
                    require(joints[i].replace(joint).is_none(), "a joint is there twice")?;
                    open.push((of(j, "child"), Some(i), identity()));
                }
            }
            require(placed.insert(link, (body, at)).is_none(), "links form a loop")?;
        }
        let missing = || "the motion has a joint that the robot has not".to_owned();
        let joints: Option<Vec<Joint>> = joints.into_iter().collect();
        let mut robot = Self { joints: joints.ok_or_else(missing)?, parts: Vec::new(), has_balls: true };
        let early = |(i, j): (usize, &Joint)| j.parent.is_none_or(|p| p < i);
        require(robot.joints.iter().enumerate().all(early), "a joint is before its parent")?;
        for (link, (body, at)) in &placed {
            if let Some(inertial) = links.get(link).and_then(|n| child(*n, "inertial")) {
                let entry = |name| scalar(child(inertial, "inertia"), name);
                let six = [entry("ixx")?, entry("ixy")?, entry("ixz")?, entry("iyy")?, entry("iyz")?, entry("izz")?];
                let mass = scalar(child(inertial, "mass"), "value")?;
                robot.add_mass(*body, &compose(at, &pose(child(inertial, "origin"))?), mass, six);
            }
        }
        if let Some(load) = option(scenario, "payload") {
            let (body, at) = placed.get(text(get(load, "link")?)?).ok_or("the payload has no link")?;
            let center = option(load, "center_m").map_or(Ok([0.0; 3]), three)?;
            let six = option(load, "inertia_kg_m2").map_or(Ok(vec![0.0; 6]), list)?;
            let six = six.try_into().map_err(|_| "six numbers are needed".to_owned())?;
            let center = (identity().0, vector(center));
            robot.add_mass(*body, &compose(at, &center), number(get(load, "mass_kg")?)?, six);
        }
        robot.add_parts(scenario, &links, &placed)?;
        Ok(robot)
    }

    fn add_mass(&mut self, body: Option<usize>, at: &Pose, mass: f64, six: [f64; 6]) {
        let Some(joint) = body.map(|body| &mut self.joints[body]) else { return };
        let [xx, xy, xz, yy, yz, zz] = six.map(Tm::new);
        let own = product(product(at.0, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), transpose(at.0));
        let (c, mass) = (at.1, Tm::new(mass));
        joint.mass = joint.mass + mass;
        joint.first = add(joint.first, times(c, mass));
        for i in 0..3 {
            for j in 0..3 {
                let square = if i == j { dot(c, c) } else { Tm::new(0.0) };
                joint.inertia[i][j] = joint.inertia[i][j] + own[i][j] + mass * (square - c[i] * c[j]);
            }
        }
    }

    /// Adds the balls of the shape of the robot.
    fn add_parts(
        &mut self,
        scenario: &Value,
        links: &BTreeMap<String, Node>,
        placed: &BTreeMap<String, (Option<usize>, Pose)>,
    ) -> Checked<()> {
        let is_shaped = links.values().any(|n| child(*n, "collision").is_some());
        let default = Value::from(if is_shaped { "collision" } else { "joint_frames" });
        let shape = option(scenario, "robot_shape").unwrap_or(&default);
        if shape == "joint_frames" {
            for body in 0..self.joints.len() {
                self.add_ball(Some(body), "", vector([0.0; 3]), 0.0);
            }
        } else if let Some(swept) = shape.get("swept_links") {
            let radius = number(get(swept, "radius_m")?)?;
            let spacing = option(swept, "spacing_m").map_or(Ok(0.05), number)?;
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
                    let ball = child(collision, "geometry").and_then(|g| child(g, "sphere"));
                    let Some(ball) = ball else {
                        self.has_balls = false;
                        continue;
                    };
                    let radius = scalar(Some(ball), "radius")?;
                    let centre = compose(at, &pose(child(collision, "origin"))?).1;
                    self.add_ball(*body, link, centre, radius);
                }
            }
        }
        let Some(load) = option(scenario, "payload").filter(|l| option(l, "shape").is_some()) else { return Ok(()) };
        let Some(ball) = option(get(load, "shape")?, "sphere") else {
            self.has_balls = false;
            return Ok(());
        };
        let link = text(get(load, "link")?)?;
        let (body, at) = placed.get(link).ok_or("the payload has no link")?;
        let center = option(load, "center_m").map_or(Ok([0.0; 3]), three)?;
        let own = option(load, "shape_pose").map_or(Ok(center), |p| three(get(p, "position_m")?))?;
        let centre = add(apply(at.0, vector(own)), at.1);
        self.add_ball(*body, link, centre, number(get(ball, "radius_m")?)?);
        Ok(())
    }

    fn add_ball(&mut self, body: Option<usize>, link: &str, centre: Vector, radius: f64) {
        self.parts.push(Part { body, link: link.to_owned(), centre, radius });
    }

    /// The torques, by the recursive Newton-Euler algorithm in the frames of the joints.
    fn torques(&self, q: &[Tm], v: &[Tm], a: &[Tm]) -> Vec<Tm> {
        let zero = vector([0.0; 3]);
        let gravity = vector([0.0, 0.0, 9.81]);
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
            if let Some(parent) = joint.parent {
                let force = apply(places[i].0, force);
                let moment = add(apply(places[i].0, moment), cross(places[i].1, force));
                loads[parent] = [add(loads[parent][0], force), add(loads[parent][1], moment)];
            }
        }
        torques
    }

    /// The centres of the balls in the base frame.
    fn centres(&self, q: &[Tm]) -> Vec<Vector> {
        let mut places: Vec<Pose> = Vec::new();
        for (joint, q) in self.joints.iter().zip(q) {
            let own = joint.placement(*q);
            places.push(joint.parent.map_or(own, |p| compose(&places[p], &own)));
        }
        let one = |part: &Part| part.body.map_or(part.centre, |b| add(apply(places[b].0, part.centre), places[b].1));
        self.parts.iter().map(one).collect()
    }
}

impl Joint {
    fn new(name: String, parent: Option<usize>, origin: Pose, axis: Vector, slides: bool) -> Self {
        let zero = Tm::new(0.0);
        let (first, inertia) = ([zero; 3], [[zero; 3]; 3]);
        let (drive, limits) = ([zero; 4], [f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY, f64::INFINITY]);
        Self { name, parent, origin, axis, slides, mass: zero, first, inertia, drive, limits }
    }

    fn read(&mut self, node: Node, kind: &str, scenario: &Value) -> Checked<()> {
        let limit = |name| scalar(child(node, "limit"), name);
        let [lower, upper, velocity, effort] = [limit("lower")?, limit("upper")?, limit("velocity")?, limit("effort")?];
        if [lower, upper, velocity, effort].iter().any(|x| *x != 0.0) {
            let known = |x: f64| if x > 0.0 { x } else { f64::INFINITY };
            self.limits = [lower, upper, known(velocity), known(effort)];
            if kind == "continuous" {
                self.limits[0] = f64::NEG_INFINITY;
                self.limits[1] = f64::INFINITY;
            }
        }
        let losses = option(scenario, "losses").unwrap_or(&Value::Bool(false));
        if *losses == Value::Bool(false) {
            return Ok(());
        }
        let of_urdf = |name| scalar(child(node, "dynamics"), name);
        let given = |key: &str, default: f64| match option(losses, key) {
            Some(Value::Object(by_name)) => by_name.get(&self.name).map_or(Ok(default), number),
            Some(same) => number(same),
            None => Ok(default),
        };
        let width = given("friction_velocity", 0.02)?;
        self.drive = [
            Tm::new(given("damping", of_urdf("damping")?)?),
            Tm::new(given("friction", of_urdf("friction")?)?),
            Tm::new(1.0).over(width),
            Tm::new(given("armature", 0.0)?),
        ];
        Ok(())
    }
}

/// A polynomial in s, and a bound on its error.
type Polynomial = (Vec<f64>, f64);

/// Positions, velocities, accelerations and jerks of the joints on a part of a segment, |x - m| <= w: Taylor
/// coefficients about m from the Chebyshev coefficients of the derivatives.
fn expand(segment: &[Vec<f64>], rate: Ball, [m, w]: [f64; 2]) -> [Vec<Polynomial>; 4] {
    let degree = segment[0].len() - 1;
    let (one, x) = (Ball::new(1.0), Ball::new(m));
    let mut chebyshev = vec![one, x];
    for j in 2..=degree {
        let twice = chebyshev[j / 2] * chebyshev[j - j / 2] * Ball::new(2.0);
        chebyshev.push(twice - if j % 2 == 0 { one } else { x });
    }
    let mut found = [const { Vec::new() }; 4];
    for coefficients in segment {
        let mut c: Vec<Ball> = coefficients.iter().map(|c| Ball::new(*c)).collect();
        let (mut taylor, mut power) = (Vec::new(), one);
        for k in 0..=degree {
            let sum = c.iter().zip(&chebyshev).fold(Ball::new(0.0), |sum, (c, t)| sum + *c * *t);
            taylor.push(sum * power);
            power = power * Ball::new(w);
            // The next derivative over k + 1.
            let n = c.len() - 1;
            let mut next = vec![Ball::new(0.0); n + 2];
            for j in (1..=n).rev() {
                next[j - 1] = next[j + 1] + c[j] * Ball::new(2.0 * j as f64);
            }
            next.truncate(n);
            if let Some(first) = next.first_mut() {
                *first = first.over(2.0);
            }
            c = next.iter().map(|c| c.over((k + 1) as f64)).collect();
        }
        for found in &mut found {
            let radius: f64 = taylor.iter().map(|c| c.r).sum();
            found.push((taylor.iter().map(|c| c.c[0]).collect(), radius * UP));
            let rates = taylor.iter().enumerate().skip(1);
            taylor = rates.map(|(k, c)| *c * Ball::new(k as f64) * rate).collect();
        }
    }
    found
}

/// The value at s = 0.
fn middle(polynomial: &Polynomial) -> Ball {
    Ball::within(polynomial.0[0], polynomial.1)
}

/// The Bernstein coefficients of the powers of s on [-1, 1].
struct Bernstein(Vec<Vec<f64>>);
impl Bernstein {
    fn new(n: usize) -> Self {
        // From s^k of degree m to degree m + 1, with the sign 1, or times s, with -1.
        let raise = |b: &[f64], sign: f64| -> Vec<f64> {
            let m = b.len();
            let at = |i: usize| b.get(i).copied().unwrap_or(0.0);
            let share = |i: usize| i as f64 / m as f64;
            (0..=m).map(|i| share(i) * at(i.wrapping_sub(1)) + sign * share(m - i) * at(i)).collect()
        };
        let (mut power, mut all) = (vec![1.0], Vec::new());
        for k in 0..=n {
            all.push((k..n).fold(power.clone(), |b, _| raise(&b, 1.0)));
            power = raise(&power, -1.0);
        }
        Self(all)
    }

    /// A lower bound on the values, which need not be above `enough`, nor closer than `accuracy` to the least one.
    fn least(&self, c: &[f64], r: f64, enough: f64, accuracy: f64) -> f64 {
        let n = self.0.len() - 1;
        let mut b = vec![0.0; n + 1];
        for (c, power) in c.iter().zip(&self.0) {
            b.iter_mut().zip(power).for_each(|(b, p)| *b += c * p);
        }
        let size: f64 = c.iter().map(|c| c.abs()).sum();
        let error = (r + 64.0 * (n + 1) as f64 * f64::EPSILON * size) * UP + TINY;
        let (mut least, mut reached) = (f64::INFINITY, b[0].min(b[n]));
        let (mut open, mut parts) = (vec![b], 1);
        while let Some(mut right) = open.pop() {
            let low = right.iter().copied().fold(f64::INFINITY, f64::min);
            if low - error >= enough || low + accuracy >= reached || parts > 1024 {
                least = least.min(low);
                continue;
            }
            let mut left = vec![right[0]];
            for level in 1..=n {
                for i in 0..=n - level {
                    right[i] = 0.5 * (right[i] + right[i + 1]);
                }
                left.push(right[0]);
            }
            reached = reached.min(right[0]).min(right[n]);
            open.extend([left, right]);
            parts += 2;
        }
        // Not a number if the error is none.
        (least - error).next_down()
    }
}

/// A limit of a joint: the name of the promise, the joint, and the bounds.
struct Limit(&'static str, usize, [f64; 2]);

/// The limits that a scenario enforces.
fn limits(scenario: &Value, robot: &Robot) -> Checked<Vec<Limit>> {
    let none = Value::Null;
    let enforced = option(scenario, "enforced_limits").unwrap_or(&none);
    let passive: Vec<&str> = match option(scenario, "passive") {
        Some(names) => array(names)?.iter().map(text).collect::<Checked<_>>()?,
        None => Vec::new(),
    };
    let share = |key: &str, joint: &str| -> Checked<Option<f64>> {
        Ok(match option(enforced, key) {
            None | Some(Value::Bool(true)) => Some(1.0),
            Some(Value::Bool(false)) => None,
            Some(Value::Number(share)) => share.as_f64(),
            Some(part) => {
                let named =
                    option(part, "joints").map_or(Ok(true), |j| Ok::<_, String>(array(j)?.iter().any(|n| n == joint)));
                let share = option(part, "share").map_or(Ok(1.0), number)?;
                named?.then_some(share)
            }
        })
    };
    let most = |key: &str, i: usize| -> Checked<Option<f64>> {
        match option(enforced, key) {
            None => Ok(None),
            Some(Value::Array(each)) => each.get(i).filter(|x| !x.is_null()).map(number).transpose(),
            Some(same) => Ok(Some(number(same).map_err(|_| format!("{key}: use the scenario of the summary"))?)),
        }
    };
    let mut all = Vec::new();
    for promise in ["position", "velocity", "acceleration", "jerk", "torque"] {
        for (i, joint) in robot.joints.iter().enumerate() {
            let [lower, upper, velocity, effort] = joint.limits;
            let given = match promise {
                "velocity" => most("max_velocity", i)?,
                "acceleration" | "jerk" => most(promise, i)?,
                _ => None,
            };
            let share = share(promise, &joint.name)?;
            let mut bounds = match (promise, share) {
                ("position", Some(share)) => {
                    let cut = 0.5 * (1.0 - share) * (upper - lower);
                    if cut.is_finite() { [lower + cut, upper - cut] } else { [lower, upper] }
                }
                ("velocity", Some(share)) => [-share * velocity, share * velocity],
                ("torque", Some(share)) if !passive.contains(&joint.name.as_str()) => [-share * effort, share * effort],
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
            if let Some(most) = given {
                bounds = [bounds[0].max(-most), bounds[1].min(most)];
            }
            if bounds.iter().any(|b| b.is_finite()) {
                all.push(Limit(promise, i, bounds));
            }
        }
    }
    Ok(all)
}

/// An obstacle: placement, kind, lengths, and the distance that is kept.
struct Obstacle {
    inverse: Matrix,
    at: Vector,
    kind: &'static str,
    size: [f64; 3],
    margin: f64,
}

fn obstacles(scenario: &Value) -> Checked<Vec<Obstacle>> {
    let given = option(scenario, "clearance_m");
    let beside = given
        .map_or(Ok(0.0), |c| if c.is_object() { option(c, "obstacles").map_or(Ok(0.0), number) } else { number(c) })?;
    let mut all = Vec::new();
    for obstacle in option(scenario, "obstacles").map_or(Ok(&Vec::new()), array)? {
        let (shape, pose) = (get(obstacle, "shape")?, get(obstacle, "pose")?);
        let of = |kind: &str, key: &str| number(get(get(shape, kind)?, key)?);
        let (kind, size) = if shape.get("sphere").is_some() {
            ("sphere", [of("sphere", "radius_m")?, 0.0, 0.0])
        } else if let Some(own) = shape.get("box") {
            ("box", three(get(own, "size_m")?)?.map(|x| 0.5 * x))
        } else if shape.get("cylinder").is_some() {
            ("cylinder", [of("cylinder", "radius_m")?, 0.5 * of("cylinder", "length_m")?, 0.0])
        } else if shape.get("capsule").is_some() {
            ("capsule", [of("capsule", "radius_m")?, 0.5 * of("capsule", "length_m")?, 0.0])
        } else {
            require(shape.get("half_space").is_some(), "an obstacle has an unknown shape")?;
            ("half_space", [0.0; 3])
        };
        all.push(Obstacle {
            inverse: transpose(quaternion(option(pose, "orientation_xyzw"))?),
            at: vector(three(get(pose, "position_m")?)?),
            kind,
            size,
            margin: option(obstacle, "clearance_m").map_or(Ok(beside), number)?,
        });
    }
    Ok(all)
}

/// Lower bounds on distances.
struct Distances<'a>(&'a Bernstein);
impl Distances<'_> {
    fn lower(&self, x: Tm) -> f64 {
        self.0.least(&x.c, x.r, f64::INFINITY, 1e-12)
    }
    fn length(&self, of: &[Tm]) -> f64 {
        let square = of.iter().fold(Tm::new(0.0), |sum, x| sum + *x * *x);
        let square = self.lower(square);
        if square < 0.0 { 0.0 } else { square.sqrt() * (1.0 - 4.0 * UNIT) }
    }
    /// From the surface of an obstacle, negative inside.
    fn from(&self, obstacle: &Obstacle, p: Vector) -> f64 {
        let p = apply(obstacle.inverse, add(p, obstacle.at.map(|x| -x)));
        let [r, h, _] = obstacle.size;
        let beyond = |i: usize, half: f64| {
            let off = if p[i].c[0] < 0.0 { -p[i] } else { p[i] } - Tm::new(half);
            (off, self.lower(off))
        };
        match obstacle.kind {
            "sphere" => self.length(&p) - r,
            "half_space" => self.lower(p[2]),
            "capsule" => {
                let (off, least) = beyond(2, h);
                self.length(&[p[0], p[1], off][..if least >= 0.0 { 3 } else { 2 }]) - r
            }
            "cylinder" => {
                let (along, across) = (beyond(2, h).1, self.length(&p[..2]) - r);
                if along >= 0.0 && across >= 0.0 { along.hypot(across) * (1.0 - 4.0 * UNIT) } else { along.max(across) }
            }
            _ => {
                let faces = [0, 1, 2].map(|i| beyond(i, obstacle.size[i]));
                let out: Vec<Tm> = faces.iter().filter(|f| f.1 >= 0.0).map(|f| f.0).collect();
                if out.len() >= 2 { self.length(&out) } else { faces.iter().fold(f64::NEG_INFINITY, |a, f| a.max(f.1)) }
            }
        }
    }
}

/// Two balls, or a ball and an obstacle, and the distance that is kept.
struct Pair {
    part: usize,
    other: Result<usize, usize>,
    margin: f64,
}

/// The pairs of a ball on a moving body and an obstacle, and those of balls of links that keep clear of each other.
fn pairs(scenario: &Value, certificate: &Value, robot: &Robot, obstacles: &[Obstacle]) -> Checked<[Vec<Pair>; 2]> {
    let (mut beside, mut links) = (Vec::new(), Vec::new());
    let given = option(scenario, "clearance_m");
    let itself = given
        .map_or(Ok(0.0), |c| if c.is_object() { option(c, "itself").map_or(Ok(0.0), number) } else { number(c) })?;
    let of_pair = |a: &str, b: &str| -> Checked<f64> {
        let own = given.and_then(|c| option(c, "pairs")).and_then(Value::as_array);
        let own = own.into_iter().flatten().find(|p| is_pair(p.get("links"), a, b));
        own.map_or(Ok(itself), |p| number(get(p, "clearance_m")?))
    };
    if !robot.has_balls {
        return Ok([Vec::new(), Vec::new()]);
    }
    let free = array(get(certificate, "may_overlap")?)?;
    let off = option(scenario, "self_collision").is_some_and(|s| s == "off");
    for (i, part) in robot.parts.iter().enumerate() {
        if part.body.is_some() {
            let all = obstacles.iter().enumerate();
            beside.extend(all.map(|(o, obstacle)| Pair { part: i, other: Err(o), margin: obstacle.margin }));
        }
        for (j, other) in robot.parts.iter().enumerate().skip(i + 1) {
            let (a, b) = (part.link.as_str(), other.link.as_str());
            let apart = !off && !a.is_empty() && !b.is_empty() && a != b && part.body != other.body;
            if apart && !free.iter().any(|pair| is_pair(Some(pair), a, b)) {
                links.push(Pair { part: i, other: Ok(j), margin: of_pair(a, b)? });
            }
        }
    }
    Ok([beside, links])
}

fn is_pair(value: Option<&Value>, a: &str, b: &str) -> bool {
    let names = value.and_then(Value::as_array).filter(|names| names.len() == 2);
    names.is_some_and(|n| n[0] == a && n[1] == b || n[0] == b && n[1] == a)
}

/// True if all pairs keep their distances and `claim` beyond them.
fn keeps(
    claim: f64,
    pairs: &[Pair],
    robot: &Robot,
    obstacles: &[Obstacle],
    centres: &[Vector],
    by: &Distances,
) -> bool {
    let distance = |pair: &Pair, p: Vector, far: bool| {
        let part = &robot.parts[pair.part];
        let surface = match pair.other {
            Err(i) => by.from(&obstacles[i], p),
            Ok(j) => {
                let centre = if far { centres[j].map(|x| Tm::new(x.c[0])) } else { centres[j] };
                by.length(&add(p, centre.map(|x| -x))) - robot.parts[j].radius
            }
        };
        surface - part.radius - pair.margin
    };
    let way = |i: usize| {
        let off = centres[i].map(|x| x.turn().1.most());
        (off.iter().map(|x| x * x).sum::<f64>().sqrt() + 1e-12) * UP
    };
    let ways: Vec<f64> = (0..centres.len()).map(way).collect();
    pairs.iter().all(|pair| {
        // The distance in the middle less the ways from there is enough for most.
        let middle = distance(pair, centres[pair.part].map(|x| Tm::new(x.c[0])), true);
        let way = ways[pair.part] + pair.other.map_or(0.0, |j| ways[j]);
        middle - way >= claim || distance(pair, centres[pair.part], false) >= claim
    })
}

/// The 64-bit xxHash of a text, with the seed zero.
fn xxh64(text: &[u8]) -> u64 {
    const P: [u64; 5] = [
        0x9E37_79B1_85EB_CA87,
        0xC2B2_AE3D_27D4_EB4F,
        0x1656_67B1_9E37_79F9,
        0x85EB_CA77_C2B2_AE63,
        0x27D4_EB2F_1656_67C5,
    ];
    let round = |a: u64, word: u64| a.wrapping_add(word.wrapping_mul(P[1])).rotate_left(31).wrapping_mul(P[0]);
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |sum, b| sum << 8 | u64::from(*b));
    let blocks = text.chunks_exact(32);
    let mut rest = blocks.remainder();
    let mut hash = P[4];
    if text.len() >= 32 {
        let mut lanes = [P[0].wrapping_add(P[1]), P[1], 0, 0_u64.wrapping_sub(P[0])];
        for block in blocks {
            for (lane, bytes) in lanes.iter_mut().zip(block.chunks(8)) {
                *lane = round(*lane, word(bytes));
            }
        }
        let turns = lanes.iter().zip([1, 7, 12, 18]).map(|(lane, by)| lane.rotate_left(by));
        hash = turns.fold(0, u64::wrapping_add);
        for lane in lanes {
            hash = (hash ^ round(0, lane)).wrapping_mul(P[0]).wrapping_add(P[3]);
        }
    }
    hash = hash.wrapping_add(text.len() as u64);
    while rest.len() >= 8 {
        hash = (hash ^ round(0, word(&rest[..8]))).rotate_left(27).wrapping_mul(P[0]).wrapping_add(P[3]);
        rest = &rest[8..];
    }
    if rest.len() >= 4 {
        hash = (hash ^ word(&rest[..4]).wrapping_mul(P[0])).rotate_left(23).wrapping_mul(P[1]).wrapping_add(P[2]);
        rest = &rest[4..];
    }
    for byte in rest {
        hash = (hash ^ u64::from(*byte).wrapping_mul(P[4])).rotate_left(11).wrapping_mul(P[0]);
    }
    hash = (hash ^ hash >> 33).wrapping_mul(P[1]);
    hash = (hash ^ hash >> 29).wrapping_mul(P[2]);
    hash ^ hash >> 32
}

/// Checks a certificate, given the texts of the robot, of the scenario (or of a summary that contains it), of the
/// summary of the solve, whose motion it is about, and of the certificate. Returns what is certified in words.
///
/// # Errors
/// The reason of a refusal.
pub fn check(robot: &str, scenario: &str, run: &str, certificate: &str) -> Checked<String> {
    let parse = |text: &str, what: &str| serde_json::from_str::<Value>(text).map_err(|e| format!("{what}: {e}"));
    let (scenario, run) = (parse(scenario, "scenario")?, parse(run, "summary")?);
    let certificate = parse(certificate, "certificate")?;
    let scenario = scenario.get("provenance").and_then(|p| p.get("scenario")).unwrap_or(&scenario);
    let given = |key: &str| get(&certificate, key);
    require(given("format")? == "aghf-certificate-1", "another format")?;
    require(number(given("tolerance")?)? == TOLERANCE, "another tolerance")?;
    require(*given("robot_xxh64")? == format!("{:016x}", xxh64(robot.as_bytes())), "another robot")?;
    let curve = get(&run, "curve")?;
    require(given("joints")? == get(curve, "joints")?, "the joints are not those of the run")?;
    let names: Vec<String> =
        array(given("joints")?)?.iter().map(|n| text(n).map(str::to_owned)).collect::<Checked<_>>()?;
    let motion = motion(given("coefficients")?, get(curve, "coefficients")?, names.len())?;
    let horizon = number(given("horizon_s")?)?;
    require(horizon == number(get(curve, "horizon_s")?)?, "the horizon is not that of the run")?;
    let [shortest, longest] = match option(scenario, "free_horizon") {
        Some(free) => [number(get(free, "shortest_s")?)?, number(get(free, "longest_s")?)?],
        None => [number(get(scenario, "horizon_s")?)?; 2],
    };
    require(shortest <= horizon && horizon <= longest && horizon > 0.0, "the horizon is not that of the scenario")?;
    let robot = Robot::read(robot, scenario, &names)?;
    let missing = not_certified(scenario, &robot, given("not_certified")?)?;
    require(*given("complete")? == missing.is_empty(), "'complete' is wrong")?;
    let limits = limits(scenario, &robot)?;
    same_limits(&limits, array(given("limits")?)?)?;
    let (degree, segments) = (motion[0][0].len() - 1, motion.len());
    let rate = |w: f64| Ball::new(2.0 * segments as f64).over(horizon).over(w);
    // Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    let short = 1.0 / f64::from(1 << 20);
    let about = |segment: &Vec<Vec<f64>>, x: f64| expand(segment, rate(short), [x, short]);
    let ends: Vec<_> = motion.iter().map(|segment| [about(segment, -1.0), about(segment, 1.0)]).collect();
    deviations(scenario, given("deviations")?, &ends)?;
    let obstacles = obstacles(scenario)?;
    let pairs = pairs(scenario, &certificate, &robot, &obstacles)?;
    let kinds = ["position", "velocity", "acceleration", "jerk", "torque"];
    let mut promises: Vec<&str> = kinds.into_iter().filter(|k| limits.iter().any(|l| l.0 == *k)).collect();
    let first = promises.len();
    let clear = ["obstacles", "self_collision"].into_iter().zip(&pairs).filter(|(_, p)| !p.is_empty());
    let (clear, pairs): (Vec<_>, Vec<_>) = clear.unzip();
    promises.extend(clear);
    require(*given("promises")? == Value::from(promises.clone()), format!("the promises are {promises:?}"))?;

    let bases = [Bernstein::new(degree), Bernstein::new(Tm::new(0.0).c.len() - 1)];
    let intervals = array(given("intervals")?)?;
    let (mut segment, mut from) = (0, -1.0);
    for interval in intervals {
        let entry = |i: usize| interval.get(i).ok_or("an interval has too few entries");
        let (own, begin, end) = (entry(0)?, number(entry(1)?)?, number(entry(2)?)?);
        let claims = list(entry(3)?)?;
        if from == 1.0 {
            (segment, from) = (segment + 1, -1.0);
        }
        let (m, w) = (0.5 * (begin + end), 0.5 * (end - begin));
        let exact = m - w == begin && m + w == end && w > 0.0 && end <= 1.0;
        require(
            *own == segment && segment < segments && begin == from && exact,
            "the intervals do not cover the horizon",
        )?;
        require(
            claims.len() == promises.len() && claims.iter().all(|c| *c >= -TOLERANCE),
            "a reserve is negative or missing",
        )?;
        from = end;
        let place = |what: &str| format!("segment {segment} from {begin} to {end}: {what} is not proved");
        let [q, v, a, jerk] = expand(&motion[segment], rate(w), [m, w]);
        let models = |all: &[Polynomial]| -> Vec<Tm> { all.iter().map(cut).collect() };
        let (places, torques) = (
            models(&q),
            match promises.contains(&"torque") {
                true => robot.torques(&models(&q), &models(&v), &models(&a)),
                false => Vec::new(),
            },
        );
        let torques: Vec<Polynomial> = torques.iter().map(|t| (t.c.to_vec(), t.r)).collect();
        for Limit(promise, joint, bounds) in &limits {
            let claim = promises.iter().zip(&claims).find(|(p, _)| *p == promise).map_or(f64::NAN, |(_, c)| *c);
            let all = [&q, &v, &a, &jerk, &torques];
            let of = kinds.iter().position(|k| k == promise).map(|k| (&bases[usize::from(k == 4)], &all[k][*joint]));
            let (basis, (c, r)) = of.ok_or("a limit is of an unknown kind")?;
            let scale = bounds.iter().filter(|b| b.is_finite()).fold(0.0_f64, |s, b| s.max(b.abs()));
            let room = claim * if scale > 0.0 { scale } else { 1.0 };
            let negative: Vec<f64> = c.iter().map(|c| -c).collect();
            let at_least =
                |c: &[f64], bound: f64| !bound.is_finite() || basis.least(c, *r, bound, 1e-13 * scale) >= bound;
            let kept = at_least(c, bounds[0] + room) && at_least(&negative, room - bounds[1]);
            require(kept, place(&format!("{promise} of joint '{}'", names[*joint])))?;
        }
        if !pairs.is_empty() {
            let (centres, by) = (robot.centres(&places), Distances(&bases[1]));
            for (i, pairs) in pairs.iter().enumerate() {
                require(
                    keeps(claims[first + i], pairs, &robot, &obstacles, &centres, &by),
                    place(promises[first + i]),
                )?;
            }
        }
    }
    require(segment == segments - 1 && from == 1.0, "the intervals do not cover the horizon")?;
    let outcome = if missing.is_empty() { "certified" } else { "certified in part" };
    let count = intervals.len();
    let proved = ["horizon", "ends"].into_iter().chain(promises).collect::<Vec<_>>().join(", ");
    let not = if missing.is_empty() { String::new() } else { format!("; not certified: {}", missing.join(", ")) };
    let assumed = unnamed(scenario, array(given("may_overlap")?)?);
    Ok(format!("{outcome} at all times, by {count} intervals: {proved}{not}{assumed}"))
}

/// The number of pairs of links of which nothing is claimed though the scenario does not name them, in words.
fn unnamed(scenario: &Value, free: &[Value]) -> String {
    let ignored = option(scenario, "self_collision").and_then(|s| option(s, "ignored_pairs")).and_then(Value::as_array);
    let names = |pair: &Value| Some([pair.get(0)?.as_str()?.to_owned(), pair.get(1)?.as_str()?.to_owned()]);
    let is_named = |[a, b]: [String; 2]| ignored.into_iter().flatten().any(|p| is_pair(Some(p), &a, &b));
    match free.iter().filter(|pair| !names(pair).is_some_and(is_named)).count() {
        0 => String::new(),
        count => format!("; assumed: {count} pairs of links that the scenario does not name may overlap or never meet"),
    }
}

/// The coefficients of the certificate, those of the run.
fn motion(own: &Value, of_run: &Value, joints: usize) -> Checked<Vec<Vec<Vec<f64>>>> {
    let (own, of_run) = (array(own)?, array(of_run)?);
    require(!own.is_empty() && own.len() == of_run.len() && joints > 0, "the segments are not those of the run")?;
    let mut all: Vec<Vec<Vec<f64>>> = Vec::new();
    for (own, of_run) in own.iter().zip(of_run) {
        let own = array(own)?.iter().map(list).collect::<Checked<Vec<_>>>()?;
        let of_run = array(of_run)?.iter().take(joints).map(list).collect::<Checked<Vec<_>>>()?;
        require(own == of_run && own.len() == joints, "the coefficients are not those of the run")?;
        let length = all.first().unwrap_or(&own)[0].len();
        require(length > 1 && own.iter().all(|c| c.len() == length), "the coefficients are of several degrees")?;
        all.push(own);
    }
    Ok(all)
}

fn cut((c, r): &Polynomial) -> Tm {
    let mut model = Tm::new(0.0);
    let kept = c.len().min(model.c.len());
    model.c[..kept].copy_from_slice(&c[..kept]);
    model.widened(r + c[kept..].iter().map(|c| c.abs()).sum::<f64>() * UP)
}

/// The promises of a scenario that no certificate covers, which the certificate has to list.
fn not_certified(scenario: &Value, robot: &Robot, listed: &Value) -> Checked<Vec<String>> {
    let some = |key: &str| option(scenario, key).is_some_and(|v| v.as_array().is_none_or(|list| !list.is_empty()));
    let by_shape = option(scenario, "robot_shape").is_none_or(|s| s.get("collision").is_some() || s == "collision");
    let apart = by_shape && option(scenario, "self_collision").is_none_or(|s| s != "off");
    let wanted = [
        ("passive_joints", some("passive")),
        ("goal", some("goal")),
        ("obstacles", !robot.has_balls && some("obstacles")),
        ("self_collision", !robot.has_balls && apart),
        ("keep", some("keep")),
    ];
    let wanted: Vec<&str> = wanted.into_iter().filter(|(_, is_missing)| *is_missing).map(|(name, _)| name).collect();
    let listed = array(listed)?.iter().map(|entry| text(get(entry, "promise")?).map(str::to_owned));
    let listed = listed.collect::<Checked<Vec<_>>>()?;
    require(listed == wanted, format!("what is not certified is {wanted:?}"))?;
    Ok(listed)
}

fn same_limits(limits: &[Limit], listed: &[Value]) -> Checked<()> {
    require(limits.len() == listed.len(), "the limits are not those of the scenario")?;
    for (Limit(promise, joint, bounds), listed) in limits.iter().zip(listed) {
        let own = [option(listed, "at_least"), option(listed, "at_most")];
        let same = bounds.iter().zip(own).all(|(bound, own)| match own.map(number) {
            Some(Ok(own)) => (own - bound).abs() <= 1e-14 * bound.abs(),
            Some(Err(_)) => false,
            None => !bound.is_finite(),
        });
        let is_it = *get(listed, "promise")? == *promise && *get(listed, "joint")? == *joint;
        require(same && is_it, format!("a {promise} limit is not that of the scenario"))?;
    }
    Ok(())
}

/// Checks the claims on the states at the ends and between segments.
fn deviations(scenario: &Value, claims: &Value, ends: &[[[Vec<Polynomial>; 4]; 2]]) -> Checked<()> {
    let (first, last) = (&ends[0][0], &ends[ends.len() - 1][1]);
    let is_set = option(scenario, "goal").is_some_and(|g| g.as_array().is_none_or(|g| !g.is_empty()));
    let free = option(scenario, "free_final_velocity").is_some_and(|f| *f == true);
    let smooth = match option(scenario, "continuity") {
        Some(continuity) => continuity == "acceleration",
        None => option(scenario, "passive").is_none_or(|p| p.as_array().is_some_and(Vec::is_empty)),
    };
    let zeros = vec![0.0; first[0].len()];
    let wanted = |key: &str| option(scenario, key).map_or(Ok(zeros.clone()), list);
    let check = |name: &str, values: Vec<Ball>, most: f64| {
        let claim = number(get(claims, name)?)?;
        let small = claim <= most && values.iter().all(|value| value.most() <= claim);
        require(small, format!("{name} is not proved"))
    };
    let off = |all: &[Polynomial], wanted: &[f64]| -> Checked<Vec<Ball>> {
        require(all.len() == wanted.len(), "a state has another number of joints")?;
        Ok(all.iter().zip(wanted).map(|(p, x)| middle(p) - Ball::new(*x)).collect())
    };
    check("start_position", off(&first[0], &wanted("q_start")?)?, STATE)?;
    check("start_velocity", off(&first[1], &wanted("v_start")?)?, STATE)?;
    if !is_set {
        check("goal_position", off(&last[0], &wanted("q_goal")?)?, STATE)?;
    }
    if !free {
        check("goal_velocity", off(&last[1], &wanted("v_goal")?)?, STATE)?;
    }
    let names = ["jump_position", "jump_velocity", "jump_acceleration"];
    for (order, name) in names.into_iter().enumerate().take(if smooth { 3 } else { 2 }).filter(|_| ends.len() > 1) {
        let between = ends.windows(2).flat_map(|pair| pair[0][1][order].iter().zip(&pair[1][0][order]));
        let jumps = between.map(|(a, b)| middle(a) - middle(b)).collect();
        check(name, jumps, if order < 2 { STATE } else { ACCELERATION })?;
    }
    Ok(())
}
