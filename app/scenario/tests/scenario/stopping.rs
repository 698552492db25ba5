//! Velocities at the ends with which no motion stays within the limits are refused before any search.

use crate::preflight::{entry, kinova, refusal};
use crate::written::with;
use serde_json::json;

/// Velocities outwards at a limit, or that need more than what is left to stop, are refused at both ends; the same
/// velocities inwards are not.
#[test]
fn velocities_that_no_motion_can_stop_are_refused() {
    for (end, sign) in [("start", 1.0), ("goal", -1.0)] {
        let [q, v] = ["q", "v"].map(|of| format!("{of}_{end}"));
        let moving =
            |at: f64, speed: f64| with(kinova(), json!({ q.clone(): entry(1, at), v.clone(): entry(1, sign * speed) }));
        let braked = |at, speed| with(moving(at, speed), json!({ "enforced_limits": { "acceleration": 2.0 } }));
        let refused = refusal(&moving(2.25, 0.1)).expect("it is at the limit");
        assert!(refused.contains(&format!("{v}: joint 'joint_2' at 2.25 rad")), "{refused}");
        assert_eq!(refusal(&moving(2.25, -0.1)), None);
        assert_eq!(refusal(&moving(2.2, 0.5)), None);
        assert_eq!(refusal(&moving(-2.2, -0.5)), None);
        let refused = refusal(&braked(2.2, 0.5)).expect("it needs 0.0625 rad");
        assert!(refused.contains("it needs 0.0625 rad at its enforced acceleration limit, 0.0500 rad"), "{refused}");
        assert!(refusal(&braked(-2.2, -0.5)).is_some());
        assert_eq!(refusal(&braked(2.2, 0.4)), None);
    }
}
