//! Plots as PNG: time against error, and sweeps.

use anyhow::{Result, anyhow};
use lightwell::measure;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};
use std::path::Path;
use std::sync::OnceLock;

/// Size of a plot \[pixels\].
const SIZE: [u32; 2] = [1000, 680];
const FONT: &str = "sans-serif";

/// One method in a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// Name.
    pub label: String,
    /// Time \[ms\].
    pub time: f64,
    /// Least and greatest time \[ms\].
    pub range: (f64, f64),
    /// Error.
    pub error: f64,
    /// A point of the baseline curve.
    pub baseline: bool,
    /// No other point beats it.
    pub on_front: bool,
}

/// A curve of a sweep: (setting, value).
pub struct Curve<'a> {
    /// The meaning of the value.
    pub label: &'a str,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

fn fonts() -> Result<()> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let register = || register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok();
    REGISTERED.get_or_init(register).then_some(()).ok_or_else(|| anyhow!("the font of the plots cannot be read"))
}

fn wrong<E: std::fmt::Display>(error: E) -> anyhow::Error {
    anyhow!("a plot could not be drawn: {error}")
}

/// Writes a line of text into an image, its upper left corner there.
///
/// # Errors
/// If the text cannot be drawn.
pub fn text(rgb: &mut [u8], size: [u32; 2], at: [i32; 2], text: &str) -> Result<()> {
    fonts()?;
    let area = BitMapBackend::with_buffer(rgb, (size[0], size[1])).into_drawing_area();
    area.draw(&Text::new(text.to_owned(), (at[0], at[1]), (FONT, 16).into_font())).map_err(wrong)?;
    area.present().map_err(wrong)
}

/// Width of a line of text as [`text`] draws it \[pixels\].
///
/// # Errors
/// If the font cannot be read.
pub fn text_width(text: &str) -> Result<u32> {
    fonts()?;
    let (low, high) = (FONT, 16).into_font().layout_box(text).map_err(wrong)?;
    Ok((high.0 - low.0).unsigned_abs())
}

/// Draws into an empty image and writes it.
fn drawn(path: &Path, draw: impl FnOnce(&Area) -> Result<()>) -> Result<()> {
    fonts()?;
    let mut rgb = vec![255; 3 * (SIZE[0] * SIZE[1]) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut rgb, (SIZE[0], SIZE[1])).into_drawing_area();
        area.fill(&WHITE).map_err(wrong)?;
        draw(&area)?;
        area.present().map_err(wrong)?;
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    Ok(measure::write_png_rgb8(path, SIZE, &rgb)?)
}

/// A range in logarithms around all values, with room at both ends.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for value in values.filter(|value| value.is_finite() && *value > 0.0) {
        (least, most) = (least.min(value), most.max(value));
    }
    if most == 0.0 {
        return 0.1..10.0;
    }
    let room = (most / least).powf(0.08).max(1.3);
    least / room..most * room * room
}

