//! Converts the numbers of a table to the points of a part: times and counters are removed, gaps are handled, and
//! longitude and latitude become metres.

use super::choice::Choice;
use super::column_notice::ColumnNotice;
use super::degrees;
use super::error::{FileError, FileErrors, MOST_ERRORS};
use super::gaps;
use super::imported::Hints;
use super::layout::Layout;
use super::part::Part;
use super::sample::{Content, is_start};
use piad_fit::data::Points;

/// The fewest points of which a first column of three is a counter: a curve may begin with x = 1, 2, 3, and a longer
/// curve is unlikely to continue like that.
const LEAST_COUNTED: usize = 8;

/// The most coordinates of points if the first column is no counter after all.
const MOST_COORDINATES: usize = 3;

/// A table whose lines are read.
pub(super) struct Table {
    pub(super) layout: Layout,
    /// The number that marks missing values.
    pub(super) no_data: Option<f64>,
    /// Its points have the values of each line.
    pub(super) part: Part,
}

impl Table {
    /// The points of the table.
    ///
    /// # Errors
    ///
    /// If too few points are left without the gaps; if degrees are invalid, at their lines.
    pub(super) fn part(self, hints: &Hints) -> Result<Part, FileErrors> {
        let Self {
            layout,
            no_data,
            mut part,
        } = self;
        let mut choice = layout.choice.clone();
        let is_parameter = choice.time.is_some_and(|time| time.is_parameter);
        let times = is_parameter || hints.times;
        let counter = separate(&mut part, &mut choice);
        let notice = ColumnNotice {
            choice: &choice,
            names: layout.names.as_deref(),
            contents: &layout.contents,
            times,
            counter,
        };
        part.notices.splice(0..0, notice.text());
        part.notices.extend(in_seconds(&choice, &layout.contents));
        part.times_are_parameters = is_parameter;
        if let Some(no_data) = no_data {
            gaps::forget(&mut part.points, no_data);
        }
        gaps::settle(&mut part, choice.degrees.is_some(), times, hints)?;
        from_first(&mut part);
        if let Some(places) = choice.degrees {
            in_metres(&mut part, places)?;
        }
        Ok(part)
    }
}

/// Removes the times from the coordinates, and the counter if it is one; returns its column.
fn separate(part: &mut Part, choice: &mut Choice) -> Option<usize> {
    let lanes = part.points.lanes_mut();
    let mut lanes: Vec<_> = lanes.iter_mut().map(std::mem::take).collect();
    if let Some(time) = choice.time {
        let times = lanes.pop().unwrap_or_default();
        part.times = Some(times.iter().map(|it| it * time.seconds).collect());
    }
    let column = choice.counter.take();
    let counts = column.is_some() && lanes.first().is_some_and(|lane| counts(lane, lanes.len()));
    match column {
        Some(_) if counts => drop(lanes.remove(0)),
        Some(column) => {
            choice.coordinates.insert(0, column);
            choice.coordinates.truncate(MOST_COORDINATES);
            lanes.truncate(MOST_COORDINATES);
        }
        None => {}
    }
    part.points = Points::from_lanes(lanes);
    column.filter(|_| counts)
}

/// Returns true if the first of this many columns counts all points.
fn counts(lane: &[f64], columns: usize) -> bool {
    let least = if columns > 3 { 2 } else { LEAST_COUNTED };
    let first = lane.first().copied().filter(|first| is_start(*first));
    let goes_on = |first: f64| (0..).zip(lane).all(|(i, it)| *it == first + f64::from(i));
    lane.len() >= least && first.is_some_and(goes_on)
}

/// The notice about coordinates that are times in ISO 8601.
fn in_seconds(choice: &Choice, contents: &[Content]) -> Option<String> {
    let is_time = |it: &&usize| contents.get(**it) == Some(&Content::Times);
    let column = choice.coordinates.iter().find(is_time)?;
    Some(format!(
        "The times of column {} are coordinates, in seconds from the first one.",
        column + 1
    ))
}

/// Counts the times from the first one.
fn from_first(part: &mut Part) {
    let times = part.times.iter_mut().flatten();
    let mut first = None;
    for time in times {
        *time -= *first.get_or_insert(*time);
    }
}

/// Makes metres of longitude and latitude, at these places of the coordinates, in a plane at the first point.
fn in_metres(part: &mut Part, places: (usize, usize)) -> Result<(), FileErrors> {
    let (longitude, latitude) = places;
    let missing = part.missing.clone();
    let is_missing = |index: usize| missing.binary_search(&index).is_ok();
    let lanes = part.points.lanes();
    let degrees = lanes.get(longitude).zip(lanes.get(latitude));
    let degrees: Vec<[f64; 2]> = degrees.map_or(Vec::new(), |(east, north)| {
        east.iter().zip(&**north).map(|(e, n)| [*e, *n]).collect()
    });
    let errors = wrong_degrees(part, &degrees, is_missing);
    if !errors.is_empty() {
        return Err(FileErrors(errors));
    }
    let known: Vec<[f64; 2]> = (0..)
        .zip(&degrees)
        .filter(|(index, _)| !is_missing(*index))
        .map(|(_, place)| *place)
        .collect();
    let (plane, notices) = degrees::plane(&known);
    part.notices.extend(notices);
    let Some(plane) = plane else {
        return Ok(());
    };
    part.origin = Some(plane.place());
    for (index, [east, north]) in degrees.iter().enumerate() {
        // A place that is not known is not in the plane either.
        let [east, north] = match (east, north) {
            (0.0, 0.0) if is_missing(index) => [0.0; 2],
            _ => plane.metres(*east, *north),
        };
        for (lane, metres) in [(longitude, east), (latitude, north)] {
            let lane = part.points.lanes_mut().get_mut(lane);
            if let Some(coordinate) = lane.and_then(|lane| lane.get_mut(index)) {
                *coordinate = metres;
            }
        }
    }
    Ok(())
}

/// The errors of degrees, at their lines.
fn wrong_degrees(
    part: &Part,
    degrees: &[[f64; 2]],
    is_missing: impl Fn(usize) -> bool,
) -> Vec<FileError> {
    let wrong = degrees
        .iter()
        .enumerate()
        .filter_map(|(index, [east, north])| {
            let detail = match () {
                () if is_missing(index) => None,
                () if north.abs() > 90.0 => {
                    Some(format!("latitude {north} is not between -90 and 90"))
                }
                () if east.abs() > 360.0 => {
                    Some(format!("longitude {east} is not between -360 and 360"))
                }
                () => None,
            };
            let line = part.lines.get(index).map(|line| *line as usize);
            Some(FileError::new(line, detail?))
        });
    wrong.take(MOST_ERRORS).collect()
}

/// The number that marks missing values, if a line above the points defines it, as in `# NODATA: -9999`.
pub(super) fn no_data(line: &str) -> Option<f64> {
    let lower = line.to_lowercase();
    let names = ["nodata", "no_data", "no data"];
    let (at, name) = names
        .iter()
        .find_map(|name| Some((lower.find(name)?, name)))?;
    let behind = lower.get(at + name.len()..)?;
    let mut words = behind.split(|c: char| c.is_whitespace() || "=:;,()".contains(c));
    words.find_map(|word| word.parse().ok())
}
