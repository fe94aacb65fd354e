//! Lines, rings and tracks of KML.

use jiff::Timestamp;

use super::curves::{Curve, Curves, Point};
use super::error::{FileError, FileErrors};
use super::imported::Hints;
use super::part::Parts;
use super::tracks::{self, timestamp};
use super::xml::{self, Element, Node, Nodes};
use crate::text::quoted;

/// The largest longitude and latitude.
const LARGEST: [(&str, f64); 2] = [("longitude", 180.0), ("latitude", 90.0)];

/// Returns true if a text is KML.
pub(super) fn is_kml(text: &str) -> bool {
    xml::root(text).as_deref() == Some("kml")
}

/// Each line, ring and track is a part, with the name of its placemark. Points are a part if there is nothing else.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let mut reader = Reader {
        curves: Curves::new(hints.most),
        points: Curve::cloud(None),
        around: Vec::new(),
        name: None,
        text: String::new(),
        curve: Curve::new(None),
        times: Vec::new(),
    };
    let mut nodes = Nodes::new(text);
    while let Some(node) = nodes.next()? {
        match node {
            Node::Start(element) => reader.start(&element),
            Node::Text(text) if reader.reads_text() => reader.text += &text,
            Node::Text(_) => {}
            Node::End => reader.end()?,
        }
    }
    reader.finish(hints)
}

/// The meaning of an element, by its name and its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    Placemark,
    Name,
    Line,
    Ring,
    Track,
    Point,
    /// The positions of a line, a ring or a point.
    Positions,
    /// A position of a track, and a time of one.
    Position,
    Time,
    Other,
}

impl Tag {
    fn of(name: &str, around: Option<Self>) -> Self {
        match (around, name) {
            (_, "Placemark") => Self::Placemark,
            (Some(Self::Placemark), "name") => Self::Name,
            (_, "LineString") => Self::Line,
            (_, "LinearRing") => Self::Ring,
            (_, "Point") => Self::Point,
            (_, "Track") => Self::Track,
            (Some(Self::Line | Self::Ring | Self::Point), "coordinates") => Self::Positions,
            (Some(Self::Track), "coord") => Self::Position,
            (Some(Self::Track), "when") => Self::Time,
            _ => Self::Other,
        }
    }
}

struct Reader {
    curves: Curves,
    points: Curve,
    /// The elements around, each with its line.
    around: Vec<(Tag, u32)>,
    /// The name of the placemark.
    name: Option<String>,
    text: String,
    curve: Curve,
    /// The times of a track; `None` where one cannot be read.
    times: Vec<Option<Timestamp>>,
}

impl Reader {
    fn start(&mut self, element: &Element<'_>) {
        let around = self.around.last().map(|(tag, _)| *tag);
        let tag = Tag::of(element.name(), around);
        self.around.push((tag, element.line));
        if tag == Tag::Placemark {
            self.name = None;
        }
        self.text.clear();
    }

    /// Returns true if the text within the last element is used.
    fn reads_text(&self) -> bool {
        let tag = self.around.last().map(|(tag, _)| *tag);
        matches!(
            tag,
            Some(Tag::Name | Tag::Positions | Tag::Position | Tag::Time)
        )
    }

    fn end(&mut self) -> Result<(), FileError> {
        let Some((tag, line)) = self.around.pop() else {
            return Ok(());
        };
        let text = std::mem::take(&mut self.text);
        match tag {
            Tag::Name => self.name = Some(text),
            Tag::Time => self.times.push(timestamp(text.trim())),
            Tag::Position => {
                let numbers = text.split_ascii_whitespace();
                self.curve.push(position(numbers, text.trim(), line)?, line);
                self.curves.check_room(&self.curve)?;
            }
            Tag::Positions => {
                let is_point = self
                    .around
                    .last()
                    .is_some_and(|(tag, _)| *tag == Tag::Point);
                let curve = match is_point {
                    true => &mut self.points,
                    false => &mut self.curve,
                };
                for position_text in text.split_ascii_whitespace() {
                    let numbers = position_text.split(',');
                    curve.push(position(numbers, position_text, line)?, line);
                    self.curves.check_room(curve)?;
                }
            }
            Tag::Line | Tag::Ring | Tag::Track => self.end_curve(tag == Tag::Ring)?,
            Tag::Placemark | Tag::Point | Tag::Other => {}
        }
        Ok(())
    }

    fn end_curve(&mut self, closed: bool) -> Result<(), FileError> {
        let mut curve = std::mem::replace(&mut self.curve, Curve::new(None));
        curve.name.clone_from(&self.name);
        curve.closed = closed;
        let times: Option<Vec<Timestamp>> = self.times.drain(..).collect();
        let times = times.filter(|it| it.len() == curve.points.len());
        curve.times = times.and_then(|times| {
            let first = *times.first()?;
            let seconds = |time: &Timestamp| time.duration_since(first).as_secs_f64();
            Some(times.iter().map(seconds).collect())
        });
        self.curves.push(curve)
    }

    fn finish(mut self, hints: &Hints) -> Result<Parts, FileErrors> {
        // Programs write 0 where there is no altitude.
        let is_flat = |[_, _, z]: &Point| *z == 0.0 || z.is_nan();
        if self.curves.points().all(is_flat) {
            for [_, _, z] in self.curves.points_mut() {
                *z = f64::NAN;
            }
        }
        tracks::finish(self.curves, self.points, "points", hints)
    }
}

/// Longitude, latitude and altitude; NaN without one.
fn position<'a>(
    numbers: impl Iterator<Item = &'a str>,
    text: &str,
    line: u32,
) -> Result<Point, FileError> {
    let wrong = |detail: String| FileError::at(line as usize, detail);
    let numbers: Option<Vec<f64>> = numbers.map(|it| it.trim().parse().ok()).collect();
    let numbers = numbers.filter(|it| it.iter().all(|x| x.is_finite()));
    let point = match numbers.as_deref() {
        Some(&[longitude, latitude]) => [longitude, latitude, f64::NAN],
        Some(&[longitude, latitude, altitude]) => [longitude, latitude, altitude],
        _ => {
            let detail = "is no longitude, latitude and altitude";
            return Err(wrong(format!("{} {detail}", quoted(text))));
        }
    };
    for ((name, largest), x) in LARGEST.iter().zip(point) {
        if x.abs() > *largest {
            let detail = format!("{name} is {x}, and not from -{largest} to {largest}");
            return Err(wrong(detail));
        }
    }
    Ok(point)
}

#[cfg(test)]
mod tests;
