//! Slacks, elastic variables and multipliers of the rows.

use super::Barrier;

/// The fraction of the penalty above which a multiplier shows that its row is violated because that is cheap.
const AT_PENALTY: f64 = 0.9;
/// The fraction of its violation that an equality may keep from one update to the next before its penalty grows: 1/4 as
/// in NW, framework 17.3.
const PROGRESS: f64 = 0.25;

/// A row of the working set.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The index among all rows.
    pub at: usize,
    /// The weight without the measure of the problem.
    pub weight: f64,
}

/// A row that is an equality.
#[derive(Clone, Copy, Debug)]
pub struct Equality {
    pub row: Row,
    /// The penalty of its square without a search before.
    pub first: f64,
    /// The penalty $\rho$ of its square.
    pub penalty: f64,
}

/// The slacks $s$, elastic variables $t$ and multipliers of the rows, for all rows in their order: those of
/// inequalities have the conditions $s \lambda = \mu$ and $t (\nu - \lambda) = \mu$. Equalities have the terms
/// $\lambda h + \tfrac12 \rho h^2$ of an augmented Lagrangian (NW 17.3).
#[derive(Clone, Debug)]
pub struct Iterate {
    /// The inequalities of the working set.
    pub working: Vec<Row>,
    pub equalities: Vec<Equality>,
    /// The largest equality at the last update of their multipliers.
    before: f64,
    pub barrier: Barrier,
    pub slack: Vec<f64>,
    pub elastic: Vec<f64>,
    /// $\lambda$; zero outside the working set.
    pub multiplier: Vec<f64>,
}

/// The weights of a row in the condensed equations.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// That of its gradient.
    pub slope: f64,
    /// That of the product of its gradient with itself.
    pub curvature: f64,
    /// That of its second derivative: the multiplier.
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

impl Iterate {
    pub fn new(rows: usize, barrier: Barrier, equalities: Vec<Equality>) -> Self {
        Self {
            working: Vec::new(),
            equalities,
            before: f64::INFINITY,
            barrier,
            slack: vec![0.0; rows],
            elastic: vec![0.0; rows],
            multiplier: vec![0.0; rows],
        }
    }

    /// Returns true if a multiplier has nearly reached the penalty.
    pub fn is_at_penalty(&self) -> bool {
        self.working.iter().any(|row| self.is_row_at_penalty(row))
    }

    /// Returns true if the multiplier of a row has nearly reached the penalty.
    pub fn is_row_at_penalty(&self, row: &Row) -> bool {
        self.multiplier[row.at] > AT_PENALTY * self.barrier.nu
    }

    /// The slack and the elastic variable that minimise the barrier function for a value of the row.
    pub fn split(&self, h: f64) -> [f64; 2] {
        let Barrier { mu, nu } = self.barrier;
        let product = h * nu;
        let root = product.hypot(2.0 * mu);
        // The root less the product and the root and the product, none of which loses digits.
        let large = root + product.abs();
        let small = 4.0 * mu * (mu / large);
        let (less, more) = if product > 0.0 {
            (small, large)
        } else {
            (large, small)
        };
        [(2.0 * mu + less) * 0.5 / nu, (2.0 * mu + more) * 0.5 / nu]
    }

    /// Replaces the working set. New rows have the slack of their value and the multiplier of that.
    pub fn set_working(&mut self, working: Vec<Row>, h: &[f64]) {
        let mut kept = vec![0.0; self.multiplier.len()];
        for row in &working {
            let at = row.at;
            if self.multiplier[at] == 0.0 {
                [self.slack[at], self.elastic[at]] = self.split(h[at]);
                self.multiplier[at] = self.central(row);
            }
            kept[at] = self.multiplier[at];
        }
        for Equality { row, .. } in &self.equalities {
            kept[row.at] = self.multiplier[row.at];
        }
        self.multiplier = kept;
        self.working = working;
    }

    /// The multiplier of slack and elastic variable, the more accurate one of two.
    fn central(&self, row: &Row) -> f64 {
        let Barrier { mu, nu } = self.barrier;
        let (s, t) = (self.slack[row.at], self.elastic[row.at]);
        if s > t { mu / s } else { nu - mu / t }
    }

