//! One row: its slack, elastic variable and multiplier, their steps, and its terms in the condensed equations.

/// The fraction of the penalty above which a multiplier shows that its row is violated because that is cheap.
const AT_PENALTY: f64 = 0.9;

/// A row of the working set.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The index among all rows.
    pub at: usize,
    /// The weight without the measure of the problem.
    pub weight: f64,
    /// True for an inequality that makes the Hessian indefinite by itself, such as a clearance: of its second
    /// derivatives the Hessian has [a part](super::Iterate::curvature_weight).
    pub is_curved: bool,
    pub is_equality: bool,
    /// True for an inequality without an elastic variable, $h + s = 0$: the violation of that equation is one of the
    /// [filter](super::Nlp::has_filter).
    pub is_hard: bool,
}

impl Row {
    /// A row all of whose second derivatives the Hessian has.
    #[must_use]
    pub const fn new(at: usize, weight: f64) -> Self {
        Self { at, weight, is_curved: false, is_equality: false, is_hard: false }
    }

    /// An equality.
    #[must_use]
    pub const fn equality(at: usize, weight: f64) -> Self {
        Self { is_equality: true, ..Self::new(at, weight) }
    }

    /// The violation by a value of the row.
    #[must_use]
    pub fn violation(&self, h: f64) -> f64 {
        if self.is_equality { h.abs() } else { h.max(0.0) }
    }
}

/// An equality of the saddle-point equations, with its multiplier $\lambda$.
#[derive(Clone, Copy, Debug)]
pub struct Equality {
    pub row: Row,
    pub multiplier: f64,
}

impl Equality {
    /// An equality without a multiplier.
    #[must_use]
    pub const fn new(row: Row) -> Self {
        Self { row, multiplier: 0.0 }
    }

    /// The terms of the Lagrangian for this value of the row.
    #[inline]
    #[must_use]
    pub fn term(&self, h: f64) -> Term {
        let multiplier = self.multiplier;
        Term { slope: multiplier, curvature: 0.0, multiplier, cost: multiplier * h }
    }
}

/// The slack $s$, the elastic variable $t$, the multiplier $\lambda$ and the penalty $\nu$ of a row, with the
/// conditions $s (\lambda - \underline\lambda) = \mu$ and $t (\nu - \lambda) = \mu$. The slack of an inequality
/// costs nothing: $\underline\lambda = 0$; that of an equality is a violation as the elastic variable is:
/// $\underline\lambda = -\nu$. The penalty of a [hard](Row::is_hard) row is infinite, and `t` is the rest of its
/// equation, not negative, which vanishes along the Newton step.
#[derive(Clone, Copy, Debug)]
pub struct RowState {
    pub row: Row,
    pub slack: f64,
    pub elastic: f64,
    pub multiplier: f64,
    /// The penalty of its violation: not less than [that of all](super::Barrier::nu).
    pub penalty: f64,
}

/// The weights of a row in the condensed equations.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// The weight of its gradient.
    pub slope: f64,
    /// The weight of the product of its gradient with itself.
    pub curvature: f64,
    /// The weight of its second derivative: the multiplier.
    pub multiplier: f64,
    /// The terms of the row in the barrier function.
    pub cost: f64,
}

impl Term {
    /// The term times a factor.
    pub fn times(self, factor: f64) -> Self {
        Self {
            slope: factor * self.slope,
            curvature: factor * self.curvature,
            multiplier: factor * self.multiplier,
            cost: factor * self.cost,
        }
    }
}

/// A step of slack, elastic variable and multiplier.
#[derive(Clone, Copy, Debug)]
pub struct RowStep {
    pub slack: f64,
    pub elastic: f64,
    pub multiplier: f64,
}

impl RowState {
    /// The least multiplier $\underline\lambda$.
    #[inline]
    pub fn least(&self) -> f64 {
        if self.row.is_equality { -self.penalty } else { 0.0 }
    }

    /// The distances of the multiplier from its bounds, $\lambda - \underline\lambda$ and $\nu - \lambda$.
    #[inline]
    pub fn distances(&self) -> [f64; 2] {
        [self.multiplier - self.least(), self.penalty - self.multiplier]
    }

    /// Returns true if the multiplier has nearly reached the penalty.
    pub fn is_at_penalty(&self) -> bool {
        let size = if self.row.is_equality { self.multiplier.abs() } else { self.multiplier };
        size > AT_PENALTY * self.penalty
    }

    /// Returns true if the row is violated by more than `feasible` because its penalty is small.
    pub fn needs_penalty(&self, h: &[f64], feasible: f64) -> bool {
        self.row.violation(h[self.row.at]) > feasible && self.is_at_penalty()
    }

    /// The terms of the row in the barrier function, without its weight.
    #[inline]
    pub fn barrier_term(&self, mu: f64) -> f64 {
        if self.row.is_hard {
            return -mu * self.slack.ln();
        }
        let costly = if self.row.is_equality { self.slack + self.elastic } else { self.elastic };
        self.penalty * costly - mu * (self.slack * self.elastic).ln()
    }

    /// The state after a fraction of a step; slack, elastic variable, multiplier and its distance from the penalty each
    /// keep at least $1 - \tau$ of their value: the fraction-to-the-boundary rule row by row (WB 15).
    #[inline]
    pub fn take(&self, step: &RowStep, fraction: f64, tau: f64) -> Self {
        let moved = |value: f64, by: f64| (value + by).max((1.0 - tau) * value);
        let ([below, above], nu) = (self.distances(), self.penalty);
        let moved_below = moved(below, fraction * step.multiplier);
        let by = moved_below - below;
        Self {
            slack: moved(self.slack, fraction * step.slack),
            elastic: moved(self.elastic, fraction * step.elastic),
            multiplier: if self.row.is_hard { moved_below } else { nu - moved(above, -by) },
            ..*self
        }
    }

    /// Enlarges slack or elastic variable until $h + s = t$.
    #[inline]
    pub fn meet(&mut self, h: f64) {
        if self.row.is_hard {
            self.slack = self.slack.max(-h);
            self.elastic = h + self.slack;
            return;
        }
        let excess = h + self.slack - self.elastic;
        if excess > 0.0 {
            self.elastic += excess;
        } else {
            self.slack -= excess;
        }
    }

    /// Keeps the multiplier within a factor `range` of the one that belongs to slack and elastic variable (WB 16).
    pub(super) fn safeguard(&mut self, mu: f64, range: f64) {
        let (s, t, nu, least) = (self.slack, self.elastic, self.penalty, self.least());
        let ([below, above], most) = (self.distances(), (1.0 - f64::EPSILON) * (nu - least));
        // Not less than rounding leaves between a multiplier and a bound that is not zero.
        if s > t || self.row.is_hard {
            let from = (mu / s / range).max(f64::EPSILON * least.abs());
            self.multiplier = least + below.clamp(from, (mu / s * range).max(from)).min(most);
        } else {
            let from = (mu / t / range).max(f64::EPSILON * nu);
            self.multiplier = nu - above.clamp(from, (mu / t * range).max(from)).min(most);
        }
    }
}
