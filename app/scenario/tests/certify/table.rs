//! Bounds on the difference between a table and a certified motion.

use crate::gantry::{FROM, TO, scenario};
use crate::{smooth, written};
use aghf::motion::sample;
use aghf_scenario::certify::{NAME, TableDifference, named_run, table_differences};
use aghf_scenario::judge::Trajectory;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;

const INTERVALS: usize = 20;

fn table() -> Trajectory {
    let scenario = scenario("table", json!({}));
    let samples = sample(&scenario.model, &smooth(), INTERVALS).expect("three joints");
    Trajectory::of_samples(samples)
}

fn differences(table: &Trajectory) -> Vec<TableDifference> {
    let scenario = scenario("table", json!({}));
    table_differences(&scenario, &written(&scenario, &smooth()), table).expect("it is of this robot")
}

/// The motion is of degree five, so that quintics have no error, and cubics one of $h^4 \max |q^{(4)}| / 384$, straight
/// lines one of $h^2 \max |\ddot q| / 8$.
#[test]
fn errors_of_interpolation_are_those_of_the_book() {
    let [line, cubic, quintic] = differences(&table())[..] else {
        panic!("there are three");
    };
    assert_eq!([line.degree, cubic.degree, quintic.degree], [1, 3, 5]);
    assert!(quintic.position < 1e-12 && quintic.velocity < 1e-9, "{quintic:?}");
    let way = FROM.iter().zip(TO).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max);
    let h = 1.0 / INTERVALS as f64;
    // Of 10 t^3 - 15 t^4 + 6 t^5: the fourth derivative at an end, the second one at 0.2113.
    for (found, most) in
        [(cubic.position, h.powi(4) / 384.0 * 360.0 * way), (line.position, h.powi(2) / 8.0 * 5.7735 * way)]
    {
        assert!(found < most && found > 0.8 * most, "{found} of {most}");
    }
}

/// A sample that is moved is seen, whatever is between the samples.
#[test]
fn moved_samples_are_seen() {
    let rng = &mut ChaCha8Rng::seed_from_u64(5);
    let exact = differences(&table());
    for _ in 0..50 {
        let mut table = table();
        let by = 10.0_f64.powf(rng.random_range(-6.0..1.0));
        table.q[rng.random_range(0..=INTERVALS)][rng.random_range(0..3)] += by;
        for (found, exact) in differences(&table).iter().zip(&exact) {
            assert!(found.position >= by - exact.position - 1e-12, "{found:?} by {by}");
            assert!(found.position <= 1.1 * by + exact.position, "{found:?} by {by}");
        }
    }
    let mut longer = table();
    longer.times[INTERVALS] += 1e-6;
    let scenario = scenario("table", json!({}));
    let found = table_differences(&scenario, &written(&scenario, &smooth()), &longer);
    assert!(found.is_err_and(|error| error.to_string().contains("the motion 1 s")));
}

#[test]
fn tables_name_their_run() {
    let hash = "ab".repeat(32);
    assert_eq!(named_run(&format!("# {NAME}{hash}\nt,q\n")), Some(hash.as_str()));
    assert_eq!(named_run(&format!("# {NAME}xyz\nt,q\n")), None);
    assert_eq!(named_run("t,q\n"), None);
}
