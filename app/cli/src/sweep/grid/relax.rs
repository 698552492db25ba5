//! The grid of the relaxation: its options, its running costs and its limits.

use super::{Refusal, check_optional, length, not_positive, optional};
use aghf::error::{Error, plain};
use aghf::relax::{PlannedStarts, RelaxSettings};
use aghf_scenario::{Enforced, Method, PerJoint, RunningCostWeights, Scenario, SolveOptions};
use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Lists of options of the relaxation, of running costs and of limits. A missing list means the default of the method
/// or the value of the scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RelaxGrid {
    /// Degrees of the polynomial, or of each segment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<Vec<usize>>,
    /// Numbers of polynomial segments of the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segments: Option<Vec<usize>>,
    /// Numbers of starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<Vec<usize>>,
    /// Relative gradient norms at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Vec<f64>>,
    /// Seeds of the starts. They count as repetitions, which a ranking combines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<Vec<u64>>,
    /// The starts that follow planned paths around obstacles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planned_starts: Option<Vec<PlannedStarts>>,
    /// Weights of the running cost, each the same for all joints.
    pub running_cost: CostLists,
    /// The enforced limits, each for all joints.
    pub enforced_limits: LimitLists,
}

/// Lists of weights of the running cost. A weight without a list is that of the scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CostLists {
    /// Weights of squared torques or forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<Vec<f64>>,
    /// Weights of squared velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Weights of squared accelerations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<Vec<f64>>,
}

/// Lists of enforced limits: `true`, `false` or a share of them. Limits without a list are those of the scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LimitLists {
    /// Limits on positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<Vec<Enforced>>,
    /// Limits on velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Enforced>>,
    /// Limits on torques and forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<Vec<Enforced>>,
}

/// One set of options of the relaxation; `None` is the default of the method, or the value of the scenario. The columns
/// of results have the names of its fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub struct RelaxPoint {
    /// Degree of the polynomial, or of each segment.
    pub degree: Option<usize>,
    /// The number of polynomials.
    pub segments: Option<usize>,
    /// The number of starts.
    pub starts: Option<usize>,
    /// The relative gradient norm at the end.
    pub tolerance: Option<f64>,
    /// The seed of the starts.
    pub seed: Option<u64>,
    /// The starts that follow planned paths around obstacles.
    pub planned_starts: Option<PlannedStarts>,
    /// The weight of squared torques or forces.
    pub cost_torque: Option<f64>,
    /// The weight of squared velocities.
    pub cost_velocity: Option<f64>,
    /// The weight of squared accelerations.
    pub cost_acceleration: Option<f64>,
    /// The enforced share of the limits on positions, 0 for none.
    pub limit_position: Option<f64>,
    /// The enforced share of the limits on velocities, 0 for none.
    pub limit_velocity: Option<f64>,
    /// The enforced share of the limits on torques and forces, 0 for none.
    pub limit_torque: Option<f64>,
}

impl RelaxGrid {
    /// The names of its lists and groups of lists.
    pub(super) const KEYS: [&str; 8] = [
        "degree",
        "segments",
        "starts",
        "tolerance",
        "seed",
        "planned_starts",
        "running_cost",
        "enforced_limits",
    ];

    pub(super) fn check(&self) -> Result<(), Refusal> {
        check_optional("degree", &self.degree, |_| None)?;
        check_optional("segments", &self.segments, |_| None)?;
        self.check_sizes()?;
        let most = RelaxSettings::LARGEST_NUM_STARTS;
        check_optional("starts", &self.starts, |n| {
            let good = (1..=most).contains(n);
            (!good).then(|| format!("it is {n}, at least 1 and at most {most} is needed"))
        })?;
        check_optional("tolerance", &self.tolerance, not_positive)?;
        check_optional("seed", &self.seed, |_| None)?;
        check_optional("planned_starts", &self.planned_starts, |_| None)?;
        let cost = &self.running_cost;
        for (key, list) in [
            ("torque", &cost.torque),
            ("velocity", &cost.velocity),
            ("acceleration", &cost.acceleration),
        ] {
            check_optional(&format!("running_cost.{key}"), list, |w| {
                let good = w.is_finite() && *w >= 0.0;
                (!good).then(|| format!("it is {}, a weight is not negative", plain(*w)))
            })?;
        }
        let limits = &self.enforced_limits;
        for (key, list) in [
            ("position", &limits.position),
            ("velocity", &limits.velocity),
            ("torque", &limits.torque),
        ] {
            check_optional(&format!("enforced_limits.{key}"), list, not_a_share)?;
        }
        Ok(())
    }

