//! SVG: a drawing of the fit with its data, 800 pixels wide.
//!
//! Curves of the plane are drawn as they are; curves and surfaces in space are seen from above and
//! aside, with z upwards. Below the drawing stand what it shows and, if there are several levels,
//! how the distance from the data has fallen.

mod curve;
mod history;
mod layout;
mod scene;
mod surface;
mod view;

use super::error::ExportError;
use super::fitted::Fitted;
use super::nurbs::Nurbs;
use super::text::{Text, one_line};
use layout::{DrawnData, MARGIN, WIDTH, shows_net};
use scene::Scene;
use view::{Canvas, Projection};

/// The height of the caption.
const CAPTION: f64 = 88.0;
/// Characters of a name that fit into a line.
const TITLE: usize = 84;

const STYLE: &str = "\
text{font:12px system-ui,sans-serif;fill:#495057}\
.title{font-size:15px;font-weight:600;fill:#212529}\
.curve{fill:none;stroke:#1864ab;stroke-width:2;stroke-linecap:round;stroke-linejoin:round}\
.net{fill:none;stroke:#868e96;stroke-width:.8;stroke-opacity:.8;stroke-linejoin:round}\
.control{fill:#fff;stroke:#868e96;stroke-width:.8}\
.data{fill:#d9480f}\
.axis{fill:none;stroke:#495057}\
.grid{fill:none;stroke:#dee2e6}";

/// The drawing as an SVG file.
pub(super) fn write(nurbs: &Nurbs, fitted: &Fitted<'_>) -> Result<Vec<u8>, ExportError> {
    let data = DrawnData::new(fitted.problem);
    let view = Projection::of(nurbs);
    let scene = match &nurbs.v {
        None => curve::scene(nurbs, &view, fitted.samples),
        Some(v) => surface::scene(nurbs, v, fitted.samples, &data, &view),
    };
    let seen = data.places.iter().map(|&place| view.project(place));
    let net = (0..nurbs.points.len()).map(|index| view.project(nurbs.place(index)));
    let net = net.take(if shows_net(nurbs) { usize::MAX } else { 0 });
    let canvas = Canvas::fit(seen.chain(scene.outline()), net)?;
    let net = (0..nurbs.points.len()).map(|index| view.project(nurbs.place(index)));
    let dots = data.places.iter().map(|&place| view.project(place));
    canvas.check(scene.places().chain(net).chain(dots))?;
    let with_history = fitted.errors.len() > 1;
    let below = if with_history { history::HEIGHT } else { 0.0 };
    let height = canvas.height() + CAPTION + below;
    let mut text = Text::default();
    open(&mut text, fitted, height);
    // The nested element cuts off what is beyond it.
    text.put(format_args!(
        "<svg width=\"{WIDTH}\" height=\"{:.1}\">\n",
        canvas.height()
    ));
    match &scene {
        Scene::Curve(pieces) => curve::draw(&mut text, pieces, nurbs, &data, &view, &canvas),
        Scene::Surface(parts) => surface::draw(&mut text, parts, &canvas),
    }
    text.push("</svg>\n");
    caption(&mut text, nurbs, fitted, &data, canvas.height());
    if view.is_spatial() {
        let middle = (WIDTH - 56.0, canvas.height() + 40.0);
        view.draw_axes(&mut text, middle);
    }
    if with_history {
        history::draw(&mut text, fitted.errors, canvas.height() + CAPTION);
    }
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
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        fitted.description(),
    ));
}

/// The name, what it is, what the colours mean and how large it is.
fn caption(text: &mut Text, nurbs: &Nurbs, fitted: &Fitted<'_>, data: &DrawnData, top: f64) {
    let mut title: String = fitted.title().chars().take(TITLE).collect();
    if title.len() < fitted.title().len() {
        title.push('…');
    }
    let (title, description) = (escape(&title), fitted.description());
    let [first, second, third, fourth] = [18.0, 38.0, 56.0, 74.0].map(|line| top + line);
    let extent = extent(nurbs);
    text.put(format_args!(
        "<text class=\"title\" x=\"{MARGIN}\" y=\"{first:.1}\">{title}</text>\n\
         <text x=\"{MARGIN}\" y=\"{second:.1}\">{description}</text>\n\
         <text x=\"{MARGIN}\" y=\"{third:.1}\">control points in {extent}</text>\n"
    ));
    let middle = fourth - 4.0;
    let dots = match data.stride {
        1 => "data points".to_owned(),
        stride => format!("data points, one in {stride}"),
    };
    text.put(format_args!(
        "<circle class=\"data\" cx=\"{:.1}\" cy=\"{middle:.1}\" r=\"3\"/>\
         <text x=\"{:.1}\" y=\"{fourth:.1}\">{dots}</text>\n",
        MARGIN + 4.0,
        MARGIN + 14.0,
    ));
    if shows_net(nurbs) {
        let (from, to) = (MARGIN + 150.0, MARGIN + 174.0);
        let polygon = if nurbs.v.is_some() { "net" } else { "polygon" };
        text.put(format_args!(
            "<path class=\"net\" d=\"M{from:.1} {middle:.1}H{to:.1}\"/>\
             <text x=\"{:.1}\" y=\"{fourth:.1}\">control {polygon}</text>\n",
            to + 8.0,
        ));
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

/// A number with four significant digits.
fn rounded(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e6 => {
            let digits = (3.0 - x.abs().log10().floor()).max(0.0) as usize;
            let text = format!("{x:.digits$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
        _ => format!("{x:.3e}"),
    }
}

/// Text content of XML: markup as entities; control characters, which XML 1.0 does not allow
/// (section 2.2), as spaces.
fn escape(value: &str) -> String {
    let mut escaped = String::with_capacity(value.len());
    for c in one_line(value).chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push('\u{fffd}'),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_is_escaped() {
        assert_eq!(
            escape("<a href=\"x\">'&'\u{0}\n"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;  "
        );
        assert_eq!(escape("翼 ü"), "翼 ü");
    }

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (-1.0, "-1"),
            (0.123_456, "0.1235"),
            (99.999_9, "100"),
            (123_456.7, "123457"),
            (1.5e-9, "1.500e-9"),
            (2.5e30, "2.500e30"),
        ] {
            assert_eq!(rounded(x), text);
        }
    }
}
