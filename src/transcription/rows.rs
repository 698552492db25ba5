//! The rows of constraints at the points of a curve.

use super::{ProximityCache, RowSelection, Shared};
use crate::constraint::{ActivePair, Constraint, Constraints, Evaluator, Phase, RowSet, StandingFoot};
use crate::cost::{CostWithControl, Points};
use crate::dynamics::Data;
use crate::error::Result;
use crate::model::Model;
use crate::scalar::{LANES, Wide};
use nalgebra::DMatrix;

/// The rows of constraints at single points, in their own units and relative to their scales, with the running cost.
#[derive(Debug)]
pub(crate) struct Rows<'a, K, P> {
    pub model: &'a Model,
    pub constraints: Shared<'a, Constraints<K>>,
    /// The running cost.
    pub cost: P,
    /// The controls at the points.
    controls: DMatrix<f64>,
    /// Scratch space for the foot.
    data: Data<Wide<f64>>,
    pub(super) evaluator: Evaluator<'a, f64, Wide<f64>>,
    /// $[q; v; a]$ and the rows of the state at points that are evaluated side by side.
    pub(super) z: Vec<Wide<f64>>,
    pub(super) wide: Vec<Wide<f64>>,
    /// Memory for the pairs that are near each other.
    pub(super) active: Vec<ActivePair<Wide>>,
    /// The largest value at the last points of each row of the state that was evaluated there.
    pub highest: Vec<f64>,
    /// The rows of the state without a cutoff, and those that were not at it at any of the last points.
    pub(super) dense: Vec<usize>,
    pub(super) touched: Vec<usize>,
    /// The rows of a standing foot.
    foot: Vec<Wide<f64>>,
    /// The running cost where it is not asked for.
    costs: Vec<f64>,
    pub(super) attributes: Attributes,
    /// The rows that may be near their bounds, at the points of a grid.
    pub near: ProximityCache,
}

/// The first row of a foot, the robot on it, the foot, and the phase if there are several.
pub(crate) type Standing<'a> = (usize, &'a Model, &'a StandingFoot, Option<&'a Phase>);

/// The foot on which a robot stands in a phase.
fn standing<'c, K>(constraints: &'c Constraints<K>, model: &'c Model, phase: usize) -> Option<Standing<'c>>
where
    K: Constraint,
{
    let stage = &constraints.stage;
    let (row, foot) = stage.foot()?;
    let first = constraints.first_of_stage() + row;
    Some(match stage.phases.get(phase) {
        None => (first, model, foot, None),
        Some(of) => (first, &of.model, &of.foot, Some(of)),
    })
}

/// The attributes of rows, one entry per row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Attributes {
    /// The factor of a row, with which a badly violated row is of the order of 0.1.
    pub scales: Vec<f64>,
    /// True if a row is an equality.
    pub equalities: Vec<bool>,
    /// One unit of the scaled row: rad, rad/s, m, N m or N.
    pub units: Vec<f64>,
    /// True for a clearance, which is far from its bound most of the time.
    pub clearances: Vec<bool>,
    /// The distance from its bound from which on a row is constant; infinite if there is none.
    pub cutoffs: Vec<f64>,
    /// The times between which a row is kept, s; infinite for most.
    pub times: Vec<[f64; 2]>,
}

// By hand, since a derived `Clone` would require it of the constraints, which are a reference.
impl<K, P: Clone> Clone for Rows<'_, K, P> {
    fn clone(&self) -> Self {
        Self {
            model: self.model,
            constraints: self.constraints.clone(),
            cost: self.cost.clone(),
            controls: self.controls.clone(),
            data: self.data.clone(),
            evaluator: self.evaluator.clone(),
            z: self.z.clone(),
            wide: self.wide.clone(),
            active: Vec::new(),
            highest: self.highest.clone(),
            dense: self.dense.clone(),
            touched: Vec::new(),
            foot: self.foot.clone(),
            costs: self.costs.clone(),
            attributes: self.attributes.clone(),
            near: self.near.clone(),
        }
    }
}