/// Plots the errors of all methods over their times, both in logarithms. The baseline's points are joined; the Pareto
/// front is a broken line.
///
/// # Errors
/// If the file cannot be written.
pub fn time_error(path: &Path, title: &str, dots: &[Dot], x: &str, y: &str) -> Result<()> {
    drawn(path, |area| {
        let (xs, ys) =
            (range(dots.iter().flat_map(|d| [d.time, d.range.0, d.range.1])), range(dots.iter().map(|d| d.error)));
        let mut chart = ChartBuilder::on(area)
            .caption(title, (FONT, 22))
            .margin(12)
            .x_label_area_size(46)
            .y_label_area_size(66)
            .build_cartesian_2d(xs.log_scale(), ys.log_scale())
            .map_err(wrong)?;
        chart
            .configure_mesh()
            .x_desc(x)
            .y_desc(y)
            .label_style((FONT, 15))
            .axis_desc_style((FONT, 17))
            .x_label_formatter(&|value| short(*value))
            .y_label_formatter(&|value| short(*value))
            .light_line_style(RGBColor(236, 236, 236))
            .bold_line_style(RGBColor(205, 205, 205))
            .draw()
            .map_err(wrong)?;
        let sorted = |keep: &dyn Fn(&Dot) -> bool| {
            let mut points: Vec<(f64, f64)> = dots.iter().filter(|d| keep(d)).map(|d| (d.time, d.error)).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        let baseline = sorted(&|dot| dot.baseline);
        chart.draw_series(LineSeries::new(baseline, BLUE.mix(0.7).stroke_width(2))).map_err(wrong)?;
        let front = DashedLineSeries::new(sorted(&|dot| dot.on_front), 5, 5, BLACK.mix(0.55).stroke_width(1));
        chart.draw_series(front).map_err(wrong)?;
        for (index, dot) in dots.iter().enumerate() {
            let color = color(index, dot);
            let bar = [(dot.range.0, dot.error), (dot.range.1, dot.error)];
            chart.draw_series([PathElement::new(bar.to_vec(), color.stroke_width(1))]).map_err(wrong)?;
            let at = (dot.time, dot.error);
            chart.draw_series([Circle::new(at, 5, color.filled())]).map_err(wrong)?;
            if dot.on_front {
                chart.draw_series([Circle::new(at, 9, BLACK.mix(0.6))]).map_err(wrong)?;
            }
        }
        let places: Vec<(i32, i32)> = dots.iter().map(|dot| chart.backend_coord(&(dot.time, dot.error))).collect();
        label(area, dots, &places)?;
        let note = "ringed and joined by the broken line: the Pareto front (nothing is both faster and better)";
        let style = TextStyle::from((FONT, 14).into_font()).color(&RGBColor(100, 100, 100));
        area.draw_text(note, &style, (84, 44)).map_err(wrong)
    })
}

/// Colours that are told apart; path tracing is blue.
fn color(index: usize, dot: &Dot) -> RGBColor {
    const OTHERS: [RGBColor; 8] = [
        RGBColor(120, 120, 120),
        RGBColor(214, 39, 40),
        RGBColor(44, 140, 44),
        RGBColor(148, 80, 189),
        RGBColor(230, 120, 10),
        RGBColor(20, 150, 160),
        RGBColor(140, 86, 75),
        RGBColor(200, 80, 160),
    ];
    if dot.baseline { RGBColor(30, 80, 200) } else { OTHERS[index % OTHERS.len()] }
}

/// Writes the names beside their points, each where no other one stands yet.
fn label(area: &Area, dots: &[Dot], places: &[(i32, i32)]) -> Result<()> {
    const HEIGHT: i32 = 17;
    let mut taken: Vec<[i32; 4]> = places.iter().map(|&(x, y)| [x - 6, y - 6, x + 6, y + 6]).collect();
    for (index, (dot, &(x, y))) in dots.iter().zip(places).enumerate() {
        let color = color(index, dot);
        let style = TextStyle::from((FONT, 16).into_font()).color(&color);
        let (width, _) = area.estimate_text_size(&dot.label, &style).map_err(wrong)?;
        let width = width as i32;
        let candidates = (0..8).flat_map(|ring| {
            let lift = 4 + ring * HEIGHT;
            [
                (x + 12, y - HEIGHT / 2 - ring * HEIGHT),
                (x + 12, y - HEIGHT / 2 + ring * HEIGHT),
                (x - 12 - width, y - lift),
                (x - width / 2, y + 8 + lift),
            ]
        });
        let fits = |&(left, top): &(i32, i32)| {
            let inside =
                left > 70 && left + width < SIZE[0] as i32 - 6 && top > 50 && top + HEIGHT < SIZE[1] as i32 - 56;
            inside && !taken.iter().any(|&[l, t, r, b]| left < r && left + width > l && top < b && top + HEIGHT > t)
        };
        let (left, top) = candidates.into_iter().find(fits).unwrap_or((x + 12, y - HEIGHT / 2));
        taken.push([left, top, left + width, top + HEIGHT]);
        let style = style.pos(Pos::new(HPos::Left, VPos::Top));
        area.draw_text(&dot.label, &style, (left, top)).map_err(wrong)?;
    }
    Ok(())
}

/// Plots curves over a setting, all in logarithms.
///
/// # Errors
/// If the file cannot be written.
pub fn sweep(path: &Path, title: &str, curves: &[Curve], x: &str) -> Result<()> {
    drawn(path, |area| {
        let all = || curves.iter().flat_map(|curve| curve.points.iter());
        let mut chart = ChartBuilder::on(area)
            .caption(title, (FONT, 22))
            .margin(12)
            .x_label_area_size(46)
            .y_label_area_size(66)
            .build_cartesian_2d(range(all().map(|p| p.0)).log_scale(), range(all().map(|p| p.1)).log_scale())
            .map_err(wrong)?;
        chart
            .configure_mesh()
            .x_desc(x)
            .label_style((FONT, 15))
            .axis_desc_style((FONT, 17))
            .x_label_formatter(&|value| short(*value))
            .y_label_formatter(&|value| short(*value))
            .light_line_style(RGBColor(236, 236, 236))
            .draw()
            .map_err(wrong)?;
        for (index, curve) in curves.iter().enumerate() {
            let color = [RGBColor(214, 39, 40), RGBColor(30, 80, 200), RGBColor(44, 140, 44)][index % 3];
            let line = LineSeries::new(curve.points.iter().copied(), color.stroke_width(2)).point_size(4);
            let series = chart.draw_series(line).map_err(wrong)?;
            series.label(curve.label).legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], color));
        }
        // Where rising curves leave room, or falling ones.
        let rises = curves.iter().all(|curve| curve.points.last().map(|p| p.1) > curve.points.first().map(|p| p.1));
        let corner = if rises { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight };
        let mut legend = chart.configure_series_labels();
        legend.position(corner);
        legend.label_font((FONT, 16)).background_style(WHITE.mix(0.85)).border_style(BLACK.mix(0.3));
        legend.draw().map_err(wrong)
    })
}

/// A number with as many digits as a label needs.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = (1 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn labels_of_axes() {
        let labels = [(0.05, "0.05"), (1.0, "1"), (250.0, "250"), (0.333, "0.33"), (2.5, "2.5")];
        labels.iter().for_each(|(value, label)| assert_eq!(short(*value), *label));
    }

    #[test]
    fn a_plot_shows_points_and_text() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("plots/a.png");
        let dot = |label: &str, time, error, baseline| Dot {
            label: label.into(),
            time,
            range: (time * 0.9, time * 1.1),
            error,
            baseline,
            on_front: true,
        };
        let dots = [dot("a", 1.0, 1.0, false), dot("b", 10.0, 0.3, true), dot("c", 100.0, 0.1, true)];
        time_error(&path, "title", &dots, "x", "y").unwrap();
        let picture = measure::read_image(&path).unwrap();
        assert_eq!(picture.size(), SIZE);
        let blue = picture.pixels().iter().filter(|p| p[2] > 0.3 && p[0] < 0.1).count();
        let dark_in_title = (0..40).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        let dark = dark_in_title.filter(|&(x, y)| picture.pixel(x, y)[0] < 0.2).count();
        assert!(blue > 150 && dark > 30, "{blue} blue pixels, {dark} dark ones in the title");
    }
}
