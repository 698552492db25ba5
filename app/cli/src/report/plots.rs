//! Plots as SVG with one curve per joint. They contain no text from the user.

use aghf::error::Result;
use plotters::coord::Shift;
use plotters::prelude::*;
use serde::Serialize;
use std::error::Error;
use std::ops::Range;

/// The number of SVG units per pixel of the page, because plotters draw at integers.
const FINE: i32 = 4;
const SIZE: [i32; 2] = [330, 160];
/// The space for labels of up to eight characters on the left, for labels below, and beyond the ends of the axes.
const LEFT_SPACE: i32 = 52;
const BELOW: i32 = 20;
const MARGIN: i32 = 8;
const FONT: i32 = 11;
/// The height of the strip beyond a bound, relative to that of the plot: strips of several joints mostly stay apart.
const STRIP: f64 = 0.03;
/// The opacities of strips by themselves, and of those that overlap others: by the second one the page recognises the
/// strips that it shows with a chosen joint alone.
const ALONE: f64 = 0.3;
const TOGETHER: f64 = 0.25;
/// The least range of a plot relative to its values: labels of four digits then distinguish its ticks.
const FLAT: f64 = 1e-2;
/// The colours that the page replaces by its own.
const INK: RGBColor = RGBColor(1, 1, 1);
const GRID: RGBColor = RGBColor(2, 2, 2);
/// Blue, orange, green and others that colour-blind readers can distinguish.
pub(super) const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(200, 140, 0),
    RGBColor(70, 160, 220),
    RGBColor(122, 92, 201),
    RGBColor(140, 130, 40),
];

/// A plot and the position of its axes.
#[derive(Serialize)]
pub(super) struct Plot {
    pub title: String,
    pub unit: &'static str,
    pub svg: String,
    /// Left, right, top and bottom of the axes as fractions of width and height.
    frame: [f64; 4],
    /// The values at both ends of the horizontal axis.
    from: f64,
    to: f64,
    /// True if the horizontal axis is time, s.
    time: bool,
    /// True if it has one curve per joint.
    per_joint: bool,
    /// Names and colours of the curves if they are not the joints.
    legend: Vec<[String; 2]>,
}

/// A curve with its bounds.
pub(super) struct Line {
    pub points: Vec<(f64, f64)>,
    pub colour: RGBColor,
    pub bounds: Range<f64>,
}

/// The axes of a plot.
pub(super) struct Axes {
    pub title: String,
    pub unit: &'static str,
    pub time: bool,
    pub logarithmic: bool,
    pub per_joint: bool,
    pub legend: Vec<[String; 2]>,
}

/// The colour of each of `count` curves.
pub(super) fn colours(count: usize) -> Vec<RGBColor> {
    if count <= COLOURS.len() {
        return COLOURS[..count].to_vec();
    }
    let colour = |i: usize| {
        // Neighbours differ in lightness, too.
        let lightness = [0.44, 0.60][i % 2];
        let (r, g, b) = HSLColor(i as f64 / count as f64, 0.62, lightness).rgb();
        RGBColor(r, g, b)
    };
    (0..count).map(colour).collect()
}

/// A colour in CSS.
pub(super) fn css(colour: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}

/// The range of a plot: that of the curves, and of bounds that are near.
fn range_of(lines: &[Line], logarithmic: bool) -> Range<f64> {
    let values = || lines.iter().flat_map(|line| &line.points).map(|p| p.1);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    if !(low.is_finite() && high.is_finite()) {
        return -1.0..1.0;
    }
    let least = if logarithmic { 1.0 } else { FLAT * low.abs().max(high.abs()).max(1e-7) };
    let span = (high - low).max(least);
    let near = (low - 0.4 * span)..(high + 0.4 * span);
    let bounds = lines.iter().flat_map(|l| [l.bounds.start, l.bounds.end]);
    let all = bounds.filter(|bound| near.contains(bound)).chain([low, high]);
    let low = all.clone().fold(f64::INFINITY, f64::min);
    let high = all.fold(f64::NEG_INFINITY, f64::max);
    let pad = 0.07 * (high - low).max(least);
    low - pad..high + pad
}

