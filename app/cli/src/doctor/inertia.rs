//! Inertias that do not fit the extent of their link: numbers in other units, most often.

use super::{Finding, Severity};
use aghf::geometry::CollisionGeometry;
use aghf::model::Model;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeMap;
use urdf_rs::{Inertia, Joint, Link, Robot};

/// The radius of gyration and the distance of the centre of mass of a link without shapes that are still plausible, as
/// a multiple of the distance to its joints: the link may extend beyond them.
const MAX_MULTIPLE: f64 = 3.0;

/// The radius of gyration that is still plausible, as a multiple of the diagonal of the box about the shapes: these may
/// be smaller than the link. A rod has 0.29.
const WIDER: f64 = 2.0;

/// The least radius of gyration that is not plausible, m: shapes of small parts are often smaller than these.
const SMALL: f64 = 0.2;

/// The share of the mass of the robot below which a link does not matter: sensors often have placeholders.
const LIGHT: f64 = 1e-3;

/// The distance to joints that a link without shapes has at least, m: the last link of an arm has none.
const NEAR: f64 = 0.5;

/// The space that a link fills, in the frame of its body.
struct Extent {
    lower: Vector3<f64>,
    upper: Vector3<f64>,
    /// The largest plausible radius of gyration, m.
    widest: f64,
    /// The largest plausible distance of the centre of mass from the space, m.
    farthest: f64,
}

/// The findings about inertias beyond the extent of their link, that of the convex parts of its shapes, or without
/// them the distance to its joints.
pub(super) fn of_inertias(robot: &Robot, model: &Model, geometry: &CollisionGeometry) -> Vec<Finding> {
    let covered = covered(geometry);
    let (mut wide, mut far) = (Vec::new(), Vec::new());
    // The inertia of what does not move has no effect.
    for frame in model.frames().iter().filter(|frame| frame.body.is_some()) {
        let Some(link) = robot.links.iter().find(|link| link.name == frame.name) else {
            continue;
        };
        let mass = link.inertial.mass.value;
        if mass <= LIGHT * model.mass() {
            continue;
        }
        let own = || by_joints(robot, link, &frame.placement.translation);
        let extent = covered.get(frame.name.as_str()).map_or_else(own, of_box);
        let gyration = (largest_moment(&link.inertial.inertia) / mass).sqrt();
        if gyration > extent.widest {
            wide.push(format!("{} ({gyration:.2} m)", link.name));
        }
        let centre = Vector3::from(link.inertial.origin.xyz.0);
        let centre = frame.placement.rotation * centre + frame.placement.translation;
        let off = (extent.lower - centre).sup(&(centre - extent.upper));
        let distance = off.sup(&Vector3::zeros()).norm();
        if distance > extent.farthest {
            far.push(format!("{} ({distance:.2} m)", link.name));
        }
    }
    let wide = Finding::about(
        Severity::Note,
        "link",
        wide,
        [
            "the radius of gyration in brackets is beyond the extent of the link: has its inertia another unit?",
            "the inertia element in the file, in kg m^2 about the centre of mass: numbers in kg mm^2 times 1e-6, in \
             g mm^2 times 1e-9",
        ],
    );
    let far = Finding::about(
        Severity::Note,
        "link",
        far,
        [
            "the centre of mass is beyond the extent of the link by the distance in brackets: are these millimetres?",
            "the origin of the inertial element in the file, or that of the shape, in m: millimetres times 1e-3",
        ],
    );
    wide.into_iter().chain(far).collect()
}

/// The boxes about the convex parts of each link, in the frame of its body.
fn covered(geometry: &CollisionGeometry) -> BTreeMap<&str, [Vector3<f64>; 2]> {
    let mut boxes = BTreeMap::new();
    for (link, part) in geometry.links.iter().zip(&geometry.parts) {
        let ends = [-1.0, 1.0].map(|side| Vector3::from_fn(|i, _| side * part.extent(&Vector3::ith(i, side))));
        let [lower, upper] = boxes.entry(link.as_str()).or_insert(ends);
        *lower = lower.inf(&ends[0]);
        *upper = upper.sup(&ends[1]);
    }
    boxes
}

fn of_box([lower, upper]: &[Vector3<f64>; 2]) -> Extent {
    let diagonal = (upper - lower).norm();
    Extent { lower: *lower, upper: *upper, widest: (WIDER * diagonal).max(SMALL), farthest: diagonal }
}

/// The extent of a link without shapes, the origin of which is at `centre`: a point, with a margin by the distances of
/// its joints.
fn by_joints(robot: &Robot, link: &Link, centre: &Vector3<f64>) -> Extent {
    let touches = |joint: &&Joint| [&joint.parent.link, &joint.child.link].contains(&&link.name);
    let distances = robot.joints.iter().filter(touches);
    let distances = distances.map(|joint| Vector3::from(joint.origin.xyz.0).norm());
    let most = MAX_MULTIPLE * distances.fold(NEAR, f64::max);
    Extent { lower: *centre, upper: *centre, widest: most, farthest: most }
}

/// The largest principal moment of inertia, kg m^2.
fn largest_moment(inertia: &Inertia) -> f64 {
    let Inertia { ixx, ixy, ixz, iyy, iyz, izz } = *inertia;
    let tensor = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    tensor.symmetric_eigenvalues().max()
}
