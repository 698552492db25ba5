//! The grid of a sweep: lists of values of options and of keys of the scenario, with a point for every combination.

use aghf::error::{Error, Result};
use aghf_scenario::{Method, Scenario, SolveOptions};
use serde_json::{Map, Value, json};

/// The largest number of values in a list: each is compared with those before it.
const MAX_VALUES: usize = 10_000;

/// The faulty key, and the reason.
pub(super) type Refusal = (String, String);

/// A list of values of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The name of the option, or the key of the scenario, with dots before the keys of inner objects.
    pub name: String,
    /// The values.
    pub values: Vec<Value>,
    /// True for a key of the scenario.
    pub of_scenario: bool,
}

/// The parameters of a sweep. The last one varies fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    parameters: Vec<Parameter>,
}

impl Grid {
    /// The option that counts as a repetition, which a ranking combines.
    pub const SEED: &'static str = "seed";

    /// The grid of these lists. Seeds vary slowest, so that all points of one stand together.
    ///
    /// # Errors
    /// A list is empty or too long, or has a value twice.
    pub(super) fn new(mut parameters: Vec<Parameter>) -> std::result::Result<Self, Refusal> {
        for Parameter { name, values, .. } in &parameters {
            if values.is_empty() {
                return Err((name.clone(), "it is an empty list".to_owned()));
            }
            if values.len() > MAX_VALUES {
                let count = values.len();
                let condition = format!("it has {count} values, at most {MAX_VALUES} are possible");
                return Err((name.clone(), condition));
            }
            for (i, value) in values.iter().enumerate() {
                if values[..i].iter().any(|other| is_same(other, value)) {
                    let condition = "the value is there already".to_owned();
                    return Err((format!("{name}[{i}]"), condition));
                }
            }
        }
        parameters.sort_by_key(|parameter| parameter.name != Self::SEED);
        Ok(Self { parameters })
    }

    /// The parameters, the slowest first.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The number of points; `None` on overflow.
    pub(super) fn count(&self) -> Option<usize> {
        let mut lengths = self.parameters.iter().map(|p| p.values.len());
        lengths.try_fold(1, usize::checked_mul)
    }

    /// The number of repetitions of each set of parameters, which is that of seeds.
    pub(super) fn repetitions(&self) -> usize {
        let seeds = self.parameters.iter().filter(|p| p.name == Self::SEED);
        seeds.map(|p| p.values.len()).product()
    }

    /// The parameters of the options alone, or of the scenario alone.
    pub(super) fn part(&self, of_scenario: bool) -> Self {
        let own = |p: &&Parameter| p.of_scenario == of_scenario;
        let parameters = self.parameters.iter().filter(own).cloned().collect();
        Self { parameters }
    }

    /// The index of a point in the part of the scenario alone.
    pub(super) fn scenario_point(&self, point: usize) -> usize {
        let digits = self.parameters.iter().zip(self.digits(point));
        let own = digits.filter(|(p, _)| p.of_scenario);
        own.fold(0, |index, (p, digit)| index * p.values.len() + digit)
    }

    /// The index into the list of each parameter at a point.
    fn digits(&self, mut point: usize) -> Vec<usize> {
        let mut digits = vec![0; self.parameters.len()];
        for (digit, parameter) in digits.iter_mut().zip(&self.parameters).rev() {
            *digit = point % parameter.values.len();
            point /= parameter.values.len();
        }
        digits
    }

    /// The values at a point, by name.
    #[must_use]
    pub fn point(&self, point: usize) -> Map<String, Value> {
        let digits = self.parameters.iter().zip(self.digits(point));
        digits.map(|(p, digit)| (p.name.clone(), p.values[digit].clone())).collect()
    }

    /// The options of a solve with these keys.
    pub(super) fn options(method: Method, mut keys: Map<String, Value>) -> Result<SolveOptions> {
        if method == Method::Direct {
            // The sets of a sweep share the cores.
            keys.entry("threads").or_insert(json!(1));
        }
        SolveOptions::from_keys(method, keys)
    }

    /// Refuses options that are invalid in `scenario`, alone or in combination.
    pub(super) fn check_options(&self, method: Method, scenario: &Scenario) -> std::result::Result<(), Refusal> {
        for point in 0..self.count().unwrap_or(0) {
            let options = Self::options(method, self.point(point));
            let checked = options.and_then(|options| options.check(scenario));
            checked.map_err(|error| self.refusal(point, error))?;
        }
        Ok(())
    }

    /// The scenario at each point of the part of the scenario.
    pub(super) fn variants(&self, scenario: &Scenario) -> std::result::Result<Vec<Scenario>, Refusal> {
        let points = 0..self.count().unwrap_or(0);
        let variant = |point| {
            let made = scenario.with_keys(&self.point(point));
            made.map_err(|error| self.refusal(point, error))
        };
        points.map(variant).collect()
    }

    /// The value at a point at which an error points, as the place in its list.
    fn refusal(&self, point: usize, error: Error) -> Refusal {
        let Error::Input { element, condition, .. } = error else {
            return ("sweep".to_owned(), error.to_string());
        };
        let own = |(p, _): &(&Parameter, usize)| {
            let rest = element.strip_prefix(&p.name);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let mut digits = self.parameters.iter().zip(self.digits(point));
        match digits.find(own) {
            Some((p, digit)) => (format!("{}[{digit}]", p.name), condition),
            None => (element, condition),
        }
    }
}

/// Returns true if two values are the same, however their numbers are written.
fn is_same(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

/// A value in a table: numbers in the shorter of the plain and the scientific form.
pub(super) fn in_table(value: &Value) -> String {
    match (value, value.as_f64()) {
        (_, Some(x)) => {
            let (plain, scientific) = (format!("{x}"), format!("{x:e}"));
            if scientific.len() < plain.len() { scientific } else { plain }
        }
        (other, None) => crate::output::csv_cell(other),
    }
}
