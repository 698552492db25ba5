//! Figures 4 and 5: the times of the right-hand side of the flow and of its Jacobian at one node, by the number of
//! joints.

use super::Settings;
use super::fit::{polynomial, power_law};
use super::systems::SCALING_ROBOTS;
use aghf::error::Result;
use aghf::flow::jacobian::{JacobianKind, NodeBlocks, NodeJacobian};
use aghf::flow::{AlgorithmB1, ControlForm, Node, RightHandSide};
use aghf::model::Model;
use aghf::urdf::load_robot;
use aghf::verify::duals::State;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// The penalty, which does not affect the times.
const K: f64 = 1e7;
/// The duration of the warm-up per robot and quantity.
const WARM_UP: Duration = Duration::from_millis(30);
/// The shortest time of a batch of calls, s: a thousand times the cost of reading the clock.
pub(super) const BATCH_SECONDS: f64 = 5e-5;
/// Batches per configuration. The fastest one counts, because other work of the machine only adds time.
pub(super) const BATCHES: usize = 5;

/// A timed quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// $\Omega$ by the control form, the default.
    OmegaControlForm,
    /// $\Omega$ by Algorithm B1, the paper's.
    OmegaAlgorithmB1,
    /// The Jacobian of the control form, the default.
    JacobianControlForm,
    /// The Jacobian by Theorem B4, the paper's.
    JacobianTheoremB4,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 4] = [
        Self::OmegaControlForm,
        Self::OmegaAlgorithmB1,
        Self::JacobianControlForm,
        Self::JacobianTheoremB4,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OmegaControlForm => "Omega, control form",
            Self::OmegaAlgorithmB1 => "Omega, Algorithm B1",
            Self::JacobianControlForm => "Jacobian, control form",
            Self::JacobianTheoremB4 => "Jacobian, Theorem B4",
        }
    }

    /// The figure of the supplement that shows the quantity.
    #[must_use]
    pub fn figure(self) -> usize {
        match self {
            Self::OmegaControlForm | Self::OmegaAlgorithmB1 => 4,
            Self::JacobianControlForm | Self::JacobianTheoremB4 => 5,
        }
    }

    /// The degree of the fitted polynomial, which is the paper's worst-case bound.
    #[must_use]
    pub fn degree(self) -> usize {
        self.figure() - 1
    }

    /// The growth with `N` stated in the supplement.
    #[must_use]
    pub fn paper(self) -> Option<&'static str> {
        match self {
            Self::OmegaAlgorithmB1 => Some("about N^2"),
            Self::JacobianTheoremB4 => Some("about N^3"),
            Self::OmegaControlForm | Self::JacobianControlForm => None,
        }
    }

    /// The times at all states.
    fn times(self, model: &Model, states: &[State]) -> Result<Times> {
        let mut omega = vec![0.0; 2 * model.dof()];
        let mut right_hand_side = |mut form: Box<dyn RightHandSide<f64, f64> + '_>| {
            measure(states, &mut |node| form.omega(node, K, &mut omega))
        };
        let mut blocks = NodeBlocks::new(model.dof());
        let mut jacobian = |mut kind: Box<dyn NodeJacobian + '_>| {
            measure(states, &mut |node| kind.evaluate(node, K, &mut blocks))
        };
        match self {
            Self::OmegaControlForm => right_hand_side(Box::new(ControlForm::new(model))),
            Self::OmegaAlgorithmB1 => right_hand_side(Box::new(AlgorithmB1::new(model))),
            Self::JacobianControlForm => jacobian(JacobianKind::ControlForm.build(model)),
            Self::JacobianTheoremB4 => jacobian(JacobianKind::TheoremB4.build(model)),
        }
    }
}

/// The times of one call over random configurations, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// Their median.
    pub median: f64,
}

impl Times {
    /// The statistics of at least one time.
    fn of(mut seconds: Vec<f64>) -> Self {
        let count = seconds.len() as f64;
        let mean = seconds.iter().sum::<f64>() / count;
        let variance = seconds.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / count;
        Self {
            mean,
            deviation: variance.sqrt(),
            median: median(&mut seconds),
        }
    }
}

/// The times of one quantity by the number of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The timed quantity.
    pub quantity: Quantity,
    /// The robots with their numbers of joints, fewest first, and the times.
    pub points: Vec<(String, usize, Times)>,
}

impl Series {
    /// Pairs of `N` and the mean time in microseconds.
    #[must_use]
    pub fn means(&self) -> Vec<(f64, f64)> {
        let mean = |(_, n, times): &(String, usize, Times)| (*n as f64, 1e6 * times.mean);
        self.points.iter().map(mean).collect()
    }

    /// Fits a polynomial in `N` to the means, microseconds; `None` if there are too few robots for its degree.
    #[must_use]
    pub fn polynomial(&self) -> Option<Vec<f64>> {
        polynomial(&self.means(), self.quantity.degree())
    }

    /// Fits a power law in `N` to the means and returns its factor, in microseconds, and its exponent; `None` for fewer
    /// than two robots.
    #[must_use]
    pub fn power_law(&self) -> Option<(f64, f64)> {
        power_law(&self.means())
    }
}

/// Times every quantity on the selected robots of Figures 4 and 5.
pub(super) fn scaling(settings: &Settings, progress: &mut dyn FnMut(&str)) -> Result<Vec<Series>> {
    let mut series = Quantity::ALL.map(|quantity| Series {
        quantity,
        points: Vec::new(),
    });
    for robot in SCALING_ROBOTS.into_iter().filter(|r| settings.chooses(r)) {
        let (model, _) = load_robot(robot)?;
        let states: Vec<State> = (0..settings.configurations)
            .map(|i| State::random(&model, settings.seed, i))
            .collect();
        for one in &mut series {
            progress(&format!("{}: {robot}", one.quantity.name()));
            let times = one.quantity.times(&model, &states)?;
            one.points.push((robot.to_owned(), model.dof(), times));
        }
    }
    Ok(series.into())
}

/// Times `call`, separately at every state by batches of the same call.
fn measure(states: &[State], call: &mut dyn FnMut(Node<'_, f64>) -> Result<()>) -> Result<Times> {
    let started = Instant::now();
    let mut calls = 0;
    for state in states.iter().cycle() {
        call(black_box(state.node()))?;
        calls += 1;
        if started.elapsed() >= WARM_UP {
            break;
        }
    }
    let warm = started.elapsed().as_secs_f64() / f64::from(calls);
    let batch = (BATCH_SECONDS / warm).ceil().max(1.0) as u32;
    let mut times = Vec::with_capacity(states.len());
    for state in states {
        let mut fastest = f64::INFINITY;
        for _ in 0..BATCHES {
            let started = Instant::now();
            for _ in 0..batch {
                call(black_box(state.node()))?;
            }
            fastest = fastest.min(started.elapsed().as_secs_f64() / f64::from(batch));
        }
        times.push(fastest);
    }
    Ok(Times::of(times))
}

/// The median of at least one number; for an even count the mean of the two middle ones.
pub(super) fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let half = numbers.len() / 2;
    if numbers.len() % 2 == 1 {
        numbers[half]
    } else {
        0.5 * (numbers[half - 1] + numbers[half])
    }
}
