//! Outlines of SVG: paths and basic shapes with their transforms.

mod path;
mod pen;
mod references;
mod scan;

use std::collections::BTreeMap;

use super::curves::Curves;
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Parts;
use super::xml::{self, Element, Node, Nodes};
use crate::text::quoted;
use pen::{ArcShape, Pen};
use references::{References, Referred, in_window};
use scan::{Scanner, Transform, length};

/// The elements that hold others.
const GROUPS: [&str; 3] = ["g", "a", "switch"];

/// The elements that are drawn and not supported.
const UNREAD: [&str; 4] = ["foreignObject", "image", "svg", "text"];

/// The element that draws another one again, and the group that is drawn only so.
const USE: &str = "use";
const SYMBOL: &str = "symbol";

/// Returns true if a text is SVG.
pub(super) fn is_svg(text: &str) -> bool {
    xml::root(text).as_deref() == Some("svg")
}

/// Each outline is a part, with the name of its element.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let mut reader = Reader {
        curves: Curves::new(hints.most),
        most: hints.most,
        around: Vec::new(),
        references: References::new(text),
        prefix: None,
        referred: None,
        unread: BTreeMap::new(),
        hidden: 0,
        notices: Vec::new(),
    };
    let mut nodes = Nodes::new(text);
    while let Some(node) = nodes.next()? {
        match node {
            Node::Start(element) => {
                let transform = reader.start(&element)?;
                reader.around.push(transform);
            }
            Node::End => {
                reader.around.pop();
            }
            Node::Text(_) => {}
        }
    }
    reader.finish()
}

struct Reader<'a> {
    curves: Curves,
    most: usize,
    references: References<'a>,
    /// The transforms of the elements around; none within one that is not read.
    around: Vec<Option<Transform>>,
    /// The prefix of the names of SVG.
    prefix: Option<String>,
    /// At the element that a reference names.
    referred: Option<Referred>,
    /// The number of skipped elements of each name.
    unread: BTreeMap<String, usize>,
    hidden: usize,
    notices: Vec<String>,
}

