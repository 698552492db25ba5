//! Clearances of a robot that is covered by many balls.

use super::clearance::clearance;
use super::label::name_of;
use super::solid_clearance::name_of_solid;
use super::{Constraint, PlacedState, RowLabel, WeightedDerivatives, Weights};
use crate::error::Result;
use crate::geometry::{FLAT, Solid, Sphere};
use crate::model::Model;
use crate::scalar::{AlgebraOver, Scalar};
use crate::spatial::{dot, outer};
use nalgebra::Vector3;

/// Balls on one body.
#[derive(Clone, Debug, PartialEq)]
pub struct BallSet<C: Scalar = f64> {
    /// The body; `None` is the base.
    pub body: Option<usize>,
    /// The balls in the body.
    pub balls: Vec<Sphere<C>>,
    /// A ball that contains them all.
    pub bound: Sphere<C>,
}

impl BallSet {
    /// A set with the ball about the middle of its bounding box as bound.
    #[must_use]
    pub fn new(body: Option<usize>, balls: Vec<Sphere>) -> Self {
        let ends = |side: f64| {
            balls
                .iter()
                .map(move |b| b.centre.add_scalar(side * b.radius))
        };
        let none = Vector3::repeat(f64::INFINITY);
        let lower = ends(-1.0).fold(none, |m, p| m.inf(&p));
        let upper = ends(1.0).fold(-none, |m, p| m.sup(&p));
        let centre = (lower + upper) * 0.5;
        let reaches = balls.iter().map(|b| (b.centre - centre).norm() + b.radius);
        let radius = reaches.fold(0.0, f64::max);
        let bound = Sphere { centre, radius };
        Self { body, balls, bound }
    }
}

/// Sets of balls stay clear of solids and of each other: $g = -\min(d, f)$ in m with `d` the least distance of a ball
/// of the set from the solid, or of balls of two sets, and `f` for [`far`](Self::far). One row per pair of a set and a
/// solid, then one per pair of sets.
///
/// The rows of sets that are further than `f` from each other by their bounds cost one distance, and a row does not
/// move there. Within, the row has a kink where two distances are the least; balls of a set that are far from each
/// other rarely are equally near.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverClearance<C: Scalar = f64> {
    /// The sets.
    pub sets: Vec<BallSet<C>>,
    /// The solid obstacles, placed in the base frame.
    pub solids: Vec<Solid<C>>,
    /// The names of the solids for reports; a solid without one is called by its shape and number.
    pub names: Vec<String>,
    /// The indices of the set and of the solid of each pair that keeps clear.
    pub solid_pairs: Vec<[usize; 2]>,
    /// The indices of the two sets of each pair that keeps clear.
    pub pairs: Vec<[usize; 2]>,
    /// The distance from which on distances count as this, m.
    pub far: C,
}

/// The sets at a state.
struct Places<S: Scalar> {
    bound: Vector3<S>,
    centres: Vec<Vector3<S>>,
}

/// The nearest of several distances.
struct Nearest<S: Scalar> {
    /// The row.
    g: S,
    /// The centres of the balls.
    points: [Vector3<S>; 2],
    /// Negative if all are far.
    is_near: S,
}

impl<S: Scalar> Nearest<S> {
    fn none(far: S) -> Self {
        Self {
            g: -far,
            points: [Vector3::zeros(); 2],
            is_near: -S::one(),
        }
    }

    /// Takes a row with a larger value, or one that is not a number.
    #[inline]
    fn take(&mut self, g: S, points: [&Vector3<S>; 2]) {
        let smaller = g - self.g;
        self.g = smaller.if_negative(self.g, g);
        self.is_near = smaller.if_negative(self.is_near, S::one());
        for (own, new) in self.points.iter_mut().zip(points) {
            *own = own.zip_map(new, |own, new| smaller.if_negative(own, new));
        }
    }
}

/// Returns true if a number is negative in all lanes.
#[inline]
fn is_negative<S: Scalar>(x: S) -> bool {
    x.if_negative(S::zero(), S::one()).vanishes()
}

/// The length of a vector and its inverse; both zero below [`FLAT`].
#[inline]
fn length_and_inverse<S: Scalar>(d: &Vector3<S>) -> [S; 2] {
    let square = dot(d, d);
    let short = square - S::from_f64(FLAT * FLAT);
    let length = square.sqrt();
    [length, S::one() / length].map(|x| short.if_negative(S::zero(), x))
}

