//! Lines for the stages of a search, for output without a terminal.

use super::tell;
use aghf::direct::Iteration;
use aghf_scenario::Record;

/// Prints the stages of a search to the standard error.
#[derive(Default)]
pub(super) struct Stages {
    /// The last iteration of the current stage, and the number of its iterations.
    current: Option<(Iteration, usize)>,
}

impl Stages {
    /// Updates the stages with a record. A stage of the direct method is one start at one degree; one of the flow is a
    /// value of `s`.
    pub fn observe(&mut self, record: &Record) {
        let iteration = match record {
            Record::Flow(r) => {
                tell(&format!("s {:.2e}: action at the nodes {:.6e}", r.s, r.action_at_nodes));
                return;
            }
            Record::Rest(r) => {
                tell(&format!(
                    "{} segments of degree {}, s {:.2e}: action {:.6e}, gradient norm {:.1e}",
                    r.segments, r.degree, r.s, r.action, r.gradient_norm
                ));
                return;
            }
            Record::Direct(iteration) => iteration,
        };
        let key = |i: &Iteration| (i.start, i.horizon, i.segments, i.degree);
        match &mut self.current {
            Some((last, count)) if key(last) == key(iteration) => {
                *last = *iteration;
                *count += 1;
            }
            _ => {
                self.finish();
                self.current = Some((*iteration, 1));
            }
        }
    }

    /// Prints the last stage.
    pub fn finish(&mut self) {
        let Some((last, count)) = self.current.take() else {
            return;
        };
        let of =
            last.start.map_or_else(|| format!("horizon {:.4} s", last.horizon), |start| format!("start {}", start + 1));
        let Iteration { segments, degree, cost, gradient_norm, .. } = last;
        let segments = if segments == 1 { String::new() } else { format!("{segments} segments of ") };
        tell(&format!(
            "{of}, {segments}degree {degree}: {count} steps, cost {cost:.6e}, gradient norm {gradient_norm:.1e}"
        ));
    }
}
