//! Extrema of cubics.

use aghf_scenario::judge::Cubic;
use proptest::array::uniform2;

proptest::proptest! {
    #![proptest_config(crate::common::config(256))]

    /// The extrema of a cubic are at its ends, where it turns and where it is fastest, and its way from the middle of a
    /// part is bounded.
    #[test]
    fn cubics_stay_within_their_extrema(
        q in uniform2(-2.0..2.0f64), v in uniform2(-8.0..8.0f64), interval in 0.01..2.0f64,
        part in uniform2(0.0..1.0f64),
    ) {
        let cubic = Cubic::new(q, v, interval);
        for (end, s) in [0.0, 1.0].into_iter().enumerate() {
            proptest::prop_assert!((cubic.position(s) - q[end]).abs() < 1e-12);
            proptest::prop_assert!((cubic.velocity(s) - v[end]).abs() < 1e-10);
        }
        let range = |values: &[f64]| {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            [least, most]
        };
        let ends = [Some(0.0), Some(1.0)];
        let turns: Vec<f64> = ends.into_iter().chain(cubic.turns()).flatten().map(|s| cubic.position(s)).collect();
        let fastest = ends.into_iter().chain([cubic.fastest([0.0, 1.0])]).flatten();
        let fastest: Vec<f64> = fastest.map(|s| cubic.velocity(s)).collect();
        let [positions, velocities] = [range(&turns), range(&fastest)];
        let part = [part[0].min(part[1]), part[0].max(part[1])];
        let (middle, way) = (cubic.position(0.5 * (part[0] + part[1])), cubic.way_from_middle(part));
        for k in 0..=500 {
            let s = f64::from(k) / 500.0;
            let (position, velocity) = (cubic.position(s), cubic.velocity(s));
            proptest::prop_assert!(position >= positions[0] - 1e-9 && position <= positions[1] + 1e-9);
            proptest::prop_assert!(velocity >= velocities[0] - 1e-9 && velocity <= velocities[1] + 1e-9);
            let within = part[0] + (part[1] - part[0]) * s;
            proptest::prop_assert!((cubic.position(within) - middle).abs() <= way + 1e-12);
        }
        let rate = (cubic.velocity(0.501) - cubic.velocity(0.499)) / (0.002 * interval);
        proptest::prop_assert!((cubic.acceleration(0.5) - rate).abs() <= 1e-6 * (1.0 + rate.abs()));
    }
}
