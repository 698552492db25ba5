//! Clearances at all times.

use super::{Check, Intervals, Outcome, Reach, Row, Worst, carriers};
use crate::{Quantity, Scenario};
use aghf::error::Result;
use aghf::geometry::{self, BallTree, CollisionSphere, Convex, Obstacle, Placed, Sphere, gap_to};

/// The largest number of gaps computed beyond those of the samples and the middles of their intervals: about ten
/// seconds.
const MAX_GAPS: usize = 50_000_000;

/// The cost of placing a robot, in gaps.
const PLACING: usize = 20;

/// The relative accuracy of a positive least clearance.
const PRECISION: f64 = 0.05;

/// A link and an obstacle or another link that must not overlap, and the distance that they keep.
struct Pair {
    between: Between,
    margin: f64,
}

/// The two sides of a pair.
enum Between {
    /// The balls of a link, as the index of their tree, and an obstacle.
    Obstacle { tree: usize, obstacle: usize },
    /// The balls of two links, and the joints that carry only one of them.
    Links { trees: [usize; 2], paths: [Vec<usize>; 2] },
}

/// A pair, and the nodes of the trees below which its balls are; the second one is that of an obstacle, without effect.
#[derive(Clone, Copy)]
struct Gap {
    pair: usize,
    nodes: [usize; 2],
}

/// The robot and its surroundings. Balls are placed and their gaps computed here once more, apart from
/// [`aghf::geometry::Scene`] on purpose: an error there must not hide from the judge.
struct Surroundings<'a> {
    trees: &'a [BallTree],
    /// The convex bodies that the balls contain, if they are not the robot.
    parts: &'a [Convex],
    paths: Vec<Vec<usize>>,
    obstacles: &'a [Obstacle],
    /// The convex forms of the obstacles; `None` for half-spaces.
    forms: &'a [Option<Convex>],
    intervals: &'a Intervals,
}

/// The rows for obstacles and for self-collision.
pub(super) fn clearances(scenario: &Scenario, intervals: &Intervals, overlap: f64) -> Result<Vec<Row>> {
    let model = &scenario.model;
    let trees = scenario.scene.trees();
    let scene = Surroundings {
        paths: trees.iter().map(|t| carriers(model, t.body)).collect(),
        obstacles: scenario.scene.obstacles(),
        forms: scenario.scene.forms(),
        trees,
        parts: &scenario.scene.robot().parts,
        intervals,
    };
    let moving = (0..trees.len()).filter(|tree| !scene.paths[*tree].is_empty());
    let beside = scenario.scene.obstacle_margins().iter().enumerate();
    let obstacles = moving.flat_map(|tree| {
        beside
            .clone()
            .map(move |(obstacle, margin)| Pair { between: Between::Obstacle { tree, obstacle }, margin: *margin })
    });
    let links = scenario.scene.tree_pairs().iter();
    let links = links.zip(scenario.scene.pair_margins());
    let links = links.map(|(trees, margin)| {
        let alone = |of: usize, other: usize| {
            let shared = &scene.paths[trees[other]];
            let path = scene.paths[trees[of]].iter();
            path.filter(|i| !shared.contains(i)).copied().collect()
        };
        let between = Between::Links { trees: *trees, paths: [alone(0, 1), alone(1, 0)] };
        Pair { between, margin: *margin }
    });
    let mut rows = Vec::new();
    let all = [(Quantity::Obstacles, obstacles.collect::<Vec<_>>()), (Quantity::SelfCollision, links.collect())];
    for (quantity, pairs) in all {
        let check = Check::Bounds(quantity);
        if pairs.is_empty() {
            let may_overlap = quantity == Quantity::SelfCollision && !scenario.keeps_links_clear();
            let why = if may_overlap { "links may overlap" } else { "there is nothing to keep clear of" };
            let outcome = Outcome::NotApplicable;
            rows.push(Row::without_value(check, overlap, outcome, why));
            continue;
        }
        let search = Search::new(&scene, Reach::new(model), &pairs, overlap);
        let place = |gap: Gap| place_of(scenario, &pairs[gap.pair], gap);
        let search = search.run()?;
        let kept = pairs[search.at.0.pair].margin;
        let least = pairs.iter().map(|pair| pair.margin);
        let least = least.fold(f64::INFINITY, f64::min);
        rows.push(search.row(check, place).beyond(kept, least));
    }
    Ok(rows)
}