    /// Refuses degrees and numbers of segments that are invalid, alone or in combination.
    fn check_sizes(&self) -> Result<(), Refusal> {
        let usual = RelaxSettings::default();
        let degrees = self.degree.clone().unwrap_or(vec![usual.degree]);
        let segments = self.segments.clone().unwrap_or(vec![usual.segments]);
        for (i, degree) in degrees.iter().enumerate() {
            for (j, segments) in segments.iter().enumerate() {
                RelaxSettings::check_size(*degree, *segments).map_err(|e| match e {
                    Error::Input {
                        element, condition, ..
                    } => {
                        let place = if element == "degree" { i } else { j };
                        (format!("{element}[{place}]"), condition)
                    }
                    other => ("sweep".to_owned(), other.to_string()),
                })?;
            }
        }
        Ok(())
    }

    /// Refuses weights that are all zero together with those of the scenario.
    pub(super) fn check_for(&self, scenario: &Scenario) -> Result<(), String> {
        let alone = Self {
            running_cost: self.running_cost.clone(),
            ..Self::default()
        };
        let count: usize = alone.lengths().into_iter().product();
        for point in (0..count).map(|i| alone.point(i)) {
            if let Some(weights) = &point.over(scenario).file.running_cost {
                let weighted = weights.weighted(scenario.model.dof());
                let name = &scenario.name;
                weighted.map_err(|e| format!("running_cost of '{name}': {e}"))?;
            }
        }
        Ok(())
    }

    pub(super) fn lengths(&self) -> Vec<usize> {
        let (cost, limits) = (&self.running_cost, &self.enforced_limits);
        vec![
            length(&limits.torque),
            length(&limits.velocity),
            length(&limits.position),
            length(&cost.acceleration),
            length(&cost.velocity),
            length(&cost.torque),
            length(&self.planned_starts),
            length(&self.tolerance),
            length(&self.starts),
            length(&self.segments),
            length(&self.degree),
            length(&self.seed),
        ]
    }

    pub(super) fn point(&self, mut index: usize) -> RelaxPoint {
        // From the list that runs fastest. Seeds run slowest, so that all rows of one stand together.
        let (index, cost, limits) = (&mut index, &self.running_cost, &self.enforced_limits);
        let share = |list: &Option<Vec<Enforced>>, index: &mut usize| {
            let shares: Option<Vec<f64>> = list.as_ref().map(|l| l.iter().map(share).collect());
            optional(&shares, index)
        };
        let limit_torque = share(&limits.torque, index);
        let limit_velocity = share(&limits.velocity, index);
        let limit_position = share(&limits.position, index);
        let cost_acceleration = optional(&cost.acceleration, index);
        let cost_velocity = optional(&cost.velocity, index);
        let cost_torque = optional(&cost.torque, index);
        let planned_starts = optional(&self.planned_starts, index);
        let tolerance = optional(&self.tolerance, index);
        let starts = optional(&self.starts, index);
        let segments = optional(&self.segments, index);
        let degree = optional(&self.degree, index);
        let seed = optional(&self.seed, index);
        RelaxPoint {
            degree,
            segments,
            starts,
            tolerance,
            seed,
            planned_starts,
            cost_torque,
            cost_velocity,
            cost_acceleration,
            limit_position,
            limit_velocity,
            limit_torque,
        }
    }
}

/// The enforced share of limits, 0 for none.
fn share(enforced: &Enforced) -> f64 {
    match enforced {
        Enforced::No => 0.0,
        Enforced::Share { share, .. } => *share,
    }
}

