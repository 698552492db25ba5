//! The space that the links of a robot sweep on the line between two configurations and on a bent path next to it.

use super::witness::Witness;
use aghf::dynamics::forward_kinematics;
use aghf::error::Result;
use aghf::geometry::{Capsule, Shape, Solid};
use aghf::spatial::Placement;
use nalgebra::{Matrix3, Vector3};

/// The number of places at which the paths are sampled.
const PLACES: usize = 61;

/// The placements of the bodies along a path, and their shape.
pub(super) struct Swept {
    places: Vec<Vec<Placement<f64>>>,
    capsules: Vec<Capsule>,
}

/// Two paths with the same ends.
pub(super) struct Paths<'a> {
    /// The motion on the bent path.
    pub witness: Witness<'a>,
    /// Straight in the configuration.
    pub line: Swept,
    /// The path that must be free.
    pub bent: Swept,
}

impl<'a> Paths<'a> {
    /// Samples the line between the ends of `witness`, and its own path. The links have this radius.
    pub(super) fn new(mut witness: Witness<'a>, radius: f64) -> Result<Self> {
        let bent = Swept::new(&witness, radius)?;
        let straight = vec![0.0; witness.bend.len()];
        let bend = std::mem::replace(&mut witness.bend, straight);
        let line = Swept::new(&witness, radius)?;
        witness.bend = bend;
        Ok(Self { witness, line, bent })
    }

    /// Returns true if the bent path stays `margin` clear of a sphere, m.
    pub(super) fn free(&self, centre: Vector3<f64>, radius: f64, margin: f64) -> Result<bool> {
        Ok(self.bent.clearance(centre, radius)? >= margin)
    }
}

impl Swept {
    /// Samples the space that a robot with links of this radius sweeps.
    fn new(witness: &Witness, radius: f64) -> Result<Self> {
        let model = witness.model;
        let places = (0..PLACES).map(|k| {
            let tau = k as f64 / (PLACES - 1) as f64;
            let q: Vec<f64> = (0..model.dof()).map(|i| witness.joint(i, tau)[0]).collect();
            let mut placements = vec![Placement::identity(); model.dof()];
            forward_kinematics(model, &q, &mut placements)?;
            Ok(placements)
        });
        Ok(Self { places: places.collect::<Result<_>>()?, capsules: Capsule::along_links(model, radius) })
    }

    /// The distance of the sphere from the swept space, m.
    pub(super) fn clearance(&self, centre: Vector3<f64>, radius: f64) -> Result<f64> {
        self.distance(&Solid {
            placement: Placement::new(Matrix3::identity(), centre),
            shape: Shape::Sphere { radius },
        })
    }

    /// The lowest point of the swept space, m.
    pub(super) fn lowest(&self) -> Result<f64> {
        self.distance(&Solid::half_space(&Vector3::z(), 0.0))
    }

    /// The distance of a sphere or a half-space from the swept space, m.
    fn distance(&self, solid: &Solid) -> Result<f64> {
        let mut smallest = f64::INFINITY;
        for placements in &self.places {
            for capsule in &self.capsules {
                if let Some(ball) = capsule.nearest_ball(placements, solid)? {
                    smallest = smallest.min(solid.distance(&ball.centre) - ball.radius);
                }
            }
        }
        Ok(smallest)
    }

    /// The segment of a capsule in the base frame, at a place between 0 and 1 along the path.
    pub(super) fn segment(&self, capsule: usize, t: f64) -> [Vector3<f64>; 2] {
        let capsule = &self.capsules[capsule];
        let placements = &self.places[(t * (PLACES - 1) as f64) as usize];
        let placement = capsule.body.map_or_else(Placement::identity, |b| placements[b]);
        (capsule.ends).map(|end| placement.rotation * end + placement.translation)
    }

    /// The capsules, in the order of their bodies.
    pub(super) fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }
}
