//! The balls and convex bodies that represent a robot.

use crate::RobotShape;
use crate::keys::obstacles::MAX_LENGTH;
use aghf::error::{Error, Result, plain};
use aghf::geometry::{Capsule, CollisionGeometry, CollisionSphere, Convex, ConvexPiece, Shape, Solid, convex_pieces};
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::load_mesh;
use rayon::prelude::*;
use std::path::Path;

/// The largest number of balls along the links of a robot: with one sphere obstacle the search then takes 130 MB at
/// degree 16.
const MAX_BALLS: f64 = 1e4;

/// The excess of meshes if none is given, m.
const EXCESS: f64 = 0.005;

/// The shapes of the links of a robot: balls if all are spheres, convex parts otherwise. Meshes are looked up from
/// `folder`, that of the URDF, and divided into [pieces](convex_pieces) until these extend beyond them by `excess` at
/// most, m, 5 mm by default, where that saves enough.
///
/// # Errors
/// The robot has no shapes, the excess is not positive, or a mesh cannot be read; the error names the link.
pub fn link_shapes(model: &Model, folder: &Path, excess: impl Into<Option<f64>>) -> Result<CollisionGeometry> {
    let excess = excess.into();
    if let Some(given) = excess.filter(|excess| !(*excess > 0.0 && excess.is_finite())) {
        let condition = format!("it is {} and must be a positive number", plain(given));
        return Err(Error::input(model.name(), "excess", condition));
    }
    link_shapes_with(model, None, folder, excess)
}

/// A shape as convex bodies, in its own frame.
#[derive(Clone, Debug)]
pub struct ShapeParts {
    /// The convex pieces of a mesh.
    pub pieces: Vec<ConvexPiece>,
    /// The convex bodies: those of the pieces, or that of a solid.
    pub parts: Vec<Convex>,
}

/// The convex bodies of a shape. A mesh is looked up from `folder`, that of the URDF.
///
/// # Errors
/// A mesh cannot be read.
pub fn shape_parts(shape: &CollisionShape, folder: &Path, excess: Option<f64>) -> Result<ShapeParts> {
    let pieces = match shape {
        CollisionShape::Solid(shape) => {
            let solid = Solid { placement: Placement::identity(), shape: *shape };
            return Ok(ShapeParts { pieces: Vec::new(), parts: Convex::of_solid(&solid).into_iter().collect() });
        }
        CollisionShape::Mesh { file, scale } => {
            convex_pieces(&load_mesh(file, folder, scale)?, excess.unwrap_or(EXCESS))?
        }
    };
    let parts = pieces.iter().map(Convex::of_piece).collect();
    Ok(ShapeParts { pieces, parts })
}

/// The [parts](shape_parts) of the shapes of a robot, in their order. Meshes are looked up from `folder`, that of the
/// URDF.
pub fn parts_of_shapes(model: &Model, folder: &Path, excess: Option<f64>) -> Vec<Result<ShapeParts>> {
    let shapes = model.collisions().par_iter();
    shapes.map(|collision| shape_parts(&collision.shape, folder, excess)).collect()
}

/// The shapes of a robot, and of a load that it carries.
fn link_shapes_with(
    model: &Model,
    load: Option<&Collision>,
    folder: &Path,
    excess: Option<f64>,
) -> Result<CollisionGeometry> {
    if model.collisions().is_empty() {
        let condition = "none of its links has a collision element";
        return Err(Error::input(model.name(), "robot", condition));
    }
    let mut geometry = CollisionGeometry::default();
    let all = || model.collisions().iter().chain(load);
    let parts = parts_of_shapes(model, folder, excess).into_iter();
    let of_load = load.map(|load| shape_parts(&load.shape, folder, excess));
    for (shape, parts) in all().zip(parts.chain(of_load)) {
        let named = |error: Error| Error::input(model.name(), format!("link '{}'", shape.link), error.to_string());
        let ShapeParts { pieces, parts } = parts.map_err(named)?;
        for part in parts {
            geometry.add(&shape.link, shape.body, part.moved(&shape.placement));
        }
        if matches!(shape.shape, CollisionShape::Mesh { .. }) {
            geometry.pieces.push(pieces);
        }
    }
    if all().all(is_sphere) {
        geometry.parts.clear();
    }
    Ok(geometry)
}

fn is_sphere(shape: &Collision) -> bool {
    matches!(shape.shape, CollisionShape::Solid(Shape::Sphere { .. }))
}

