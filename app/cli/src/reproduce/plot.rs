//! Pictures of Figures 4 and 5 and of the actions of the variants.

use super::{ActionPath, Quantity, Series, fit};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::error::Error;
use std::io;
use std::ops::Range;

const SIZE: (u32, u32) = (720, 480);
/// Blue, orange, green and pink that colour-blind readers can distinguish.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];
/// The number of points of a curve.
const CURVE: usize = 40;

/// Draws one figure: means, standard deviations and polynomials of its quantities over `N`, both axes logarithmic.
pub(super) fn figure(number: usize, series: &[Series]) -> io::Result<String> {
    draw(number, series).map_err(|e| io::Error::other(e.to_string()))
}

fn draw(number: usize, series: &[Series]) -> Result<String, Box<dyn Error>> {
    let shown: Vec<&Series> = (series.iter())
        .filter(|s| s.quantity.figure() == number)
        .collect();
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let what = if number == 4 {
        "the right-hand side of the flow"
    } else {
        "the Jacobian of the right-hand side"
    };
    let points = || shown.iter().flat_map(|s| s.means());
    let (across, up) = (
        range(points().map(|p| p.0), 1.15),
        range(points().map(|p| p.1), 2.0),
    );
    let mut chart = ChartBuilder::on(&root)
        .caption(
            format!("Time of {what} at one node (cf. Figure {number})"),
            ("sans-serif", 18),
        )
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(Logarithmic(across.clone()), Logarithmic(up.clone()))?;
    chart
        .configure_mesh()
        .x_desc("number of joints N")
        .y_desc("time, microseconds")
        .axis_desc_style(("sans-serif", 15))
        .label_style(("sans-serif", 13))
        .light_line_style(WHITE)
        .x_labels(12)
        .y_labels(12)
        .draw()?;
    for (series, colour) in shown.iter().zip(COLOURS) {
        let bars = series.points.iter().map(|(_, n, times)| {
            let (mean, deviation) = (1e6 * times.mean, 1e6 * times.deviation);
            let low = (mean - deviation).max(up.start);
            ErrorBar::new_vertical(*n as f64, low, mean, mean + deviation, colour.filled(), 7)
        });
        chart
            .draw_series(bars)?
            .label(legend(series.quantity, series.power_law()))
            .legend(move |at| dash(at, colour));
        let Some(coefficients) = series.polynomial() else {
            continue;
        };
        let first = series.means().first().map_or(1.0, |p| p.0);
        let last = series.means().last().map_or(1.0, |p| p.0);
        let step = (last / first).powf(1.0 / CURVE as f64);
        // A polynomial may leave the picture where it is far from any point.
        let curve = (0..=CURVE)
            .map(|i| first * step.powi(i as i32))
            .map(|n| (n, fit::value(&coefficients, n)))
            .filter(|(_, t)| up.contains(t));
        chart.draw_series(LineSeries::new(curve, colour.stroke_width(1)))?;
    }
    draw_legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
    root.present()?;
    drop(chart);
    drop(root);
    Ok(text)
}

/// Draws the action against `s`, one line per flow, both axes logarithmic; points with a coordinate that is not
/// positive are left out.
pub(super) fn actions(scenario: &str, paths: &[ActionPath]) -> io::Result<String> {
    draw_actions(scenario, paths).map_err(|e| io::Error::other(e.to_string()))
}

fn draw_actions(scenario: &str, paths: &[ActionPath]) -> Result<String, Box<dyn Error>> {
    let lines = paths.iter().map(|path| {
        let points = path.points.iter().copied();
        points
            .filter(|(s, action)| *s > 0.0 && *action > 0.0 && s.is_finite() && action.is_finite())
    });
    let points = || lines.clone().flatten();
    if points().next().is_none() {
        return Err(format!("no flow of {scenario} has a positive action to draw").into());
    }
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(format!("Action on the way, {scenario}"), ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(
            Logarithmic(range(points().map(|p| p.0), 2.0)),
            Logarithmic(range(points().map(|p| p.1), 2.0)),
        )?;
    chart
        .configure_mesh()
        .x_desc("s")
        .y_desc("action")
        .axis_desc_style(("sans-serif", 15))
        .label_style(("sans-serif", 13))
        .light_line_style(WHITE)
        .draw()?;
    for ((path, line), colour) in paths.iter().zip(lines.clone()).zip(COLOURS) {
        chart
            .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
            .label(path.variant)
            .legend(move |at| dash(at, colour));
    }
    draw_legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    root.present()?;
    drop(chart);
    drop(root);
    Ok(text)
}

/// Draws the names of the series in a frame.
fn draw_legend<'a, X: Ranged, Y: Ranged>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
    position: SeriesLabelPosition,
) -> Result<(), Box<dyn Error>> {
    chart
        .configure_series_labels()
        .position(position)
        .margin(14)
        .label_font(("sans-serif", 13))
        .background_style(WHITE)
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

/// The mark of a series next to its name.
fn dash((x, y): (i32, i32), colour: RGBColor) -> PathElement<(i32, i32)> {
    PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2))
}

fn legend(quantity: Quantity, power: Option<(f64, f64)>) -> String {
    let power = power.map_or_else(String::new, |(_, e)| format!(", about N^{e:.1}"));
    format!("{}{power}", quantity.name())
}

/// The range of positive numbers, extended by a factor on both sides.
fn range(numbers: impl Iterator<Item = f64> + Clone, room: f64) -> Range<f64> {
    let low = numbers.clone().fold(f64::INFINITY, f64::min);
    let high = numbers.fold(0.0, f64::max);
    low / room..high * room
}

/// The largest number of decades with marks at 1, 2 and 5.
const FEW_DECADES: i32 = 4;
/// The approximate number of marked powers of ten beyond that.
const POWERS: i32 = 10;

/// A logarithmic axis with marks at 1, 2 and 5 of every decade, or at powers of ten if there are many decades.
#[derive(Clone)]
struct Logarithmic(Range<f64>);

impl Ranged for Logarithmic {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (low, high): (i32, i32)) -> i32 {
        let share = (value / self.0.start).ln() / (self.0.end / self.0.start).ln();
        low + (share * f64::from(high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        let first = self.0.start.log10().floor() as i32;
        let last = self.0.end.log10().ceil() as i32;
        let count = last - first;
        let (marks, every): (&[f64], i32) = if count <= FEW_DECADES {
            (&[1.0, 2.0, 5.0], 1)
        } else {
            (&[1.0], count / POWERS + 1)
        };
        (first..=last)
            .step_by(every as usize)
            .flat_map(|d| marks.iter().map(move |m| m * 10_f64.powi(d)))
            .filter(|x| self.0.contains(x))
            .collect()
    }

    fn range(&self) -> Range<f64> {
        self.0.clone()
    }
}

impl ValueFormatter<f64> for Logarithmic {
    fn format(value: &f64) -> String {
        if (1e-3..1e6).contains(value) {
            // Such as 0.30000000000000004 is 0.3 to the reader.
            format!("{}", (value * 1e6).round() / 1e6)
        } else {
            format!("{value:.0e}")
        }
    }
}
