//! Rows: quantities with their bounds.

use crate::Checked;
use crate::arithmetic::{Matrix, Tm, Vector, add, apply, cross, dot, product, sub, transpose, unit, vector};
use crate::json::{entries, is_true, list, number, number_or, option, require, text, three};
use crate::motion::Polynomial;
use crate::robot::{Pose, Robot, compose, pose_of, quaternion};
use serde_json::Value;
use std::f64::consts::FRAC_PI_3;

/// The largest deviation of a row that is zero, in its unit.
const EQUALITY: f64 = 1e-6;

/// A quantity, its bounds, and the unit of reserves.
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) value: Polynomial,
    pub(crate) bounds: [f64; 2],
    pub(crate) scale: f64,
}

/// The state of a robot: positions, velocities and the placements of its bodies in the base frame.
pub(crate) struct State<'a> {
    robot: &'a Robot,
    pub(crate) q: Vec<Tm>,
    pub(crate) v: Vec<Tm>,
    pub(crate) places: Vec<Pose>,
}

fn row(name: &str, x: Tm, bounds: [f64; 2], scale: f64) -> Row {
    Row { name: name.to_owned(), value: (x.c.to_vec(), x.r), bounds, scale }
}

/// At most zero.
fn most(name: &str, x: Tm, scale: f64) -> Row {
    row(name, x, [f64::NEG_INFINITY, 0.0], scale)
}

/// Zero.
fn zero(name: &str, x: Tm, scale: f64) -> Row {
    row(name, x, [-EQUALITY * scale, EQUALITY * scale], scale)
}

impl<'a> State<'a> {
    pub(crate) fn new(robot: &'a Robot, q: Vec<Tm>, v: Vec<Tm>) -> Self {
        let places = robot.places(&q);
        Self { robot, q, v, places }
    }

    /// The placement of the link that a key names, and its body.
    fn link(&self, of: &Value, key: &str) -> Checked<(Pose, Option<usize>)> {
        let name = text(&of[key]);
        let (body, at) = self.robot.links.get(name).ok_or_else(|| format!("there is no link '{name}'"))?;
        Ok((body.map_or(*at, |body| compose(&self.places[body], at)), *body))
    }

    /// The rows of a set of poses.
    pub(crate) fn poses(&self, of: &Value) -> Checked<Vec<Row>> {
        let ((mut turn, mut at), _) = self.link(of, "frame")?;
        if option(of, "relative_to").is_some() {
            let inverse = self.link(of, "relative_to")?.0;
            at = apply(transpose(inverse.0), sub(at, inverse.1));
            turn = product(transpose(inverse.0), turn);
        }
        let has = |key: &str| option(of, key).is_some();
        let (position, orientation) = (has("position_m"), has("orientation_xyzw"));
        let is_double = position && has("box") || orientation && has("axis");
        let is_of = (position || !has("tolerance_m")) && (orientation || has("axis") || !has("tolerance_rad"));
        require(!is_double && is_of, "a set of poses has a tolerance of nothing, or two conditions of a kind")?;
        let mut rows = Vec::new();
        if let Some(position) = option(of, "position_m") {
            let off = sub(at, vector(three(position)));
            match option(of, "tolerance_m").map(number) {
                Some(r) => rows.push(most("distance", dot(off, off) - Tm::new(r) * Tm::new(r), 2.0 * r)),
                None => rows.extend(off.map(|x| zero("position", x, 1.0))),
            }
        }
        if let Some(within) = option(of, "box") {
            let centre = pose_of(&within["pose"])?;
            let off = apply(transpose(centre.0), sub(at, centre.1));
            let sizes = entries(within, "size_m");
            for (x, size) in off.into_iter().zip(sizes).filter(|(_, size)| !size.is_null()) {
                let half = 0.5 * number(size);
                let inside = row("position in a box", x, [-half, half], 1.0);
                rows.push(if half == 0.0 { zero("position", x, 1.0) } else { inside });
            }
        }
        let within = option(of, "tolerance_rad").map(number);
        if let Some(orientation) = option(of, "orientation_xyzw") {
            let m = product(transpose(quaternion(Some(orientation))?), turn);
            let cosine = (m[0][0] + m[1][1] + m[2][2] - Tm::new(1.0)).over(2.0);
            rows.extend(angle(skew(m), cosine, within));
        } else if let Some(axis) = option(of, "axis") {
            let own = apply(turn, unit(three(&axis["of_frame"])));
            let aim = unit(three(&axis["direction"]));
            rows.extend(angle(cross(own, aim), dot(own, aim), within));
        }
        require(!rows.is_empty(), "a set of poses has no condition")?;
        Ok(rows)
    }

