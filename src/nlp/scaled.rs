//! A smooth program with scaled objective and rows, as the interior-point method takes it.

use super::{Equality, Iterate, Kkt, Nlp, Row, Scales, SmoothDerivatives, SmoothProgram, Tightened};
use crate::error::{Error, Result};
use nalgebra::DVector;

/// The part of its range, or of its size, by which an unknown is inside its bounds at the start: 1e-2 as in WB (3.6).
const INSIDE: f64 = 1e-2;

/// The part of its distance from a bound that an unknown or a slack moves at most in a step: 0.99 as in WB (8).
pub(super) const TO_BOUND: f64 = 0.99;

/// A bound of a row or of an unknown: `sign * (value - bound)` is at most zero.
pub(super) struct OneSided {
    /// The index of the row, or that of the unknown after all rows.
    pub source: usize,
    pub sign: f64,
    pub bound: f64,
    pub is_equality: bool,
}

/// A program with scaled objective and rows.
pub(super) struct Scaled<'p, P> {
    pub program: &'p mut P,
    pub bounds: Vec<[f64; 2]>,
    pub rows: Vec<OneSided>,
    pub scales: Scales,
    /// True if equalities are rows with elastic variables.
    pub is_elastic: bool,
    pub g: DVector<f64>,
    pub derivatives: SmoothDerivatives,
}

impl<'p, P: SmoothProgram> Scaled<'p, P> {
    pub fn new(program: &'p mut P, x: &DVector<f64>) -> Result<Self> {
        let (bounds, row_bounds) = (program.bounds(), program.row_bounds());
        let (n, m) = (bounds.len(), row_bounds.len());
        if x.len() != n {
            let condition = format!("it has {} entries, and there are bounds of {n} unknowns", x.len());
            return Err(Error::input("nlp", "x", condition));
        }
        if let Some(k) = x.iter().position(|x| !x.is_finite()) {
            return Err(Error::input("nlp", format!("x[{k}]"), format!("it is {}", x[k])));
        }
        let mut rows = Vec::new();
        for (source, [lower, upper]) in row_bounds.iter().chain(&bounds).copied().enumerate() {
            let good = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
            if !good {
                let (what, k) = if source < m { ("row", source) } else { ("unknown", source - m) };
                let condition = format!("its bounds are {lower} and {upper}");
                return Err(Error::input("nlp", format!("{what} {k}"), condition));
            }
            if lower == upper {
                rows.push(OneSided { source, sign: 1.0, bound: upper, is_equality: true });
                continue;
            }
            let sides = [(-1.0, lower), (1.0, upper)].into_iter().filter(|(_, bound)| bound.is_finite());
            rows.extend(sides.map(|(sign, bound)| OneSided { source, sign, bound, is_equality: false }));
        }
        Ok(Self {
            program,
            bounds,
            rows,
            scales: Scales { objective: 1.0, rows: DVector::from_element(m, 1.0) },
            is_elastic: false,
            g: DVector::zeros(m),
            derivatives: SmoothDerivatives::new(n, m),
        })
    }

    /// The nearest point that is well inside the bounds.
    pub fn inside(&self, x: &DVector<f64>) -> DVector<f64> {
        let inside = |i: usize| {
            let [lower, upper] = self.bounds[i];
            let distance = |bound: f64| (INSIDE * bound.abs().max(1.0)).min(INSIDE * (upper - lower));
            if lower == upper {
                return lower;
            }
            let from = if lower.is_finite() { lower + distance(lower) } else { lower };
            let to = if upper.is_finite() { upper - distance(upper) } else { upper };
            x[i].max(from).min(to)
        };
        DVector::from_fn(x.len(), |i, _| inside(i))
    }

    /// The factor of the value of a one-sided row.
    pub fn factor(&self, row: &OneSided) -> f64 {
        row.sign * self.scales.rows.get(row.source).copied().unwrap_or(1.0)
    }

    /// The gradient of a one-sided row by the last derivatives.
    pub fn slope(&self, at: usize) -> DVector<f64> {
        let (row, m) = (&self.rows[at], self.g.len());
        let mut slope = DVector::zeros(self.bounds.len());
        if row.source < m {
            slope.copy_from(&self.derivatives.jacobian.row(row.source).transpose());
        } else {
            slope[row.source - m] = 1.0;
        }
        slope * self.factor(row)
    }

    /// A one-sided row as one of the interior-point method.
    pub fn row(&self, at: usize) -> Row {
        let OneSided { source, is_equality, .. } = self.rows[at];
        let is_hard = !is_equality && (!self.is_elastic || source >= self.g.len());
        Row { is_equality, is_hard, ..Row::new(at, 1.0) }
    }