    /// Uses known multipliers $\lambda$ of the first rows, except those that are zero. An inequality whose slack is
    /// smaller than the one that belongs to its multiplier and the barrier parameter moves away from its bound, at most
    /// to `largest`.
    pub fn set_multipliers(&mut self, known: &[f64], h: &[f64], largest: f64, range: f64) {
        for row in self.working.clone() {
            let at = row.at;
            let Some(z) = known.get(at).filter(|known| **known != 0.0) else {
                continue;
            };
            let slack = (self.barrier.mu / z).min(largest);
            if slack > self.slack[at] {
                self.slack[at] = slack;
                self.elastic[at] = h[at] + slack;
            }
            self.multiplier[at] = *z;
            self.safeguard(&row, range);
        }
        for Equality { row, .. } in &self.equalities {
            self.multiplier[row.at] = known.get(row.at).copied().unwrap_or(0.0);
        }
    }

    /// Updates the multipliers of equalities, $\lambda \leftarrow \lambda + \rho h$, and multiplies their penalties by
    /// `factor`, at most to `largest`, if the largest equality is more than a quarter of that before (NW, framework
    /// 17.3).
    pub fn update_equalities(&mut self, h: &[f64], factor: f64, largest: f64) {
        let mut most = 0.0_f64;
        for Equality { row, penalty, .. } in &self.equalities {
            self.multiplier[row.at] += penalty * h[row.at];
            most = most.max(h[row.at].abs());
        }
        if most > PROGRESS * self.before {
            for equality in &mut self.equalities {
                let now = equality.penalty;
                // The objective may have been far smaller when they were first set.
                equality.penalty = (factor * now).min(largest.max(now));
            }
        }
        self.before = most;
    }

    /// Replaces slacks and elastic variables by the best ones for these values of the rows.
    pub fn recentre(&mut self, h: &[f64], barrier: Barrier) {
        self.barrier = barrier;
        for row in self.working.clone() {
            [self.slack[row.at], self.elastic[row.at]] = self.split(h[row.at]);
            self.multiplier[row.at] = self.central(&row);
        }
    }

    /// Changes the barrier.
    pub fn set_barrier(&mut self, barrier: Barrier, range: f64) {
        self.barrier = barrier;
        self.safeguard_all(range);
    }

    /// Makes the constraints $h + s = t$ hold for other values of the rows.
    pub fn reset(&mut self, h: &[f64], range: f64) {
        for row in self.working.clone() {
            let at = row.at;
            if h[at] < 0.0 {
                self.slack[at] = self.elastic[at] - h[at];
            } else {
                self.elastic[at] = self.slack[at] + h[at];
            }
            self.safeguard(&row, range);
        }
    }

    /// The sum of the products of slacks and multipliers, without the measure.
    pub fn gap(&self) -> f64 {
        let product = |row: &Row| row.weight * self.slack[row.at] * self.multiplier[row.at];
        self.working.iter().map(product).sum()
    }

    /// The terms of an inequality of this value.
    pub fn term(&self, row: &Row, h: f64) -> Term {
        let Barrier { mu, nu } = self.barrier;
        let [s, t, z] = self.of(row);
        let curvature = self.curvature(row);
        Term {
            slope: z + curvature * (h + mu / z - mu / (nu - z)),
            curvature,
            multiplier: z,
            cost: nu * t - mu * (s * t).ln(),
        }
    }

    /// The terms of an equality of this value.
    pub fn equality_term(&self, equality: &Equality, h: f64) -> Term {
        let (lambda, rho) = (self.multiplier[equality.row.at], equality.penalty);
        Term {
            slope: lambda + rho * h,
            curvature: rho,
            multiplier: lambda + rho * h,
            cost: (lambda + 0.5 * rho * h) * h,
        }
    }

    /// Slack, elastic variable and multiplier of a row.
    fn of(&self, row: &Row) -> [f64; 3] {
        [&self.slack, &self.elastic, &self.multiplier].map(|all| all[row.at])
    }

