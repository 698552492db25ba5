//! Rows on the placement of a frame: goals by pose, a kept orientation, a position in a box.

use super::{Constraint, PlacedState, Quantity, RowForm, RowLabel, RowSet, WeightedDerivatives, Weights};
use crate::error::{Error, Result};
use crate::model::{Frame, Model};
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{apply, apply_transpose, dot, multiply, outer, rotation_of_z_to, unit_vector};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_3, PI};

/// A row on the position `d` and the rotation `M` of a frame in a reference,
/// $g = c + a \cdot d + \sum_{ij} W_{ij} M_{ij} + s\\, |d|^2$.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRow<C: Scalar = f64> {
    /// The constant `c`.
    pub constant: C,
    /// The coefficients `a` of the position, in the axes of the reference.
    pub position: Vector3<C>,
    /// The coefficients `W` of the rotation.
    pub rotation: Matrix3<C>,
    /// The coefficient `s` of the square of the distance.
    pub square: C,
    /// The slope of the row at its boundary, see [`RowSet::scale`].
    pub scale: C,
    /// The limited quantity, for the label of the row.
    pub what: &'static str,
    /// The unit of that quantity.
    pub unit: &'static str,
    /// The function of that quantity that the row is.
    pub form: RowForm,
    /// Whether the row is an equality.
    pub is_equality: bool,
}

impl FrameRow {
    /// A row on the position, in m, of slope one.
    fn of_position(what: &'static str, position: Vector3<f64>, constant: f64) -> Self {
        Self {
            constant,
            position,
            rotation: Matrix3::zeros(),
            square: 0.0,
            scale: 1.0,
            what,
            unit: "m",
            form: RowForm::Linear,
            is_equality: false,
        }
    }

    /// A row on the rotation, in rad.
    fn of_rotation(what: &'static str, rotation: Matrix3<f64>, constant: f64, scale: f64) -> Self {
        Self { rotation, scale, unit: "rad", ..Self::of_position(what, Vector3::zeros(), constant) }
    }

    /// The same as an equality.
    fn equality(self) -> Self {
        Self { is_equality: true, ..self }
    }
}

/// Rows on the placement of a frame in a reference, which is fixed to the base or to another body: with $R_f, p_f$ and
/// $R_r, p_r$ the placements of both in the base frame, the rows are functions of $M = R_r^T R_f$ and
/// $d = R_r^T (p_f - p_r)$. Goals by pose have the pose of the goal as the reference.
///
/// All rows are polynomials in the entries of rotations and positions. Derivation: `proofs/constraints.md`.
///
/// ```
/// use aghf::constraint::{Constraint, Evaluator, FrameRows};
/// use aghf::model::Frame;
/// use aghf::spatial::Placement;
/// use nalgebra::{Rotation3, Vector3};
///
/// let model = aghf::urdf::builtin_robot("kinova_gen3")?;
/// let tool = model.frames().last().expect("it has links");
/// let down = Rotation3::from_euler_angles(3.14, 0.0, 0.0).into_inner();
/// let goal = Placement::new(down, Vector3::new(0.4, 0.1, 0.3));
/// let rows = FrameRows::new(tool, Frame::new("goal", None, goal)).at_origin().oriented();
/// let mut g = vec![0.0; rows.dim()];
/// Evaluator::new(&model).at(&[0.0; 14])?.value(&rows, &mut g)?;
/// assert_eq!(g.len(), 7);
/// # Ok::<(), aghf::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FrameRows<C: Scalar = f64> {
    /// The frame.
    pub frame: Frame<C>,
    /// The reference.
    pub reference: Frame<C>,
    /// The rows.
    pub rows: Vec<FrameRow<C>>,
}

/// The angle beyond which equalities of orientation are violated. The entries of $M - M^T$ and those of an axis across
/// a direction are zero at half a turn as well; with this bound as a further row the sum of the squares of the scaled
/// rows grows all the way to half a turn.
const WRONG: f64 = FRAC_PI_3;

/// The names of the axes.
const AXES: [[&str; 3]; 3] = [
    ["position along x", "position along y", "position along z"],
    [
        "upper bound of the position along x",
        "upper bound of the position along y",
        "upper bound of the position along z",
    ],
    [
        "lower bound of the position along x",
        "lower bound of the position along y",
        "lower bound of the position along z",
    ],
];

impl FrameRows {
    /// No rows on `frame` in `reference`.
    #[must_use]
    pub fn new(frame: &Frame<f64>, reference: Frame<f64>) -> Self {
        Self { frame: frame.clone(), reference, rows: Vec::new() }
    }

