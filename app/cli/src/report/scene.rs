//! The scene: the shapes of the links, the obstacles, and the points whose paths are drawn.

use super::links::{base_shapes, capsules_along_links};
use super::mesh::{MeshData, Meshes};
use aghf::error::{Error, Result};
use aghf::geometry::{Obstacle, Shape};
use aghf::model::{CollisionShape, Model};
use aghf::spatial::Placement;
use aghf::urdf::{Visual, load_mesh, read_visuals};
use aghf_scenario::Scenario;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

/// A scene of the page. Lengths in m, in the base frame except for shapes of bodies.
#[derive(Serialize)]
pub(super) struct Scene {
    pub shapes: Vec<Item>,
    pub meshes: Vec<MeshData>,
    pub obstacles: Vec<Item>,
    pub planes: Vec<Plane>,
    pub tips: Vec<Tip>,
    /// The source of the robot's shapes, and the shapes that could not be shown.
    pub notes: Vec<String>,
}

/// A shape with its pose.
#[derive(Serialize)]
pub(super) struct Item {
    /// The body; `None` for the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<usize>,
    pub kind: &'static str,
    /// Half lengths along the axes of the shape; for a capsule the last is that of its segment.
    pub size: [f64; 3],
    /// Position, and orientation as a unit quaternion `x y z w`.
    pub pose: [f64; 7],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The index of the mesh, for a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    /// True for the symbol of a joint.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub joint: bool,
}

/// The boundary of a half-space.
#[derive(Serialize)]
pub(super) struct Plane {
    pub name: String,
    pub normal: [f64; 3],
    pub offset: f64,
}

/// A point of a body whose path is drawn.
#[derive(Clone, Serialize)]
pub(super) struct Tip {
    pub name: String,
    pub body: usize,
    pub point: [f64; 3],
}

impl Item {
    /// A shape at `placement` in a body.
    pub fn new(body: Option<usize>, placement: &Placement<f64>, shape: &Shape<f64>) -> Self {
        Self {
            body,
            kind: shape.name(),
            size: shape.half_lengths().into(),
            pose: pose(placement),
            color: None,
            name: None,
            mesh: None,
            joint: false,
        }
    }
}

/// Position and unit quaternion `x y z w` of a placement.
pub(super) fn pose(placement: &Placement<f64>) -> [f64; 7] {
    let rotation = Rotation3::from_matrix_unchecked(placement.rotation);
    let turn = UnitQuaternion::from_rotation_matrix(&rotation);
    let (p, q) = (placement.translation, turn.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}

/// Builds the scene of a scenario.
pub(super) fn scene_of(scenario: &Scenario) -> Result<Scene> {
    let (planes, solids): (Vec<_>, Vec<_>) =
        (scenario.scene.obstacles().iter()).partition(|obstacle| obstacle.solid.shape == Shape::HalfSpace);
    let item = |Obstacle { name, solid }: &Obstacle| Item {
        name: Some(name.clone()),
        ..Item::new(None, &solid.placement, &solid.shape)
    };
    let plane = |Obstacle { name, solid }: &Obstacle| {
        let normal = solid.placement.rotation.column(2);
        Plane {
            name: name.clone(),
            normal: normal.into_owned().into(),
            offset: normal.dot(&solid.placement.translation),
        }
    };
    let obstacles = solids.into_iter().map(item).collect();
    let planes = planes.into_iter().map(plane).collect();
    let mut robot = Robot::new(scenario);
    robot.gather();
    Ok(Scene {
        shapes: robot.shapes,
        meshes: robot.meshes.data(),
        obstacles,
        planes,
        tips: super::links::tips(&scenario.model),
        notes: robot.notes,
    })
}

/// The shapes of a robot during their collection.
struct Robot<'a> {
    scenario: &'a Scenario,
    model: &'a Model,
    shapes: Vec<Item>,
    meshes: Meshes,
    /// The links with a mesh that cannot be read, and the reason for the first.
    unread: Option<(Vec<String>, Error)>,
    notes: Vec<String>,
}

impl<'a> Robot<'a> {
    fn new(scenario: &'a Scenario) -> Self {
        Self {
            scenario,
            model: &scenario.model,
            shapes: Vec::new(),
            meshes: Meshes::default(),
            unread: None,
            notes: Vec::new(),
        }
    }

    /// Collects the visual shapes of each link, otherwise its collision shapes; capsules along links without either.
    fn gather(&mut self) {
        let (visuals, faults) = read_visuals(&self.scenario.source.text, &self.scenario.file.packages);
        self.notes.extend(faults);
        let mut unseen = Vec::new();
        for frame in self.model.frames() {
            let own = visuals.iter().filter(|visual| visual.link == frame.name);
            let mut shown = Vec::new();
            let mut whole = true;
            for Visual { placement, shape, color, .. } in own {
                let placement = frame.placement.compose(placement);
                match self.item(&frame.name, frame.body, &placement, shape) {
                    Some(item) => shown.push(Item { color: *color, ..item }),
                    None => whole = false,
                }
            }
            if shown.is_empty() || !whole {
                let collisions = self.model.collisions().iter();
                let own: Vec<_> = collisions.filter(|c| c.link == frame.name).collect();
                let shapes: Vec<_> =
                    own.iter().filter_map(|c| self.item(&c.link, c.body, &c.placement, &c.shape)).collect();
                if !shapes.is_empty() {
                    shown = shapes;
                }
            }
            if shown.is_empty() {
                unseen.push(frame.body);
            }
            self.shapes.extend(shown);
        }
        if let Some((links, error)) = &self.unread {
            let links = links.join(", ");
            let note = format!("meshes that cannot be read, of the links {links}; the first one: {error}");
            self.notes.push(note);
        }
        let seen = |body: Option<usize>| self.shapes.iter().any(|item| item.body == body);
        unseen.retain(|body| !seen(*body));
        let capsules = capsules_along_links(self.model, &unseen);
        // The base is drawn only for a robot without shapes of its own.
        if self.shapes.is_empty() {
            let base = base_shapes(self.model);
            self.shapes.extend(base);
        }
        self.shapes.extend(capsules);
    }

    /// A shape of a link; `None`, with its link among the unread ones, for a mesh that cannot be read.
    fn item(
        &mut self,
        link: &str,
        body: Option<usize>,
        placement: &Placement<f64>,
        shape: &CollisionShape,
    ) -> Option<Item> {
        let (file, scale) = match shape {
            CollisionShape::Solid(shape) => return Some(Item::new(body, placement, shape)),
            CollisionShape::Mesh { file, scale } => (file, scale),
        };
        let key = format!("{file} {scale:?}");
        let known = self.meshes.find(&key);
        let number = match known {
            Some(number) => number,
            None => match load_mesh(file, self.scenario.source.folder(), scale) {
                Ok(triangles) => self.meshes.add(key, &triangles),
                Err(error) => {
                    let (links, _) = self.unread.get_or_insert((Vec::new(), error));
                    if links.iter().all(|other| other != link) {
                        links.push(link.to_owned());
                    }
                    return None;
                }
            },
        };
        Some(Item {
            kind: "mesh",
            mesh: Some(number),
            ..Item::new(body, placement, &Shape::Cuboid { half_extents: Vector3::repeat(1.0) })
        })
    }
}
