//! SVG: a drawing of the fit with its data, 800 pixels wide.
//!
//! Curves of the plane are drawn as they are; curves and surfaces in space are seen from above and aside, with z
//! upwards. Colours show the distances of the data. Below the drawing are a caption and, if there are several steps, a
//! plot of the distance from the data. In browsers, drawings are dark on dark pages.

mod cubics;
mod curve;
mod heat;
mod history;
mod layout;
mod measured;
mod numbers;
pub(in crate::export) mod path;
mod scale;
mod scene;
mod style;
mod surface;
mod view;

use super::error::ExportError;
use super::fitted::Fitted;
use super::nurbs::Nurbs;
use super::text::{Text, escape};
use history::History;
use layout::{DrawnData, shows_net};
use measured::Measured;
use numbers::rounded;
use scene::Scene;
use style::STYLE;
use view::{Canvas, MARGIN, Projection, WIDTH};

/// The height of the caption.
const CAPTION: f64 = 88.0;
/// Characters of a name that fit into a line.
const TITLE: usize = 84;

/// The drawing as an SVG file.
pub(super) fn write(nurbs: &Nurbs, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let (problem, options) = (fitted.problem, fitted.options);
    let view = Projection::of(nurbs);
    let measured = Measured::of(fitted, nurbs);
    let mut scene = match &nurbs.v {
        None => curve::scene(problem, nurbs, &view, options.samples, measured.as_ref()),
        Some(v) => surface::scene(
            problem,
            (nurbs, v),
            options.samples,
            &view,
            measured.as_ref(),
        ),
    };
    let mut data = DrawnData::new(problem, &view);
    let net = || (0..nurbs.points.len()).map(|index| view.project(nurbs.place(index)));
    let shown_net = net().take(if shows_net(nurbs) { usize::MAX } else { 0 });
    let seen = data.places.iter().copied();
    let canvas = Canvas::fit(seen.clone().chain(scene.outline()), shown_net)?;
    canvas.check(scene.places().chain(net()).chain(seen))?;
    data.choose(options.dots, &canvas);
    scene.finish(nurbs, &data);
    let heat = measured.map(|it| it.most);
    let legend = if heat.is_some() { scale::HEIGHT } else { 0.0 };
    let history = History::of(fitted.errors);
    let history_top = canvas.height() + CAPTION + legend;
    let mut text = Text::default();
    open(&mut text, fitted, history_top + history.height());
    // The nested element clips the drawing.
    text.put(format_args!(
        "<svg width=\"{WIDTH}\" height=\"{:.1}\">\n",
        canvas.height()
    ));
    match &scene {
        Scene::Curve(pieces, heat) => {
            curve::draw(&mut text, (pieces, heat), nurbs, &data, &view, &canvas);
        }
        Scene::Surface(parts) => surface::draw(&mut text, parts, &data, &canvas),
    }
    data.draw_outliers(&mut text, &canvas);
    text.push("</svg>\n");
    caption(&mut text, nurbs, fitted, &data, canvas.height());
    if let Some(most) = heat {
        scale::draw_legend(&mut text, most, canvas.height() + CAPTION);
    }
    if view.is_spatial() {
        let middle = (WIDTH - 56.0, canvas.height() + 40.0);
        view.draw_axes(&mut text, middle);
    }
    history.draw(&mut text, history_top);
    text.push("</svg>\n");
    Ok(text.into_bytes())
}

fn open(text: &mut Text, fitted: &Fitted<'_>, height: f64) {
    let title = escape(fitted.title());
    text.put(format_args!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
         width=\"{WIDTH}\" height=\"{height:.0}\" role=\"img\">\n\
         <title>{title}</title>\n\
         <desc>{}</desc>\n\
         <style>{STYLE}</style>\n\
         <rect class=\"page\" width=\"100%\" height=\"100%\"/>\n",
        fitted.description(),
    ));
}

/// The name, a description, the size, and the meaning of dots and lines.
fn caption(text: &mut Text, nurbs: &Nurbs, fitted: &Fitted<'_>, data: &DrawnData, top: f64) {
    let mut title: String = fitted.title().chars().take(TITLE).collect();
    if title.len() < fitted.title().len() {
        title.push('…');
    }
    let (title, description) = (escape(&title), fitted.description());
    let [first, second, third, fourth] = [18.0, 38.0, 56.0, 74.0].map(|line| top + line);
    let count = match nurbs.v {
        None => nurbs.rows().to_string(),
        Some(_) => format!("{} x {}", nurbs.rows(), nurbs.columns()),
    };
    let extent = extent(nurbs);
    text.put(format_args!(
        "<text class=\"title\" x=\"{MARGIN}\" y=\"{first:.1}\">{title}</text>\n\
         <text x=\"{MARGIN}\" y=\"{second:.1}\">{description}</text>\n\
         <text x=\"{MARGIN}\" y=\"{third:.1}\">{count} control points in {extent}</text>\n"
    ));
    let middle = fourth - 4.0;
    let mut left = MARGIN;
    let dots = data.legend().map(|dots| ("data", dots));
    let outliers = data
        .legend_of_outliers()
        .map(|dots| ("outlier", dots.to_owned()));
    for (class, dots) in dots.into_iter().chain(outliers) {
        text.put(format_args!(
            "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3\"/>\
             <text x=\"{:.1}\" y=\"{fourth:.1}\">{dots}</text>\n",
            left + 4.0,
            left + 14.0,
        ));
        left += if class == "data" { 190.0 } else { 140.0 };
    }
    let mut line = |class: &str, what: &str| {
        let to = left + 24.0;
        text.put(format_args!(
            "<path class=\"{class}\" d=\"M{left:.1} {middle:.1}H{to:.1}\"/>\
             <text x=\"{:.1}\" y=\"{fourth:.1}\">{what}</text>\n",
            to + 8.0,
        ));
        left += 130.0;
    };
    if nurbs.v.is_none() {
        line("curve", "curve");
    }
    if shows_net(nurbs) {
        let is_surface = nurbs.v.is_some();
        line(
            "net",
            if is_surface {
                "control net"
            } else {
                "control polygon"
            },
        );
    }
}

/// The bounding box of the control points, with four digits.
fn extent(nurbs: &Nurbs) -> String {
    let lanes = nurbs.points.lanes().iter();
    let ranges = lanes.map(|lane| {
        let low = lane.iter().copied().fold(f64::INFINITY, f64::min);
        let high = lane.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        format!("[{}, {}]", rounded(low), rounded(high))
    });
    ranges.collect::<Vec<_>>().join(" × ")
}
