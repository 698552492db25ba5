//! Rows that have a term.

/// The rows at each point that have a term: most of those of a robot among obstacles are far from being active.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    count: usize,
    rows: Vec<Vec<usize>>,
}

impl Near {
    /// No rows yet of so many in all at so many points.
    pub fn new(count: usize, points: usize) -> Self {
        Self {
            count,
            rows: vec![Vec::new(); points],
        }
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        self.rows.len()
    }

    /// The rows at a point, ascending.
    pub fn at(&self, point: usize) -> &[usize] {
        &self.rows[point]
    }

    /// Those of them below `states`.
    pub fn of_state(&self, point: usize, states: usize) -> impl Iterator<Item = usize> + '_ {
        let rows = self.rows[point].iter().copied();
        rows.take_while(move |row| *row < states)
    }

    /// The places of all rows at all points in what is filed row by row for each point, each with its row.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (points, count) = (self.rows.iter().enumerate(), self.count);
        points.flat_map(move |(g, rows)| rows.iter().map(move |row| (g * count + row, *row)))
    }

    /// Lists the rows at a point anew, of which it is said whether they have a term.
    pub fn list(&mut self, point: usize, rows: impl Iterator<Item = bool>) {
        let near = &mut self.rows[point];
        near.clear();
        near.extend(rows.enumerate().filter_map(|(row, has)| has.then_some(row)));
    }
}