/// The fault of limits in a list, if they have one.
fn not_a_share(enforced: &Enforced) -> Option<String> {
    match enforced {
        Enforced::Share {
            joints: Some(_), ..
        } => Some(
            "a sweep enforces limits of all joints or of none; a scenario can name joints".into(),
        ),
        Enforced::Share { share, .. } if !(*share > 0.0 && *share <= 1.0) => {
            Some(format!("it is {share}, a share is above 0 and at most 1"))
        }
        _ => None,
    }
}

impl RelaxPoint {
    pub(super) fn options(&self) -> SolveOptions {
        SolveOptions {
            method: Method::Relax,
            degree: self.degree,
            segments: self.segments,
            num_starts: self.starts,
            tolerance: self.tolerance,
            seed: self.seed,
            planned_starts: self.planned_starts,
            // The sets of a sweep share the cores.
            threads: Some(1),
            ..SolveOptions::default()
        }
    }

    /// Applies the running cost and the limits to `scenario`.
    pub(super) fn over<'s>(&self, scenario: &'s Scenario) -> Cow<'s, Scenario> {
        let weights = [self.cost_torque, self.cost_velocity, self.cost_acceleration];
        let shares = [self.limit_position, self.limit_velocity, self.limit_torque];
        if weights.iter().chain(&shares).all(Option::is_none) {
            return Cow::Borrowed(scenario);
        }
        let mut own = scenario.clone();
        let file = &mut own.file;
        if weights.iter().any(Option::is_some) {
            let cost: &mut RunningCostWeights = file.running_cost.get_or_insert_default();
            let of = [&mut cost.torque, &mut cost.velocity, &mut cost.acceleration];
            for (own, weight) in of.into_iter().zip(weights) {
                if let Some(weight) = weight {
                    *own = PerJoint::Same(weight);
                }
            }
        }
        let limits = &mut file.enforced_limits;
        let of = [
            &mut limits.position,
            &mut limits.velocity,
            &mut limits.torque,
        ];
        for (own, share) in of.into_iter().zip(shares) {
            match share {
                None => (),
                Some(0.0) => *own = Enforced::No,
                Some(share) => {
                    let joints = None;
                    *own = Enforced::Share { share, joints };
                }
            }
        }
        Cow::Owned(own)
    }

    pub(super) fn columns<S: SerializeStruct>(&self, row: &mut S) -> Result<(), S::Error> {
        row.serialize_field("degree", &self.degree)?;
        row.serialize_field("segments", &self.segments)?;
        row.serialize_field("starts", &self.starts)?;
        row.serialize_field("tolerance", &self.tolerance)?;
        row.serialize_field("seed", &self.seed)?;
        row.serialize_field("planned_starts", &self.planned_starts)?;
        row.serialize_field("cost_torque", &self.cost_torque)?;
        row.serialize_field("cost_velocity", &self.cost_velocity)?;
        row.serialize_field("cost_acceleration", &self.cost_acceleration)?;
        row.serialize_field("limit_position", &self.limit_position)?;
        row.serialize_field("limit_velocity", &self.limit_velocity)?;
        row.serialize_field("limit_torque", &self.limit_torque)
    }

    /// Names and values of the parameters for which the grid has a list.
    pub(super) fn cells(&self) -> Vec<(&'static str, String)> {
        let number = |x: Option<f64>| x.map(|x| x.to_string());
        let count = |x: Option<usize>| x.map(|x| x.to_string());
        let all = [
            ("degree", count(self.degree)),
            ("segments", count(self.segments)),
            ("starts", count(self.starts)),
            ("tolerance", self.tolerance.map(|x| format!("{x:e}"))),
            (
                "planned_starts",
                self.planned_starts.map(|starts| starts.to_string()),
            ),
            ("cost_torque", number(self.cost_torque)),
            ("cost_velocity", number(self.cost_velocity)),
            ("cost_acceleration", number(self.cost_acceleration)),
            ("limit_position", number(self.limit_position)),
            ("limit_velocity", number(self.limit_velocity)),
            ("limit_torque", number(self.limit_torque)),
        ];
        let given = all.into_iter().filter_map(|(name, x)| Some((name, x?)));
        given.collect()
    }
}