/// Builds the collision geometry of a scenario's robot and of the load that it carries; `path` names the scenario in
/// errors. Meshes are looked up from `folder`. If joints of the robot are locked, `bodies` has per body of `model` the
/// one of the reduced robot that contains it, and its placement there.
pub(crate) fn collision_geometry(
    (model, load): (&Model, Option<&Collision>),
    bodies: Option<&[(Option<usize>, Placement<f64>)]>,
    shape: RobotShape,
    folder: &Path,
    path: &str,
) -> Result<CollisionGeometry> {
    let bounded = |x: &[f64]| x.iter().all(|x| x.abs() <= MAX_LENGTH);
    let refuse = |condition: String| Err(Error::input(path, "robot_shape", condition));
    let (mut capsules, spacing) = match shape {
        RobotShape::JointFrames => {
            let points = CollisionSphere::joint_frames(model);
            let point =
                |ball: CollisionSphere| Capsule { body: ball.body, ends: [ball.centre; 2], radius: ball.radius };
            // Any spacing is sufficient for points.
            (points.into_iter().map(point).collect::<Vec<_>>(), 1.0)
        }
        RobotShape::SweptLinks { radius_m, spacing_m } => {
            if !(bounded(&[radius_m, spacing_m]) && radius_m >= 0.0 && spacing_m > 0.0) {
                return refuse(format!(
                    "a radius that is not negative and a positive spacing are needed, no number above \
                    {MAX_LENGTH} m"
                ));
            }
            let capsules = Capsule::along_links(model, radius_m);
            let count = capsules.iter().map(|c| c.pieces(spacing_m) + 1.0).sum();
            check_count(spacing_m, count, path)?;
            (capsules, spacing_m)
        }
        RobotShape::Collision { excess_m } => {
            if !excess_m.is_none_or(|excess| bounded(&[excess]) && excess > 0.0) {
                return refuse(format!("a positive excess of at most {MAX_LENGTH} m is needed"));
            }
            let refused = |e: Error| Error::input(path, "robot_shape", e.to_string());
            let mut geometry = link_shapes_with(model, load, folder, excess_m).map_err(refused)?;
            for i in 0..geometry.balls.len() {
                let ball = &mut geometry.balls[i];
                let Some(place) = reduced(bodies, &mut ball.body) else { continue };
                ball.centre = place.point(&ball.centre);
                if let Some(part) = geometry.parts.get_mut(i) {
                    *part = part.moved(&place);
                }
            }
            return Ok(geometry);
        }
    };
    let mut load = load.cloned();
    if let Some(load) = &mut load
        && let Some(place) = reduced(bodies, &mut load.body)
    {
        load.placement = place.compose(&load.placement);
    }
    for Capsule { body, ends, .. } in &mut capsules {
        if let Some(place) = reduced(bodies, body) {
            *ends = ends.map(|end| place.point(&end));
        }
    }
    match load {
        None => CollisionGeometry::of_capsules(capsules, spacing),
        Some(Collision { body, placement, shape: CollisionShape::Solid(Shape::Sphere { radius }), .. }) => {
            capsules.push(Capsule { body, ends: [placement.translation; 2], radius });
            CollisionGeometry::of_capsules(capsules, spacing)
        }
        Some(Collision { link, body, placement, shape }) => {
            let parts = shape_parts(&shape, folder, None);
            let parts = parts.map_err(|e| Error::input(path, "payload.shape", e.to_string()))?.parts;
            let mut geometry = CollisionGeometry::default();
            for Capsule { body, ends, radius } in capsules {
                geometry.add(&link, body, Convex::of_corners(ends.to_vec(), radius));
            }
            for part in parts {
                geometry.add(&link, body, part.moved(&placement));
            }
            // They belong to no links that could keep clear of each other.
            geometry.links.clear();
            Ok(geometry)
        }
    }
}

/// Refuses links swept by too many balls of this spacing.
fn check_count(spacing: f64, count: f64, path: &str) -> Result<()> {
    if count <= MAX_BALLS {
        return Ok(());
    }
    let (given, count, key) = (plain(spacing), plain(count), "robot_shape.swept_links.spacing_m");
    let condition =
        format!("it is {given}, which takes {count} balls to cover the robot, at most {MAX_BALLS} are allowed");
    Err(Error::input(path, key, condition))
}

/// Takes a body to the one of the reduced robot that contains it; returns its placement there if it is another.
fn reduced(bodies: Option<&[(Option<usize>, Placement<f64>)]>, body: &mut Option<usize>) -> Option<Placement<f64>> {
    let (reduced, placement) = bodies?[(*body)?];
    *body = reduced;
    Some(placement)
}
