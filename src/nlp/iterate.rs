//! Slacks, elastic variables and multipliers of the rows.

use super::Barrier;

/// A row of the working set.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The index among all rows.
    pub at: usize,
    /// The weight without the measure of the problem.
    pub weight: f64,
    pub equality: bool,
}

/// The slacks $s$, elastic variables $t$ and multipliers of the rows, for all rows in their order.
///
/// An equality is an inequality whose slack is penalised as well, which shifts its multiplier: with
/// $\lambda = z + z_0$, where $z_0 = 0$ for an inequality and $-\nu$ for an equality, and the range
/// $\bar z = \nu - z_0$, both have the conditions $s z = \mu$ and $t (\bar z - z) = \mu$.
#[derive(Clone, Debug)]
pub struct Iterate {
    pub working: Vec<Row>,
    pub barrier: Barrier,
    pub slack: Vec<f64>,
    pub elastic: Vec<f64>,
    /// $z$; zero outside the working set.
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
    pub fn new(rows: usize, barrier: Barrier) -> Self {
        Self {
            working: Vec::new(),
            barrier,
            slack: vec![0.0; rows],
            elastic: vec![0.0; rows],
            multiplier: vec![0.0; rows],
        }
    }

    /// $z_0$ and $\bar z$ of a row.
    fn range(&self, row: &Row) -> [f64; 2] {
        let nu = self.barrier.nu;
        if row.equality {
            [-nu, 2.0 * nu]
        } else {
            [0.0, nu]
        }
    }

    /// The multiplier $\lambda$ of a row.
    pub fn lambda(&self, row: &Row) -> f64 {
        self.multiplier[row.at] + self.range(row)[0]
    }

    /// Returns true if the multiplier of a row is so near the penalty that its elastic variables do not vanish with the
    /// barrier parameter. Those of an equality differ by $2 \mu \lambda / (\nu^2 - \lambda^2)$.
    pub fn is_at_penalty(&self, row: &Row) -> bool {
        let share = if row.equality { 0.1 } else { 0.9 };
        self.lambda(row).abs() > share * self.barrier.nu
    }

    /// The slack and the elastic variable that minimise the barrier function for a value of the row.
    pub fn split(&self, row: &Row, h: f64) -> [f64; 2] {
        let (mu, range) = (self.barrier.mu, self.range(row)[1]);
        let product = h * range;
        let root = product.hypot(2.0 * mu);
        // The root less the product and the root and the product, none of which loses digits.
        let large = root + product.abs();
        let small = 4.0 * mu * (mu / large);
        let (less, more) = if product > 0.0 {
            (small, large)
        } else {
            (large, small)
        };
        [
            (2.0 * mu + less) * 0.5 / range,
            (2.0 * mu + more) * 0.5 / range,
        ]
    }

    /// Replaces the working set. New rows have the slack of their value and the multiplier of that.
    pub fn set_working(&mut self, working: Vec<Row>, h: &[f64]) {
        let mut kept = vec![0.0; self.multiplier.len()];
        for row in &working {
            let at = row.at;
            if self.multiplier[at] == 0.0 {
                [self.slack[at], self.elastic[at]] = self.split(row, h[at]);
                self.multiplier[at] = self.central(row);
            }
            kept[at] = self.multiplier[at];
        }
        self.multiplier = kept;
        self.working = working;
    }

    /// The multiplier of slack and elastic variable, the more accurate one of two.
    fn central(&self, row: &Row) -> f64 {
        let (mu, range) = (self.barrier.mu, self.range(row)[1]);
        let (s, t) = (self.slack[row.at], self.elastic[row.at]);
        if s > t { mu / s } else { range - mu / t }
    }

    /// Uses known multipliers $\lambda$ of the first rows, except those that are zero. A row whose slack is smaller than
    /// the one that belongs to its multiplier and the barrier parameter moves away from its bound, at most to `room`.
    pub fn set_multipliers(&mut self, lambda: &[f64], h: &[f64], room: f64, range: f64) {
        for row in self.working.clone() {
            let (at, [lower, whole]) = (row.at, self.range(&row));
            let Some(known) = lambda.get(at).filter(|known| **known != 0.0) else {
                continue;
            };
            let z = (known - lower).clamp(0.0, whole);
            let slack = (self.barrier.mu / z).min(room);
            if slack > self.slack[at] {
                self.slack[at] = slack;
                self.elastic[at] = h[at] + slack;
            }
            self.multiplier[at] = z;
            self.safeguard(&row, range);
        }
    }

