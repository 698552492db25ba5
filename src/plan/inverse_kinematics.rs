//! Inverse kinematics: configurations that keep the rows of a constraint.

use crate::constraint::{Constraint, Evaluator, Weights};
use crate::error::{Error, Result, check_length};
use crate::model::{JointKind, Model};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// The largest number of steps from one first guess.
const STEPS: usize = 60;
/// The damping relative to the norm of the residuals: the first one, the least one after a step that failed, and that
/// beyond which no step helps.
const DAMPING: f64 = 0.1;
const MIN_DAMPING: f64 = 1e-6;
const MAX_DAMPING: f64 = 1e6;
/// A number of steps, and the share of the norm before them that must be left of it at most.
const PATIENCE: usize = 12;
const PROGRESS: f64 = 0.9;

/// Inverse kinematics for the rows of any constraint at zero velocity, by the Levenberg-Marquardt method within bounds
/// of the joints (Nocedal and Wright, section 10.3, with the projection of section 16.7).
///
/// The residuals are the scaled rows, of inequalities only their violations. A step solves
/// $(J^T J + \mu |r|) p = -J^T r$ in the joints that are not held by a bound. Cost O(N^3) per step, and
/// that of the derivatives of the rows.
///
/// ```
/// use aghf::constraint::FrameRows;
/// use aghf::model::Frame;
/// use aghf::plan::InverseKinematics;
/// use aghf::spatial::Placement;
/// use nalgebra::{Matrix3, Vector3};
///
/// let model = aghf::urdf::builtin_robot("kinova_gen3")?;
/// let tool = model.frames().last().expect("it has links");
/// let at = Placement::new(Matrix3::identity(), Vector3::new(0.4, 0.1, 0.3));
/// let goal = FrameRows::new(tool, Frame::new("goal", None, at)).at_origin().oriented();
/// let limits = model.joints().iter().map(|j| [j.limits().lower, j.limits().upper]);
/// let mut search = InverseKinematics::new(&model, &goal, limits.collect())?;
/// let guesses = search.guesses(&[0.1; 7], 0);
/// let found = guesses.take(20).map(|guess| search.solve(&guess)).collect::<Result<Vec<_>, _>>()?;
/// assert!(found.iter().any(|end| end.violation < 1e-8));
/// # Ok::<(), aghf::Error>(())
/// ```
#[derive(Debug)]
pub struct InverseKinematics<'a, K: ?Sized> {
    model: &'a Model,
    constraint: &'a K,
    evaluator: Evaluator<'a>,
    bounds: Vec<[f64; 2]>,
    /// The reciprocals of the scales of the rows.
    scales: Vec<f64>,
    equalities: Vec<bool>,
    state: Vec<f64>,
    /// The residuals of the last configuration.
    residuals: Vec<f64>,
}

/// The end of a search from one first guess.
#[derive(Clone, Debug, PartialEq)]
pub struct Posture {
    /// The configuration, `N` entries.
    pub q: Vec<f64>,
    /// The norm of the residuals, in the units of the scaled rows: m and rad.
    pub violation: f64,
}

impl<'a, K: Constraint + ?Sized> InverseKinematics<'a, K> {
    /// The norm of the residuals below which a search ends, in m and rad.
    pub const TOLERANCE: f64 = 1e-9;

    /// A search within `bounds`, the lower and the upper position of each joint, which may be infinite.
    ///
    /// # Errors
    /// There are not `N` bounds, or a lower bound is not below the upper one.
    pub fn new(model: &'a Model, constraint: &'a K, bounds: Vec<[f64; 2]>) -> Result<Self> {
        check_length("bounds", model.dof(), bounds.len())?;
        for (joint, [lower, upper]) in model.joints().iter().zip(&bounds) {
            if lower.is_nan() || upper.is_nan() || lower > upper {
                let joint = format!("joint '{}'", joint.name());
                let condition = format!("the lower bound {lower} exceeds the upper bound {upper}");
                return Err(Error::input(model.name(), joint, condition));
            }
        }
        let rows = constraint.dim();
        Ok(Self {
            model,
            constraint,
            evaluator: Evaluator::new(model),
            bounds,
            scales: constraint.row_scales().into_iter().map(f64::recip).collect(),
            equalities: (0..rows).map(|row| constraint.row_set(row).is_equality).collect(),
            state: vec![0.0; 2 * model.dof()],
            residuals: vec![0.0; rows],
        })
    }

