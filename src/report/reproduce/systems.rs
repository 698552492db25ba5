//! What the paper's experiments are about. A line each.

use crate::scenario::FlowParameters;

/// A system of the paper's experiments and what the supplement says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct System {
    /// Its name in the report.
    pub title: &'static str,
    /// What the names of its scenarios, which are built in, begin with.
    pub prefix: &'static str,
    /// The best set that the supplement prints, if it does.
    pub paper: Option<PaperSet>,
}

/// A best set as the supplement prints it, section C-C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSet {
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// How far the flow runs.
    pub s_max: f64,
}

impl PaperSet {
    /// This set, and `others` for what the supplement does not print.
    #[must_use]
    pub fn over(self, others: FlowParameters) -> FlowParameters {
        FlowParameters {
            p: self.p,
            k: self.k,
            s_max: self.s_max,
            ..others
        }
    }
}

/// The systems, in the order of the report.
pub const SYSTEMS: [System; 7] = [
    system("pendulum, 1 link", "pendulum_1_", None),
    system("pendulum, 2 links", "pendulum_2_", None),
    system("pendulum, 3 links", "pendulum_3_", None),
    system("pendulum, 4 links", "pendulum_4_", None),
    system("pendulum, 5 links", "pendulum_5_", None),
    system("Kinova", "kinova_free_", Some((9, 1e9, 0.1))),
    system("Digit", "digit_free_", Some((6, 1e7, 1.0))),
];

const fn system(
    title: &'static str,
    prefix: &'static str,
    paper: Option<(usize, f64, f64)>,
) -> System {
    let paper = match paper {
        Some((p, k, s_max)) => Some(PaperSet { p, k, s_max }),
        None => None,
    };
    System {
        title,
        prefix,
        paper,
    }
}

/// The robots of Figures 4 and 5.
pub const SCALING_ROBOTS: [&str; 7] = [
    "pendulum_2",
    "pendulum_3",
    "pendulum_4",
    "pendulum_5",
    "pendulum_6",
    "kinova_gen3",
    "digit_v3_pinned",
];
