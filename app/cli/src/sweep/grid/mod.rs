//! The grids of the methods: lists of values, with a point for every combination.

mod flow;
mod relax;

pub use flow::{FlowGrid, FlowPoint};
pub use relax::{CostLists, LimitLists, RelaxGrid, RelaxPoint};

use aghf::error::plain;
use aghf_scenario::{Method, Scenario, SolveOptions};
use serde::Serialize;
use serde::ser::SerializeStruct;
use std::borrow::Cow;

/// The lists of a sweep, by method.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Grid {
    /// Lists of the flow.
    Flow(FlowGrid),
    /// Lists of the relaxation.
    Relax(RelaxGrid),
}

/// One point of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameters {
    /// Parameters of the flow.
    Flow(FlowPoint),
    /// Parameters of the relaxation.
    Relax(RelaxPoint),
}

/// The faulty key, and the reason.
pub(super) type Refusal = (String, String);

impl Grid {
    /// The keys of the lists of a method.
    pub(super) fn keys(method: Method) -> &'static [&'static str] {
        match method {
            Method::Flow => &FlowGrid::KEYS,
            Method::Relax => &RelaxGrid::KEYS,
        }
    }

    /// The method of the grid.
    #[must_use]
    pub fn method(&self) -> Method {
        match self {
            Self::Flow(_) => Method::Flow,
            Self::Relax(_) => Method::Relax,
        }
    }

    /// Refuses values that are invalid for all scenarios.
    pub(super) fn check(&self) -> Result<(), Refusal> {
        match self {
            Self::Flow(grid) => grid.check(),
            Self::Relax(grid) => grid.check(),
        }
    }

    /// Refuses values that are invalid for this scenario.
    pub(super) fn check_for(&self, scenario: &Scenario) -> Result<(), String> {
        match self {
            Self::Flow(grid) => grid.check_for(scenario),
            Self::Relax(grid) => grid.check_for(scenario),
        }
    }

    /// The lengths of the lists, beginning with the last one, which varies fastest.
    fn lengths(&self) -> Vec<usize> {
        match self {
            Self::Flow(grid) => grid.lengths(),
            Self::Relax(grid) => grid.lengths(),
        }
    }

    /// The number of points; `None` on overflow.
    pub(super) fn count(&self) -> Option<usize> {
        let mut lengths = self.lengths().into_iter();
        lengths.try_fold(1, usize::checked_mul)
    }

    /// The number of repetitions of each set of parameters, which is that of seeds.
    pub(super) fn repetitions(&self) -> usize {
        match self {
            Self::Flow(_) => 1,
            Self::Relax(grid) => grid.seed.as_ref().map_or(1, Vec::len),
        }
    }

    /// The point with this index, from 0.
    pub(super) fn point(&self, index: usize) -> Parameters {
        match self {
            Self::Flow(grid) => Parameters::Flow(grid.point(index)),
            Self::Relax(grid) => Parameters::Relax(grid.point(index)),
        }
    }
}

impl Parameters {
    /// The parameters of the flow, if it is the method.
    #[must_use]
    pub fn flow(&self) -> Option<&FlowPoint> {
        match self {
            Self::Flow(point) => Some(point),
            Self::Relax(_) => None,
        }
    }

    /// The parameters of the relaxation, if it is the method.
    #[must_use]
    pub fn relax(&self) -> Option<&RelaxPoint> {
        match self {
            Self::Flow(_) => None,
            Self::Relax(point) => Some(point),
        }
    }

    /// The options of a solve with these parameters.
    pub(super) fn options(&self) -> SolveOptions {
        match self {
            Self::Flow(point) => point.options(),
            Self::Relax(point) => point.options(),
        }
    }

    /// Applies the parameters to `scenario`.
    pub(super) fn over<'s>(&self, scenario: &'s Scenario) -> Cow<'s, Scenario> {
        match self {
            Self::Flow(_) => Cow::Borrowed(scenario),
            Self::Relax(point) => point.over(scenario),
        }
    }

    /// The parameters without the seed.
    pub(super) fn of_any_seed(self) -> Self {
        match self {
            Self::Flow(_) => self,
            Self::Relax(point) => Self::Relax(RelaxPoint {
                seed: None,
                ..point
            }),
        }
    }

    /// Writes the parameters as columns of a row.
    pub(super) fn columns<S: SerializeStruct>(&self, row: &mut S) -> Result<(), S::Error> {
        match self {
            Self::Flow(point) => point.columns(row),
            Self::Relax(point) => point.columns(row),
        }
    }

    /// Names and values of the parameters for a table.
    pub(super) fn cells(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Flow(point) => point.cells(),
            Self::Relax(point) => point.cells(),
        }
    }
}

/// The entry of a list at its digit of `index`, which is divided to give the digits of the slower lists.
fn entry<T: Copy>(list: &[T], index: &mut usize) -> T {
    let entry = list[*index % list.len()];
    *index /= list.len();
    entry
}

/// The entry of an optional list, found as by [`entry`].
fn optional<T: Copy>(list: &Option<Vec<T>>, index: &mut usize) -> Option<T> {
    list.as_ref().map(|list| entry(list, index))
}

/// The factor by which an optional list enlarges the grid.
fn length<T>(list: &Option<Vec<T>>) -> usize {
    list.as_ref().map_or(1, Vec::len)
}

/// The largest number of values in a list: each is compared with those before it.
const MOST_VALUES: usize = 10_000;

/// Refuses a list that is empty or too long, has a value that `wrong` rejects, or has a value twice.
fn check_list<T: PartialEq>(
    key: &str,
    list: &[T],
    wrong: impl Fn(&T) -> Option<String>,
) -> Result<(), Refusal> {
    if list.is_empty() {
        return Err((key.to_owned(), "it is an empty list".to_owned()));
    }
    if list.len() > MOST_VALUES {
        let condition = format!(
            "it has {} values, at most {MOST_VALUES} are possible",
            list.len()
        );
        return Err((key.to_owned(), condition));
    }
    for (i, value) in list.iter().enumerate() {
        let twice = || list[..i].contains(value);
        let twice = || twice().then(|| "the value is there already".to_owned());
        if let Some(condition) = wrong(value).or_else(twice) {
            return Err((format!("{key}[{i}]"), condition));
        }
    }
    Ok(())
}

/// Checks an optional list as [`check_list`] does.
fn check_optional<T: PartialEq>(
    key: &str,
    list: &Option<Vec<T>>,
    wrong: impl Fn(&T) -> Option<String>,
) -> Result<(), Refusal> {
    match list {
        Some(list) => check_list(key, list, wrong),
        None => Ok(()),
    }
}

/// The fault of a number that must be positive, if it has one.
fn not_positive(x: &f64) -> Option<String> {
    let positive = x.is_finite() && *x > 0.0;
    (!positive).then(|| format!("it is {}, a positive number is needed", plain(*x)))
}