    /// Adds $d = 0$, three equalities in m.
    #[must_use]
    pub fn at_origin(mut self) -> Self {
        let axes = AXES[0].into_iter().enumerate();
        self.rows.extend(axes.map(|(i, what)| FrameRow::of_position(what, Vector3::ith(i, 1.0), 0.0).equality()));
        self
    }

    /// Adds $l \le d \le h$ in m, with an equality where both are the same; an infinite bound is none. So a plane has
    /// two infinite pairs, and a line one.
    ///
    /// # Errors
    /// A bound is no number, or the lower one is above the upper one.
    pub fn in_box(mut self, lower: &Vector3<f64>, upper: &Vector3<f64>) -> Result<Self> {
        for (i, (l, h)) in lower.iter().zip(upper).enumerate() {
            let between = l <= h && *l < f64::INFINITY && *h > f64::NEG_INFINITY;
            if !between {
                let condition = format!("the lower bound {l} exceeds the upper bound {h}");
                return Err(self.refused("bounds of the position", condition));
            }
            let axis = Vector3::ith(i, 1.0);
            if l == h {
                let row = FrameRow::of_position(AXES[0][i], axis, -l);
                self.rows.push(row.equality());
                continue;
            }
            let sides = [(1, axis, -h), (2, -axis, *l)];
            let sides = sides.into_iter().filter(|(.., c)| c.is_finite());
            self.rows.extend(sides.map(|(side, axis, c)| FrameRow::of_position(AXES[side][i], axis, c)));
        }
        Ok(self)
    }

    /// Adds $|d|^2 - r^2 \le 0$, with the scale $2 r$.
    ///
    /// # Errors
    /// The distance `r`, in m, is not positive and finite.
    pub fn within_distance(mut self, r: f64) -> Result<Self> {
        if !(r > 0.0 && r.is_finite()) {
            let condition = format!("it is {r} and must be a positive number");
            return Err(self.refused("largest distance", condition));
        }
        self.rows.push(FrameRow {
            square: 1.0,
            scale: 2.0 * r,
            form: RowForm::Square,
            ..FrameRow::of_position("distance", Vector3::zeros(), -r * r)
        });
        Ok(self)
    }

    /// Adds $M = I$: three equalities, the entries of $M - M^T$, which are $2 \sin \varphi$ times the axis of the turn
    /// by $\varphi$ from the reference, and a row that excludes half a turn, $\varphi \le \pi / 3$.
    #[must_use]
    pub fn oriented(mut self) -> Self {
        let names = ["turn about x", "turn about y", "turn about z"];
        for (i, what) in names.into_iter().enumerate() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let mut rotation = Matrix3::zeros();
            (rotation[(k, j)], rotation[(j, k)]) = (1.0, -1.0);
            let row = FrameRow::of_rotation(what, rotation, 0.0, 2.0);
            self.rows.push(row.equality());
        }
        self.rows.push(Self::angle(WRONG));
        self
    }

    /// Adds $\varphi \le \theta$ for the angle $\varphi$ of the turn from the reference: $1 + 2 \cos \theta -
    /// \mathrm{tr}\\, M \le 0$, with the scale $2 \sin \theta$.
    ///
    /// # Errors
    /// The angle $\theta$, in rad, is not between 0 and $\pi$.
    pub fn within_angle(mut self, theta: f64) -> Result<Self> {
        self.check_angle(theta)?;
        self.rows.push(Self::angle(theta));
        Ok(self)
    }

    /// Adds that `axis`, in the frame, has the direction `to`, in the reference: two equalities, the parts across
    /// `to`, and a row that excludes the opposite direction, an angle of at most $\pi / 3$.
    ///
    /// # Errors
    /// A vector is zero or not finite.
    pub fn axis_along(mut self, axis: &Vector3<f64>, to: &Vector3<f64>) -> Result<Self> {
        let (axis, to) = (self.unit("axis", axis)?, self.unit("direction", to)?);
        let across = rotation_of_z_to(&to);
        let names = ["first tilt of the axis", "second tilt of the axis"];
        for (i, what) in names.into_iter().enumerate() {
            let rotation = outer(&across.column(i).into_owned(), &axis);
            let row = FrameRow::of_rotation(what, rotation, 0.0, 1.0);
            self.rows.push(row.equality());
        }
        self.rows.push(Self::tilt(&axis, &to, WRONG));
        Ok(self)
    }

    /// Adds that `axis`, in the frame, is within the angle $\theta$ of the direction `to`, in the reference:
    /// $\cos \theta - t \cdot M n \le 0$ with their unit vectors `n` and `t`, and with the scale $\sin \theta$.
    ///
    /// # Errors
    /// A vector is zero or not finite, or the angle, in rad, is not between 0 and $\pi$.
    pub fn axis_within(mut self, axis: &Vector3<f64>, to: &Vector3<f64>, theta: f64) -> Result<Self> {
        let (axis, to) = (self.unit("axis", axis)?, self.unit("direction", to)?);
        self.check_angle(theta)?;
        self.rows.push(Self::tilt(&axis, &to, theta));
        Ok(self)
    }

    fn angle(theta: f64) -> FrameRow {
        let (sin, cos) = theta.sin_cos();
        FrameRow {
            form: RowForm::Cosine(theta),
            ..FrameRow::of_rotation("angle", -Matrix3::identity(), 1.0 + 2.0 * cos, 2.0 * sin)
        }
    }

    fn tilt(axis: &Vector3<f64>, to: &Vector3<f64>, theta: f64) -> FrameRow {
        let (sin, cos) = theta.sin_cos();
        FrameRow {
            form: RowForm::Cosine(theta),
            ..FrameRow::of_rotation("tilt of the axis", -outer(to, axis), cos, sin)
        }
    }

    fn unit(&self, what: &str, v: &Vector3<f64>) -> Result<Vector3<f64>> {
        unit_vector(v).ok_or_else(|| {
            let [x, y, z] = [v.x, v.y, v.z];
            self.refused(what, format!("({x}, {y}, {z}) has length zero or is not finite"))
        })
    }

    fn check_angle(&self, theta: f64) -> Result<()> {
        if theta > 0.0 && theta < PI {
            return Ok(());
        }
        let condition = format!("it is {theta} and must be an angle between 0 and pi");
        Err(self.refused("largest angle", condition))
    }

    fn refused(&self, what: &str, condition: String) -> Error {
        Error::input(format!("frame '{}'", self.frame.name), what, condition)
    }
}

