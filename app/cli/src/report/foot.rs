//! The sole of a standing foot, and the force of the ground on it over time.

use super::encode::of_f32;
use super::plots::{Axes, Line, Plot, colours, css, plot};
use super::scene::pose;
use aghf::constraint::FootContact;
use aghf::direct::DirectSettings;
use aghf::error::Result;
use aghf::motion::Sample;
use aghf_scenario::Scenario;
use nalgebra::Vector3;
use serde::Serialize;

/// A foot in the picture and in the plots.
#[derive(Serialize)]
pub(super) struct Foot {
    /// Position, m, and orientation `x y z w` of the sole in the base frame.
    pose: [f64; 7],
    /// Half of its length and width, m.
    size: [f64; 2],
    /// The weight of the robot, N.
    weight: f64,
    /// The centres of pressure in the base frame, three numbers per time, m.
    points: String,
    /// The forces in the base frame, three numbers per time, N.
    forces: String,
    /// True at each time at which the foot holds, to within the tolerance of a verdict.
    holds: Vec<bool>,
    /// The coefficient of friction.
    #[serde(skip)]
    friction: f64,
    #[serde(skip)]
    contacts: Vec<FootContact>,
}

impl Foot {
    /// The standing foot of a scenario in these states; `None` without one.
    pub fn new(scenario: &Scenario, rows: &[Sample]) -> Result<Option<Self>> {
        let Some(foot) = scenario.foot() else {
            return Ok(None);
        };
        let contacts = (rows.iter())
            .filter_map(|row| scenario.contact([&row.q, &row.v, &row.a]).transpose())
            .collect::<Result<Vec<_>>>()?;
        let point = |contact: &FootContact| {
            let [along, across] = contact.centre_of_pressure;
            foot.sole.rotation * Vector3::new(along, across, 0.0) + foot.sole.translation
        };
        let force = |contact: &FootContact| foot.sole.rotation * Vector3::from(contact.force);
        let numbers =
            |of: &dyn Fn(&FootContact) -> Vector3<f64>| of_f32(contacts.iter().flat_map(|c| <[f64; 3]>::from(of(c))));
        let holds = |c: &FootContact| c.excess <= DirectSettings::FEASIBLE;
        Ok(Some(Self {
            pose: pose(&foot.sole),
            size: [foot.half_length, foot.half_width],
            weight: foot.weight,
            points: numbers(&point),
            forces: numbers(&force),
            holds: contacts.iter().map(holds).collect(),
            friction: foot.friction,
            contacts,
        }))
    }

    /// Plots of the centre of pressure and of the friction in these states, with strips beyond their bounds.
    pub fn plots(&self, rows: &[Sample]) -> Result<[Plot; 2]> {
        let colours = colours(2);
        let line = |value: &dyn Fn(&FootContact) -> f64, colour, bounds| {
            let points = rows.iter().zip(&self.contacts);
            Line { points: points.map(|(row, c)| (row.t, value(c))).collect(), colour, bounds }
        };
        let pressure = [0, 1].map(|axis| {
            let half = self.size[axis];
            line(&|c| c.centre_of_pressure[axis], colours[axis], -half..half)
        });
        let friction = line(&|c| c.friction, colours[0], f64::NEG_INFINITY..self.friction);
        let names = ["along", "across"].iter().zip(&colours);
        let legend = names.map(|(name, colour)| [(*name).to_owned(), css(*colour)]);
        let axes = |title: &str, unit, legend| Axes {
            title: title.to_owned(),
            unit,
            time: true,
            logarithmic: false,
            per_joint: false,
            legend,
        };
        Ok([
            plot(axes("Centre of pressure", "m", legend.collect()), &pressure)?,
            plot(axes("Friction", "", Vec::new()), &[friction])?,
        ])
    }
}
