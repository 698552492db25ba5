//! Clearances at all times.

use super::{Check, Intervals, Outcome, Reach, Row, Worst, carriers};
use crate::Scenario;
use aghf::error::Result;
use aghf::geometry::{CollisionGeometry, CollisionSphere, Margins, Obstacle};

/// The largest number of gaps computed beyond those of the samples and the middles of their intervals: about ten
/// seconds.
const MOST_GAPS: usize = 50_000_000;

/// The cost of placing a robot, in gaps.
const PLACING: usize = 20;

/// The relative accuracy of a positive least clearance.
const PRECISION: f64 = 0.05;

/// A pair that must not overlap.
enum Gap {
    /// A ball and an obstacle.
    Obstacle { ball: usize, obstacle: usize },
    /// Two balls, and the joints that carry only one of them.
    Balls {
        balls: [usize; 2],
        paths: [Vec<usize>; 2],
    },
}

/// The robot and its surroundings. Balls are placed and their gaps computed here once more, apart from
/// [`aghf::geometry::Scene`] on purpose: an error there must not hide from the judge.
struct Surroundings<'a> {
    balls: &'a [CollisionSphere],
    paths: Vec<Vec<usize>>,
    obstacles: &'a [Obstacle],
    /// The margins from obstacles and between balls.
    margins: [f64; 2],
    intervals: &'a Intervals,
}

/// The rows for obstacles and for self-collision.
pub(super) fn clearances(
    scenario: &Scenario,
    intervals: &Intervals,
    overlap: f64,
) -> Result<Vec<Row>> {
    let model = &scenario.model;
    let CollisionGeometry { balls, links, .. } = scenario.scene.robot();
    let Margins {
        obstacles: beside,
        itself,
    } = scenario.scene.margins();
    let scene = Surroundings {
        margins: [beside, itself],
        paths: balls
            .iter()
            .map(|ball| carriers(model, ball.body))
            .collect(),
        obstacles: scenario.scene.obstacles(),
        balls,
        intervals,
    };
    let moving = (0..scene.balls.len()).filter(|ball| !scene.paths[*ball].is_empty());
    let obstacles = moving.flat_map(|ball| {
        (0..scene.obstacles.len()).map(move |obstacle| Gap::Obstacle { ball, obstacle })
    });
    let pairs = scenario.scene.pairs().iter().map(|balls| {
        let alone = |of: usize, other: usize| {
            let shared = &scene.paths[balls[other]];
            let path = scene.paths[balls[of]].iter();
            path.filter(|i| !shared.contains(i)).copied().collect()
        };
        let paths = [alone(0, 1), alone(1, 0)];
        Gap::Balls {
            balls: *balls,
            paths,
        }
    });
    let part = |ball: usize| match (links.get(ball), balls[ball].body) {
        (Some(link), _) => format!("link '{link}'"),
        (None, Some(body)) => format!("the body of joint '{}'", model.joints()[body].name()),
        (None, None) => "the base".to_owned(),
    };
    let place = |gap: &Gap| match gap {
        Gap::Obstacle { ball, obstacle } => {
            format!("{} and '{}'", part(*ball), scene.obstacles[*obstacle].name)
        }
        Gap::Balls { balls: [a, b], .. } => format!("{} and {}", part(*a), part(*b)),
    };
    let mut rows = Vec::new();
    for (check, gaps) in [
        (Check::Obstacles, obstacles.collect::<Vec<_>>()),
        (Check::SelfCollision, pairs.collect()),
    ] {
        if gaps.is_empty() {
            let why = match check {
                Check::SelfCollision if scenario.file.self_collision.is_none() => {
                    "it is not asked for"
                }
                _ => "there is nothing to keep clear of",
            };
            rows.push(Row::not_checked(check, overlap, why));
            continue;
        }
        let search = Search::new(&scene, Reach::new(model), &gaps, overlap);
        let margin = match check {
            Check::Obstacles => beside,
            _ => itself,
        };
        rows.push(search.run()?.row(check, place).beyond(margin));
    }
    Ok(rows)
}

/// A bound; negative infinity if numbers overflow.
fn known(bound: f64) -> f64 {
    if bound.is_nan() {
        f64::NEG_INFINITY
    } else {
        bound
    }
}

