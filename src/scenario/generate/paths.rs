//! The line between two configurations and a bent path beside it.

use super::CLEAR;
use crate::constraint::{Capsule, HalfSpace, Sphere};
use crate::dynamics::forward_kinematics;
use crate::error::Result;
use crate::model::Model;
use crate::spatial::Placement;
use nalgebra::Vector3;

/// At how many places the paths are looked at.
const PLACES: usize = 41;

/// Where the bodies are along a path, and the shape they have.
pub(super) struct Swept {
    places: Vec<Vec<Placement<f64>>>,
    capsules: Vec<Capsule>,
}

/// Two paths with the same ends.
pub(super) struct Paths {
    pub start: Vec<f64>,
    pub goal: Vec<f64>,
    /// The velocities at start and goal.
    pub rates: [Vec<f64>; 2],
    /// Straight in the configuration.
    pub line: Swept,
    /// The path that is to be free.
    pub bent: Swept,
}

impl Paths {
    /// The line from `start` to `goal`, and the same with `bend` added in the middle. The shape has links of this radius.
    pub(super) fn new(
        model: &Model,
        [start, goal]: [Vec<f64>; 2],
        bend: &[f64],
        radius: f64,
    ) -> Result<Self> {
        let sweep = |scale: f64| -> Result<Swept> {
            let places = (0..PLACES).map(|i| {
                let t = i as f64 / (PLACES - 1) as f64;
                let bump = scale * 16.0 * (t * (1.0 - t)).powi(2);
                let q: Vec<f64> = (0..model.dof())
                    .map(|j| start[j] + (goal[j] - start[j]) * t + bend[j] * bump)
                    .collect();
                let mut placements = vec![Placement::identity(); model.dof()];
                forward_kinematics(model, &q, &mut placements)?;
                Ok(placements)
            });
            Ok(Swept {
                places: places.collect::<Result<_>>()?,
                capsules: Capsule::along_links(model, radius),
            })
        };
        Ok(Self {
            line: sweep(0.0)?,
            bent: sweep(1.0)?,
            rates: [vec![0.0; model.dof()], vec![0.0; model.dof()]],
            start,
            goal,
        })
    }

    /// Whether the bent path stays clear of a sphere.
    pub(super) fn free(&self, centre: Vector3<f64>, radius: f64) -> Result<bool> {
        Ok(self.bent.clearance(centre, radius)? >= CLEAR)
    }
}

impl Swept {
    /// How far the sphere is from all that is swept, m.
    pub(super) fn clearance(&self, centre: Vector3<f64>, radius: f64) -> Result<f64> {
        let sphere = Sphere { centre, radius };
        self.smallest(|capsule, placements| capsule.clearance(placements, &sphere))
    }

    /// The lowest point that is swept, m.
    pub(super) fn lowest(&self) -> Result<f64> {
        let ground = HalfSpace {
            normal: Vector3::z(),
            offset: 0.0,
        };
        self.smallest(|capsule, placements| capsule.height(placements, &ground))
    }

    fn smallest(
        &self,
        measure: impl Fn(&Capsule, &[Placement<f64>]) -> Result<f64>,
    ) -> Result<f64> {
        let mut smallest = f64::INFINITY;
        for placements in &self.places {
            for capsule in &self.capsules {
                smallest = smallest.min(measure(capsule, placements)?);
            }
        }
        Ok(smallest)
    }

    /// The segment of a capsule in the base frame, at a place between 0 and 1 along the path.
    pub(super) fn segment(&self, capsule: usize, t: f64) -> [Vector3<f64>; 2] {
        let capsule = &self.capsules[capsule];
        let placements = &self.places[(t * (PLACES - 1) as f64) as usize];
        let placement = capsule
            .body
            .map_or_else(Placement::identity, |b| placements[b]);
        (capsule.ends).map(|end| placement.rotation * end + placement.translation)
    }

    /// The capsules, in the order of their bodies.
    pub(super) fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }
}
