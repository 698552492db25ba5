//! The rows with a term.

/// The rows with a term at each point: most rows of a robot among obstacles are far from active.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    count: usize,
    rows: Vec<Vec<usize>>,
}

impl Near {
    /// An empty list for `count` rows and this number of points.
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

    /// The rows with a term at a point that are below `states`.
    pub fn of_state(&self, point: usize, states: usize) -> impl Iterator<Item = usize> + '_ {
        let rows = self.rows[point].iter().copied();
        rows.take_while(move |row| *row < states)
    }

    /// The indices of all listed rows in data stored row by row for each point, each with its row.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (points, count) = (self.rows.iter().enumerate(), self.count);
        points.flat_map(move |(g, rows)| rows.iter().map(move |row| (g * count + row, *row)))
    }

    /// Replaces the list at a point; `rows` gives for each row whether it has a term.
    pub fn list(&mut self, point: usize, rows: impl Iterator<Item = bool>) {
        let near = &mut self.rows[point];
        near.clear();
        near.extend(rows.enumerate().filter_map(|(row, has)| has.then_some(row)));
    }
}