/// The search for the least gap over time.
struct Search<'a> {
    scene: &'a Surroundings<'a>,
    reach: Reach<'a>,
    gaps: &'a [Gap],
    overlap: f64,
    /// The least gap found so far, m.
    least: f64,
    /// The index of the least gap, and its time.
    at: (usize, f64),
    /// The proved lower bound of all gaps, m.
    proved: f64,
    /// The remaining number of gaps for halving.
    budget: usize,
    q: Vec<f64>,
    ways: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(scene: &'a Surroundings<'a>, reach: Reach<'a>, gaps: &'a [Gap], overlap: f64) -> Self {
        Self {
            scene,
            reach,
            gaps,
            overlap,
            least: f64::INFINITY,
            at: (0, 0.0),
            proved: f64::INFINITY,
            budget: MOST_GAPS,
            q: Vec::new(),
            ways: Vec::new(),
        }
    }

    /// Evaluates all samples, so that the least gap is nearly known, and then proves bounds between them.
    fn run(mut self) -> Result<Self> {
        let all: Vec<usize> = (0..self.gaps.len()).collect();
        let intervals = self.scene.intervals.cubics.len();
        for k in 0..intervals {
            self.look(k, 0.0, &all)?;
        }
        self.look(intervals - 1, 1.0, &all)?;
        for k in 0..intervals {
            // Depth first, so that at most two lists per halving are kept.
            let mut open = vec![([0.0, 1.0], all.clone())];
            while let Some(([from, to], gaps)) = open.pop() {
                let (middle, left) = self.prove(k, [from, to], &gaps)?;
                if left.is_empty() {
                    continue;
                }
                open.push(([middle, to], left.clone()));
                open.push(([from, middle], left));
            }
        }
        Ok(self)
    }

    /// Places the robot at the fraction `s` of interval `k`, and updates the least of the given gaps.
    fn look(&mut self, k: usize, s: f64, gaps: &[usize]) -> Result<Vec<f64>> {
        let cubics = &self.scene.intervals.cubics[k];
        self.q.clear();
        self.q.extend(cubics.iter().map(|cubic| cubic.position(s)));
        self.reach.place(&self.q)?;
        let mut found = Vec::with_capacity(gaps.len());
        for gap in gaps {
            let distance = known(self.distance(&self.gaps[*gap]));
            if distance < self.least {
                self.least = distance;
                self.at = (*gap, self.scene.intervals.time(k, s));
            }
            found.push(distance);
        }
        Ok(found)
    }

    /// Evaluates the middle of a part of interval `k`. Returns it, and the gaps that may be smaller elsewhere in the
    /// part.
    fn prove(&mut self, k: usize, range: [f64; 2], gaps: &[usize]) -> Result<(f64, Vec<usize>)> {
        let middle = 0.5 * (range[0] + range[1]);
        let distances = self.look(k, middle, gaps)?;
        let cubics = &self.scene.intervals.cubics[k];
        self.ways.clear();
        self.ways
            .extend(cubics.iter().map(|cubic| cubic.way_from_middle(range)));
        let mut left = Vec::new();
        let whole = range == [0.0, 1.0];
        if !whole {
            self.budget = self.budget.saturating_sub(gaps.len() + PLACING);
        }
        let resolved = (0.1 * self.overlap).max(PRECISION * self.least.abs());
        // The range can no longer be halved in floating point.
        let last = self.budget == 0 || middle <= range[0] || middle >= range[1];
        for (gap, distance) in gaps.iter().zip(distances) {
            let bound = known(distance - self.way(&self.gaps[*gap]));
            if last || bound >= self.least - resolved {
                self.proved = self.proved.min(bound);
            } else {
                left.push(*gap);
            }
        }
        Ok((middle, left))
    }

    /// The current gap, m; negative for an overlap.
    fn distance(&self, gap: &Gap) -> f64 {
        let ball = |i: usize| &self.scene.balls[i];
        let centre = |i: usize| self.reach.centre(ball(i));
        let [beside, between] = self.scene.margins;
        match gap {
            Gap::Obstacle { ball: i, obstacle } => {
                let solid = &self.scene.obstacles[*obstacle].solid;
                solid.distance(&centre(*i)) - ball(*i).radius - beside
            }
            Gap::Balls { balls: [a, b], .. } => {
                (centre(*a) - centre(*b)).norm() - ball(*a).radius - ball(*b).radius - between
            }
        }
    }

    /// A bound on the change of a gap in the current part of the interval, m.
    fn way(&self, gap: &Gap) -> f64 {
        let way = |i: usize, path: &[usize]| {
            let centre = self.reach.centre(&self.scene.balls[i]);
            self.reach.way(&centre, path, &self.ways)
        };
        match gap {
            Gap::Obstacle { ball, .. } => way(*ball, &self.scene.paths[*ball]),
            Gap::Balls { balls, paths } => way(balls[0], &paths[0]) + way(balls[1], &paths[1]),
        }
    }

    /// The row of the check in the verdict.
    fn row(self, check: Check, place: impl Fn(&Gap) -> String) -> Row {
        let (gap, at_s) = self.at;
        let mut row = Row::new(check, self.overlap);
        let least = Worst::between(self.least, [0.0, f64::INFINITY], "m", at_s);
        row.take(least, || place(&self.gaps[gap]));
        // A gap found later may be smaller than the proved bounds.
        let proved = self.proved.min(self.least);
        let short = -self.overlap - proved;
        if row.outcome == Outcome::Pass && short > 0.0 {
            row.outcome = Outcome::Undecided;
            row.note = Some(format!("within {short:.1e} m"));
        }
        row.proved_at_least = Some(proved);
        row
    }
}
