//! The options of a solve on the command line: a flag for each, made from its schema.

use super::choice::choice;
use aghf::error::Result;
use aghf_scenario::{DescribedOption, Method, SolveOptions, described_options};
use clap::builder::{
    BoolValueParser, PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser, ValueParser,
};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};
use serde_json::{Map, Number, Value};

/// The given options.
#[derive(Debug, Default)]
pub(super) struct OptionArgs {
    method: Option<Method>,
    keys: Map<String, Value>,
}

impl OptionArgs {
    /// The given options, completed by those of the repeated solve if that used the same method.
    pub fn over(self, repeated: &SolveOptions) -> Result<SolveOptions> {
        let method = self.method.unwrap_or(repeated.method());
        let mut keys = if method == repeated.method() { repeated.keys()? } else { Map::new() };
        keys.extend(self.keys);
        SolveOptions::from_keys(method, keys)
    }
}

impl FromArgMatches for OptionArgs {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut keys = Map::new();
        for DescribedOption { name, .. } in described_options() {
            if let Some(value) = matches.get_one::<Value>(&name) {
                keys.insert(name, value.clone());
            }
        }
        let method = matches.get_one(Method::KEY).copied();
        Ok(Self { method, keys })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for OptionArgs {
    fn augment_args(command: Command) -> Command {
        let method = Arg::new(Method::KEY).long(Method::KEY);
        let method = method.value_parser(choice::<Method>());
        let method = method.help(format!("Method; by default {}.", Method::default()));
        command.arg(method).args(described_options().iter().map(flag))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The flag of an option.
fn flag(option: &DescribedOption) -> Arg {
    let helps = option.helps.iter().map(|(help, methods)| {
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        format!("For {}: {help}", methods.join(", "))
    });
    Arg::new(option.name.clone())
        .long(option.name.replace('_', "-"))
        .value_name(option.name.to_uppercase())
        .help(helps.collect::<Vec<_>>().join(" "))
        .allow_negative_numbers(true)
        .value_parser(parser(&option.schema))
}

/// The parser of the values that a schema allows.
fn parser(schema: &Value) -> ValueParser {
    if let Some(choices) = schema["oneOf"].as_array() {
        let text = |choice: &Value, key: &str| choice[key].as_str().unwrap_or_default().to_owned();
        let values =
            choices.iter().map(|choice| PossibleValue::new(text(choice, "const")).help(text(choice, "description")));
        return PossibleValuesParser::new(values).map(Value::from).into();
    }
    let types = &schema["type"];
    let of = |name: &str| types == name || types.as_array().is_some_and(|all| all.iter().any(|one| one == name));
    if of("integer") {
        value_parser!(u64).map(Value::from).into()
    } else if of("number") {
        ValueParser::new(finite)
    } else if of("boolean") {
        BoolValueParser::new().map(Value::from).into()
    } else {
        StringValueParser::new().map(Value::from).into()
    }
}

/// A finite number.
fn finite(text: &str) -> std::result::Result<Value, String> {
    let x: f64 = text.parse().map_err(|e| format!("{e}"))?;
    let number = Number::from_f64(x).map(Value::Number);
    number.ok_or_else(|| format!("it is {x} and must be a finite number"))
}