    /// The row of the speed of a point.
    fn speed(&self, of: &Value) -> Checked<Row> {
        let ((turn, at), mut body) = self.link(of, "frame")?;
        let point = apply(turn, vector(option(of, "point_m").map_or([0.0; 3], three)));
        let (point, mut velocity) = (add(at, point), vector([0.0; 3]));
        while let Some(i) = body {
            let (joint, place) = (&self.robot.joints[i], &self.places[i]);
            let axis = apply(place.0, joint.axis);
            let way = if joint.slides { axis } else { cross(axis, sub(point, place.1)) };
            velocity = add(velocity, way.map(|x| x * self.v[i]));
            body = joint.parent;
        }
        let bound = number(&of["most_m_s"]);
        Ok(most("speed", dot(velocity, velocity) - Tm::new(bound) * Tm::new(bound), 2.0 * bound))
    }

    /// The rows of a condition along the way.
    pub(crate) fn kept(&self, condition: &Value) -> Checked<Vec<Row>> {
        match (option(condition, "poses"), option(condition, "speed")) {
            (Some(poses), None) => self.poses(poses),
            (None, Some(speed)) => Ok(vec![self.speed(speed)?]),
            _ => Err("one of poses and speed is kept".to_owned()),
        }
    }

    /// The rows of a waypoint.
    pub(crate) fn waypoint(&self, point: &Value) -> Checked<Vec<Row>> {
        let mut rows = option(point, "poses").map_or(Ok(Vec::new()), |poses| self.poses(poses))?;
        if let Some(aims) = option(point, "q") {
            let aims = list(aims);
            require(aims.len() == self.q.len(), "a waypoint has another number of joints")?;
            rows.extend(self.q.iter().zip(aims).map(|(q, aim)| zero("position", *q - Tm::new(aim), 1.0)));
        }
        if is_true(point, "stop") {
            rows.extend(self.v.iter().map(|v| zero("velocity", *v, 1.0)));
        }
        require(option(point, "q").is_some() != option(point, "poses").is_some(), "a waypoint is q or poses")?;
        Ok(rows)
    }

    /// The rows of a standing foot under the force of the ground on the base and its moment about the origin.
    pub(crate) fn foot(&self, stand: &Value, [force, moment]: [Vector; 2]) -> Checked<Vec<Row>> {
        let of = |key: &str| number_or(stand, key, f64::NAN);
        let (mut sole, body) = self.link(stand, "frame")?;
        require(body.is_none(), "the foot moves")?;
        if let Some(pose) = option(stand, "sole") {
            sole = compose(&sole, &pose_of(pose)?);
        }
        let axes = transpose(sole.0);
        let [x, y, up] = apply(axes, force);
        let [along, across, about] = apply(axes, sub(moment, cross(sole.1, force)));
        let weight = self.robot.weight();
        let mut rows = vec![most("normal force", -up, weight)];
        let mut edge = |name: &str, m: Tm, half: f64| {
            rows.extend([m, -m].map(|m| most(name, m - up * Tm::new(half), weight)));
        };
        edge("centre of pressure along", across, of("half_length_m"));
        edge("centre of pressure across", along, of("half_width_m"));
        if option(stand, "torsion").is_some() {
            edge("torsion", about, of("torsion"));
        }
        let friction = of("friction");
        let most_across = Tm::new(friction) * up;
        let slip = (x * x + y * y - most_across * most_across).over(2.0 * friction);
        rows.push(most("friction", slip, weight * weight));
        Ok(rows)
    }
}

/// The sine of the angle of a rotation times its axis.
fn skew(m: Matrix) -> Vector {
    [[2, 1], [0, 2], [1, 0]].map(|[i, j]| (m[i][j] - m[j][i]).over(2.0))
}

/// The rows of an angle with this sine, times an axis, and cosine, which is at most a bound or, without one, zero.
fn angle(sine: Vector, cosine: Tm, within: Option<f64>) -> Vec<Row> {
    let most_angle = within.unwrap_or(FRAC_PI_3);
    let mut rows = vec![most("angle", Tm::new(most_angle.cos()) - cosine, most_angle.sin())];
    if within.is_none() {
        rows.extend(sine.map(|x| zero("angle", x, 1.0)));
    }
    rows
}
