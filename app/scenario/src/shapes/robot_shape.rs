//! The balls that represent a robot.

use crate::RobotShape;
use crate::keys::obstacles::{MAX_LENGTH, default_spacing};
use aghf::error::{Error, Result, plain};
use aghf::geometry::{
    Capsule, CollisionGeometry, CollisionSphere, ConvexPiece, Cover, PIECE_RADIUS, Shape, Sphere, convex_pieces,
    cover_triangles,
};
use aghf::model::{Collision, CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::load_mesh;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::path::Path;

/// The largest number of balls that cover a robot: with one sphere obstacle the search then takes 130 MB at degree 16.
const MAX_BALLS: f64 = 1e4;

/// The excess of shapes if none is given, m: of meshes, and the least and the largest of others.
const EXCESS: [f64; 2] = [0.005, 0.02];

/// The excess of a box or a cylinder if none is given, relative to its smallest extent. The edges of large ones take
/// thousands of balls with that of a mesh.
const SHARE: f64 = 0.1;

/// Larger excesses that are tried for a robot that takes too many balls, m.
const LARGER: [f64; 4] = [0.01, 0.02, 0.05, 0.1];

/// Covers the shapes of the links of a robot by balls, in [sets](CollisionGeometry::with_sets) unless all shapes are
/// spheres: these as they are, others by [`cover_shape`]. Meshes are looked up from `folder`, that of the URDF.
///
/// # Errors
/// The robot has no shapes, a mesh cannot be read, or too many balls are needed; the error names the link.
pub fn cover_links(model: &Model, folder: &Path, excess: impl Into<Option<f64>>) -> Result<CollisionGeometry> {
    cover_with(model, None, folder, excess.into())
}

/// A shape covered by balls.
#[derive(Clone, Debug)]
pub struct CoveredShape {
    /// The convex pieces of a mesh, which the balls cover.
    pub pieces: Vec<ConvexPiece>,
    /// The balls, in the frame of the shape.
    pub cover: Cover,
}

/// Covers a shape in its own frame by balls that stick out by `excess` at most, m, with [`Shape::cover`], or the
/// [pieces](convex_pieces) of a mesh, with [`cover_triangles`]; by default by 5 mm, of a solid by a tenth of its
/// smallest extent, from 5 to 20 mm. A mesh is looked up from `folder`, that of the URDF.
///
/// # Errors
/// A mesh cannot be read, or too many balls are needed.
pub fn cover_shape(shape: &CollisionShape, folder: &Path, excess: impl Into<Option<f64>>) -> Result<CoveredShape> {
    let [least, most] = EXCESS;
    let given = excess.into();
    match shape {
        CollisionShape::Solid(solid) => {
            let by_size = || (2.0 * SHARE * solid.half_lengths().min()).clamp(least, most);
            Ok(CoveredShape { pieces: Vec::new(), cover: solid.cover(given.unwrap_or_else(by_size))? })
        }
        CollisionShape::Mesh { file, scale } => {
            let excess = given.unwrap_or(least);
            let pieces = convex_pieces(&load_mesh(file, folder, scale)?, excess)?;
            let surface: Vec<_> = pieces.iter().flat_map(ConvexPiece::triangles).collect();
            let mut cover = cover_triangles(&surface, excess)?;
            for ball in &mut cover.balls {
                ball.radius += PIECE_RADIUS;
            }
            cover.excess += PIECE_RADIUS;
            Ok(CoveredShape { pieces, cover })
        }
    }
}

/// The covers of the shapes of a robot by [`cover_shape`], in their order. Meshes are looked up from `folder`, that of
/// the URDF.
pub fn cover_each(model: &Model, folder: &Path, excess: impl Into<Option<f64>>) -> Vec<Result<CoveredShape>> {
    let excess = excess.into();
    let shapes = model.collisions().par_iter();
    let covers = shapes.map(|collision| cover_shape(&collision.shape, folder, excess));
    covers.collect()
}

/// Covers the shapes of a robot, and of a load that it carries.
fn cover_with(
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
    let covers = cover_each(model, folder, excess).into_iter();
    let of_load = load.map(|load| cover_shape(&load.shape, folder, excess));
    for (shape, cover) in all().zip(covers.chain(of_load)) {
        let named = |error: Error| Error::input(model.name(), format!("link '{}'", shape.link), error.to_string());
        let CoveredShape { pieces, cover } = cover.map_err(named)?;
        geometry.links.extend(cover.balls.iter().map(|_| shape.link.clone()));
        geometry.balls.extend(placed(shape, cover));
        if matches!(shape.shape, CollisionShape::Mesh { .. }) {
            geometry.pieces.push(pieces);
        }
    }
    let is_sphere = |c: &Collision| matches!(c.shape, CollisionShape::Solid(Shape::Sphere { .. }));
    let are_spheres = all().all(is_sphere);
    Ok(if are_spheres { geometry } else { geometry.with_sets() })
}

/// The balls that cover a shape of a link, in the frame of its body.
fn placed(collision: &Collision, cover: Cover) -> impl Iterator<Item = CollisionSphere> {
    let Collision { body, placement, .. } = collision;
    let placed = |ball: Sphere| CollisionSphere {
        body: *body,
        centre: placement.rotation * ball.centre + placement.translation,
        radius: ball.radius,
    };
    cover.balls.into_iter().map(placed)
}

/// The reason why a cover of a robot, and of a load that it carries, by this many balls is refused, and the remedy, in
/// words; `None` if so many are allowed. The remedy has the least of some larger excesses with which few enough balls
/// are needed.
#[must_use]
pub fn too_many_balls(
    (model, load): (&Model, Option<&Collision>),
    count: usize,
    folder: &Path,
    excess: Option<f64>,
) -> Option<[String; 2]> {
    if count as f64 <= MAX_BALLS {
        return None;
    }
    let given = excess.map_or_else(|| "not given".to_owned(), plain);
    let condition =
        format!("excess_m is {given}, which takes {count} balls to cover the robot, at most {MAX_BALLS} are allowed");
    let mut larger = LARGER.into_iter().filter(|larger| {
        let all = model.collisions().par_iter().chain(load.into_par_iter());
        let counts = all.map(|shape| Some(cover_shape(&shape.shape, folder, *larger).ok()?.cover.balls.len()));
        let count: Option<usize> = counts.sum();
        excess.is_none_or(|excess| *larger > excess) && count.is_some_and(|count| count as f64 <= MAX_BALLS)
    });
    let remedy = larger.next().map_or_else(
        || "spheres of the links in an SRDF (\"link_sphere_approximation\")".to_owned(),
        |larger| format!("\"robot_shape\": {{\"collision\": {{\"excess_m\": {larger}}}}}"),
    );
    Some([condition, remedy])
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
            let mut geometry = cover_with(model, load, folder, excess_m).map_err(refused)?;
            let count = geometry.balls.len();
            if let Some([condition, remedy]) = too_many_balls((model, load), count, folder, excess_m) {
                return refuse(format!("{condition}: {remedy} is needed"));
            }
            for CollisionSphere { body, centre, .. } in &mut geometry.balls {
                reduce(bodies, body, &mut [centre]);
            }
            return Ok(geometry);
        }
    };
    if let Some(load) = load {
        let cover = cover_shape(&load.shape, folder, spacing.min(default_spacing()));
        let cover = cover.map_err(|e| Error::input(path, "payload.shape", e.to_string()))?.cover;
        capsules.extend(placed(load, cover).map(|ball| Capsule {
            body: ball.body,
            ends: [ball.centre; 2],
            radius: ball.radius,
        }));
    }
    for Capsule { body, ends, .. } in &mut capsules {
        reduce(bodies, body, &mut ends.each_mut());
    }
    CollisionGeometry::of_capsules(capsules, spacing)
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

/// Moves points of a body to the body of the reduced robot that contains it.
fn reduce(
    bodies: Option<&[(Option<usize>, Placement<f64>)]>,
    body: &mut Option<usize>,
    points: &mut [&mut Vector3<f64>],
) {
    if let (Some(bodies), Some(full)) = (bodies, *body) {
        let (reduced, placement) = bodies[full];
        *body = reduced;
        for point in points {
            **point = placement.rotation * **point + placement.translation;
        }
    }
}