impl<C: Scalar> CoverClearance<C> {
    fn places<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>) -> Result<Vec<Places<S>>> {
        let places = |set: &BallSet<C>| {
            let centres = set.balls.iter().map(|b| at.point(set.body, &b.centre));
            Ok(Places {
                bound: at.point(set.body, &set.bound.centre)?,
                centres: centres.collect::<Result<_>>()?,
            })
        };
        self.sets.iter().map(places).collect()
    }

    /// The row of a set and a solid.
    #[inline]
    fn of_solid<S: AlgebraOver<C>>(&self, places: &[Places<S>], [i, j]: [usize; 2]) -> Nearest<S> {
        let (set, solid, at) = (&self.sets[i], &self.solids[j], &places[i]);
        let mut nearest = Nearest::none(S::lift(self.far));
        let reach = S::lift(set.bound.radius + self.far);
        if is_negative(reach - solid.distance(&at.bound)) {
            return nearest;
        }
        for (ball, p) in set.balls.iter().zip(&at.centres) {
            nearest.take(S::lift(ball.radius) - solid.distance(p), [p, p]);
        }
        nearest
    }

    /// The row of two sets.
    #[inline]
    fn of_sets<S: AlgebraOver<C>>(&self, places: &[Places<S>], [i, j]: [usize; 2]) -> Nearest<S> {
        let ([a, b], [at_a, at_b]) = ([i, j].map(|i| &self.sets[i]), [i, j].map(|i| &places[i]));
        let mut nearest = Nearest::none(S::lift(self.far));
        let is_far = |p: &Vector3<S>, radius: C| {
            let reach = S::lift(radius + b.bound.radius + self.far);
            let d = p - at_b.bound;
            is_negative(reach * reach - dot(&d, &d))
        };
        if is_far(&at_a.bound, a.bound.radius) {
            return nearest;
        }
        for (ball, p) in a.balls.iter().zip(&at_a.centres) {
            if is_far(p, ball.radius) {
                continue;
            }
            for (other, q) in b.balls.iter().zip(&at_b.centres) {
                let [length, _] = length_and_inverse(&(p - q));
                nearest.take(S::lift(ball.radius + other.radius) - length, [p, q]);
            }
        }
        nearest
    }
}

impl<C: Scalar> Constraint<C> for CoverClearance<C> {
    fn dim(&self) -> usize {
        self.solid_pairs.len() + self.pairs.len()
    }

    /// Places every ball once, in newly allocated memory.
    fn value<S: AlgebraOver<C>>(&self, at: &PlacedState<'_, C, S>, g: &mut [S]) -> Result<()> {
        let places = self.places(at)?;
        let (of_solids, of_sets) = g.split_at_mut(self.solid_pairs.len());
        for (g, pair) in of_solids.iter_mut().zip(&self.solid_pairs) {
            *g = self.of_solid(&places, *pair).g;
        }
        for (g, pair) in of_sets.iter_mut().zip(&self.pairs) {
            *g = self.of_sets(&places, *pair).g;
        }
        Ok(())
    }

    fn label(&self, row: usize, model: &Model<C>) -> RowLabel {
        let name = |set: usize| name_of(self.sets[set].body, model);
        let names = match (
            self.solid_pairs.get(row),
            row.checked_sub(self.solid_pairs.len()),
        ) {
            (Some([i, j]), _) => [name(*i), name_of_solid(&self.names, &self.solids, *j)],
            (None, Some(pair)) if pair < self.pairs.len() => self.pairs[pair].map(name),
            _ => return RowLabel::numbered(row),
        };
        clearance(format!("distance of {} from {}", names[0], names[1]))
    }

    /// Those of the nearest balls. As a function of $s = d^2 / 2$ the row of two sets is $r - \sqrt{2 s}$, with
    /// derivatives $-1 / d$ and $1 / d^3$. Rows with zero weights are skipped.
    fn add_weighted_derivatives<S: AlgebraOver<C>>(
        &self,
        at: &PlacedState<'_, C, S>,
        weights: Weights<'_, S>,
        out: &mut WeightedDerivatives<S>,
    ) -> Result<()> {
        let places = self.places(at)?;
        let weights_of = |row: usize, nearest: &Nearest<S>| {
            let c = weights.gauss_newton.map_or(S::zero(), |c| c[row]);
            [weights.first_order[row], c].map(|w| nearest.is_near.if_negative(S::zero(), w))
        };
        for (row, pair) in self.solid_pairs.iter().enumerate() {
            if weights.vanish(row) {
                continue;
            }
            let nearest = self.of_solid(&places, *pair);
            let [w, c] = weights_of(row, &nearest);
            let p = &nearest.points[0];
            let near = self.solids[pair[1]].distance_derivatives(p);
            let stiffness = outer(&(near.normal * c), &near.normal) - near.curvature * w;
            out.add_point(self.sets[pair[0]].body, p, &(near.normal * -w), &stiffness)?;
        }
        for (pair, row) in self.pairs.iter().zip(self.solid_pairs.len()..) {
            if weights.vanish(row) {
                continue;
            }
            let nearest = self.of_sets(&places, *pair);
            let [w, c] = weights_of(row, &nearest);
            let [p, q] = &nearest.points;
            let [_, inverse] = length_and_inverse(&(p - q));
            let square = inverse * inverse;
            let bodies = pair.map(|i| self.sets[i].body);
            out.add_pair(bodies, [p, q], -w * inverse, (w * inverse + c) * square)?;
        }
        Ok(())
    }
}
