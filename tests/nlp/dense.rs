//! Dense nonlinear programs, with derivatives by duals.

use aghf::Result;
use aghf::cost::HyperDual64;
use aghf::linalg::BlockTridiagonal;
use aghf::nlp::{Bordered, Equality, Iterate, Kkt, Nlp, Options, Row, Solution, Term, Tightened, solve};
use nalgebra::{DMatrix, DVector};

/// The objective and the rows as functions of the unknowns.
pub type Functions = fn(&[HyperDual64]) -> (HyperDual64, Vec<HyperDual64>);

/// A program whose rows are those of `functions` in the order `rows`, each times a factor.
#[derive(Clone)]
pub struct Dense {
    pub functions: Functions,
    pub start: Vec<f64>,
    /// The index, the factor and the weight of each row, and true for an equality.
    pub rows: Vec<(usize, f64, f64, bool)>,
    pub measure: f64,
    pub stopped: bool,
    pub coarse: bool,
    /// The margin of all inequalities from the end of the search on.
    pub margin: f64,
    pub tightened: bool,
    /// The other margin after every second look between the points in the first rounds, if there is one.
    pub swing: Option<f64>,
    /// The rounds of these looks.
    pub rounds: Vec<usize>,
    /// The number of evaluations of the functions.
    pub evaluations: usize,
    /// The last evaluated point, at which the method asks for derivatives.
    pub last: DVector<f64>,
}

/// The options of the tests: as accurate as rounding allows, far beyond the differences that are compared.
pub fn accurate() -> Options {
    Options {
        tolerance: 1e-8,
        feasible: 1e-9,
        last_barrier: 1e-10,
        // Slacks are as small as that.
        tangent: 1e-7,
        ..Options::default()
    }
}

/// The unit matrix of `n` unknowns as the norm of steps.
pub fn unit_norm(n: usize) -> Kkt {
    let mut matrix = BlockTridiagonal::new(&[n], 0);
    matrix.diagonal[0].fill_with_identity();
    Kkt::new(Bordered::with_border(matrix, 0)).expect("the unit matrix is positive definite")
}

/// Gradient and Hessian of each function.
pub fn derivatives(
    x: &DVector<f64>,
    functions: impl Fn(&[HyperDual64]) -> Vec<HyperDual64>,
) -> Vec<(DVector<f64>, DMatrix<f64>)> {
    let n = x.len();
    let mut found = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let mut dual: Vec<_> = x.iter().map(|x| HyperDual64::from(*x)).collect();
            dual[i].eps1 = 1.0;
            dual[j].eps2 = 1.0;
            let all = functions(&dual);
            found.resize(all.len(), (DVector::zeros(n), DMatrix::zeros(n, n)));
            for ((gradient, hessian), f) in found.iter_mut().zip(all) {
                gradient[i] = f.eps1;
                hessian[(i, j)] = f.eps1eps2;
            }
        }
    }
    found
}

impl Dense {
    /// A program with `equalities` first, then `inequalities`, all of weight 1.
    pub fn new(functions: Functions, start: &[f64], equalities: usize, all: usize) -> Self {
        Self {
            functions,
            start: start.to_vec(),
            rows: (0..all).map(|i| (i, 1.0, 1.0, i < equalities)).collect(),
            measure: 1.0,
            stopped: false,
            coarse: false,
            margin: 0.0,
            tightened: false,
            swing: None,
            rounds: Vec::new(),
            evaluations: 0,
            last: DVector::zeros(0),
        }
    }

    /// The objective, then the rows.
    fn all(&self, x: &[HyperDual64]) -> Vec<HyperDual64> {
        let (f, h) = (self.functions)(x);
        let rows = self.rows.iter().map(|(i, factor, ..)| h[*i] * *factor);
        std::iter::once(f).chain(rows).collect()
    }

    /// Gradient and Hessian of the objective, then of the rows.
    fn twice(&self, x: &DVector<f64>) -> Vec<(DVector<f64>, DMatrix<f64>)> {
        derivatives(x, |x| self.all(x))
    }

    /// The gradient of the Lagrangian with the multipliers of an iterate.
    pub fn lagrangian_gradient(&self, x: &DVector<f64>, iterate: &Iterate) -> DVector<f64> {
        let all = self.twice(x);
        let (mut sum, multipliers) = (all[0].0.clone(), iterate.multipliers(self.rows.len()));
        for (at, (.., weight, _)) in self.rows.iter().enumerate() {
            let factor = self.measure * weight * multipliers[at];
            sum.axpy(factor, &all[1 + at].0, 1.0);
        }
        sum
    }