/// The two sides of a gap, in words.
fn place_of(scenario: &Scenario, pair: &Pair, gap: Gap) -> String {
    let part = |tree: usize, node: usize| {
        let tree = &scenario.scene.trees()[tree];
        let link = tree.nodes[node].leaf.and_then(|ball| scenario.scene.robot().links.get(ball));
        match (link, tree.body) {
            (Some(link), _) => format!("link '{link}'"),
            (None, Some(body)) => {
                format!("the body of joint '{}'", scenario.model.joints()[body].name())
            }
            (None, None) => "the base".to_owned(),
        }
    };
    let [node, beside] = gap.nodes;
    match &pair.between {
        Between::Obstacle { tree, obstacle } => {
            let name = &scenario.scene.obstacles()[*obstacle].name;
            format!("{} and '{name}'", part(*tree, node))
        }
        Between::Links { trees: [a, b], .. } => {
            format!("{} and {}", part(*a, node), part(*b, beside))
        }
    }
}

/// A bound; negative infinity if numbers overflow.
fn known(bound: f64) -> f64 {
    if bound.is_nan() { f64::NEG_INFINITY } else { bound }
}

/// The search for the least gap over time.
struct Search<'a> {
    scene: &'a Surroundings<'a>,
    reach: Reach<'a>,
    pairs: &'a [Pair],
    overlap: f64,
    /// The least gap found so far, m.
    least: f64,
    /// The least gap, and its time.
    at: (Gap, f64),
    /// The proved lower bound of all gaps, m.
    proved: f64,
    /// The remaining number of gaps for halving.
    budget: usize,
    q: Vec<f64>,
    ways: Vec<f64>,
}

impl<'a> Search<'a> {
    fn new(scene: &'a Surroundings<'a>, reach: Reach<'a>, pairs: &'a [Pair], overlap: f64) -> Self {
        let first = Gap { pair: 0, nodes: [0, 0] };
        Self {
            scene,
            reach,
            pairs,
            overlap,
            least: f64::INFINITY,
            at: (first, 0.0),
            proved: f64::INFINITY,
            budget: MAX_GAPS,
            q: Vec::new(),
            ways: Vec::new(),
        }
    }

    /// Evaluates all samples, so that the least gap is nearly known, and then proves bounds between them.
    fn run(mut self) -> Result<Self> {
        let root = |pair| Gap { pair, nodes: [0, 0] };
        let all: Vec<Gap> = (0..self.pairs.len()).map(root).collect();
        let intervals = self.scene.intervals.joints.len();
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

    /// Places the robot at the fraction `s` of interval `k`.
    fn place(&mut self, k: usize, s: f64) -> Result<()> {
        let joints = &self.scene.intervals.joints[k];
        self.q.clear();
        self.q.extend(joints.iter().map(|joint| joint.at(0, s)));
        self.reach.place(&self.q)
    }

    /// Updates the least gap with one between two balls.
    fn take(&mut self, gap: Gap, distance: f64, k: usize, s: f64) {
        if distance < self.least {
            self.least = distance;
            self.at = (gap, self.scene.intervals.time(k, s));
        }
    }

    /// Updates the least of the given gaps at the fraction `s` of interval `k`.
    fn look(&mut self, k: usize, s: f64, gaps: &[Gap]) -> Result<()> {
        self.place(k, s)?;
        let mut open = gaps.to_vec();
        while let Some(gap) = open.pop() {
            let distance = known(self.distance(gap));
            match self.below(gap) {
                _ if distance >= self.least => {}
                Some(below) => open.extend(below),
                None => self.take(gap, distance, k, s),
            }
        }
        Ok(())
    }

    /// Evaluates the middle of a part of interval `k`. Returns it, and the gaps between balls that may be smaller
    /// elsewhere in the part. A ball around others moves with them as one body, so a bound on its motion bounds the
    /// changes of their distances.
    fn prove(&mut self, k: usize, range: [f64; 2], gaps: &[Gap]) -> Result<(f64, Vec<Gap>)> {
        let middle = 0.5 * (range[0] + range[1]);
        self.place(k, middle)?;
        let joints = &self.scene.intervals.joints[k];
        self.ways.clear();
        self.ways.extend(joints.iter().map(|joint| joint.way_from_middle(range)));
        let mut left = Vec::new();
        let mut visited = 0;
        let mut open = gaps.to_vec();
        // The range can no longer be halved in floating point.
        let last = self.budget == 0 || middle <= range[0] || middle >= range[1];
        while let Some(gap) = open.pop() {
            visited += 1;
            let distance = known(self.distance(gap));
            let below = self.below(gap);
            if below.is_none() {
                self.take(gap, distance, k, middle);
            }
            let resolved = (0.1 * self.overlap).max(PRECISION * self.least.abs());
            let bound = known(distance - self.way(gap));
            match below {
                _ if bound >= self.least - resolved => self.proved = self.proved.min(bound),
                Some(below) => open.extend(below),
                None if last => self.proved = self.proved.min(bound),
                None => left.push(gap),
            }
        }
        if range != [0.0, 1.0] {
            self.budget = self.budget.saturating_sub(visited + PLACING);
        }
        Ok((middle, left))
    }

    /// The gaps below one; `None` for one between two balls.
    fn below(&self, gap: Gap) -> Option<[Gap; 2]> {
        let [node, beside] = gap.nodes;
        let nodes = match &self.pairs[gap.pair].between {
            Between::Obstacle { tree, .. } => {
                let below = self.scene.trees[*tree].below(node)?;
                below.map(|node| [node, beside])
            }
            Between::Links { trees, .. } => {
                let [tree, other] = trees.map(|i| &self.scene.trees[i]);
                tree.below_pair(other, gap.nodes)?
            }
        };
        Some(nodes.map(|nodes| Gap { nodes, ..gap }))
    }

    /// A ball of a tree.
    fn ball(&self, tree: usize, node: usize) -> CollisionSphere {
        let tree = &self.scene.trees[tree];
        let Sphere { centre, radius } = tree.nodes[node].bound;
        CollisionSphere { body: tree.body, centre, radius }
    }

    /// The convex body of a leaf of a tree, if the robot has any.
    fn part(&self, tree: usize, node: usize) -> Option<Placed<'_, f64, f64>> {
        let tree = &self.scene.trees[tree];
        let convex = self.scene.parts.get(tree.nodes[node].leaf?)?;
        Some(self.reach.placed(tree.body, convex))
    }