    /// First guesses without end, the same for the same seed: the configuration `near`, then in turn one at a growing
    /// distance from it and one anywhere within the bounds, or within half a turn or $\pi$ metres of `near` where these
    /// are farther apart than a turn.
    pub fn guesses(&self, near: &[f64], seed: u64) -> impl Iterator<Item = Vec<f64>> + use<K> {
        let (near, bounds) = (near.to_vec(), self.bounds.clone());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0_usize..).map(move |number| {
            let spread = match number {
                0 => 0.0,
                odd if odd % 2 == 1 => 0.25 * (odd + 1) as f64,
                _ => f64::INFINITY,
            };
            let draw = |(near, [lower, upper]): (&f64, &[f64; 2])| {
                let most = if upper - lower <= TAU { spread } else { spread.min(PI) };
                let (from, to) = (lower.max(near - most), upper.min(near + most));
                (from + (to - from) * rng.random::<f64>()).clamp(*lower, *upper)
            };
            near.iter().zip(&bounds).map(draw).collect()
        })
    }

    /// Searches from a first guess, `N` entries, which is first taken into the bounds.
    ///
    /// # Errors
    /// The guess does not have `N` entries, or the constraint does not fit the robot.
    pub fn solve(&mut self, guess: &[f64]) -> Result<Posture> {
        check_length("guess", self.bounds.len(), guess.len())?;
        let mut q = self.clamp(guess);
        let mut norm = self.evaluate(&q)?;
        let mut damping = DAMPING;
        let mut before = [f64::INFINITY; PATIENCE];
        for step in 0..STEPS {
            let slow = &mut before[step % PATIENCE];
            if norm <= Self::TOLERANCE || norm > PROGRESS * *slow {
                break;
            }
            *slow = norm;
            let (gradient, matrix) = self.normal_equations()?;
            let free = self.free(&q, &gradient);
            if free.is_empty() {
                break;
            }
            loop {
                if let Some(p) = damped(&matrix, &gradient, &free, damping * norm) {
                    let to: Vec<_> = q.iter().zip(&p).map(|(q, p)| q + p).collect();
                    let to = self.clamp(&to);
                    let reached = self.evaluate(&to)?;
                    if reached < norm {
                        damping *= adjusted(&matrix, &gradient, [&q, &to], [norm, reached]);
                        (q, norm) = (to, reached);
                        break;
                    }
                }
                damping = 4.0 * damping.max(MIN_DAMPING);
                if damping > MAX_DAMPING {
                    return Ok(Posture { q, violation: norm });
                }
            }
        }
        Ok(Posture { q, violation: norm })
    }

    /// The same configuration with each revolute joint by whole turns as near to `to` as its bounds allow. Entries
    /// beyond those of the shorter one are left out.
    #[must_use]
    pub fn nearer(&self, q: &[f64], to: &[f64]) -> Vec<f64> {
        let joints = self.model.joints().iter().zip(&self.bounds);
        let turned = q.iter().zip(to).zip(joints);
        let turned = turned.map(|((q, to), (joint, [lower, upper]))| {
            if joint.kind() == JointKind::Prismatic {
                return *q;
            }
            nearest_turn(*q, *to, [*lower, *upper])
        });
        turned.collect()
    }

    fn clamp(&self, q: &[f64]) -> Vec<f64> {
        let bounds = q.iter().zip(&self.bounds);
        bounds.map(|(q, [lower, upper])| q.clamp(*lower, *upper)).collect()
    }

    /// Computes the residuals and their norm.
    fn evaluate(&mut self, q: &[f64]) -> Result<f64> {
        self.state[..q.len()].copy_from_slice(q);
        let placed = self.evaluator.at(&self.state)?;
        placed.value(self.constraint, &mut self.residuals)?;
        let rows = self.residuals.iter_mut().zip(&self.scales);
        for ((r, scale), equality) in rows.zip(&self.equalities) {
            *r *= scale;
            if !equality {
                *r = r.max(0.0);
            }
        }
        let square: f64 = self.residuals.iter().map(|r| r * r).sum();
        Ok(square.sqrt())
    }

    /// The gradient $J^T r$ and the matrix $J^T J$ of the violated rows at the configuration of the last evaluation.
    fn normal_equations(&mut self) -> Result<(DVector<f64>, DMatrix<f64>)> {
        let n = self.bounds.len();
        let scaled = self.residuals.iter().zip(&self.scales);
        let first: Vec<_> = scaled.map(|(r, scale)| r * scale).collect();
        let rows = self.residuals.iter().zip(&self.equalities).zip(&self.scales);
        let squares: Vec<_> =
            rows.map(|((r, equality), scale)| if *equality || *r > 0.0 { scale * scale } else { 0.0 }).collect();
        let mut placed = self.evaluator.at(&self.state)?;
        let gradient =
            placed.weighted_derivatives(self.constraint, Weights { first_order: &first, gauss_newton: None })?;
        let gradient = gradient.gradient().rows(0, n).into_owned();
        let matrix = placed.weighted_derivatives(
            self.constraint,
            Weights { first_order: &vec![0.0; first.len()], gauss_newton: Some(&squares) },
        )?;
        Ok((gradient, matrix.hessian().view((0, 0), (n, n)).into_owned()))
    }

    /// The joints that no bound holds against the descent.
    fn free(&self, q: &[f64], gradient: &DVector<f64>) -> Vec<usize> {
        let held = |i: &usize| {
            let [lower, upper] = self.bounds[*i];
            (q[*i] <= lower && gradient[*i] > 0.0) || (q[*i] >= upper && gradient[*i] < 0.0)
        };
        (0..q.len()).filter(|i| !held(i)).collect()
    }
}

