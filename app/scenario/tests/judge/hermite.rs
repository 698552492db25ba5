//! Bounds of the motion between two samples.

use aghf_scenario::judge::Hermite;
use proptest::array::uniform2;
use proptest::option::of;

proptest::proptest! {
    #![proptest_config(crate::common::config(256))]

    /// The polynomial has the positions, velocities and given accelerations of both samples, and its values on a part
    /// are within its Bernstein coefficients and its way from the middle.
    #[test]
    fn values_are_within_their_bounds(
        q in uniform2(-2.0..2.0f64), v in uniform2(-8.0..8.0f64), a in uniform2(of(-20.0..20.0f64)),
        interval in 0.01..2.0f64, part in uniform2(0.0..1.0f64),
    ) {
        let motion = Hermite::new(q, v, a, interval);
        let size = 60.0 * (4.0 + 16.0 * interval + 40.0 * interval * interval);
        for (end, s) in [0.0, 1.0].into_iter().enumerate() {
            let given = [Some(q[end]), Some(v[end]), a[end]];
            for (order, given) in given.into_iter().enumerate() {
                let off = given.map_or(0.0, |given| (motion.at(order, s) - given).abs());
                proptest::prop_assert!(off <= 1e-14 * size / interval.powi(order as i32), "{order}: {off}");
            }
        }
        let part = [part[0].min(part[1]), part[0].max(part[1])];
        let middle = motion.at(0, 0.5 * (part[0] + part[1]));
        for order in 0..=3 {
            let [[least, most], ends] = motion.bounds(order, part);
            let rounding = 1e-13 * size / interval.powi(order as i32);
            for (end, s) in ends.into_iter().zip(part) {
                proptest::prop_assert!((motion.at(order, s) - end).abs() <= rounding);
            }
            for k in 0..=200 {
                let s = part[0] + (part[1] - part[0]) * f64::from(k) / 200.0;
                let value = motion.at(order, s);
                proptest::prop_assert!(value >= least - rounding && value <= most + rounding, "{order}");
                let step = 1e-4;
                let rate = (motion.at(order, s + step) - motion.at(order, s - step)) / (2.0 * step * interval);
                // The error of a central difference is a sixth of the square of the step of the next derivatives.
                let error = 1e-5 * size * 60.0 / interval.powi(order as i32 + 1);
                proptest::prop_assert!(order == 3 || (motion.at(order + 1, s) - rate).abs() <= error, "{order}");
            }
        }
        let way = motion.way_from_middle(part);
        for k in 0..=200 {
            let s = part[0] + (part[1] - part[0]) * f64::from(k) / 200.0;
            proptest::prop_assert!((motion.at(0, s) - middle).abs() <= way + 1e-13 * size);
        }
    }

    /// Without accelerations the degree is three, and with one of them four.
    #[test]
    fn the_degree_is_the_least(
        q in uniform2(-2.0..2.0f64), v in uniform2(-2.0..2.0f64), a in -5.0..5.0f64,
    ) {
        // A difference of order n + 1 of a polynomial of degree n vanishes.
        for (given, weights) in [
            ([None, None], &[1.0, -4.0, 6.0, -4.0, 1.0][..]),
            ([Some(a), None], &[1.0, -5.0, 10.0, -10.0, 5.0, -1.0]),
            ([None, Some(a)], &[1.0, -5.0, 10.0, -10.0, 5.0, -1.0]),
        ] {
            let motion = Hermite::new(q, v, given, 1.0);
            let values = weights.iter().enumerate().map(|(k, w)| w * motion.at(0, 0.2 * k as f64));
            proptest::prop_assert!(values.sum::<f64>().abs() < 1e-12);
        }
    }
}
