//! A curve as written to a file.

use aghf::curve::{Chebyshev, Curve};
use aghf::error::{Error, Result};
use aghf::linalg::rows;
use aghf::model::{Joint, Model};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// The largest jump of the state between segments that is rounding of the coefficients, relative to the state or to
/// one.
const ROUNDING: f64 = 1e-9;

/// A curve of `E` segments of degree `p` in a file: its coefficients, which determine it.
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
    /// The coefficients of Chebyshev polynomials per segment and per entry of the state (`2 N`), see
    /// [`Curve::coefficients`].
    pub coefficients: Vec<Vec<Vec<f64>>>,
}

impl CurveFile {
    /// The file form of a curve of a robot with these joints.
    #[must_use]
    pub fn new(curve: &Curve, joints: Vec<String>) -> Self {
        let coefficients = |segment| rows(&curve.coefficients(segment));
        Self {
            horizon_s: curve.horizon(),
            segments: curve.segments(),
            degree: curve.degree(),
            joints,
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
                format!("the motion and robot '{}' have {given} and {own} joints", model.name())
            }
            Some((own, given)) => {
                format!("the motion has joint '{given}', robot '{}' has '{own}' in its place", model.name())
            }
            None => return Ok(()),
        };
        Err(Error::input(file, "curve.joints", condition))
    }

    /// The curve with these coefficients. `file` names it in errors.
    ///
    /// # Errors
    /// The joints are not those of the robot, or the coefficients do not form such a curve.
    pub fn curve(&self, model: &Model, file: &str) -> Result<Curve> {
        let (rows, length) = (2 * model.dof(), self.degree.saturating_add(1));
        let refuse = |element: String, condition: String| Error::input(file, element, condition);
        self.check_joints(model, file)?;
        let found = self.coefficients.len();
        if found != self.segments || found == 0 {
            let condition = format!("{found} segments are given, {} are needed", self.segments);
            return Err(refuse("curve.coefficients".to_owned(), condition));
        }
        for (i, segment) in self.coefficients.iter().enumerate() {
            if segment.len() != rows || segment.iter().any(|row| row.len() != length) {
                let condition = format!("{rows} rows of {length} numbers are needed");
                return Err(refuse(format!("curve.coefficients[{i}]"), condition));
            }
        }
        let of_curve = |e: Error| refuse("curve".to_owned(), e.to_string());
        let chebyshev = Chebyshev::new(self.degree, self.horizon_s).map_err(of_curve)?;
        let mut x = DMatrix::zeros(rows, length * self.segments);
        for (e, segment) in self.coefficients.iter().enumerate() {
            let own = DMatrix::from_fn(rows, length, |i, k| segment[i][k]);
            x.columns_mut(e * length, length).copy_from(&chebyshev.values(&own));
            if e > 0 {
                // The end of the segment before and the beginning of this one differ by rounding.
                let end = x.column(e * length - 1).into_owned();
                let jump = (x.column(e * length) - &end).amax();
                if jump <= ROUNDING * end.amax().max(1.0) {
                    x.set_column(e * length, &end);
                }
            }
        }
        Curve::piecewise(self.horizon_s, self.segments, x).map_err(of_curve)
    }

    /// The coefficients of the positions, per segment and joint.
    #[must_use]
    pub fn positions(&self) -> Vec<Vec<Vec<f64>>> {
        let dof = self.joints.len();
        let positions = |segment: &Vec<Vec<f64>>| segment.iter().take(dof).cloned().collect();
        self.coefficients.iter().map(positions).collect()
    }
}