impl<'a, K: Constraint, P: CostWithControl> Rows<'a, K, P> {
    pub fn new(model: &'a Model, constraints: impl Into<Shared<'a, Constraints<K>>>, cost: P) -> Result<Self> {
        let constraints = constraints.into();
        constraints.check(model)?;
        let state = &constraints.state;
        let n = model.dof();
        let [scales, units] = constraints.factors_and_units();
        let states = state.dim();
        let mut sets: Vec<_> = (0..states).map(|row| state.row_set(row)).collect();
        sets.extend((states..scales.len()).map(|row| RowSet {
            is_equality: constraints.is_equality(row),
            is_clearance: constraints.label(row, model).quantity.is_clearance(),
            ..RowSet::at_most_zero()
        }));
        let attributes = Attributes {
            clearances: sets.iter().map(|set| set.is_clearance && !set.is_equality).collect(),
            cutoffs: sets.iter().map(|set| set.cutoff.unwrap_or(f64::INFINITY)).collect(),
            units,
            equalities: sets.iter().map(|set| set.is_equality).collect(),
            times: constraints.times(),
            scales,
        };
        Ok(Self {
            model,
            cost,
            controls: DMatrix::zeros(n, 0),
            data: Data::new(model),
            evaluator: Evaluator::new(model),
            z: vec![Wide::splat(0.0); 3 * n],
            wide: vec![Wide::splat(0.0); states],
            active: Vec::new(),
            highest: vec![0.0; states],
            dense: (0..states).filter(|row| attributes.cutoffs[*row].is_infinite()).collect(),
            touched: Vec::new(),
            foot: Vec::new(),
            costs: Vec::new(),
            attributes,
            near: ProximityCache::default(),
            constraints,
        })
    }

    /// Allocates memory for lists of all rows of the state.
    pub fn allocate(&mut self) {
        let pairs = self.attributes.cutoffs.iter().filter(|cutoff| cutoff.is_finite()).count();
        self.near.allocate(pairs);
        self.active.reserve(pairs);
    }

    /// The number of rows.
    pub fn count(&self) -> usize {
        self.attributes.scales.len()
    }

    /// The rows of the state that are equalities, with their units.
    pub fn equalities_of_state(&self) -> impl Iterator<Item = (usize, f64)> + use<'_, 'a, K, P> {
        let Attributes { equalities, units, .. } = &self.attributes;
        let rows = (0..self.states()).filter(|row| equalities[*row]);
        rows.map(|row| (row, units[row]))
    }

    /// The number of rows of the state; those of the torque follow.
    pub fn states(&self) -> usize {
        self.wide.len()
    }

    /// Returns true if a row is kept in a phase.
    pub fn is_kept(&self, row: usize, phase: usize) -> bool {
        let phases = self.constraints.stage.phases.iter().enumerate();
        let mut elsewhere = phases.filter(|(k, _)| *k != phase);
        !elsewhere.any(|(_, other)| other.rows.contains(&row))
    }

    /// Returns true if a row is kept in one phase alone.
    pub fn is_of_phase(&self, row: usize) -> bool {
        let mut phases = self.constraints.stage.phases.iter();
        phases.any(|phase| phase.rows.contains(&row))
    }