    /// The current gap, m; negative for an overlap.
    fn distance(&self, gap: Gap) -> f64 {
        let margin = self.pairs[gap.pair].margin;
        match &self.pairs[gap.pair].between {
            Between::Obstacle { tree, obstacle } => {
                let solid = &self.scene.obstacles[*obstacle].solid;
                if let Some(part) = self.part(*tree, gap.nodes[0]) {
                    return gap_to(&part, (solid, self.scene.forms[*obstacle].as_ref())).distance - margin;
                }
                let ball = self.ball(*tree, gap.nodes[0]);
                solid.distance(&self.reach.centre(&ball)) - ball.radius - margin
            }
            Between::Links { trees, .. } => {
                if let [Some(a), Some(b)] = [0, 1].map(|i| self.part(trees[i], gap.nodes[i])) {
                    return geometry::gap(&[a, b]).distance - margin;
                }
                let [a, b] = [0, 1].map(|i| self.ball(trees[i], gap.nodes[i]));
                let [p, q] = [a, b].map(|ball| self.reach.centre(&ball));
                (p - q).norm() - a.radius - b.radius - margin
            }
        }
    }

    /// A bound on the change of a gap in the current part of the interval, m.
    fn way(&self, gap: Gap) -> f64 {
        let way = |tree: usize, node: usize, path: &[usize]| {
            let ball = self.ball(tree, node);
            match self.part(tree, node) {
                Some(_) => self.reach.way_within(&ball, path, &self.ways),
                None => self.reach.way(&self.reach.centre(&ball), path, &self.ways),
            }
        };
        let [node, beside] = gap.nodes;
        match &self.pairs[gap.pair].between {
            Between::Obstacle { tree, .. } => way(*tree, node, &self.scene.paths[*tree]),
            Between::Links { trees, paths } => way(trees[0], node, &paths[0]) + way(trees[1], beside, &paths[1]),
        }
    }

    /// The row of the check in the verdict.
    fn row(self, check: Check, place: impl Fn(Gap) -> String) -> Row {
        let (gap, at_s) = self.at;
        let mut row = Row::new(check, self.overlap);
        let least = Worst::between(self.least, [0.0, f64::INFINITY], "m", at_s);
        row.take(least, || place(gap));
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