    /// The unit matrix as the norm of steps.
    pub fn kkt(&self) -> Kkt {
        unit_norm(self.start.len())
    }

    /// The equalities or the inequalities.
    fn all_rows(&self, equalities: bool) -> impl Iterator<Item = Row> {
        let rows = self.rows.iter().enumerate();
        let of_kind = rows.filter(move |(_, row)| row.3 == equalities);
        of_kind.map(|(at, row)| Row { is_curved: !row.3, ..Row::new(at, row.2) })
    }

    /// The solution from the start.
    pub fn solve(&mut self, options: &Options) -> Solution {
        self.solve_from(&self.start.clone(), None, options)
    }

    /// The solution from other unknowns, with known multipliers.
    pub fn solve_from(&mut self, x: &[f64], multipliers: Option<&[f64]>, options: &Options) -> Solution {
        let (x, kkt) = (DVector::from_column_slice(x), self.kkt());
        let end = solve(self, x, multipliers, kkt, options, &mut |_| ());
        end.expect("the functions do not fail")
    }

    /// The largest violation of a row at `x`.
    pub fn violation(&mut self, x: &DVector<f64>) -> Result<f64> {
        let mut h = Vec::new();
        self.value(x, &mut h)?;
        let rows = h.iter().zip(&self.rows);
        let violations = rows.map(|(h, (.., equality))| if *equality { h.abs() } else { *h });
        Ok(violations.fold(0.0, f64::max))
    }
}

impl Nlp for Dense {
    fn value(&mut self, x: &DVector<f64>, h: &mut Vec<f64>) -> Result<f64> {
        self.last.clone_from(x);
        let x: Vec<_> = x.iter().map(|x| HyperDual64::from(*x)).collect();
        let all = self.all(&x);
        self.evaluations += 1;
        h.clear();
        let margin = |row: &(usize, f64, f64, bool)| if row.3 || !self.tightened { 0.0 } else { self.margin };
        let rows = all[1..].iter().zip(&self.rows);
        h.extend(rows.map(|(h, row)| h.re + margin(row)));
        Ok(all[0].re)
    }

    fn derivatives(&mut self, x: &DVector<f64>, iterate: &Iterate, out: &mut Kkt) -> Result<()> {
        assert_eq!(*x, self.last, "derivatives elsewhere");
        let all = self.twice(x);
        let mut h = Vec::new();
        self.value(x, &mut h)?;
        let (mut gradient, mut hessian) = all[0].clone();
        let mut add = |row: &Row, term: Term| {
            let (term, (slope, second)) = (term.times(self.measure * row.weight), &all[1 + row.at]);
            gradient.axpy(term.slope, slope, 1.0);
            hessian += second * term.multiplier;
            hessian.ger(term.curvature, slope, slope, 1.0);
        };
        for state in &iterate.working {
            add(&state.row, iterate.term(state, h[state.row.at]));
        }
        for equality in &iterate.equalities {
            let row = &equality.row;
            add(row, equality.term(h[row.at]));
        }
        let Kkt { hessian: blocks, equalities, .. } = out;
        equalities.clear();
        for equality in &iterate.equalities {
            equalities.push(blocks, 0, &all[1 + equality.row.at].0);
        }
        out.gradient = gradient;
        out.hessian.matrix.diagonal[0] = hessian;
        Ok(())
    }

    fn measure(&self, _: &DVector<f64>) -> f64 {
        self.measure
    }

    fn equalities(&self) -> Vec<Equality> {
        self.all_rows(true).map(Equality::new).collect()
    }

    fn working_set(&mut self, _: &[f64], rows: &mut Vec<Row>) {
        rows.clear();
        rows.extend(self.all_rows(false));
    }

    fn tighten(&mut self, x: &DVector<f64>, _: &mut Vec<f64>, round: usize) -> Result<Tightened> {
        // The first round is that at which the last barrier parameter is reached.
        self.tightened |= round > 1;
        self.rounds.push(round);
        if let Some(other) = self.swing.as_mut().filter(|_| round <= 4) {
            std::mem::swap(other, &mut self.margin);
        }
        if self.coarse {
            return Ok(Tightened::QuadratureTooCoarse);
        }
        self.violation(x).map(Tightened::Violation)
    }

    fn is_stopped(&self) -> bool {
        self.stopped
    }
}