    /// The multipliers of the rows, then of the unknowns, from those of the one-sided rows.
    pub fn multipliers(&self, one_sided: impl Iterator<Item = (usize, f64)>) -> [DVector<f64>; 2] {
        let mut all = [DVector::zeros(self.g.len()), DVector::zeros(self.bounds.len())];
        for (at, multiplier) in one_sided {
            let (row, m) = (&self.rows[at], self.g.len());
            let to = if row.source < m { &mut all[0][row.source] } else { &mut all[1][row.source - m] };
            *to += self.factor(row) * multiplier / self.scales.objective;
        }
        all
    }

    /// Puts the values of the one-sided rows at `x`, the last evaluated point, into `h`.
    pub fn put_rows(&self, x: &DVector<f64>, h: &mut Vec<f64>) {
        let value = |source: usize| self.g.get(source).copied().unwrap_or_else(|| x[source - self.g.len()]);
        h.clear();
        h.extend(self.rows.iter().map(|row| self.factor(row) * (value(row.source) - row.bound)));
    }
}

impl<P: SmoothProgram> Nlp for Scaled<'_, P> {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        let f = self.program.value(x, &mut self.g)?;
        self.put_rows(x, h);
        let is_finite = f.is_finite() && h.iter().all(|h| h.is_finite());
        Ok(if is_finite { self.scales.objective * f } else { f64::INFINITY })
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        let mut h = Vec::new();
        self.put_rows(x, &mut h);
        let terms = iterate.working.iter().map(|state| (state.row.at, iterate.term(state, h[state.row.at])));
        let terms: Vec<_> = terms.collect();
        let held = iterate.equalities.iter().map(|held| (held.row.at, held.multiplier));
        let [y, _] = self.multipliers(terms.iter().map(|(at, term)| (*at, term.multiplier)).chain(held.clone()));
        self.program.derivatives(x, &y, &mut self.derivatives)?;
        out.gradient.copy_from(&self.derivatives.gradient);
        out.gradient *= self.scales.objective;
        out.equalities.clear();
        for (at, multiplier) in held {
            let slope = self.slope(at);
            out.gradient.axpy(multiplier, &slope, 1.0);
            out.equalities.push(&out.hessian, 0, &slope);
        }
        let hessian = &mut out.hessian.matrix.diagonal[0];
        hessian.copy_from(&self.derivatives.hessian);
        *hessian *= self.scales.objective;
        for (at, term) in terms {
            let slope = self.slope(at);
            out.gradient.axpy(term.slope, &slope, 1.0);
            if self.rows[at].source < self.g.len() {
                hessian.ger(term.curvature, &slope, &slope, 1.0);
            } else {
                let i = self.rows[at].source - self.g.len();
                hessian[(i, i)] += term.curvature * slope[i] * slope[i];
            }
        }
        Ok(())
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        1.0
    }

    fn working_set(&mut self, _: &[f64], rows: &mut Vec<Row>) {
        rows.clear();
        rows.extend((0..self.rows.len()).map(|at| self.row(at)).filter(|row| self.is_elastic || !row.is_equality));
    }

    fn has_filter(&self) -> bool {
        !self.is_elastic && (!self.g.is_empty() || self.rows.iter().any(|row| row.is_equality))
    }

    fn equalities(&self) -> Vec<Equality> {
        let rows = (0..self.rows.len()).map(|at| self.row(at)).filter(|row| !self.is_elastic && row.is_equality);
        rows.map(Equality::new).collect()
    }

    const HAS_ROW_GRADIENTS: bool = true;

    fn add_row_gradients(&self, weights: &[(usize, f64)], out: &mut DVector<f64>) {
        for (at, weight) in weights {
            out.axpy(*weight, &self.slope(*at), 1.0);
        }
    }

    /// Unknowns remain inside their bounds.
    fn max_step_fraction(&self, x: &DVector<f64>, step: &DVector<f64>) -> f64 {
        let mut fraction = 1.0_f64;
        for ((x, step), [lower, upper]) in x.iter().zip(step).zip(&self.bounds) {
            let distance = if *step > 0.0 { upper - x } else { x - lower };
            if lower < upper && TO_BOUND * distance < fraction * step.abs() {
                fraction = TO_BOUND * distance / step.abs();
            }
        }
        fraction
    }

    fn tighten(&mut self, x: &DVector<f64>, h: &mut Vec<f64>, _: usize) -> Result<Tightened> {
        self.value(x, h)?;
        let violations = h.iter().enumerate().map(|(at, h)| self.row(at).violation(*h));
        Ok(Tightened::Violation(violations.fold(0.0, f64::max)))
    }
}