impl Reader<'_> {
    /// Reads an element. Returns the transform of those in it, if they are read.
    fn start(&mut self, element: &Element<'_>) -> Result<Option<Transform>, FileError> {
        let Some(around) = self.around.last() else {
            return self.root(element).map(Some);
        };
        let Some(around) = *around else {
            return Ok(None);
        };
        if element.prefix() != self.prefix.as_deref() {
            return Ok(None);
        }
        let name = element.name();
        if UNREAD.contains(&name) {
            self.count_unread(name);
            return Ok(None);
        }
        let referred = self.referred.take().filter(|_| name == SYMBOL);
        let is_symbol = referred.is_some();
        let is_group = GROUPS.contains(&name) || is_symbol;
        if !is_group && !is_shape(name) && name != USE {
            return Ok(None);
        }
        if is_hidden(element)? {
            self.hidden += 1;
            return Ok(None);
        }
        let window = match referred {
            None => Transform::IDENTITY,
            Some(Referred { size }) => match in_window(element, size)? {
                Some(window) => window,
                None => {
                    self.count_unread("symbol in a window of unknown size");
                    return Ok(None);
                }
            },
        };
        let transform = around.after(own_transform(element)?).after(window);
        match (name, is_group) {
            (USE, _) => self.draw_again(element, transform)?,
            (_, false) => self.shape(element, transform)?,
            (_, true) => {}
        }
        Ok(is_group.then_some(transform))
    }

    /// Reads the element that a `use` names where that places it.
    fn draw_again(&mut self, element: &Element<'_>, around: Transform) -> Result<(), FileError> {
        let Some([x, y]) = lengths(element, ["x", "y"])? else {
            self.count_unread("use with lengths in % or of fonts");
            return Ok(());
        };
        let Some(mut nodes) = self.references.enter(element)? else {
            self.count_unread("use of what is not in the file");
            return Ok(());
        };
        let inside = vec![Some(around.after(Transform::shifted(x, y)))];
        let outside = std::mem::replace(&mut self.around, inside);
        self.referred = Some(Referred {
            size: lengths(element, ["width", "height"])?,
        });
        while let Some(node) = nodes.next()? {
            match node {
                Node::Start(element) => {
                    let transform = self.start(&element)?;
                    self.around.push(transform);
                }
                Node::End => {
                    self.around.pop();
                    if self.around.len() < 2 {
                        break;
                    }
                }
                Node::Text(_) => {}
            }
        }
        self.referred = None;
        self.around = outside;
        self.references.leave(element, nodes.position())
    }

    /// Reads the first element: where its lower edge is, which y is measured from, and what its unit is.
    fn root(&mut self, element: &Element<'_>) -> Result<Transform, FileError> {
        self.prefix = element.prefix().map(str::to_owned);
        let window = element.attribute("viewBox")?;
        let window: Option<[f64; 4]> = window.and_then(|text| Scanner::new(&text).numbers());
        let sides = [element.attribute("width")?, element.attribute("height")?];
        let [width, height] = sides
            .each_ref()
            .map(|side| side.as_deref().and_then(length));
        let height = match window {
            Some([_, top, _, height]) => 2.0 * top + height,
            None => height.unwrap_or(0.0),
        };
        self.notices.push(format!(
            "y points up, as in CAD: it is {height} minus that of the file, where it points down."
        ));
        let physical = ["mm", "cm", "in", "pt", "pc"];
        let physical = |text: &String| physical.iter().any(|unit| text.trim().ends_with(unit));
        let is_physical = sides[0].as_ref().is_some_and(physical);
        if let (Some([_, _, units, _]), Some(width), true) = (window, width, is_physical) {
            let unit = width / units * 25.4 / 96.0;
            if unit.is_finite() {
                self.notices.push(format!(
                    "A unit of the coordinates is {} mm of the drawing.",
                    (unit * 1e6).round() / 1e6
                ));
            }
        }
        let own = own_transform(element)?;
        Ok(Transform::turned_over(height).after(own))
    }

    fn shape(&mut self, element: &Element<'_>, transform: Transform) -> Result<(), FileError> {
        let mut pen = Pen::new(transform, element.line);
        let room = self.most.saturating_sub(self.curves.count());
        if draw(element, &mut pen, room)?.is_none() {
            self.count_unread(&format!("{} with lengths in % or of fonts", element.name()));
            return Ok(());
        }
        let label = element.attribute("inkscape:label")?;
        let name = label.map_or_else(|| element.attribute("id"), |label| Ok(Some(label)))?;
        for mut curve in pen.curves() {
            curve.name.clone_from(&name);
            self.curves.push(curve)?;
        }
        Ok(())
    }

    fn count_unread(&mut self, name: &str) {
        *self.unread.entry(name.to_owned()).or_default() += 1;
    }

    fn finish(mut self) -> Result<Parts, FileErrors> {
        if !self.unread.is_empty() {
            let unread = self.unread.iter();
            let unread = unread.map(|(name, count)| format!("{count} {name}"));
            let unread = unread.collect::<Vec<_>>().join(", ");
            self.notices
                .push(format!("Elements that are not read: {unread}."));
        }
        if self.hidden > 0 {
            self.notices.push(format!(
                "{} elements are hidden (display: none), and are left out.",
                self.hidden
            ));
        }
        self.curves.finish(2, self.notices)
    }
}

/// Returns true if elements of a name have an outline.
fn is_shape(name: &str) -> bool {
    matches!(
        name,
        "path" | "polyline" | "polygon" | "line" | "rect" | "circle" | "ellipse"
    )
}

/// The transform of an element itself.
fn own_transform(element: &Element<'_>) -> Result<Transform, FileError> {
    let Some(text) = element.attribute("transform")? else {
        return Ok(Transform::IDENTITY);
    };
    Transform::of_text(&text).ok_or_else(|| {
        let detail = format!("{} is no transform", quoted(&text));
        FileError::at(element.line as usize, detail)
    })
}

/// Returns true if an element is not displayed.
fn is_hidden(element: &Element<'_>) -> Result<bool, FileError> {
    let style = element.attribute("style")?.unwrap_or_default();
    let mut styles = style.split(';').filter_map(|it| it.split_once(':'));
    let styled = styles.any(|(name, value)| name.trim() == "display" && value.trim() == "none");
    Ok(styled || element.attribute("display")?.as_deref() == Some("none"))
}

/// Draws the outlines of an element; `None` if a length is unknown.
fn draw(element: &Element<'_>, pen: &mut Pen, most: usize) -> Result<Option<()>, FileError> {
    match element.name() {
        "path" => draw_path(element, pen, most)?,
        "polyline" => draw_points(element, pen, false)?,
        "polygon" => draw_points(element, pen, true)?,
        "line" => return draw_line(element, pen),
        "rect" => return draw_rectangle(element, pen),
        _ => return draw_ellipse(element, pen),
    }
    Ok(Some(()))
}

