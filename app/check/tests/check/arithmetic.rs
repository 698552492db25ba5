//! Each operation encloses the exact result: against rational numbers, with inputs of which the remainder, the terms
//! beyond the degree, the radius or rounding dominates.

#[allow(dead_code)]
#[path = "../../src/arithmetic.rs"]
mod checker;

use checker::{Bernstein, Enclosure};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{FromPrimitive, One, Signed, Zero};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const N: usize = 6;
type Small = Enclosure<N>;

/// The number of random inputs of each operation.
const INPUTS: usize = 400;

fn exact(x: f64) -> BigRational {
    BigRational::from_f64(x).expect("it is finite")
}

/// The value of a polynomial.
fn value(c: &[f64], s: &BigRational) -> BigRational {
    c.iter().rev().fold(BigRational::zero(), |sum, c| sum * s + exact(*c))
}

/// A function within an enclosure: its polynomial and a constant within the radius.
fn random(rng: &mut impl Rng) -> (Small, BigRational) {
    let scale = [1.0, 1e-3, 1e-9][rng.random_range(0..3)];
    let mut model = Small::new(rng.random_range(-1.0..1.0));
    for c in &mut model.c[1..] {
        *c = scale * rng.random_range(-1.0..1.0);
    }
    model.r = [0.0, 0.0, 1e-17, 1e-3, 0.5][rng.random_range(0..5)] * rng.random_range(0.5..1.0);
    let off = exact(model.r) * exact([-1.0, 0.0, 1.0][rng.random_range(0..3)]);
    (model, off)
}

/// A place from -1 to 1, often an end.
fn place(rng: &mut impl Rng) -> BigRational {
    exact([-1.0, 1.0, rng.random_range(-1.0..1.0)][rng.random_range(0..3)])
}

fn encloses<const M: usize>(what: &str, model: &Enclosure<M>, s: &BigRational, found: &BigRational) {
    let off = (value(&model.c, s) - found).abs();
    assert!(model.r.is_infinite() || off <= exact(model.r), "{what}: {model:?} at {s}: off by {off}");
}

#[test]
fn sums_products_and_quotients_enclose() {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    for _ in 0..INPUTS {
        let ((a, off_a), (b, off_b), s) = (random(rng), random(rng), place(rng));
        let (x, y) = (value(&a.c, &s) + off_a, value(&b.c, &s) + off_b);
        encloses("sum", &(a + b), &s, &(&x + &y));
        encloses("difference", &(a - b), &s, &(&x - &y));
        encloses("product", &(a * b), &s, &(&x * &y));
        let by = rng.random_range(0.1..9.0);
        encloses("quotient", &a.over(by), &s, &(&x / exact(by)));
        encloses("multiple", &a.scaled(by), &s, &(&x * exact(by)));
        assert!(exact(a.most()) >= x.abs());
    }
}

/// The sine and the cosine by their series about zero, to 1e-40 for numbers up to 5.
fn sin_cos(x: &BigRational) -> [BigRational; 2] {
    let mut found = [BigRational::zero(), BigRational::zero()];
    let mut term = BigRational::one();
    for k in 1..70_i64 {
        let (of, negative) = ((k as usize) % 2, (k - 1) % 4 >= 2);
        found[of] += if negative { -term.clone() } else { term.clone() };
        term = term * x / BigRational::from_i64(k).expect("it is small");
        // Shortened to 50 digits.
        let digits = BigInt::from(10).pow(50);
        term = BigRational::new((term * BigRational::from(digits.clone())).round().to_integer(), digits);
    }
    let [sin, cos] = found;
    [sin, cos]
}

/// With as many coefficients as the series have terms, of a linear function, the remainder is not lost beside the terms
/// beyond the degree.
#[test]
fn sines_and_cosines_enclose() {
    let rng = &mut ChaCha8Rng::seed_from_u64(2);
    for _ in 0..INPUTS / 2 {
        let mut a = Enclosure::<20>::new(rng.random_range(-3.0..3.0));
        a.c[1] = [0.999, -0.999, 1e-3][rng.random_range(0..3)];
        a.r = [0.0, 0.0, 1e-4][rng.random_range(0..3)];
        let s = place(rng);
        let (sin, cos) = a.sin_cos();
        let [odd, even] = sin_cos(&(value(&a.c, &s) + exact(a.r)));
        encloses("cosine", &cos, &s, &even);
        encloses("sine", &sin, &s, &odd);
    }
}

/// Compared by squares: a root is enclosed if the square of the number less the radius is at most the exact value.
#[test]
fn inverse_roots_enclose() {
    let rng = &mut ChaCha8Rng::seed_from_u64(3);
    for _ in 0..INPUTS {
        let ((mut a, off), s) = (random(rng), place(rng));
        let size: f64 = a.c[1..].iter().map(|c| c.abs()).sum::<f64>() + a.r;
        a.c[0] = size * [1.02, 1.2, 5.0, 1e6][rng.random_range(0..4)] + 1e-3;
        let found = a.inverse_sqrt();
        if found.r.is_infinite() {
            continue;
        }
        let inverse = BigRational::one() / (value(&a.c, &s) + off);
        let [lower, upper] = [-1.0, 1.0].map(|sign| value(&found.c, &s) + exact(found.r) * exact(sign));
        let is_below = lower.is_negative() || &lower * &lower <= inverse;
        assert!(is_below && &upper * &upper >= inverse, "{a:?} at {s}: {found:?}");
    }
}

#[test]
fn least_values_are_bounds() {
    let rng = &mut ChaCha8Rng::seed_from_u64(4);
    for n in [3, 9, 16] {
        let basis = Bernstein::new(n);
        for _ in 0..INPUTS {
            let mut c: Vec<f64> = (0..=n).map(|_| rng.random_range(-1.0..1.0)).collect();
            // Nearly a root at an end, where rounding counts.
            let sum: f64 = c.iter().sum();
            c[0] -= sum;
            let r = [0.0, 0.0, 1e-3][rng.random_range(0..3)];
            let enough = [f64::INFINITY, -0.5][rng.random_range(0..2)];
            let least = basis.least(&c, r, enough, 1e-12);
            for s in [exact(1.0), exact(-1.0), place(rng), place(rng)] {
                let lowest = value(&c, &s) - exact(r);
                assert!(exact(least) <= lowest, "{c:?}: {least} at {s}");
            }
        }
    }
}