/// The damped step in the free joints, zero in the others; `None` if the matrix is singular.
fn damped(matrix: &DMatrix<f64>, gradient: &DVector<f64>, free: &[usize], damping: f64) -> Option<DVector<f64>> {
    let mut within = matrix.select_rows(free).select_columns(free);
    for i in 0..free.len() {
        within[(i, i)] += damping.max(f64::EPSILON);
    }
    let step = within.cholesky()?.solve(&-gradient.select_rows(free));
    let mut p = DVector::zeros(gradient.len());
    for (i, step) in free.iter().zip(&step) {
        p[*i] = *step;
    }
    Some(p)
}

/// The factor of the damping after a step, from the ratio of the decrease of $|r|^2 / 2$ and that of its model.
fn adjusted(matrix: &DMatrix<f64>, gradient: &DVector<f64>, [from, to]: [&[f64]; 2], [before, after]: [f64; 2]) -> f64 {
    let moved = DVector::from_iterator(from.len(), to.iter().zip(from).map(|(to, from)| to - from));
    let expected = -gradient.dot(&moved) - 0.5 * moved.dot(&(matrix * &moved));
    let ratio = 0.5 * (before * before - after * after) / expected;
    if ratio > 0.75 {
        0.2
    } else if ratio < 0.25 {
        4.0
    } else {
        1.0
    }
}

/// The angle that differs from `q` by whole turns and is as near to `near` as `bounds` allow, all in rad; the bounds
/// may be infinite.
#[must_use]
pub fn nearest_turn(q: f64, near: f64, [lower, upper]: [f64; 2]) -> f64 {
    let least = ((lower - q) / TAU).ceil();
    let most = ((upper - q) / TAU).floor();
    q + TAU * ((near - q) / TAU).round().max(least).min(most)
}