impl<C: Scalar> Constraint<C> for FrameRows<C> {
    fn dim(&self) -> usize {
        self.rows.len()
    }

    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let (frame, reference) = (at.frame(&self.frame)?, at.frame(&self.reference)?);
        let off = frame.translation - reference.translation;
        let d = apply_transpose(&reference.rotation, &off);
        let m = multiply(&reference.rotation.transpose(), &frame.rotation);
        for (row, g) in self.rows.iter().zip(g) {
            let sum = |sum: S, (x, c): (&S, &C)| sum + x.scale(*c);
            let linear = d.iter().zip(&row.position).fold(S::lift(row.constant), sum);
            let turned = m.iter().zip(&row.rotation).fold(linear, sum);
            *g = turned + dot(&d, &d).scale(row.square);
        }
        Ok(())
    }

    fn row_set(&self, row: usize) -> RowSet<C> {
        self.rows.get(row).map_or_else(RowSet::at_most_zero, |row| {
            let set = if row.is_equality { RowSet::zero() } else { RowSet::at_most_zero() };
            set.scaled(row.scale)
        })
    }

    fn label(&self, row: usize, _: &Model<C>) -> RowLabel {
        let Some(row) = self.rows.get(row) else {
            return RowLabel::numbered(row);
        };
        let (frame, reference) = (&self.frame.name, &self.reference);
        let relative = match reference.body {
            None => String::new(),
            Some(_) => format!(" in frame '{}'", reference.name),
        };
        let name = format!("{} of frame '{frame}'{relative}", row.what);
        RowLabel { form: row.form, ..RowLabel::new(name, row.unit, Quantity::Frame) }
    }

    /// The columns of `M` are positions of points relative to the origin of the frame, so that a row acts on these
    /// points by the forces $R_r (a + 2 s d)$ at the origin and the columns of $R_r W$. Rows with zero weights are
    /// skipped.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let (frame, reference) = (at.frame(&self.frame)?, at.frame(&self.reference)?);
        let bodies = [self.frame.body, self.reference.body];
        let (r, p) = (&reference.rotation, &frame.translation);
        let off = p - reference.translation;
        for (i, row) in self.rows.iter().enumerate() {
            if weights.vanish(i) {
                continue;
            }
            let w = weights.first_order[i];
            let square = S::lift(row.square);
            let twice = square + square;
            let force = apply(r, &row.position.map(S::lift)) + off * twice;
            let turning = multiply(r, &row.rotation.map(S::lift)).transpose();
            let virial = outer(p, &force) + multiply(&frame.rotation, &turning);
            let c = weights.gauss_newton.map(|c| c[i]);
            out.add_forces(bodies, &force, &virial, w, c)?;
            if c.is_none() || row.square.vanishes() {
                continue;
            }
            // The slope of the force itself.
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                out.add_forces(bodies, &axis, &outer(p, &axis), S::zero(), Some(w * twice))?;
            }
        }
        Ok(())
    }
}
