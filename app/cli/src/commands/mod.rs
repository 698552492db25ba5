//! The command line interface, which reads arguments, calls the library and prints results.

mod benchmark;
mod certify;
mod check;
mod choice;
mod compare;
mod doctor;
mod eval;
mod export;
mod ik;
mod import;
mod judge;
mod options;
mod output;
mod pairs;
mod progress;
mod prove;
mod robots;
mod sample;
mod scenarios;
mod signals;
mod solve;
mod stages;
mod sweep;
mod tradeoff;
mod view;

use aghf::error::Error;
use aghf::input::is_standard_input;
use aghf::model::Model;
use aghf::urdf::{LoadNote, LoadReport, Losses, Mimic, UrdfOptions, builtin_robots, load_robot_with, summarised};
use aghf_scenario::{LoadOptions, Scenario, SolveOptions};
use choice::choice;
use clap::{Args, Parser, Subcommand};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit code for a derivative error above its bound, an identity that fails, or a trajectory that is not valid.
const CHECK_FAILED: u8 = 1;
/// Exit code for invalid input.
const BAD_INPUT: u8 = 2;
/// Exit code for a failed solve.
const FAILED: u8 = 3;
/// Exit code for a certificate or a judgement that does not cover all of its scenario.
const IN_PART: u8 = 4;

/// Plans motions of robots by a direct method, or by the Affine Geometric Heat Flow.
///
/// Without a command it plans a motion for kinova_table_01: an arm over a table and past a post, within all limits,
/// with a cost of the duration.
#[derive(Debug, Parser)]
#[command(name = "aghf", version, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const EXIT_CODES: &str = "Exit codes: 0 success, 1 a check, a proof or a trajectory failed, 2 bad input, 3 the motion \
    of a solve is not valid, or no motion can be planned for a robot, 4 a certificate or a judgement covers a part of \
    its scenario.";

#[derive(Debug, Subcommand)]
enum Command {
    Solve(solve::SolveArgs),
    View(view::View),
    Compare(compare::Compare),
    Export(export::Export),
    Sample(sample::Sample),
    Sweep(sweep::Sweep),
    Tradeoff(tradeoff::TradeoffArgs),
    Doctor(doctor::Doctor),
    Robots(robots::Robots),
    #[command(visible_alias = "scenario")]
    Scenarios(scenarios::Scenarios),
    Import(import::Import),
    Judge(judge::Judge),
    Certify(certify::Certify),
    CheckCertificate(certify::CheckCertificate),
    Benchmark(benchmark::Benchmark),
    Pairs(pairs::Pairs),
    Ik(ik::Ik),
    Eval(eval::Eval),
    Check(check::Check),
    Prove(prove::Prove),
}

/// Options of reading a robot.
#[derive(Debug, Args)]
struct UrdfArgs {
    /// Treatment of mimic joints in a URDF file: refuse the robot, or let them move independently.
    #[arg(long, value_parser = choice::<Mimic>(), default_value_t)]
    mimic: Mimic,
    /// The link that becomes the root of the robot, such as the foot on which it stands [default: that of the file].
    #[arg(long, value_name = "LINK")]
    root: Option<String>,
    /// Counts the damping and the friction in the URDF, which are left out otherwise.
    #[arg(long)]
    losses: bool,
    #[command(flatten)]
    packages: PackageArgs,
}

impl UrdfArgs {
    /// Loads the built-in robot of this name, otherwise the one in this file, and prints the notes.
    fn load(&self, robot: &str) -> Result<Model, Error> {
        let (model, notes) = self.load_silently(robot)?;
        tell_notes(robot, &notes);
        Ok(model)
    }

    /// Loads a robot with all notes.
    fn load_silently(&self, robot: &str) -> Result<(Model, LoadReport), Error> {
        load_robot_with(robot, Path::new(""), self.options())
    }

    /// The options of reading a robot.
    fn options(&self) -> UrdfOptions {
        UrdfOptions {
            mimic: self.mimic,
            root: self.root.clone(),
            losses: self.losses.then(Losses::default),
            packages: self.packages.folders(),
            ..UrdfOptions::default()
        }
    }
}

/// The folders of packages.
#[derive(Debug, Default, Args)]
struct PackageArgs {
    /// The folder of a package, for meshes `package://NAME/PATH`; may be given several times. Other packages are
    /// searched for above the URDF, in ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, and by ROS.
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = package)]
    packages: Vec<(String, PathBuf)>,
}

impl PackageArgs {
    /// The folders by the names of the packages; the last one of a name holds.
    fn folders(&self) -> BTreeMap<String, PathBuf> {
        self.packages.iter().cloned().collect()
    }
}

/// Reads the name of a package and its folder.
fn package(text: &str) -> Result<(String, PathBuf), String> {
    let (name, folder) = text.split_once('=').ok_or("NAME=FOLDER is needed")?;
    if !Path::new(folder).is_dir() {
        return Err(format!("there is no folder '{folder}'"));
    }
    Ok((name.to_owned(), PathBuf::from(folder)))
}

