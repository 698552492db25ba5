//! A standing foot: the judge's own sums against the wrench of the root.

use crate::robot::{FROM, TO, bounds, failed, good, scenario, verdict};
use aghf_scenario::Quantity;
use aghf_scenario::judge::Check;
use serde_json::{Value, json};

fn stand(keys: Value) -> Value {
    let mut stand = json!({ "frame": "rail", "half_length_m": 9.0, "half_width_m": 9.0, "friction": 9.0 });
    for (key, value) in keys.as_object().expect("an object") {
        stand[key] = value.clone();
    }
    json!({ "stand": stand })
}

/// The extremes over the samples of what the judge compares with each bound are those of the wrench of the root.
#[test]
fn the_force_of_the_ground_is_the_wrench_of_the_root() {
    let sole = json!({ "position_m": [0.1, -0.2, -0.5], "orientation_xyzw": [0.0, 0.0, 0.6, 0.8] });
    let plain = scenario("plain", stand(json!({ "sole": sole })));
    let motion = good(&plain.model, FROM, TO, 101);
    assert_eq!(failed(&verdict(&plain, &motion)), []);
    let [v, a] = [&motion.v, &motion.a].map(|of| of.as_ref().expect("it is given"));
    let contacts = (0..motion.times.len()).map(|k| {
        let z = [&motion.q[k][..], &v[k][..], &a[k][..]];
        plain.contact(z).expect("its joints").expect("it stands")
    });
    let contacts: Vec<_> = contacts.collect();
    let largest =
        |of: &dyn Fn(&aghf::constraint::FootContact) -> f64| contacts.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    for (key, place, largest) in [
        ("half_length_m", "centre of pressure along", largest(&|c| c.centre_of_pressure[0].abs())),
        ("half_width_m", "centre of pressure across", largest(&|c| c.centre_of_pressure[1].abs())),
        ("friction", "friction", largest(&|c| c.friction)),
        ("torsion", "torsion", largest(&|c| c.torsion.abs())),
    ] {
        // Half of the largest value is too little.
        let small = json!({ "sole": sole, key: 0.5 * largest });
        let tight = scenario(key, stand(small));
        let judgement = verdict(&tight, &motion);
        assert_eq!(failed(&judgement), [Check::Bounds(Quantity::Foot)]);
        let worst = bounds(&judgement, Quantity::Foot).worst.clone().expect("it was checked");
        assert_eq!(worst.place.as_deref(), Some(&*format!("{place} of foot 'rail'")));
        let off = (worst.value.abs() - largest).abs();
        assert!(off < 1e-3 * largest, "{key}: {} {largest}", worst.value);
    }
}
