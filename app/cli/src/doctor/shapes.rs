//! The collision shapes of a robot: which are read, and how far their convex pieces extend beyond them.

use super::{Finding, Severity};
use aghf::error::{Error, Result};
use aghf::geometry::{CollisionGeometry, ConvexPiece, excess};
use aghf::model::{CollisionShape, Model};
use aghf::urdf::load_mesh;
use aghf_scenario::{ShapeParts, parts_of_shapes};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The accuracy of the excess of pieces, m.
const EXCESS_ACCURACY: f64 = 5e-4;

/// The collision shapes of a robot.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Shapes {
    /// The shapes in the order of the file's tree.
    pub shapes: Vec<LinkShape>,
    /// The number of their convex pieces.
    pub pieces: usize,
    /// The largest distance of a point of a piece from the mesh that it is part of, m.
    pub excess_m: f64,
}

/// A collision shape of a link.
#[derive(Clone, Debug, Serialize)]
pub struct LinkShape {
    /// The name of the link.
    pub link: String,
    /// The kind of a primitive shape, or the file of a mesh.
    pub shape: String,
    /// Whether it is a mesh.
    pub mesh: bool,
    /// The number of convex pieces, and that of their corners.
    pub pieces: usize,
    /// See [`pieces`](Self::pieces).
    pub corners: usize,
    /// The largest distance of a point of a piece from the mesh, m.
    pub excess_m: f64,
    /// The reason why it cannot be read.
    pub unread: Option<String>,
}

impl Shapes {
    /// The largest excess by links, m.
    pub(super) fn excess_of_links(&self) -> BTreeMap<&str, f64> {
        let mut all = BTreeMap::new();
        for shape in &self.shapes {
            let most = all.entry(shape.link.as_str()).or_insert(0.0_f64);
            *most = most.max(shape.excess_m);
        }
        all
    }
}

/// The convex bodies of the shapes that can be read, as in a scenario; names the others.
pub(super) fn convex(model: &Model, folder: &Path, most: Option<f64>) -> (Shapes, CollisionGeometry, Vec<Finding>) {
    let all = parts_of_shapes(model, folder, most);
    let (mut shapes, mut geometry) = (Shapes::default(), CollisionGeometry::default());
    for (collision, parts) in model.collisions().iter().zip(all) {
        let (shape, mesh) = match &collision.shape {
            CollisionShape::Solid(solid) => (solid.name().to_owned(), false),
            CollisionShape::Mesh { file, .. } => (file.clone(), true),
        };
        let (link, unread) = (collision.link.clone(), None);
        let mut item = LinkShape { link, shape, mesh, pieces: 0, corners: 0, excess_m: 0.0, unread };
        let own = parts.and_then(|of| Ok((excess_of(&of.pieces, &collision.shape, folder)?, of)));
        match own {
            Err(Error::Input { condition, .. }) => item.unread = Some(condition),
            Err(error) => item.unread = Some(error.to_string()),
            Ok((excess, ShapeParts { parts, .. })) => {
                item.pieces = parts.len();
                item.corners = parts.iter().map(|part| part.corners().len()).sum();
                item.excess_m = excess;
                shapes.pieces += item.pieces;
                shapes.excess_m = shapes.excess_m.max(item.excess_m);
                for part in parts {
                    geometry.add(&collision.link, collision.body, part.moved(&collision.placement));
                }
            }
        }
        shapes.shapes.push(item);
    }
    let unread = shapes.shapes.iter().filter(|shape| shape.unread.is_some());
    let mut links: Vec<_> = unread.map(|shape| shape.link.clone()).collect();
    links.dedup();
    let found = Finding::about(
        Severity::NeedsKey,
        "link",
        links,
        [
            "a collision shape of it cannot be used, for the reason in the table, so a scenario is refused \
             unless it says \"robot_shape\": \"joint_frames\" or \"swept_links\"",
            "--package NAME=FOLDER or ROS_PACKAGE_PATH where the package is not found; another format or shape in the \
             file otherwise",
        ],
    );
    (shapes, geometry, found.into_iter().collect())
}

/// The largest distance of the points of the pieces of a mesh from it, m; zero for another shape.
fn excess_of(pieces: &[ConvexPiece], shape: &CollisionShape, folder: &Path) -> Result<f64> {
    match shape {
        CollisionShape::Solid(_) => Ok(0.0),
        CollisionShape::Mesh { file, scale } => excess(pieces, &load_mesh(file, folder, scale)?, EXCESS_ACCURACY),
    }
}