    /// The weight of the product of the gradient of a row with itself, $1 / (s / \lambda + t / (\nu - \lambda))$.
    fn curvature(&self, row: &Row) -> f64 {
        let [s, t, z] = self.of(row);
        let upper = self.barrier.nu - z;
        z * upper / (s * upper + t * z)
    }

    /// The Newton step of an inequality that changes by `change`.
    pub fn step(&self, row: &Row, h: f64, change: f64) -> RowStep {
        let Barrier { mu, nu } = self.barrier;
        let [s, t, z] = self.of(row);
        let upper = nu - z;
        let multiplier = self.curvature(row) * (h + change + mu / z - mu / upper);
        RowStep {
            slack: mu / z - s - s / z * multiplier,
            elastic: mu / upper - t + t / upper * multiplier,
            multiplier,
        }
    }

    /// The curvature of slack and elastic variable along a step, and the part of it in the condensed matrix.
    pub fn bend(&self, row: &Row, step: &RowStep, change: f64) -> [f64; 2] {
        let [s, t, z] = self.of(row);
        let upper = self.barrier.nu - z;
        let own = z / s * step.slack * step.slack + upper / t * step.elastic * step.elastic;
        [own, self.curvature(row) * change * change]
    }

    /// Takes a fraction of a step from another iterate; slack, elastic variable, multiplier and its distance from the
    /// penalty each keep at least $1 - \tau$ of their value: the fraction-to-the-boundary rule row by row (WB 15).
    pub fn take(&mut self, from: &Self, row: &Row, step: &RowStep, fraction: f64, tau: f64) {
        let (at, nu) = (row.at, self.barrier.nu);
        let moved = |value: f64, by: f64| (value + by).max((1.0 - tau) * value);
        let [s, t, z] = from.of(row);
        self.slack[at] = moved(s, fraction * step.slack);
        self.elastic[at] = moved(t, fraction * step.elastic);
        let by = moved(z, fraction * step.multiplier) - z;
        self.multiplier[at] = nu - moved(nu - z, -by);
    }

    /// Enlarges slack or elastic variable of a row until $h + s = t$.
    pub fn meet(&mut self, row: &Row, h: f64) {
        let (s, t) = (&mut self.slack[row.at], &mut self.elastic[row.at]);
        let excess = h + *s - *t;
        if excess > 0.0 {
            *t += excess;
        } else {
            *s -= excess;
        }
    }

    /// Safeguards the multipliers of all rows; see [`safeguard`](Self::safeguard).
    pub fn safeguard_all(&mut self, range: f64) {
        let working = std::mem::take(&mut self.working);
        for row in &working {
            self.safeguard(row, range);
        }
        self.working = working;
    }

    /// The terms of all rows in the barrier function, without their measure.
    pub fn barrier_terms(&self, h: &[f64]) -> f64 {
        let (mut sum, Barrier { mu, nu }) = (0.0, self.barrier);
        for row in &self.working {
            let (s, t) = (self.slack[row.at], self.elastic[row.at]);
            sum += row.weight * (nu * t - mu * (s * t).ln());
        }
        for equality in &self.equalities {
            let row = equality.row;
            sum += row.weight * self.equality_term(equality, h[row.at]).cost;
        }
        sum
    }

    /// Keeps the multiplier within a factor `range` of the one that belongs to slack and elastic variable (WB 16).
    fn safeguard(&mut self, row: &Row, range: f64) {
        let Barrier { mu, nu } = self.barrier;
        let (s, t) = (self.slack[row.at], self.elastic[row.at]);
        let z = &mut self.multiplier[row.at];
        if s > t {
            *z = z.max(mu / s / range).min((mu / s * range).min(0.5 * nu));
        } else {
            // Not less than rounding leaves between a multiplier and the penalty.
            let least = (mu / t / range).max(f64::EPSILON * nu);
            let upper = (nu - *z).max(least).min((mu / t * range).max(least));
            *z = nu - upper.min((1.0 - f64::EPSILON) * nu);
        }
    }
}
