//! Tracks, routes and waypoints of GPX.

use jiff::Timestamp;

use super::curves::{Curve, Curves};
use super::error::{FileError, FileErrors, MOST_ERRORS};
use super::imported::Hints;
use super::part::Parts;
use super::tracks::{self, timestamp};
use super::xml::{self, Element, Node, Nodes};
use crate::text::quoted;

/// Returns true if a text is GPX.
pub(super) fn is_gpx(text: &str) -> bool {
    xml::root(text).as_deref() == Some("gpx")
}

/// Each segment of a track and each route is a part. Waypoints are a part if there is nothing else.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Parts, FileErrors> {
    let mut reader = Reader::new(hints.most);
    let mut nodes = Nodes::new(text);
    while let Some(node) = nodes.next()? {
        match node {
            Node::Start(element) => reader.start(&element)?,
            Node::Text(text) if reader.reads_text() => reader.text += &text,
            Node::Text(_) => {}
            Node::End => reader.end()?,
        }
        if reader.errors.len() >= MOST_ERRORS {
            break;
        }
    }
    reader.finish(hints)
}

/// The meaning of an element, by its name and its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    File,
    Track,
    Segment,
    Route,
    Waypoint,
    /// Of a track or of a route.
    Point,
    Name,
    Elevation,
    Time,
    Other,
}

impl Tag {
    fn of(name: &str, around: Option<Self>) -> Self {
        match (around, name) {
            (None, _) => Self::File,
            (Some(Self::File), "trk") => Self::Track,
            (Some(Self::File), "rte") => Self::Route,
            (Some(Self::File), "wpt") => Self::Waypoint,
            (Some(Self::Track), "trkseg") => Self::Segment,
            (Some(Self::Segment), "trkpt") | (Some(Self::Route), "rtept") => Self::Point,
            (Some(Self::Track | Self::Route), "name") => Self::Name,
            (Some(Self::Point | Self::Waypoint), "ele") => Self::Elevation,
            (Some(Self::Point), "time") => Self::Time,
            _ => Self::Other,
        }
    }
}

struct Reader {
    curves: Curves,
    /// The elements around.
    around: Vec<Tag>,
    /// The text of a name, an elevation or a time.
    text: String,
    /// The name of the track or route.
    name: Option<String>,
    /// The segment or route.
    curve: Curve,
    times: Times,
    waypoints: Curve,
    errors: Vec<FileError>,
}

/// The times of the points of a segment or route.
#[derive(Default)]
struct Times {
    first: Option<Timestamp>,
    /// Seconds from the first one; NaN where there is none.
    seconds: Vec<f64>,
}

impl Reader {
    fn new(most: usize) -> Self {
        Self {
            curves: Curves::new(most),
            around: Vec::new(),
            text: String::new(),
            name: None,
            curve: Curve::new(None),
            times: Times::default(),
            waypoints: Curve::cloud(None),
            errors: Vec::new(),
        }
    }

    fn start(&mut self, element: &Element<'_>) -> Result<(), FileError> {
        let tag = Tag::of(element.name(), self.around.last().copied());
        self.around.push(tag);
        match tag {
            Tag::Track | Tag::Route => self.name = None,
            Tag::Point | Tag::Waypoint => self.point(tag, element)?,
            _ => {}
        }
        self.text.clear();
        Ok(())
    }

    /// Returns true if the text within the last element is used.
    fn reads_text(&self) -> bool {
        matches!(
            self.around.last(),
            Some(Tag::Name | Tag::Elevation | Tag::Time)
        )
    }

    fn point(&mut self, tag: Tag, element: &Element<'_>) -> Result<(), FileError> {
        let longitude = degrees(element, "lon", 180.0);
        let latitude = degrees(element, "lat", 90.0);
        let (longitude, latitude) = match (longitude, latitude) {
            (Ok(longitude), Ok(latitude)) => (longitude, latitude),
            (Err(error), _) | (_, Err(error)) => {
                self.errors.push(error);
                return Ok(());
            }
        };
        let curve = match tag {
            Tag::Waypoint => &mut self.waypoints,
            _ => {
                self.times.seconds.push(f64::NAN);
                &mut self.curve
            }
        };
        curve.push([longitude, latitude, f64::NAN], element.line);
        self.curves.check_room(curve)
    }

    fn end(&mut self) -> Result<(), FileError> {
        let tag = self.around.pop();
        let around = self.around.last();
        match tag {
            Some(Tag::Name) => self.name = Some(std::mem::take(&mut self.text)),
            Some(Tag::Elevation) => {
                let curve = match around {
                    Some(Tag::Waypoint) => &mut self.waypoints,
                    _ => &mut self.curve,
                };
                let elevation = self
                    .text
                    .trim()
                    .parse()
                    .ok()
                    .filter(|z: &f64| z.is_finite());
                if let (Some([_, _, z]), Some(elevation)) = (curve.points.last_mut(), elevation) {
                    *z = elevation;
                }
            }
            Some(Tag::Time) => self.times.put(timestamp(self.text.trim())),
            Some(Tag::Segment | Tag::Route) => return self.end_curve(),
            _ => {}
        }
        Ok(())
    }

    fn end_curve(&mut self) -> Result<(), FileError> {
        let mut curve = std::mem::replace(&mut self.curve, Curve::new(None));
        curve.name.clone_from(&self.name);
        let times = std::mem::take(&mut self.times).seconds;
        let all = times.len() == curve.points.len() && times.iter().all(|time| time.is_finite());
        curve.times = all.then_some(times);
        self.curves.push(curve)
    }

    fn finish(self, hints: &Hints) -> Result<Parts, FileErrors> {
        if !self.errors.is_empty() {
            return Err(FileErrors(self.errors));
        }
        tracks::finish(self.curves, self.waypoints, "waypoints", hints)
    }
}

impl Times {
    /// Sets the time of the last point.
    fn put(&mut self, time: Option<Timestamp>) {
        let (Some(time), Some(seconds)) = (time, self.seconds.last_mut()) else {
            return;
        };
        let first = *self.first.get_or_insert(time);
        *seconds = time.duration_since(first).as_secs_f64();
    }
}

/// An attribute that is an angle from the negative of the largest one up to it.
fn degrees(element: &Element<'_>, name: &str, largest: f64) -> Result<f64, FileError> {
    let line = element.line as usize;
    let Some(text) = element.attribute(name)? else {
        return Err(FileError::at(line, format!("this point has no {name}")));
    };
    let number = text.trim().parse().ok();
    number
        .filter(|number: &f64| number.abs() <= largest)
        .ok_or_else(|| {
            let detail = format!(
                "{name} is {}, and not a number from -{largest} to {largest}",
                quoted(&text)
            );
            FileError::at(line, detail)
        })
}

#[cfg(test)]
mod tests;
