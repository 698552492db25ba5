//! The polynomials of a motion.

use crate::Checked;
use crate::arithmetic::{Ball, Enclosure, Tm, UP};
use crate::json::{entries, is_true, list, number, option, require};
use serde_json::Value;

/// A polynomial in s, and a bound on its error.
pub(crate) type Polynomial = (Vec<f64>, f64);

/// The accepted deviations of states and of accelerations.
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// The largest degree of a motion.
const DEGREE: f64 = 100.0;

/// The piecewise polynomial motion.
pub(crate) struct Motion {
    pub(crate) horizon: f64,
    /// The Chebyshev coefficients per segment and joint.
    coefficients: Vec<Vec<Vec<f64>>>,
}

impl Motion {
    /// The motion of a run: positions, and velocities which are their rates.
    pub(crate) fn read(curve: &Value, joints: usize) -> Checked<Self> {
        let horizon = number(&curve["horizon_s"]);
        let (segments, degree) = (&curve["segments"], &curve["degree"]);
        require(number(degree) <= DEGREE, format!("the degree of the motion is above {DEGREE}"))?;
        let mut coefficients: Vec<Vec<Vec<f64>>> = Vec::new();
        for segment in entries(curve, "coefficients") {
            let states: Vec<Vec<f64>> = segment.as_array().into_iter().flatten().map(list).collect();
            let is_whole = |c: &Vec<f64>| c.len() >= 2 && *degree == c.len() - 1;
            require(states.len() == 2 * joints && states.iter().all(is_whole), "a segment has other coefficients")?;
            coefficients.push(states);
        }
        require(joints > 0 && *segments == coefficients.len() && !coefficients.is_empty(), "the segments are others")?;
        let rate = Ball::new(2.0 * coefficients.len() as f64).over(horizon);
        for states in &mut coefficients {
            for (velocity, position) in states.split_off(joints).iter().zip(&*states) {
                let mut rates = derivative(&position.iter().map(|c| Ball::new(*c)).collect::<Vec<_>>());
                rates.push(Ball::new(0.0));
                let off = velocity.iter().zip(rates).map(|(v, c)| (Ball::new(*v) - c * rate).most());
                require(off.sum::<f64>() * UP <= STATE, "a velocity of the run is not the rate of the position")?;
            }
        }
        Ok(Self { horizon, coefficients })
    }

    pub(crate) fn segments(&self) -> usize {
        self.coefficients.len()
    }

    pub(crate) fn degree(&self) -> usize {
        self.coefficients[0][0].len() - 1
    }

    /// The time of a place, s, with an error of less than 1e-15 of the horizon.
    pub(crate) fn time(&self, segment: usize, x: f64) -> f64 {
        (segment as f64 + 0.5 * (1.0 + x)) * self.horizon / self.segments() as f64
    }

    /// Positions, velocities, accelerations and jerks of the joints on |x - m| <= w of a segment.
    pub(crate) fn expand(&self, segment: usize, [m, w]: [f64; 2]) -> [Vec<Polynomial>; 4] {
        let rate = Ball::new(2.0 * self.segments() as f64).over(self.horizon).over(w);
        expand(&self.coefficients[segment], rate, [m, w])
    }
}

/// Positions, velocities, accelerations and jerks of the joints on a part of a segment, |x - m| <= w: Taylor
/// coefficients about m from the Chebyshev coefficients of the derivatives.
fn expand(segment: &[Vec<f64>], rate: Ball, [m, w]: [f64; 2]) -> [Vec<Polynomial>; 4] {
    let degree = segment[0].len() - 1;
    let (one, x) = (Ball::new(1.0), Ball::new(m));
    let mut chebyshev = vec![one, x];
    for j in 2..=degree {
        let twice = chebyshev[j / 2] * chebyshev[j - j / 2] * Ball::new(2.0);
        chebyshev.push(twice - if j % 2 == 0 { one } else { x });
    }
    let mut found = [const { Vec::new() }; 4];
    for coefficients in segment {
        let mut c: Vec<Ball> = coefficients.iter().map(|c| Ball::new(*c)).collect();
        let (mut taylor, mut power) = (Vec::new(), one);
        for k in 0..=degree {
            let sum = c.iter().zip(&chebyshev).fold(Ball::new(0.0), |sum, (c, t)| sum + *c * *t);
            taylor.push(sum * power);
            power = power * Ball::new(w);
            // The next derivative over k + 1.
            c = derivative(&c).iter().map(|c| c.over((k + 1) as f64)).collect();
        }
        for found in &mut found {
            let radius: f64 = taylor.iter().map(|c| c.r).sum();
            found.push((taylor.iter().map(|c| c.c[0]).collect(), radius * UP));
            let rates = taylor.iter().enumerate().skip(1);
            taylor = rates.map(|(k, c)| *c * Ball::new(k as f64) * rate).collect();
        }
    }
    found
}

