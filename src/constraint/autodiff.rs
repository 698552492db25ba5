//! Contractions of the derivatives of any constraint by dual numbers.

use super::{Constraint, PlacedState, WeightedDerivatives, Weights};
use crate::dynamics::forward_kinematics;
use crate::error::Result;
use crate::scalar::{AlgebraOver, Jet, Scalar};
use crate::spatial::Placement;

/// The number of tangents per pass.
const TANGENTS: usize = 4;

/// The numbers for gradients.
type First<S> = Jet<S, TANGENTS>;
/// The numbers for Hessians: rows in the inner tangent, columns in the outer ones.
type Second<S> = Jet<Jet<S, 1>, TANGENTS>;

/// Numbers with tangents, stored so that they are allocated only once.
#[derive(Clone, Debug)]
pub(super) struct Scratch<S: Scalar> {
    first: Moving<First<S>>,
    second: Moving<Second<S>>,
}

impl<S: Scalar> Scratch<S> {
    pub(super) fn new() -> Self {
        Self { first: Moving::new(), second: Moving::new() }
    }
}

/// A state with tangents, and the values there.
#[derive(Clone, Debug)]
struct Moving<T: Scalar> {
    x: Vec<T>,
    placements: Vec<Placement<T>>,
    g: Vec<T>,
}

impl<T: Scalar> Moving<T> {
    fn new() -> Self {
        Self { x: Vec::new(), placements: Vec::new(), g: Vec::new() }
    }

    /// Sets the state to the constants `x`, with space for `rows` values.
    fn reset<S: Copy>(&mut self, x: &[S], constant: impl Fn(S) -> T, rows: usize) {
        self.x.clear();
        self.x.extend(x.iter().map(|x| constant(*x)));
        self.placements.resize(x.len() / 2, Placement::identity());
        self.g.resize(rows, T::zero());
    }

    /// Computes the values of the constraint at the current state.
    fn value<C: Scalar, S: Scalar, K: Constraint<C> + ?Sized>(
        &mut self,
        constraint: &K,
        at: &PlacedState<'_, C, S>,
    ) -> Result<&[T]>
    where
        T: AlgebraOver<C>,
    {
        forward_kinematics(at.model, &self.x[..self.x.len() / 2], &mut self.placements)?;
        let moved = PlacedState { model: at.model, x: &self.x, placements: &self.placements, active_pairs: None };
        constraint.value(&moved, &mut self.g)?;
        Ok(&self.g)
    }
}

/// Adds the contractions of `constraint` to `out`.
pub(super) fn add_weighted_derivatives<C: Scalar, S: AlgebraOver<C>, K: Constraint<C> + ?Sized>(
    constraint: &K,
    at: &PlacedState<'_, C, S>,
    weights: Weights<'_, S>,
    out: &mut WeightedDerivatives<S>,
) -> Result<()> {
    if constraint.dim() == 0 {
        return Ok(());
    }
    let WeightedDerivatives { gradient, hessian, scratch, .. } = out;
    let Weights { first_order: w, gauss_newton: c } = weights;
    let m = at.x.len();
    let chunks = |end: usize| (0..end).step_by(TANGENTS).map(move |start| start..(start + TANGENTS).min(end));

    let moving = &mut scratch.first;
    moving.reset(at.x, Jet::constant, constraint.dim());
    for chunk in chunks(m) {
        for (lane, j) in chunk.clone().enumerate() {
            moving.x[j].eps[lane] = S::one();
        }
        for (w, g) in w.iter().zip(moving.value(constraint, at)?) {
            for (lane, j) in chunk.clone().enumerate() {
                gradient[j] += *w * g.eps[lane];
            }
        }
        for j in chunk {
            moving.x[j] = Jet::constant(at.x[j]);
        }
    }

    let Some(c) = c else { return Ok(()) };
    let moving = &mut scratch.second;
    let constant = |x| Jet::constant(Jet::constant(x));
    moving.reset(at.x, constant, constraint.dim());
    for i in 0..m {
        moving.x[i].re.eps[0] = S::one();
        for chunk in chunks(i + 1) {
            for (lane, j) in chunk.clone().enumerate() {
                moving.x[j].eps[lane].re = S::one();
            }
            for ((w, c), g) in w.iter().zip(c).zip(moving.value(constraint, at)?) {
                for (lane, j) in chunk.clone().enumerate() {
                    let (by_j, by_ij) = (g.eps[lane].re, g.eps[lane].eps[0]);
                    let entry = *w * by_ij + *c * g.re.eps[0] * by_j;
                    hessian[(i, j)] += entry;
                    if j < i {
                        hessian[(j, i)] += entry;
                    }
                }
            }
            for (lane, j) in chunk.enumerate() {
                moving.x[j].eps[lane].re = S::zero();
            }
        }
        moving.x[i].re.eps[0] = S::zero();
    }
    Ok(())
}
