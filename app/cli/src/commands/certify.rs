//! `aghf certify` and `aghf check-certificate`.

use super::compare::summary_at;
use super::{CHECK_FAILED, IN_PART, RobotArgs, print};
use crate::output::{certification_text, refuse_existing, table_difference_text, write_json, write_text};
use aghf::error::{Error, Result};
use aghf::input::{read_bytes, read_text};
use aghf::urdf::mesh_path;
use aghf_scenario::certify::{Certificate, NAME, TOLERANCE, Texts, certify, named_run, table_differences};
use aghf_scenario::judge::Trajectory;
use aghf_scenario::{Details, Solved};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Proves that a motion keeps the promises of its scenario at all times, and writes the proof.
///
/// Limits of positions, velocities, accelerations, jerks and torques, clearances, conditions along the way and the
/// force on a standing foot are proved for every time, not for samples, and the states at both ends and at waypoints,
/// with rounding accounted for. The certificate lists intervals and a reserve of each promise on each; `aghf-check` and
/// `python -m aghf.check_certificate` check it with code of their own. Exit code 1, and no file, if a promise is broken
/// or cannot be proved; the message names each row, its time and its excess. Parts of the scenario that certificates do
/// not cover yet are listed in it and printed, with exit code 4.
#[derive(Debug, Args)]
pub(super) struct Certify {
    /// A built-in or generated scenario, or the path of a JSON file, "-" for the standard input.
    scenario: String,
    #[command(flatten)]
    robot: RobotArgs,
    /// Folder of a solve, or its summary.json.
    run: PathBuf,
    /// File for the certificate.
    #[arg(long, short, default_value = "certificate.json")]
    out: PathBuf,
    /// The largest deviation of the position of each joint from the motion, as its controller keeps it, rad or m:
    /// all is proved for positions within it, with the velocities and accelerations of the motion.
    #[arg(long, value_name = "RAD", default_value_t = 0.0)]
    tracking_error: f64,
    /// Replaces the file if it exists.
    #[arg(long)]
    force: bool,
}

impl Certify {
    pub(super) fn run(self) -> Result<ExitCode> {
        refuse_existing(&self.out, self.force)?;
        let scenario = self.robot.scenario(&self.scenario)?;
        let run = summary_at(&self.run)?;
        let solved = Solved::load(&run)?;
        (solved.summary.curve).check_joints(&scenario.model, &run)?;
        let run = read_text(Path::new(&run))?;
        let full = json(&scenario.file)?;
        let given = self.given()?;
        let scenarios = given.iter().chain([&full]).map(String::as_str);
        let scenarios: Vec<&str> = scenarios.collect();
        let texts = Texts { scenario: &scenarios, run: &run };
        let begin = Instant::now();
        let times = match &solved.summary.details {
            Details::Direct(details) => &details.waypoint_times_s[..],
            _ => &[],
        };
        let curve = &solved.summary.curve;
        let certification = certify(&scenario, curve, texts, times, self.tracking_error)?;
        let seconds = begin.elapsed().as_secs_f64();
        print(&certification_text(&certification, scenario.robot_shape(), seconds))?;
        let Some(certificate) = certification.certificate else {
            return Ok(ExitCode::from(CHECK_FAILED));
        };
        let text = json(&certificate)?;
        let packages = &scenario.file.packages;
        let mesh = |name: &str| read_bytes(&mesh_path(name, scenario.source.folder(), packages).ok()?).ok();
        let checked = aghf_check::check([&scenario.source.text, &full, &run, &text], &mesh);
        let report = match checked {
            Ok(report) => report,
            Err(fault) => {
                print(&format!("not certified: the checker refuses the certificate: {fault}"))?;
                return Ok(ExitCode::from(CHECK_FAILED));
            }
        };
        if certificate.complete && !report.is_complete {
            print(&report.text)?;
        }
        write_text(&text, &self.out)?;
        print(&format!("wrote {}", self.out.display()))?;
        Ok(if report.is_complete { ExitCode::SUCCESS } else { ExitCode::from(IN_PART) })
    }

