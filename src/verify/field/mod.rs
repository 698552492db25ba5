//! Every numbered equation as an identity over a prime field.
//!
//! The two sides of an equation are computed by independent methods at random instances: random robots, states and
//! penalties whose numbers are elements of $GF(2^{61} - 1)$. They are compared with `==`. The pages in `proofs/` state
//! each equation with its conventions; a test checks that pages and identities agree.

mod action;
mod algorithm_b1;
mod algorithm_b2;
mod algorithm_b3;
mod constraint_kinds;
mod constraints;
mod direct;
mod discretisation;
mod dynamics;
mod dynamics_derivatives;
mod general_flow;
mod geometry;
mod instance;
mod reference;
mod running_cost;
mod standing_foot;
mod theorem_b3;
mod theorem_b3_gradient;
mod theorem_b4;
mod wrt;

pub use instance::RandomInstance;
// The tests read statements of the text literally with these.
#[doc(hidden)]
pub use wrt::{NodeFunction, Wrt, derivative, gathered};

use crate::error::{Result, check_count};
use crate::scalar::{Jet, PrimeField, Scalar};
use crate::verify::reference::{Differentiable, DualNumber};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The field.
pub type Gf = PrimeField;
/// First-order dual numbers over the field.
pub type Jet1 = Jet<Gf, 1>;
/// Nested first-order dual numbers.
pub(crate) type Jet2 = Jet<Jet1, 1>;

impl<S: Scalar> DualNumber for Jet<S, 1> {
    type Base = S;

    fn from_parts(real: S, tangent: S) -> Self {
        Self::new(real, [tangent])
    }

    fn real(self) -> S {
        self.re
    }

    fn tangent(self) -> S {
        self.eps[0]
    }
}

impl Differentiable for PrimeField {
    type Dual = Jet1;
}

impl<S: Scalar> Differentiable for Jet<S, 1> {
    type Dual = Jet<Self, 1>;
}

/// A bound on the degrees of the numerators of all identities in the random inputs; `proofs/README.md` derives it.
pub const DEGREE: u64 = 1 << 17;

/// The largest number of random instances: one almost always shows a false identity, and this number takes a quarter of
/// an hour and 100 MB.
pub const MAX_POINTS: usize = 1000;

/// Two sides that should be equal, entry by entry.
pub struct Equality {
    what: &'static str,
    left: DMatrix<Gf>,
    right: DMatrix<Gf>,
}

impl Equality {
    /// Two matrices that should be equal. `what` names the block of an equation with several blocks.
    #[must_use]
    pub fn new(what: &'static str, left: DMatrix<Gf>, right: DMatrix<Gf>) -> Self {
        Self { what, left, right }
    }

    /// Two vectors that should be equal.
    #[must_use]
    pub fn vectors(what: &'static str, left: &DVector<Gf>, right: &DVector<Gf>) -> Self {
        let column = |v: &DVector<Gf>| DMatrix::from_column_slice(v.len(), 1, v.as_slice());
        Self::new(what, column(left), column(right))
    }

    /// Two numbers that should be equal.
    #[must_use]
    pub fn numbers(what: &'static str, left: Gf, right: Gf) -> Self {
        Self::new(what, DMatrix::from_element(1, 1, left), DMatrix::from_element(1, 1, right))
    }

    /// The first entry that differs, if any, or the sizes if these differ.
    #[must_use]
    pub fn difference(&self) -> Option<String> {
        if self.left.shape() != self.right.shape() {
            let (left, right) = (self.left.shape(), self.right.shape());
            return Some(format!("{}: sizes {left:?} and {right:?}", self.what));
        }
        let (rows, what) = (self.left.nrows().max(1), self.what);
        let mut pairs = self.left.iter().zip(&self.right).enumerate();
        let (i, (left, right)) = pairs.find(|(_, (left, right))| left != right)?;
        Some(format!("{what}: entry ({}, {}) is {left:?} left and {right:?} right", i % rows, i / rows))
    }
}

/// One numbered equation, step of an algorithm, or law of the dynamics.
pub struct Identity {
    /// Its label: `B5`, `A1`, `Algorithm B1 line 4`, `rnea`.
    pub label: &'static str,
    /// The identity in a few words.
    pub statement: &'static str,
    /// The index convention, if there is a choice.
    pub convention: &'static str,
    /// Computes both sides at a random instance.
    pub claims: fn(&RandomInstance) -> Result<Vec<Equality>>,
}

/// The result of proving one identity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The label of the identity.
    pub label: String,
    /// The identity in a few words.
    pub statement: String,
    /// The number of random instances.
    pub points: usize,
    /// The number of compared entries.
    pub entries: usize,
    /// The largest probability with which a false identity would pass.
    pub bound: f64,
    /// The first difference between the sides: the conventions, the point and the entry.
    pub failure: Option<String>,
}

/// All identities, in the order of the supplement, those of the dynamics first.
#[must_use]
pub fn identities() -> Vec<Identity> {
    let mut all = Vec::new();
    all.extend(dynamics::identities());
    all.extend(dynamics_derivatives::identities());
    all.extend(constraints::identities());
    all.extend(constraint_kinds::identities());
    all.extend(standing_foot::identities());
    all.extend(geometry::identities());
    all.extend(theorem_b3::identities());
    all.extend(theorem_b3_gradient::identities());
    all.extend(theorem_b4::identities());
    all.extend(algorithm_b1::identities());
    all.extend(algorithm_b2::identities());
    all.extend(algorithm_b3::identities());
    all.extend(direct::identities());
    all.extend(running_cost::identities());
    all.extend(general_flow::identities());
    all.extend(action::identities());
    all
}

/// Tests every identity at `points` random instances; the same seed gives the same instances.
///
/// # Errors
/// `points` is zero or above [`MAX_POINTS`].
pub fn prove(points: usize, seed: u64) -> Result<Vec<Verdict>> {
    prove_identities(&identities(), points, seed)
}

/// Tests these identities, such as those of user-defined formulas, in the same way as [`prove`]. The degree of their
/// numerators in the random inputs must not exceed [`DEGREE`].
///
/// # Errors
/// Those of [`prove`] and of the claims.
pub fn prove_identities(identities: &[Identity], points: usize, seed: u64) -> Result<Vec<Verdict>> {
    check_count("points", points, 1..=MAX_POINTS)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let points = (0..points).map(|_| RandomInstance::random(&mut rng)).collect::<Result<Vec<_>>>()?;
    identities.iter().map(|identity| verdict(identity, &points)).collect()
}

fn verdict(identity: &Identity, points: &[RandomInstance]) -> Result<Verdict> {
    let mut verdict = Verdict {
        label: identity.label.to_owned(),
        statement: identity.statement.to_owned(),
        points: points.len(),
        entries: 0,
        bound: (DEGREE as f64 / Gf::ORDER as f64).powf(points.len() as f64),
        failure: None,
    };
    for (number, point) in points.iter().enumerate() {
        for claim in (identity.claims)(point)? {
            verdict.entries += claim.left.len();
            if let (None, Some(difference)) = (&verdict.failure, claim.difference()) {
                verdict.failure = Some(format!(
                    "({}) {} [{}] fails at point {number}, {} joints: {difference}",
                    identity.label,
                    identity.statement,
                    identity.convention,
                    point.dof()
                ));
            }
        }
    }
    Ok(verdict)
}
