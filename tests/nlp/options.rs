//! Options out of range.

use crate::common::assert_refused;
use aghf::nlp::Options;

/// A change of the options.
type Change = fn(&mut Options);

#[test]
fn options_with_which_a_search_would_not_end_are_refused() {
    assert!(Options::default().check().is_ok());
    let cases: [(Change, &str); 10] = [
        (|o| o.tolerance = 0.0, "nlp: tolerance: it is 0"),
        (|o| o.last_barrier = f64::NAN, "last_barrier: it is NaN"),
        (|o| o.backtracking = 1.0, "backtracking: it is 1 and must be a number between 0 and 1"),
        (|o| o.fraction_to_boundary = 1.5, "fraction_to_boundary: it is 1.5"),
        (|o| o.penalty_factor = 1.0, "penalty_factor: it is 1 and must be more than 1"),
        (|o| o.regularisation_factors[1] = 0.5, "more than 1 for the second"),
        (|o| o.regularisation_factors[2] = 3.0, "between 0 and 1 for the third"),
        (|o| o.curvature_factors[0] = 1.5, "curvature_factors: it is 1.5"),
        (|o| o.curvature_factors[1] = 0.5, "more than 1 for the second"),
        (|o| o.min_curvature_weight = 2.0, "min_curvature_weight: it is 2"),
    ];
    for (change, words) in cases {
        let mut options = Options::default();
        change(&mut options);
        assert_refused(options.check(), words);
    }
}