    /// The text of the scenario as it was given, if it is a file.
    fn given(&self) -> Result<Option<String>> {
        let path = Path::new(&self.scenario);
        path.is_file().then(|| read_text(path)).transpose()
    }
}

/// The text of a JSON file.
fn json(value: &impl Serialize) -> Result<String> {
    let mut text = Vec::new();
    write_json(value, &mut text).map_err(|e| Error::io("certificate", e))?;
    Ok(format!("{}\n", String::from_utf8_lossy(&text)))
}

/// Checks a certificate with code that shares nothing with the planner, as the program `aghf-check` does.
///
/// Exit code 1 and the reason if the certificate is refused, 4 if it leaves a part of the scenario out or a mesh is not
/// read, which is printed. Meshes in STL and OBJ are read.
#[derive(Debug, Args)]
pub(super) struct CheckCertificate {
    /// The URDF file of the robot.
    robot: PathBuf,
    /// The JSON file of the scenario, or a summary.json, which contains one.
    scenario: PathBuf,
    /// The summary.json of the solve.
    run: PathBuf,
    /// The certificate.
    certificate: PathBuf,
    /// A folder of packages with meshes, which are also looked up in the folder of the URDF and in those above it.
    #[arg(long, value_name = "FOLDER")]
    packages: Vec<PathBuf>,
    /// A table or a message with the motion, as `aghf sample` and `aghf export` write them: the difference from the
    /// certified motion is bounded at all times, for straight lines between the samples, and for cubics and quintics if
    /// there are velocities and accelerations. Exit code 4 if each is beyond the tracking error of the certificate; a
    /// file that names another motion is an error.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

impl CheckCertificate {
    /// Bounds the difference of a table from the certified motion, in words; true if it is within the tracking error.
    fn check_table(&self, path: &Path) -> Result<(Vec<String>, bool)> {
        let run = self.run.display().to_string();
        let Solved { scenario, summary, .. } = Solved::load(&run)?;
        let certificate: Certificate = serde_json::from_str(&read_text(&self.certificate)?)
            .map_err(|e| Error::input(self.certificate.display().to_string(), "certificate", e.to_string()))?;
        let (name, text) = (path.display().to_string(), read_text(path)?);
        if named_run(&text).is_some_and(|hash| hash != certificate.run_sha256) {
            let condition = "it names another motion than the certificate";
            return Err(Error::input(name, NAME.trim_end_matches(':'), condition));
        }
        let table = Trajectory::load(path, &scenario.model)?;
        let found = table_differences(&scenario, &summary.curve, &table)?;
        let (count, tube) = (table.times.len(), certificate.tracking_error.max(TOLERANCE));
        let differences = found.iter();
        let text = |difference| table_difference_text(&name, count, difference);
        let mut lines: Vec<String> = differences.map(text).collect();
        let least = found.iter().map(|of| of.position).fold(f64::INFINITY, f64::min);
        if least > tube {
            lines.push(format!(
                "{name}: beyond the tracking error of the certificate, or the tolerance {TOLERANCE}; \
                 `aghf certify --tracking-error` takes a larger one"
            ));
        }
        Ok((lines, least <= tube))
    }

    pub(super) fn run(self) -> Result<ExitCode> {
        let files = [&self.robot, &self.scenario, &self.run, &self.certificate];
        let [robot, scenario, run, certificate] = files.map(|file| read_text(file));
        let mesh = |name: &str| aghf_check::find_mesh(name, &self.robot, &self.packages);
        match aghf_check::check([&robot?, &scenario?, &run?, &certificate?], &mesh) {
            Ok(report) => {
                let table = self.table.as_ref().map(|table| self.check_table(table));
                let (lines, is_kept) = table.unwrap_or_else(|| Ok((Vec::new(), true)))?;
                print(&[&[report.text][..], &lines].concat().join("\n"))?;
                Ok(if report.is_complete && is_kept { ExitCode::SUCCESS } else { ExitCode::from(IN_PART) })
            }
            Err(fault) => {
                print(&format!("refused: {fault}"))?;
                Ok(ExitCode::from(CHECK_FAILED))
            }
        }
    }
}
