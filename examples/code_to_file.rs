//! From code to file: a built-in scenario is changed in code and solved; trajectory, summary, the page of the motion
//! and plots go to a new folder in `out`.

use aghf::model::Model;
use aghf::motion::{Sample, sample};
use aghf_cli::output::{OutputFolder, Sampling, write_report, write_text};
use aghf_cli::report::{Motion, page};
use aghf_scenario::{Scenario, Solve};
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

/// A chart of one quantity of all joints over time, as the text of an SVG file.
fn plot(title: &str, model: &Model, samples: &[Sample], of: fn(&Sample) -> &[f64]) -> Result<String, Box<dyn Error>> {
    let all = || samples.iter().flat_map(|s| of(s).iter().copied());
    let (low, high) = all().fold((0.0, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
    let horizon = samples.last().map_or(1.0, |s| s.t);
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (720, 400)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(32)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..horizon, low..high)?;
    chart.configure_mesh().x_desc("time, s").draw()?;
    for (i, joint) in model.joints().iter().enumerate() {
        let line = LineSeries::new(samples.iter().map(|s| (s.t, of(s)[i])), Palette99::pick(i));
        let legend = move |(x, y)| PathElement::new([(x, y), (x + 18, y)], Palette99::pick(i));
        chart.draw_series(line)?.label(joint.name()).legend(legend);
    }
    chart.configure_series_labels().border_style(BLACK).draw()?;
    root.present()?;
    drop((chart, root));
    Ok(svg)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scenario = Scenario::load("kinova_cross_01")?;
    scenario.file.horizon_s += 1.0;
    let report = Solve::new(&scenario).run()?;
    println!("success: {}, effort {:.1}", report.summary.success, report.summary.control_effort);
    // A folder that was not there before: out/code_to_file, then out/code_to_file-2 and so on.
    let folder = OutputFolder::fresh(Path::new("out/code_to_file"))?;
    let model = &scenario.model;
    let page = page(&[Motion::of_report(&scenario, &report)])?;
    let files = write_report(&scenario, &report, Some(&page), &folder, Some(Sampling::Rate(1e3)))?;
    let samples = sample(model, &report.curve, 400)?;
    let (positions, torques) = (folder.path().join("q.svg"), folder.path().join("u.svg"));
    write_text(&plot("positions, rad", model, &samples, |s| &s.q)?, &positions)?;
    write_text(&plot("torques, N m", model, &samples, |s| &s.u)?, &torques)?;
    files.iter().chain([&positions, &torques]).for_each(|file| println!("{}", file.display()));
    Ok(())
}
