//! Bounds on the values of polynomials.

use super::Polynomial;

/// The largest number of halvings of the interval, and of parts that are examined.
const MAX_PARTS: usize = 256;

/// The Bernstein basis of one degree `n` on `[-1, 1]`.
///
/// With $s = 2 x - 1$ a polynomial is $\sum_i b_i \binom ni x^i (1 - x)^{n - i}$. Its values are within those of the
/// coefficients, and equal to $b_0$ and $b_n$ at the ends; halves of the interval, by de Casteljau's recursion of
/// averages, approach the extrema quadratically.
#[derive(Clone, Debug)]
pub struct Bernstein {
    /// The Bernstein coefficients of the powers of `s`: `n + 1` per power. None is above one.
    powers: Vec<Vec<f64>>,
}

/// Bounds on the values of a function on an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// No value is below.
    pub lower: f64,
    /// No value is above.
    pub upper: f64,
    /// Some value is at most this.
    pub least_at_most: f64,
    /// Some value is at least this.
    pub most_at_least: f64,
    /// The places of these two values, `s` from -1 to 1.
    pub places: [f64; 2],
}

impl Bernstein {
    /// The basis of degree `n`. Cost O(n^3).
    #[must_use]
    pub fn new(n: usize) -> Self {
        let mut power = vec![1.0];
        let mut powers = Vec::with_capacity(n + 1);
        for k in 0..=n {
            // The coefficients of a power of degree `k`, raised to degree `n`.
            powers.push((k..n).fold(power.clone(), |b, m| {
                let share = |i: usize| i as f64 / (m + 1) as f64;
                let at = |i: usize| b.get(i).copied().unwrap_or(0.0);
                (0..=m + 1).map(|i| share(i) * at(i.wrapping_sub(1)) + share(m + 1 - i) * at(i)).collect()
            }));
            // Times s = x - (1 - x).
            let share = |i: usize| i as f64 / (k + 1) as f64;
            let at = |i: usize| power.get(i).copied().unwrap_or(0.0);
            power = (0..=k + 1).map(|i| share(i) * at(i.wrapping_sub(1)) - share(k + 1 - i) * at(i)).collect();
        }
        Self { powers }
    }

    /// Bounds the values of a polynomial of at most this degree, each to within `accuracy` beyond the bound on its
    /// error, unless that takes more than 256 parts. Cost O(n^2) per part.
    #[must_use]
    pub fn range(&self, polynomial: &Polynomial, accuracy: f64) -> Range {
        let n = self.powers.len() - 1;
        let mut b = vec![0.0; n + 1];
        let mut size = 0.0;
        for (c, power) in polynomial.coefficients.iter().zip(&self.powers) {
            size += c.abs();
            for (b, power) in b.iter_mut().zip(power) {
                *b += c * power;
            }
        }
        // In units of 2^-53 times the size: the entries of `powers` have errors of at most 8 n, the sums of n, and the
        // averages of 128 halvings, as many as there can be one after the other, of 128 n.
        let rounding = 128.0 * (n + 1) as f64 * f64::EPSILON * size;
        let error = (polynomial.radius + rounding) * (1.0 + 1e-15) + f64::MIN_POSITIVE;
        let (upper, most, at) = largest(&b, accuracy);
        for b in &mut b {
            *b = -*b;
        }
        let (lower, least, at_least) = largest(&b, accuracy);
        Range {
            lower: (-lower - error).next_down(),
            upper: (upper + error).next_up(),
            least_at_most: -least + error,
            most_at_least: most - error,
            places: [at_least, at],
        }
    }
}

/// A bound on the largest value of a polynomial by its Bernstein coefficients, a value, and the place of that value.
fn largest(b: &[f64], accuracy: f64) -> (f64, f64, f64) {
    let n = b.len() - 1;
    let end = |b: &[f64], [from, to]: [f64; 2]| {
        if b[0] >= b[n] { (b[0], from) } else { (b[n], to) }
    };
    let (mut found, mut bound) = (end(b, [-1.0, 1.0]), f64::NEG_INFINITY);
    let mut open = vec![(b.to_vec(), [-1.0, 1.0])];
    let mut parts = 1;
    while let Some((mut right, [from, to])) = open.pop() {
        let top = right.iter().fold(f64::NEG_INFINITY, |top, b| if *b <= top { top } else { *b });
        if parts >= MAX_PARTS || top <= found.0 + accuracy {
            bound = if top <= bound { bound } else { top };
            continue;
        }
        // The first averages of each level are the left half, the remaining ones the right half.
        let mut left = vec![right[0]];
        for level in 1..=n {
            for i in 0..=n - level {
                right[i] = 0.5 * (right[i] + right[i + 1]);
            }
            left.push(right[0]);
        }
        let middle = 0.5 * (from + to);
        for half in [(left, [from, middle]), (right, [middle, to])] {
            let reached = end(&half.0, half.1);
            if reached.0 > found.0 {
                found = reached;
            }
            open.push(half);
        }
        parts += 2;
    }
    (bound, found.0, found.1)
}
