//! The named contractions of tensors.

use aghf::linalg::{Tensor3, Tensor4};
use nalgebra::{DMatrix, DVector};

fn tensor(n: usize, entry: impl Fn(usize, usize, usize) -> f64) -> Tensor3<f64> {
    let mut t = Tensor3::new(n);
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                t[(i, j, k)] = entry(i, j, k);
            }
        }
    }
    t
}

/// Every contraction against its sum, on a tensor without any symmetry.
#[test]
fn contractions_are_the_sums_that_they_say() {
    let n = 3;
    let number = |i: usize| ((i as f64 + 1.0) * 0.77).sin();
    let index = |i: usize, j: usize, k: usize| ((i * n + j) * n + k) * n;
    let a = &tensor(n, |i, j, k| number(index(i, j, k)));
    let mut b = Tensor4::new(n);
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                for l in 0..n {
                    b[(i, j, k, l)] = number(100 + index(i, j, k) + l);
                }
            }
        }
    }
    let w = DVector::from_vec(vec![0.3, -1.1, 2.0]);
    let u = DVector::from_vec(vec![0.9, 0.4, -0.6]);
    let m = DMatrix::from_fn(n, n, |i, j| number(200 + i + 7 * j));
    let sum = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>();
    let matrix = |f: &dyn Fn(usize, usize) -> f64| DMatrix::from_fn(n, n, f);
    let same = |x: &DMatrix<f64>, y: &DMatrix<f64>| assert_close!(x, y, 1e-15);
    same(&a.times_first(&w), &matrix(&|j, k| sum(&|i| a[(i, j, k)] * w[i])));
    same(&a.times_second(&w), &matrix(&|i, k| sum(&|j| a[(i, j, k)] * w[j])));
    same(&a.times_third(&w), &matrix(&|i, j| sum(&|k| a[(i, j, k)] * w[k])));
    same(&b.times_first_and_second(&u, &w), &matrix(&|k, l| sum(&|i| sum(&|j| b[(i, j, k, l)] * u[i] * w[j]))));
    let same = |x: &Tensor3<f64>, y: &Tensor3<f64>| assert_close!(x.entries(), y.entries(), 1e-15);
    same(&a.map_first(&m), &tensor(n, |i, j, k| sum(&|l| m[(i, l)] * a[(l, j, k)])));
    same(&a.map_second(&m), &tensor(n, |i, j, k| sum(&|l| a[(i, l, k)] * m[(l, j)])));
    same(&a.swap_last(), &tensor(n, |i, j, k| a[(i, k, j)]));
    let mut fourth = Tensor3::new(n);
    b.times_fourth(w.as_slice(), &mut fourth);
    same(&fourth, &tensor(n, |i, j, k| sum(&|l| b[(i, j, k, l)] * w[l])));
    same(&(a.clone() + &fourth), &tensor(n, |i, j, k| a[(i, j, k)] + fourth[(i, j, k)]));
}