/// The robot of a scenario.
#[derive(Debug, Default, Args)]
struct RobotArgs {
    /// For a generated scenario for any robot: a built-in robot, or the path of a URDF file, "-" for the standard input
    /// [default: kinova_gen3].
    #[arg(long, requires = "scenario")]
    robot: Option<String>,
    /// Treatment of mimic joints: refuse the robot, or let them move independently [default: that of the scenario,
    /// otherwise refuse].
    #[arg(long, value_parser = choice::<Mimic>(), requires = "scenario")]
    mimic: Option<Mimic>,
    #[command(flatten)]
    packages: PackageArgs,
    /// Group of the SRDF whose joints are planned; the others are held [default: that of the scenario].
    #[arg(long, requires = "scenario")]
    group: Option<String>,
    /// SRDF with that group [default: that of the scenario].
    #[arg(long, requires = "scenario")]
    srdf: Option<PathBuf>,
}

impl RobotArgs {
    /// Loads the scenario that is built in or generated under this name, otherwise the one in this file.
    fn scenario(&self, scenario: &str) -> Result<Scenario, Error> {
        let (scenario, _) = self.scenario_with_options(scenario)?;
        Ok(scenario)
    }

    /// Loads a scenario with the options of the solve if the file is the summary of one.
    fn scenario_with_options(&self, scenario: &str) -> Result<(Scenario, SolveOptions), Error> {
        let loaded = Scenario::load_with_options(scenario, &self.given())?;
        tell_notes_of([&loaded.0]);
        Ok(loaded)
    }

    /// These options for the library.
    fn given(&self) -> LoadOptions {
        LoadOptions {
            robot: self.robot.clone(),
            mimic: self.mimic,
            packages: self.packages.folders(),
            srdf: self.srdf.clone(),
            group: self.group.clone(),
        }
    }
}

/// Prints the notes from loading a robot that affect its motions. Those of built-in robots are documented
/// (`robots/SOURCES.md`).
fn tell_notes(robot: &str, notes: &[LoadNote]) {
    if builtin_robots().all(|name| name != robot) {
        for note in summarised(notes) {
            let robot = if is_standard_input(Path::new(robot)) { "standard input" } else { robot };
            tell(&format!("note: {robot}: {note}"));
        }
    }
}

/// Prints the notes of the robots of scenarios, once each.
fn tell_notes_of<'a>(scenarios: impl IntoIterator<Item = &'a Scenario>) {
    let mut told = BTreeSet::new();
    for scenario in scenarios {
        if told.insert(&scenario.file.robot) {
            tell_notes(&scenario.file.robot, &scenario.load_notes);
        }
    }
}

/// Runs the command line and returns its exit code.
#[must_use]
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    let command = command.unwrap_or_else(|| Command::Solve(solve::SolveArgs::default()));
    let result = signals::listen().and_then(|()| match command {
        Command::Solve(solve) => solve.run(),
        Command::View(view) => view.run(),
        Command::Compare(compare) => compare.run(),
        Command::Export(export) => export.run(),
        Command::Sample(sample) => sample.run(),
        Command::Sweep(sweep) => sweep.run(),
        Command::Tradeoff(tradeoff) => tradeoff.run(),
        Command::Doctor(doctor) => doctor.run(),
        Command::Robots(robots) => robots.run(),
        Command::Scenarios(scenarios) => scenarios.run(),
        Command::Import(import) => import.run(),
        Command::Judge(judge) => judge.run(),
        Command::Certify(certify) => certify.run(),
        Command::CheckCertificate(check) => check.run(),
        Command::Benchmark(benchmark) => benchmark.run(),
        Command::Pairs(pairs) => pairs.run(),
        Command::Ik(ik) => ik.run(),
        Command::Eval(eval) => eval.run(),
        Command::Check(check) => check.run(),
        Command::Prove(prove) => prove.run(),
    });
    result.unwrap_or_else(|error: Error| {
        tell(&format!("aghf: {error}"));
        ExitCode::from(BAD_INPUT)
    })
}

/// Prints a line to the standard error. A closed reader is not an error.
fn tell(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints to the standard output; a closed reader is not an error.
fn print(text: &str) -> Result<(), Error> {
    use std::io::Write;
    printed(writeln!(std::io::stdout(), "{text}"))
}

/// The result of writing to the standard output.
fn printed(result: std::io::Result<()>) -> Result<(), Error> {
    match result {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("standard output", e)),
        _ => Ok(()),
    }
}

/// Prints a value as JSON.
fn print_json(value: &impl serde::Serialize) -> Result<(), Error> {
    let mut text = Vec::new();
    crate::output::write_json(value, &mut text).map_err(|e| Error::io("standard output", e))?;
    print(&String::from_utf8_lossy(&text))
}