/// Formats a number at an axis with up to four digits, without rounding errors; `range` is that of the axis.
fn label(x: f64, range: &Range<f64>) -> String {
    let scale = range.start.abs().max(range.end.abs());
    if x.abs() < 1e-9 * scale {
        return "0".to_owned();
    }
    let rounded = format!("{x:.3e}");
    let (digits, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    if (1e-3..1e5).contains(&x.abs()) {
        rounded.parse::<f64>().unwrap_or(x).to_string()
    } else {
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        format!("{digits}e{exponent}")
    }
}

/// Formats a number at a logarithmic axis: only powers of ten, unless the axis has too few of them.
fn power_label(x: f64, few: bool) -> String {
    let whole = (x - x.round()).abs() < 1e-6;
    match (few, whole) {
        (true, _) => format!("{:.2e}", 10_f64.powf(x)),
        (false, true) => format!("1e{}", x.round()),
        (false, false) => String::new(),
    }
}

/// Draws curves with a strip in the colour of each beyond its bounds, and a grey one where strips overlap.
pub(super) fn plot(axes: Axes, lines: &[Line]) -> Result<Plot> {
    let across = lines.iter().flat_map(|l| &l.points).map(|p| p.0);
    let across = across.clone().fold(f64::INFINITY, f64::min)..across.fold(1e-9, f64::max);
    let mut text = String::new();
    let size = (SIZE[0] * FINE, SIZE[1] * FINE);
    {
        let size = (size.0 as u32, size.1 as u32);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&root, &axes, lines, &across)
            .map_err(|e| aghf::error::Error::input("report", axes.title.clone(), e.to_string()))?;
    }
    let [width, height] = SIZE.map(f64::from);
    Ok(Plot {
        title: axes.title,
        unit: axes.unit,
        svg: text.replace(" fill=\"none\" opacity=\"1\"", "").replace(" \"/>", "\"/>"),
        frame: [
            f64::from(MARGIN + LEFT_SPACE) / width,
            1.0 - f64::from(MARGIN) / width,
            f64::from(MARGIN) / height,
            1.0 - f64::from(MARGIN + BELOW) / height,
        ],
        from: across.start,
        to: across.end,
        time: axes.time,
        per_joint: axes.per_joint,
        legend: axes.legend,
    })
}

/// A strip beyond a bound of a curve: its colour, and where it begins and ends.
struct Strip {
    colour: RGBColor,
    from: f64,
    to: f64,
}

impl Strip {
    fn overlaps(&self, other: &Self) -> bool {
        self.from < other.to && other.from < self.to
    }
}

/// The strips of curves in a range.
fn strips_of(lines: &[Line], up: &Range<f64>) -> Vec<Strip> {
    let height = STRIP * (up.end - up.start);
    let each = lines.iter().flat_map(|line| {
        let Range { start, end } = line.bounds;
        let both = [(start, start - height, start), (end, end, end + height)];
        let within = both.into_iter().filter(|(bound, ..)| up.contains(bound));
        within.map(|(_, from, to)| Strip { colour: line.colour, from: from.max(up.start), to: to.min(up.end) })
    });
    each.collect()
}

/// The strips that overlap others, and the rest.
fn apart(strips: Vec<Strip>) -> (Vec<Strip>, Vec<Strip>) {
    let overlaps = |strip: &Strip| strips.iter().filter(|other| strip.overlaps(other)).count() > 1;
    let together: Vec<bool> = strips.iter().map(overlaps).collect();
    let mut together = together.into_iter();
    strips.into_iter().partition(|_| together.next() == Some(true))
}

/// The unions of strips that overlap.
fn joined(mut strips: Vec<Strip>) -> Vec<Strip> {
    strips.sort_by(|a, b| a.from.total_cmp(&b.from));
    let mut all = Vec::<Strip>::new();
    for strip in strips {
        match all.last_mut().filter(|last| last.overlaps(&strip)) {
            Some(last) => last.to = last.to.max(strip.to),
            None => all.push(strip),
        }
    }
    all
}

type Drawn = std::result::Result<(), Box<dyn Error>>;

fn draw(root: &DrawingArea<SVGBackend<'_>, Shift>, axes: &Axes, lines: &[Line], across: &Range<f64>) -> Drawn {
    let up = range_of(lines, axes.logarithmic);
    let fine = |x: i32| x * FINE;
    let mut chart = ChartBuilder::on(root)
        .margin(fine(MARGIN))
        .x_label_area_size(fine(BELOW))
        .y_label_area_size(fine(LEFT_SPACE))
        .build_cartesian_2d(across.clone(), up.clone())?;
    let mut rectangle = |strip: &Strip, style: RGBAColor| {
        let corners = [(across.start, strip.from), (across.end, strip.to)];
        let drawn = chart.draw_series([Rectangle::new(corners, style.filled())]);
        drawn.map(|_| ())
    };
    let (together, alone) = apart(strips_of(lines, &up));
    for strip in &alone {
        rectangle(strip, strip.colour.mix(ALONE))?;
    }
    for strip in &together {
        rectangle(strip, strip.colour.mix(TOGETHER))?;
    }
    for strip in &joined(together) {
        rectangle(strip, INK.mix(ALONE))?;
    }
    let few = up.end - up.start < 1.5;
    let up_label = |y: &f64| if axes.logarithmic { power_label(*y, few) } else { label(*y, &up) };
    let font = ("sans-serif", f64::from(fine(FONT)) * 1.24);
    chart
        .configure_mesh()
        .label_style(font.into_font().color(&INK))
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(FINE as u32))
        .axis_style(GRID.stroke_width(FINE as u32))
        .x_labels(6)
        .y_labels(5)
        .x_label_formatter(&|x| label(*x, across))
        .y_label_formatter(&up_label)
        .set_all_tick_mark_size(fine(3))
        .draw()?;
    for line in lines {
        let points = line.points.iter().copied();
        let stroke = line.colour.stroke_width((FINE * 3 / 2) as u32);
        chart.draw_series([PathElement::new(points.collect::<Vec<_>>(), stroke)])?;
    }
    root.present()?;
    Ok(())
}