fn draw_path(element: &Element<'_>, pen: &mut Pen, most: usize) -> Result<(), FileError> {
    let data = element.attribute("d")?.unwrap_or_default();
    path::draw(&data, pen, most).map_err(|rest| {
        let detail = format!("the data of this path is wrong from {} on", quoted(rest));
        FileError::at(element.line as usize, detail)
    })
}

fn draw_points(element: &Element<'_>, pen: &mut Pen, closed: bool) -> Result<(), FileError> {
    let text = element.attribute("points")?.unwrap_or_default();
    let mut scanner = Scanner::new(&text);
    let mut first = true;
    while !scanner.is_at_end() {
        let before = scanner;
        let place = scanner.numbers().ok_or_else(|| {
            let detail = format!("these points are wrong from {} on", quoted(before.rest));
            FileError::at(element.line as usize, detail)
        })?;
        match first {
            true => pen.move_to(place),
            false => pen.line_to(place),
        }
        first = false;
    }
    if closed {
        pen.close();
    }
    Ok(())
}

/// The lengths of an element, 0 where they are missing; `None` if one is unknown.
fn lengths<const N: usize>(
    element: &Element<'_>,
    names: [&str; N],
) -> Result<Option<[f64; N]>, FileError> {
    let mut lengths = [0.0; N];
    for (found, name) in lengths.iter_mut().zip(names) {
        if let Some(text) = element.attribute(name)? {
            let Some(length) = length(&text) else {
                return Ok(None);
            };
            *found = length;
        }
    }
    Ok(Some(lengths))
}

fn draw_line(element: &Element<'_>, pen: &mut Pen) -> Result<Option<()>, FileError> {
    let lengths = lengths(element, ["x1", "y1", "x2", "y2"])?;
    Ok(lengths.map(|[x1, y1, x2, y2]| {
        pen.move_to([x1, y1]);
        pen.line_to([x2, y2]);
    }))
}

fn draw_rectangle(element: &Element<'_>, pen: &mut Pen) -> Result<Option<()>, FileError> {
    let Some([x, y, width, height]) = lengths(element, ["x", "y", "width", "height"])? else {
        return Ok(None);
    };
    let mut radii = [None, None];
    for (radius, name) in radii.iter_mut().zip(["rx", "ry"]) {
        *radius = element.attribute(name)?.as_deref().and_then(length);
    }
    let [rx, ry] = match radii {
        [Some(rx), Some(ry)] => [rx, ry],
        [Some(r), None] | [None, Some(r)] => [r; 2],
        [None, None] => [0.0; 2],
    };
    if width <= 0.0 || height <= 0.0 {
        return Ok(Some(()));
    }
    let [rx, ry] = [rx.clamp(0.0, width / 2.0), ry.clamp(0.0, height / 2.0)];
    let [right, bottom] = [x + width, y + height];
    let round = ArcShape {
        radii: [rx, ry],
        rotation: 0.0,
        large: false,
        sweep: true,
    };
    pen.move_to([x + rx, y]);
    // The sides, each with the corner at its end.
    for (side, corner) in [
        ([right - rx, y], [right, y + ry]),
        ([right, bottom - ry], [right - rx, bottom]),
        ([x + rx, bottom], [x, bottom - ry]),
        ([x, y + ry], [x + rx, y]),
    ] {
        if side != pen.place {
            pen.line_to(side);
        }
        if rx > 0.0 && ry > 0.0 {
            pen.arc_to(round, corner);
        }
    }
    pen.close();
    Ok(Some(()))
}

fn draw_ellipse(element: &Element<'_>, pen: &mut Pen) -> Result<Option<()>, FileError> {
    let lengths = match element.name() {
        "circle" => lengths(element, ["cx", "cy", "r", "r"])?,
        _ => lengths(element, ["cx", "cy", "rx", "ry"])?,
    };
    Ok(lengths.map(|[x, y, rx, ry]| {
        if rx <= 0.0 || ry <= 0.0 {
            return;
        }
        let half = ArcShape {
            radii: [rx, ry],
            rotation: 0.0,
            large: false,
            sweep: true,
        };
        pen.move_to([x + rx, y]);
        pen.arc_to(half, [x - rx, y]);
        pen.arc_to(half, [x + rx, y]);
        pen.close();
    }))
}

#[cfg(test)]
mod tests;
