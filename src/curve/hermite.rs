//! Hermite polynomials on an interval, and slopes of Legendre polynomials.

/// The Hermite polynomial number `index` of `2 k` on `[-1, 1]`: first those with one unit derivative at -1, from the
/// highest, `k - 1`, to the value, then those at 1. Returns the number of the unit derivative, and value and first
/// three derivatives at `s`.
pub(crate) fn hermite(k: usize, index: usize, s: f64) -> (usize, [f64; 4]) {
    let (s2, s3, s4, s5) = (s * s, s * s * s, s * s * s * s, s * s * s * s * s);
    let derivative = k - 1 - index % k;
    let quarter = |x: [f64; 4]| x.map(|x| 0.25 * x);
    let sixteenth = |x: [f64; 4]| x.map(|x| x / 16.0);
    // Those at 1 are those at -1 mirrored.
    let end = if index < k { 1.0 } else { -1.0 };
    let values = match (k, derivative) {
        (1, _) => [0.5 - 0.5 * end * s, -0.5 * end, 0.0, 0.0],
        (2, 1) => quarter([end - s - end * s2 + s3, -1.0 - end * 2.0 * s + 3.0 * s2, -end * 2.0 + 6.0 * s, 6.0]),
        (2, _) => quarter([2.0 - end * 3.0 * s + end * s3, -end * 3.0 + end * 3.0 * s2, end * 6.0 * s, end * 6.0]),
        (_, 2) => sixteenth([
            1.0 - end * s - 2.0 * s2 + end * 2.0 * s3 + s4 - end * s5,
            -end - 4.0 * s + end * 6.0 * s2 + 4.0 * s3 - end * 5.0 * s4,
            -4.0 + end * 12.0 * s + 12.0 * s2 - end * 20.0 * s3,
            end * 12.0 + 24.0 * s - end * 60.0 * s2,
        ]),
        (_, 1) => sixteenth([
            end * 5.0 - 7.0 * s - end * 6.0 * s2 + 10.0 * s3 + end * s4 - 3.0 * s5,
            -7.0 - end * 12.0 * s + 30.0 * s2 + end * 4.0 * s3 - 15.0 * s4,
            -end * 12.0 + 60.0 * s + end * 12.0 * s2 - 60.0 * s3,
            60.0 + end * 24.0 * s - 180.0 * s2,
        ]),
        (_, _) => sixteenth([
            8.0 - end * 15.0 * s + end * 10.0 * s3 - end * 3.0 * s5,
            end * (-15.0 + 30.0 * s2 - 15.0 * s4),
            end * (60.0 * s - 60.0 * s3),
            end * (60.0 - 180.0 * s2),
        ]),
    };
    (derivative, values)
}

/// The slope of the Legendre polynomial $P_j$ from the values `p` of those before it:
/// $P_j' = (2 j - 1) P_{j-1} + (2 j - 5) P_{j-3} + \ldots$
pub(crate) fn legendre_slope(p: &[f64], j: usize) -> f64 {
    let below = (0..j).rev().step_by(2);
    below.map(|i| (2 * i + 1) as f64 * p[i]).sum()
}
