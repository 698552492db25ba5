//! The systems of the paper's experiments.

use aghf_scenario::{FlowParameters, builtin_scenarios, generated_scenarios};

/// A system of the paper's experiments, or a family of harder scenarios, with the data of the supplement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct System {
    /// Its name in the report.
    pub title: &'static str,
    /// The prefix of the names of its scenarios, which are built in or generated.
    pub prefix: &'static str,
    /// The best set printed in the supplement, if there is one.
    pub paper: Option<PaperSet>,
}

impl System {
    /// The names of its scenarios.
    pub fn scenarios(self) -> impl Iterator<Item = String> {
        let builtin = builtin_scenarios().map(str::to_owned);
        let all = builtin.chain(generated_scenarios());
        all.filter(move |name| name.starts_with(self.prefix))
    }
}

/// A best set printed in the supplement, section C-C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSet {
    /// Degree of the polynomial.
    pub p: usize,
    /// Penalty of (11).
    pub k: f64,
    /// The value of `s` at which the flow stops.
    pub s_max: f64,
    /// Weight (A2) and sharpness (A3) of the constraints, for scenarios with obstacles.
    pub constraints: Option<(f64, f64)>,
}

impl PaperSet {
    /// This set, completed by `others`.
    #[must_use]
    pub fn over(self, others: FlowParameters) -> FlowParameters {
        let (k_cons, c_cons) = self.constraints.unwrap_or((others.k_cons, others.c_cons));
        FlowParameters {
            p: self.p,
            k: self.k,
            s_max: self.s_max,
            guess: others.guess,
            k_cons,
            c_cons,
        }
    }
}

/// The systems, in the order of the report.
pub const SYSTEMS: [System; 13] = [
    system("pendulum, 1 link", "pendulum_1_", None),
    system("pendulum, 2 links", "pendulum_2_", None),
    system("pendulum, 3 links", "pendulum_3_", None),
    system("pendulum, 4 links", "pendulum_4_", None),
    system("pendulum, 5 links", "pendulum_5_", None),
    system("Kinova", "kinova_free_", Some(set(9, 1e9, 0.1, None))),
    system("Digit", "digit_free_", Some(set(6, 1e7, 1.0, None))),
    system(
        "Kinova, obstacles",
        "kinova_obstacles_",
        Some(set(8, 1e9, 0.1, Some((1e9, 1.0)))),
    ),
    system(
        "Digit, obstacles",
        "digit_obstacles_",
        Some(set(6, 1e7, 1.0, Some((1e5, 200.0)))),
    ),
    system("Kinova, cross", "kinova_cross_", None),
    system("Kinova, gap", "kinova_gap_", None),
    system("Kinova, floor", "kinova_floor_", None),
    system("Digit, box", "digit_box_", None),
];

const fn system(title: &'static str, prefix: &'static str, paper: Option<PaperSet>) -> System {
    System {
        title,
        prefix,
        paper,
    }
}

const fn set(p: usize, k: f64, s_max: f64, constraints: Option<(f64, f64)>) -> PaperSet {
    PaperSet {
        p,
        k,
        s_max,
        constraints,
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
