//! The active rows out of hundreds.

use super::barrier_cost::BarrierCost;
use super::equality::Equalities;
use super::near::Near;
use super::row::Kind;
use crate::constraint::Constraint;
use crate::relax::CostWithControl;
use crate::relax::tuning::{FAR, LISTED, RESERVE};

impl<K: Constraint, P: CostWithControl> BarrierCost<'_, K, P> {
    /// Returns true if an unlisted row has come so near that it would have a term.
    pub(super) fn is_list_old(&self) -> bool {
        self.rows.unlisted_highest > -FAR
    }

    /// Lists all rows. The next evaluation then covers those that were not listed.
    pub(super) fn list_all(&mut self) {
        let states = self.rows.constraints.state.dim();
        if self.rows.states < states {
            let all: Vec<usize> = (0..states).collect();
            self.list(&all);
        }
    }

    /// Lists, out of all rows, which were evaluated last, those that are near their bound anywhere and all that are not
    /// clearances. With equalities all rows are kept. A row that is NaN counts as near.
    pub(super) fn list_those_near(&mut self) {
        let (count, states) = (self.rows.count(), self.rows.states);
        if self.kinds.iter().any(|kind| *kind != Kind::Inequality) {
            return;
        }
        let floors = &self.rows.of().floors;
        let mut near: Vec<bool> = floors[..states].iter().map(|f| f.is_infinite()).collect();
        for rows in self.h.chunks_exact(count.max(1)) {
            for (near, h) in near.iter_mut().zip(rows) {
                *near |= h.is_nan() || *h > -LISTED;
            }
        }
        let ids = self.rows.ids[..states].iter().zip(near);
        let listed: Vec<usize> = ids.filter_map(|(id, near)| near.then_some(*id)).collect();
        self.list(&listed);
        for (at, row) in self.near.places() {
            if self.multipliers[at] == 0.0 {
                self.multipliers[at] = self.multiplier(at, row);
            }
        }
    }

    /// Updates the list of rows with a term at a point; `h` are its rows with their margins.
    pub(super) fn list_near(&mut self, point: usize) {
        let count = self.rows.count();
        let own = point * count..(point + 1) * count;
        let rows = self.h[own.clone()].iter().zip(&self.kinds[own]);
        let rows = rows.zip(&self.rows.of().floors);
        self.near.list(
            point,
            rows.map(|((h, kind), floor)| match kind {
                Kind::Idle => false,
                // What is no number is not far either.
                Kind::Inequality => h.is_nan() || h >= floor,
                Kind::Equality => true,
            }),
        );
    }

    /// Lists these rows of the state, and moves the data of each row with it.
    fn list(&mut self, rows: &[usize]) {
        let (before, points) = (self.rows.ids.clone(), self.near.points());
        let count_before = before.len();
        self.rows.list(rows);
        let mut places = vec![None; self.rows.count_all()];
        for (place, id) in before.iter().enumerate() {
            places[*id] = Some(place);
        }
        let from: Vec<Option<usize>> = self.rows.ids.iter().map(|id| places[*id]).collect();
        let moved = |values: &[f64], otherwise: f64| -> Vec<f64> {
            let points = (0..points).flat_map(|g| from.iter().map(move |place| (g, place)));
            points
                .map(|(g, place)| place.map_or(otherwise, |place| values[g * count_before + place]))
                .collect()
        };
        self.h = moved(&self.h, f64::NEG_INFINITY);
        self.multipliers = moved(&self.multipliers, 0.0);
        self.margins = moved(&self.margins, RESERVE);
        self.relaxations = moved(&self.relaxations, 0.0);
        let count = self.rows.count();
        self.kinds = vec![Kind::Inequality; points * count];
        self.equalities = Equalities::new(vec![false; count], points);
        self.near = Near::new(count, points);
        for point in 0..points {
            self.list_near(point);
        }
    }
}