    /// Replaces slacks and elastic variables by the best ones for these values of the rows.
    pub fn recentre(&mut self, h: &[f64], barrier: Barrier) {
        self.barrier = barrier;
        for row in self.working.clone() {
            [self.slack[row.at], self.elastic[row.at]] = self.split(&row, h[row.at]);
            self.multiplier[row.at] = self.central(&row);
        }
    }

    /// Changes the barrier; multipliers of equalities do not move with the penalty.
    pub fn set_barrier(&mut self, barrier: Barrier, range: f64) {
        let old = self.barrier;
        for row in self.working.clone() {
            if row.equality {
                self.multiplier[row.at] += barrier.nu - old.nu;
            }
        }
        self.barrier = barrier;
        for row in self.working.clone() {
            self.safeguard(&row, range);
        }
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

    /// The terms of a row of this value.
    pub fn term(&self, row: &Row, h: f64) -> Term {
        let ([lower, range], mu) = (self.range(row), self.barrier.mu);
        let (s, t, z) = (
            self.slack[row.at],
            self.elastic[row.at],
            self.multiplier[row.at],
        );
        let upper = range - z;
        let curvature = z * upper / (s * upper + t * z);
        Term {
            slope: lower + z + curvature * (h + mu / z - mu / upper),
            curvature,
            multiplier: lower + z,
            cost: range * t + lower * h - mu * (s * t).ln(),
        }
    }

    /// The Newton step of a row that changes by `change`.
    pub fn step(&self, row: &Row, h: f64, change: f64) -> RowStep {
        let ([_, range], mu) = (self.range(row), self.barrier.mu);
        let (s, t, z) = (
            self.slack[row.at],
            self.elastic[row.at],
            self.multiplier[row.at],
        );
        let upper = range - z;
        let curvature = z * upper / (s * upper + t * z);
        let multiplier = curvature * (h + change + mu / z - mu / upper);
        RowStep {
            slack: mu / z - s - s / z * multiplier,
            elastic: mu / upper - t + t / upper * multiplier,
            multiplier,
        }
    }

    /// The curvature of slack and elastic variable along a step, and the part of it in the condensed matrix.
    pub fn bend(&self, row: &Row, step: &RowStep, change: f64) -> [f64; 2] {
        let range = self.range(row)[1];
        let (s, t, z) = (
            self.slack[row.at],
            self.elastic[row.at],
            self.multiplier[row.at],
        );
        let upper = range - z;
        let curvature = z * upper / (s * upper + t * z);
        let own = z / s * step.slack * step.slack + upper / t * step.elastic * step.elastic;
        [own, curvature * change * change]
    }

    /// Takes a fraction of a step from another iterate; each of slack, elastic variable and multiplier keeps at least
    /// $1 - \tau$ of its distance from zero, the fraction-to-the-boundary rule row by row (WB 15).
    pub fn take(&mut self, from: &Self, row: &Row, step: &RowStep, fraction: f64, tau: f64) {
        let (at, range) = (row.at, self.range(row)[1]);
        let moved = |value: f64, by: f64| (value + by).max((1.0 - tau) * value);
        self.slack[at] = moved(from.slack[at], fraction * step.slack);
        self.elastic[at] = moved(from.elastic[at], fraction * step.elastic);
        let z = moved(from.multiplier[at], fraction * step.multiplier);
        self.multiplier[at] = range - moved(range - from.multiplier[at], from.multiplier[at] - z);
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
        let (mut sum, mu) = (0.0, self.barrier.mu);
        for row in &self.working {
            let [lower, range] = self.range(row);
            let (s, t) = (self.slack[row.at], self.elastic[row.at]);
            sum += row.weight * (range * t + lower * h[row.at] - mu * (s * t).ln());
        }
        sum
    }

    /// Keeps the multiplier within a factor `range` of the one that belongs to slack and elastic variable (WB 16).
    fn safeguard(&mut self, row: &Row, range: f64) {
        let (mu, [_, whole]) = (self.barrier.mu, self.range(row));
        let (s, t) = (self.slack[row.at], self.elastic[row.at]);
        let z = &mut self.multiplier[row.at];
        if s > t {
            *z = z.max(mu / s / range).min((mu / s * range).min(0.5 * whole));
        } else {
            let upper = (whole - *z).max(mu / t / range);
            *z = whole - upper.min((mu / t * range).min((1.0 - 1e-12) * whole));
        }
    }
}
