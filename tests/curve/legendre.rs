//! The quadratures of Gauss.

use aghf::curve::{gauss_legendre, gauss_lobatto};

#[test]
fn gauss_legendre_is_exact_to_its_degree() {
    for m in [1, 2, 5, 16, 97] {
        let (nodes, weights) = gauss_legendre(m);
        assert!(nodes.windows(2).all(|w| w[0] < w[1]) && weights.iter().all(|w| *w > 0.0));
        for power in [0, 1, m, 2 * m - 2, 2 * m - 1] {
            let integral: f64 = nodes.iter().zip(&weights).map(|(x, w)| w * x.powi(power as i32)).sum();
            let exact = if power % 2 == 0 { 2.0 / (power as f64 + 1.0) } else { 0.0 };
            assert!((integral - exact).abs() < 1e-14 * m as f64, "{m} {power}: {integral} {exact}");
        }
    }
}

/// With both ends among the nodes, two degrees less.
#[test]
fn gauss_lobatto_is_exact_to_its_degree() {
    for m in [2, 3, 5, 16, 97] {
        let (nodes, weights) = gauss_lobatto(m);
        assert_eq!((nodes[0], nodes[m - 1]), (-1.0, 1.0));
        assert!(nodes.windows(2).all(|w| w[0] < w[1]) && weights.iter().all(|w| *w > 0.0));
        for power in [0, 1, m.min(2 * m - 3), 2 * m - 4, 2 * m - 3] {
            let terms = nodes.iter().zip(&weights);
            let integral: f64 = terms.map(|(x, w)| w * x.powi(power as i32)).sum();
            let even = f64::from(u8::from(power % 2 == 0));
            let exact = even * 2.0 / (power as f64 + 1.0);
            assert!((integral - exact).abs() < 1e-14 * m as f64, "{m} {power}: {integral} {exact}");
        }
    }
}