/// The Chebyshev coefficients of the derivative of a polynomial.
fn derivative(c: &[Ball]) -> Vec<Ball> {
    let n = c.len() - 1;
    let mut next = vec![Ball::new(0.0); n + 2];
    for j in (1..=n).rev() {
        next[j - 1] = next[j + 1] + c[j] * Ball::new(2.0 * j as f64);
    }
    next.truncate(n);
    if let Some(first) = next.first_mut() {
        *first = first.over(2.0);
    }
    next
}

/// The value at s = 0. A derivative beyond the degree has no coefficients.
pub(crate) fn middle<const N: usize>(polynomial: &Polynomial) -> Enclosure<N> {
    Enclosure::within(polynomial.0.first().copied().unwrap_or(0.0), polynomial.1)
}

pub(crate) fn cut((c, r): &Polynomial) -> Tm {
    let mut model = Tm::new(0.0);
    let kept = c.len().min(model.c.len());
    model.c[..kept].copy_from_slice(&c[..kept]);
    model.widened(r + c[kept..].iter().map(|c| c.abs()).sum::<f64>() * UP)
}

/// Proves the states at the ends, accelerations that are given or zero at rest there, and continuity.
pub(crate) fn prove_ends(scenario: &Value, motion: &Motion) -> Checked<()> {
    // Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    let about = |segment: usize, x: f64| motion.expand(segment, [x, 1.0 / f64::from(1 << 20)]);
    let ends: Vec<_> = (0..motion.segments()).map(|e| [about(e, -1.0), about(e, 1.0)]).collect();
    let (first, last) = (&ends[0][0], &ends[ends.len() - 1][1]);
    let zeros = vec![0.0; first[0].len()];
    let smooth = match option(scenario, "continuity") {
        Some(continuity) => continuity == "acceleration",
        None => entries(scenario, "passive").is_empty(),
    };
    let wanted = |key: &str| option(scenario, key).map_or(zeros.clone(), list);
    let [start, end] = [wanted("v_start"), wanted("v_goal")];
    let (is_set, free) = (!entries(scenario, "goal").is_empty(), is_true(scenario, "free_final_velocity"));
    let off = |name: &str, all: &[Polynomial], wanted: &[f64], most: f64| {
        let near = |(p, x): (&Polynomial, &f64)| (middle(p) - Ball::new(*x)).most() <= most;
        let kept = all.len() == wanted.len() && all.iter().zip(wanted).all(near);
        require(kept, format!("{name} is not proved"))
    };
    off("the start position", &first[0], &wanted("q_start"), STATE)?;
    off("the start velocity", &first[1], &start, STATE)?;
    let goal = wanted("q_goal");
    let is_one = |all: &Vec<f64>| all.len() == zeros.len() || is_set && all.is_empty();
    require(is_one(&goal) && is_one(&end), "a goal is of another number of joints")?;
    let end = if end.is_empty() { zeros.clone() } else { end };
    if !is_set {
        off("the goal position", &last[0], &goal, STATE)?;
    }
    if !free {
        off("the goal velocity", &last[1], &end, STATE)?;
    }
    let given = |key: &str| option(scenario, key).map(list);
    if let Some(a) = given("a_start").or((smooth && start == zeros).then(|| zeros.clone())) {
        off("the start acceleration", &first[2], &a, ACCELERATION)?;
    }
    if let Some(a) = given("a_goal").or((smooth && !free && end == zeros).then(|| zeros.clone())) {
        off("the goal acceleration", &last[2], &a, ACCELERATION)?;
    }
    for (order, name) in
        ["positions", "velocities", "accelerations"].into_iter().enumerate().take(2 + usize::from(smooth))
    {
        let most = if order < 2 { STATE } else { ACCELERATION };
        let mut between = ends.windows(2).flat_map(|pair| pair[0][1][order].iter().zip(&pair[1][0][order]));
        let kept = between.all(|(a, b)| (middle::<1>(a) - middle(b)).most() <= most);
        require(kept, format!("continuity of {name} is not proved"))?;
    }
    Ok(())
}