    /// The robot, the foot, and the phase if there are several.
    pub fn standing(&self, phase: usize) -> Option<Standing<'_>> {
        standing(&self.constraints, self.model, phase)
    }

    /// The attributes of all rows.
    pub fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    /// Returns true if any row depends on the control.
    fn with_control(&self) -> bool {
        let Constraints { torque, stage, .. } = &*self.constraints;
        torque.dim() > 0 || !stage.custom.is_empty()
    }

    /// The highest order of a derivative on which a row or the cost depends.
    pub fn order(&self) -> usize {
        self.constraints.stage.order().max(self.cost.order())
    }

    /// Computes all rows at all points into `h`, row by row for each point, and the running cost there into `costs`.
    /// At the points of a grid rows that are far keep the last value that was computed.
    pub fn at(&mut self, points: Points<'_, f64>, h: &mut [f64], costs: &mut [f64]) -> Result<()> {
        self.of_state(points, RowSelection::Cached, h)?;
        self.others(points, false, h, costs)
    }

    /// Computes the rows that do not concern the state alone, those that are kept for a part of the time also `always`,
    /// and the running cost.
    fn others(&mut self, points: Points<'_, f64>, always: bool, h: &mut [f64], costs: &mut [f64]) -> Result<()> {
        self.of_rates(points, h);
        self.of_foot(points, h)?;
        if !self.with_control() {
            return self.cost.values(points, costs);
        }
        let (states, count) = (self.states(), self.count());
        let Constraints { torque, stage, .. } = &*self.constraints;
        let rates = states + torque.dim();
        if self.controls.ncols() < points.count() {
            self.controls = DMatrix::zeros(points.states.nrows(), points.count());
        }
        self.cost.values_with_control(points, costs, &mut self.controls)?;
        let scales = &self.attributes.scales;
        for (g, (h, u)) in h.chunks_exact_mut(count).zip(self.controls.column_iter()).enumerate() {
            if rates > states {
                torque.value(u.as_slice(), &mut h[states..rates])?;
            }
            for (h, scale) in h[states..rates].iter_mut().zip(&scales[states..]) {
                *h *= scale;
            }
            for (first, other) in stage.custom_rows() {
                let own = rates + first..rates + first + other.dim();
                let at = points.point(g).with_control(u.as_slice());
                match other.window().filter(|_| always) {
                    Some(window) => window.at_all_times(&at, &mut h[own.clone()])?,
                    None => other.value(&at, &mut h[own.clone()])?,
                }
                for (h, scale) in h[own.clone()].iter_mut().zip(&scales[own]) {
                    *h *= scale;
                }
            }
        }
        Ok(())
    }

    /// Computes the rows of the limits of rates.
    fn of_rates(&self, points: Points<'_, f64>, h: &mut [f64]) {
        let first = self.constraints.first_of_stage();
        let rows = h.chunks_exact_mut(self.count().max(1)).take(points.count());
        for (g, h) in rows.enumerate() {
            for (h, rate) in h[first..].iter_mut().zip(&self.constraints.stage.rates) {
                let of_joint = match rate.order.checked_sub(3) {
                    Some(higher) => points.higher[higher][(rate.joint, g)],
                    None => points.states[(rate.joint, 3 * g + rate.order)],
                };
                *h = rate.side.sign() * of_joint / rate.limit - 1.0;
            }
        }
    }

    /// Computes the rows of a standing foot.
    fn of_foot(&mut self, points: Points<'_, f64>, h: &mut [f64]) -> Result<()> {
        let found = standing(&self.constraints, self.model, points.phase);
        let Some((first, model, foot, phase)) = found else {
            return Ok(());
        };
        let (n, count) = (self.model.dof(), self.attributes.scales.len());
        let scales = &self.attributes.scales[first..first + foot.dim()];
        let g = &mut self.foot;
        g.resize(foot.dim(), Wide::splat(0.0));
        for start in (0..points.count()).step_by(LANES) {
            let found = points.gather(start, &mut self.z);
            if let Some(phase) = phase {
                phase.sort(&self.z.clone(), &mut self.z);
            }
            let z = [0, 1, 2].map(|part| &self.z[part * n..(part + 1) * n]);
            foot.value(model, &mut self.data, z, g)?;
            for lane in 0..found {
                let h = &mut h[(start + lane) * count + first..];
                for (h, (g, scale)) in h.iter_mut().zip(g.iter().zip(scales)) {
                    *h = g.0[lane] * scale;
                }
            }
        }
        Ok(())
    }

    /// Computes the rows without the running cost, which is skipped if only the state has constraints, also those that
    /// are kept for a part of the time. Returns true if these are all rows of the state.
    pub fn of_all(&mut self, points: Points<'_, f64>, which: RowSelection<'_>, h: &mut [f64]) -> Result<bool> {
        if self.with_control() {
            let mut costs = std::mem::take(&mut self.costs);
            costs.resize(points.count(), 0.0);
            let done = self.others(points, true, h, &mut costs);
            self.costs = costs;
            done?;
        } else {
            self.of_rates(points, h);
            self.of_foot(points, h)?;
        }
        self.of_state(points, which, h)
    }
}
