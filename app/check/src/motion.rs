//! The polynomials of a motion.

use crate::Checked;
use crate::arithmetic::{Ball, Enclosure, Tm, UP};
use crate::json::{array, entries, get, list, number, option, require};
use serde_json::Value;

/// A polynomial in s, and a bound on its error.
pub(crate) type Polynomial = (Vec<f64>, f64);

/// The accepted deviations of states and of accelerations.
const STATE: f64 = 1e-9;
const ACCELERATION: f64 = 1e-6;

/// The piecewise polynomial motion.
pub(crate) struct Motion {
    pub(crate) horizon: f64,
    /// The Chebyshev coefficients per segment and joint.
    coefficients: Vec<Vec<Vec<f64>>>,
}

impl Motion {
    /// The coefficients of the certificate, which are those of the run.
    pub(crate) fn read(own: &Value, of_run: &Value, joints: usize, horizon: f64) -> Checked<Self> {
        let (own, of_run) = (array(own)?, array(of_run)?);
        require(!own.is_empty() && own.len() == of_run.len() && joints > 0, "the segments are not those of the run")?;
        let mut coefficients: Vec<Vec<Vec<f64>>> = Vec::new();
        for (own, of_run) in own.iter().zip(of_run) {
            let own = array(own)?.iter().map(list).collect::<Checked<Vec<_>>>()?;
            let of_run = array(of_run)?.iter().take(joints).map(list).collect::<Checked<Vec<_>>>()?;
            require(own == of_run && own.len() == joints, "the coefficients are not those of the run")?;
            let length = coefficients.first().unwrap_or(&own)[0].len();
            let same = length > 1 && own.iter().all(|c| c.len() == length);
            require(same, "the coefficients are of several degrees")?;
            coefficients.push(own);
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
            let n = c.len() - 1;
            let mut next = vec![Ball::new(0.0); n + 2];
            for j in (1..=n).rev() {
                next[j - 1] = next[j + 1] + c[j] * Ball::new(2.0 * j as f64);
            }
            next.truncate(n);
            if let Some(first) = next.first_mut() {
                *first = first.over(2.0);
            }
            c = next.iter().map(|c| c.over((k + 1) as f64)).collect();
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

/// The value at s = 0.
pub(crate) fn middle<const N: usize>(polynomial: &Polynomial) -> Enclosure<N> {
    Enclosure::within(polynomial.0[0], polynomial.1)
}

pub(crate) fn cut((c, r): &Polynomial) -> Tm {
    let mut model = Tm::new(0.0);
    let kept = c.len().min(model.c.len());
    model.c[..kept].copy_from_slice(&c[..kept]);
    model.widened(r + c[kept..].iter().map(|c| c.abs()).sum::<f64>() * UP)
}

/// Checks the claims on the states at the ends and between segments.
pub(crate) fn deviations(scenario: &Value, claims: &Value, motion: &Motion) -> Checked<()> {
    // Short intervals about both ends of each segment, where Chebyshev polynomials are exact.
    let about = |segment: usize, x: f64| motion.expand(segment, [x, 1.0 / f64::from(1 << 20)]);
    let ends: Vec<_> = (0..motion.segments()).map(|e| [about(e, -1.0), about(e, 1.0)]).collect();
    let (first, last) = (&ends[0][0], &ends[ends.len() - 1][1]);
    let is_set = !entries(scenario, "goal").is_empty();
    let free = option(scenario, "free_final_velocity").is_some_and(|f| *f == true);
    let smooth = match option(scenario, "continuity") {
        Some(continuity) => continuity == "acceleration",
        None => entries(scenario, "passive").is_empty(),
    };
    let zeros = vec![0.0; first[0].len()];
    let wanted = |key: &str| option(scenario, key).map_or(Ok(zeros.clone()), list);
    let check = |name: &str, values: Vec<Ball>, most: f64| {
        let claim = number(get(claims, name)?)?;
        let small = claim <= most && values.iter().all(|value| value.most() <= claim);
        require(small, format!("{name} is not proved"))
    };
    let off = |all: &[Polynomial], wanted: &[f64]| -> Checked<Vec<Ball>> {
        require(all.len() == wanted.len(), "a state has another number of joints")?;
        Ok(all.iter().zip(wanted).map(|(p, x)| middle(p) - Ball::new(*x)).collect())
    };
    check("start_position", off(&first[0], &wanted("q_start")?)?, STATE)?;
    check("start_velocity", off(&first[1], &wanted("v_start")?)?, STATE)?;
    if !is_set {
        check("goal_position", off(&last[0], &wanted("q_goal")?)?, STATE)?;
    }
    if !free {
        check("goal_velocity", off(&last[1], &wanted("v_goal")?)?, STATE)?;
    }
    let names = ["jump_position", "jump_velocity", "jump_acceleration"];
    for (order, name) in names.into_iter().enumerate().take(if smooth { 3 } else { 2 }).filter(|_| ends.len() > 1) {
        let between = ends.windows(2).flat_map(|pair| pair[0][1][order].iter().zip(&pair[1][0][order]));
        let jumps = between.map(|(a, b)| middle(a) - middle(b)).collect();
        check(name, jumps, if order < 2 { STATE } else { ACCELERATION })?;
    }
    Ok(())
}
