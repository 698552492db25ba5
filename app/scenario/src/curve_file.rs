//! A curve as written to a file.

use aghf::curve::Curve;
use aghf::error::{Error, Result};
use aghf::linalg::rows;
use aghf::model::{Joint, Model};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// A curve of `E` segments of degree `p` in a file: its states $[q; v]$ at the nodes, which determine it, and its
/// coefficients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveFile {
    /// The horizon `T`, s.
    pub horizon_s: f64,
    /// The number of segments `E`.
    pub segments: usize,
    /// The degree `p` of each segment.
    pub degree: usize,
    /// The names of the `N` joints.
    pub joints: Vec<String>,
    /// The times of the nodes, `p + 1` per segment, s.
    pub nodes_s: Vec<f64>,
    /// The state at each node, `2 N` entries, rad or m and rad/s or m/s.
    pub states: Vec<Vec<f64>>,
    /// The coefficients of Chebyshev polynomials per segment and per entry of the state (`2 N`), see
    /// [`Curve::coefficients`].
    pub coefficients: Vec<Vec<Vec<f64>>>,
}

impl CurveFile {
    /// The file form of a curve of a robot with these joints.
    pub(super) fn new(curve: &Curve, joints: Vec<String>) -> Self {
        let begins = curve.breakpoints().iter().take(curve.segments());
        let nodes = |segment| curve.chebyshev(segment).times().iter();
        let coefficients = |segment| rows(&curve.coefficients(segment));
        Self {
            horizon_s: curve.horizon(),
            segments: curve.segments(),
            degree: curve.degree(),
            joints,
            nodes_s: begins
                .enumerate()
                .flat_map(|(segment, begin)| nodes(segment).map(move |t| begin + t))
                .collect(),
            states: rows(&curve.x().transpose()),
            coefficients: (0..curve.segments()).map(coefficients).collect(),
        }
    }

    /// Checks that the motion is one of this robot. `file` names it in errors.
    ///
    /// # Errors
    /// The joints are others.
    pub fn check_joints(&self, model: &Model, file: &str) -> Result<()> {
        let (own, given) = (model.dof(), self.joints.len());
        let names = model.joints().iter().map(Joint::name);
        let differ = names.zip(&self.joints).find(|(own, given)| own != given);
        let condition = match differ {
            _ if own != given => {
                format!(
                    "the motion and robot '{}' have {given} and {own} joints",
                    model.name()
                )
            }
            Some((own, given)) => {
                format!(
                    "the motion has joint '{given}', robot '{}' has '{own}' in its place",
                    model.name()
                )
            }
            None => return Ok(()),
        };
        Err(Error::input(file, "curve.joints", condition))
    }

    /// The curve through the states. `file` names it in errors.
    ///
    /// # Errors
    /// The joints are not those of the robot, or the states do not form such a curve.
    pub(super) fn curve(&self, model: &Model, file: &str) -> Result<Curve> {
        let dof = model.dof();
        let refuse = |element: String, condition: String| Error::input(file, element, condition);
        self.check_joints(model, file)?;
        for (i, state) in self.states.iter().enumerate() {
            if state.len() != 2 * dof {
                let condition = format!(
                    "{} numbers are given, the robot has {dof} joints",
                    state.len()
                );
                return Err(refuse(format!("curve.states[{i}]"), condition));
            }
        }
        let nodes = self.degree.saturating_add(1).saturating_mul(self.segments);
        if self.states.len() != nodes {
            let condition = format!("{} are given, {nodes} are needed", self.states.len());
            return Err(refuse("curve.states".to_owned(), condition));
        }
        let x = DMatrix::from_fn(2 * dof, nodes, |i, j| self.states[j][i]);
        Curve::piecewise(self.horizon_s, self.segments, x)
            .map_err(|e| refuse("curve".to_owned(), e.to_string()))
    }
}
