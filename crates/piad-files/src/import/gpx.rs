//! Tracks, routes and waypoints of GPX.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::curves::{Curve, Curves};
use super::degrees;
use super::error::{FileError, FileErrors, MOST_ERRORS};
use super::imported::Hints;
use super::part::Parts;
use super::xml::{self, Element, Node, Nodes};
use crate::short::quoted;

/// Returns true if a text is GPX.
pub(super) fn is_gpx(text: &str) -> bool {
    xml::root(text).as_deref() == Some("gpx")
}

/// Each segment of a track and each route is a part. Waypoints are one if there is nothing else.
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

/// What an element is, by its name and by what it stands in.
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

    /// Returns true if the text within the last element means something.
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

    fn finish(mut self, hints: &Hints) -> Result<Parts, FileErrors> {
        if !self.errors.is_empty() {
            return Err(FileErrors(self.errors));
        }
        let mut notices = Vec::new();
        let waypoints = self.waypoints.points.len();
        if self.curves.count() == 0 {
            self.curves.push(self.waypoints)?;
        } else if waypoints > 0 {
            notices.push(format!("{waypoints} waypoints are not read."));
        }
        let heights = self.curves.points().filter(|[_, _, z]| z.is_finite());
        let heights = heights.count();
        let count = self.curves.count();
        if heights > 0 && heights < count {
            notices.push(format!(
                "{} of {count} points have no elevation, which is left out.",
                count - heights
            ));
        }
        notices.splice(0..0, degrees::to_metres(&mut self.curves));
        let dimension = if heights == count { 3 } else { 2 };
        let mut parts = self.curves.finish(dimension, notices)?;
        if parts.parts.iter().any(|part| part.times.is_some()) && !hints.times {
            let notice =
                "The points have times, which are not used; curve.parameters=time uses them.";
            parts.notices.push(notice.to_owned());
        }
        Ok(parts)
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

/// A time in ISO 8601. One without an offset from UTC, which GPX does not allow, is taken as UTC.
fn timestamp(text: &str) -> Option<Timestamp> {
    let with_offset = text.parse().ok();
    with_offset.or_else(|| {
        let local: DateTime = text.parse().ok()?;
        TimeZone::UTC.to_timestamp(local).ok()
    })
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
mod tests {
    use proptest::prelude::*;

    use crate::import::tests::HINTS;
    use crate::import::{FileErrors, Hints, Imported, read_parts};

    fn parts(body: &str, hints: &Hints) -> Result<Vec<Imported>, FileErrors> {
        let text = format!("<?xml version=\"1.0\"?>\n<gpx version=\"1.1\">\n{body}</gpx>");
        read_parts(text.as_bytes(), hints)
    }

    fn point(tag: &str, i: u32, more: &str) -> String {
        let (lat, lon) = (48.0 + f64::from(i) * 1e-4, 11.5 + f64::from(i * i) * 1e-5);
        format!("<{tag} lat=\"{lat}\" lon='{lon}'>{more}</{tag}>\n")
    }

    fn points(tag: &str, more: impl Fn(u32) -> String) -> String {
        (0..4).map(|i| point(tag, i, &more(i))).collect()
    }

    fn timed(i: u32) -> String {
        format!(
            "<ele>{}</ele><time>2026-05-01T10:0{i}:00.5+02:00</time>",
            500 + i
        )
    }

    #[test]
    fn segments_and_routes_are_parts() {
        let segment = format!("<trkseg>\n{}</trkseg>", points("trkpt", timed));
        let body = format!(
            "<metadata><name>no</name></metadata><wpt lat='1' lon='1'/>\n<trk><name>A &amp; B</name>{segment}\n<trkseg/>{segment}</trk>\n<rte>{}</rte>",
            points("rtept", timed)
        );
        let parts = parts(&body, &HINTS).unwrap();
        let names = parts.iter().map(|part| part.name.as_deref());
        let names: Vec<_> = names.collect();
        assert_eq!(names, [Some("A & B"), Some("A & B 2"), None]);
        let part = &parts[0];
        assert_eq!((part.points.dimension(), part.points.len()), (3, 4));
        assert_eq!(part.lines, [5, 6, 7, 8]);
        assert_eq!(part.points.lane(2), [500.0, 501.0, 502.0, 503.0]);
        assert!((part.points.lane(1)[1] - 11.12).abs() < 0.01);
        assert!((part.points.lane(0)[1] - 0.746).abs() < 0.001);
        assert_eq!(
            part.notices,
            [
                "Longitude and latitude are metres east and north of latitude 48, longitude 11.5.",
                "1 waypoints are not read.",
                "Part 2 of the file has fewer than 2 different points, and is left out.",
                "The points have times, which are not used; curve.parameters=time uses them.",
            ]
        );
    }

    #[test]
    fn times_are_parameters_where_they_are_asked_for() {
        let times = Hints {
            times: true,
            ..HINTS
        };
        let body = |more: fn(u32) -> String| {
            format!(
                "<wpt lat='48' lon='11'/><trk><trkseg>{}</trkseg></trk>",
                points("trkpt", more)
            )
        };
        let part = parts(&body(timed), &times).unwrap().remove(0);
        assert_eq!(part.parameters, Some(vec![0.0, 60.0, 120.0, 180.0]));
        assert!(part.notices.iter().all(|it| !it.contains("not used")));
        // One that has none, or is none.
        for more in [
            (|i| if i == 2 { String::new() } else { timed(i) }) as fn(u32) -> String,
            |i| timed(i).replace("T10:02", "T30:02"),
        ] {
            let error = parts(&body(more), &times).unwrap_err();
            assert!(error.to_string().contains("no times"), "{error}");
        }
        // Without an offset, as some devices write it.
        let local = |i| format!("<time>2026-05-01T08:00:0{i}</time>");
        let part = parts(&body(local), &times).unwrap().remove(0);
        assert_eq!(part.parameters, Some(vec![0.0, 1.0, 2.0, 3.0]));
    }

    #[test]
    fn elevations_and_waypoints_are_taken_where_they_are_all_there_is() {
        let some = |i| match i {
            0 => String::new(),
            _ => timed(i),
        };
        let body = format!("<trk><trkseg>{}</trkseg></trk>", points("trkpt", some));
        let part = parts(&body, &HINTS).unwrap().remove(0);
        assert_eq!(part.points.dimension(), 2);
        let notice = "1 of 4 points have no elevation, which is left out.";
        assert_eq!(part.notices[1], notice);
        let waypoints = points("wpt", |_| String::new());
        let part = parts(&waypoints, &HINTS).unwrap().remove(0);
        assert_eq!((part.points.len(), part.points.dimension()), (4, 2));
    }

    #[test]
    fn what_is_wrong_is_said_at_its_line() {
        let good = points("trkpt", |_| String::new());
        for (wrong, line, detail) in [
            ("<trkpt lat='1'/>", 8, "this point has no lon"),
            (
                "<trkpt lat='91' lon='0'/>",
                8,
                "lat is \"91\", and not a number from -90 to 90",
            ),
            (
                "<trkpt lat='1,5' lon='0'/>",
                8,
                "lat is \"1,5\", and not a number from -90 to 90",
            ),
            (
                "<trkpt lat='1' lon='nan'/>",
                8,
                "lon is \"nan\", and not a number from -180 to 180",
            ),
        ] {
            let body = format!("<trk><trkseg>\n{good}{wrong}</trkseg></trk>");
            let error = parts(&body, &HINTS).unwrap_err().0.remove(0);
            assert_eq!((error.line, &*error.detail), (Some(line), detail));
        }
        let body = format!("<trk><trkseg>{good}");
        assert!(parts(&body, &HINTS).is_err());
        let few = Hints { most: 6, ..HINTS };
        let body = format!("<trk><trkseg>\n{good}</trkseg><trkseg>\n{good}</trkseg></trk>");
        let error = parts(&body, &few).unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 11: there are more than 6 points, the limit"
        );
        assert!(
            parts("", &HINTS)
                .unwrap_err()
                .to_string()
                .contains("no points")
        );
        let cut = read_parts(b"<gpx><trk><trkseg><trkpt lat='1' lon='2'>", &HINTS);
        assert!(cut.unwrap_err().to_string().contains("cut off"));
    }

    #[test]
    fn points_around_the_world_stay_degrees() {
        let far = [(0.0, 0.0), (20.0, 100.0), (0.0, -170.0)];
        let far = far.map(|(lat, lon)| format!("<rtept lat='{lat}' lon='{lon}'/>"));
        let part = parts(&format!("<rte>{}</rte>", far.concat()), &HINTS);
        let part = part.unwrap().remove(0);
        assert_eq!(part.points.lane(0), [0.0, 100.0, -170.0]);
        assert!(part.notices[0].contains("kept as degrees"));
    }

    #[test]
    fn deep_and_wide_files_take_no_more_than_their_size() {
        let deep = format!(
            "<gpx>{}{}</gpx>",
            "<a>".repeat(200_000),
            "</a>".repeat(200_000)
        );
        assert!(read_parts(deep.as_bytes(), &HINTS).is_err());
        let wide: String = (0..200_000)
            .map(|i| format!(" a{i}='' xmlns:b{i}=''"))
            .collect();
        let wide = format!("<gpx><wpt{wide} lat='1' lon='1'/></gpx>");
        assert!(read_parts(wide.as_bytes(), &HINTS).is_err());
        let entities: String = (1..60)
            .map(|i| format!("<!ENTITY a{i} '&a{};&a{};'>", i - 1, i - 1))
            .collect();
        let bomb = format!(
            "<!DOCTYPE gpx [<!ENTITY a0 'aaaaaaaa'>{entities}]><gpx><trk><name>&a59;</name></trk></gpx>"
        );
        assert!(read_parts(bomb.as_bytes(), &HINTS).is_err());
        // In Latin 1: the letter is lost, the points are not.
        let route = points("rtept", |_| String::new());
        let mut latin = b"<gpx><rte><name>\xe4</name>".to_vec();
        latin.extend(route.bytes().chain(*b"</rte></gpx>"));
        assert_eq!(read_parts(&latin, &HINTS).unwrap()[0].points.len(), 4);
    }

    proptest! {
        #[test]
        fn no_text_panics(body in "(<(/?)(trk|trkseg|trkpt lat='1' lon='[0-9]'|ele|time|name|rte|rtept)/?>|[0-9&;<!\\[\\-]|\n){0,40}") {
            let _ = parts(&body, &HINTS);
        }
    }
}
