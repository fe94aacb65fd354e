//! Lines of numbers, with titles or names of columns above them, comments and blank lines between
//! them, and remarks below them.

use rayon::prelude::*;

use super::airfoil;
use super::error::{FileError, FileErrors, MOST_ERRORS};
use super::fast_path::{self, Piece};
use super::head::Head;
use super::imported::Hints;
use super::layout::Layout;
use super::line::{blank_or_tab, line_end, without_comment};
use super::names;
use super::number_format::Notation;
use super::part::{NO_POINTS, Part};
use super::sample::Below;
use super::table::{self, Table};
use super::text_column::text_column;
use crate::text::quoted;
use piad_fit::data::Points;

/// Files of more points get room for all of them at once.
const PREALLOCATION_POINTS: usize = 1024;

/// The most lines of words above the points. More of them are the head of a format of its own.
const MOST_TITLES: usize = 3;

/// Reads the lines of a file.
pub(super) fn read(text: &str, hints: &Hints) -> Result<Part, FileErrors> {
    let end = line_end(text);
    let mut reader = Reader::new(hints, fast_path::count_lines(text, end));
    let mut rest = Some(text);
    for number in 1.. {
        let Some(text) = rest.filter(|text| !reader.takes_all(text, end, number)) else {
            break;
        };
        let (line, below) = match text.split_once(end) {
            Some((line, below)) => (line, Some(below)),
            None => (text, None),
        };
        rest = below;
        if reader.layout.is_none() {
            reader.no_data = table::no_data(line).or(reader.no_data);
        }
        let is_blank = line.trim_matches(blank_or_tab).is_empty();
        let line = without_comment(line);
        let line = match reader.layout.as_ref().is_none_or(Layout::has_tabs) {
            true => line,
            false => line.trim_matches('\t'),
        };
        let below = Below {
            text: below.unwrap_or_default(),
            end,
        };
        if is_blank {
            reader.pause();
        } else if line.trim().is_empty() {
            // A comment line is no separator.
        } else if let Err(error) = reader.line(number, line, below) {
            reader.errors.push(error);
            // If a file has no line of numbers so far, all further lines have the same error.
            if reader.layout.is_none() {
                break;
            }
        }
        if reader.errors.len() >= MOST_ERRORS || reader.is_full() {
            break;
        }
    }
    reader.end()
}

/// The meaning of a first line of two numbers: the domain of a grid, as in files of MSES.
#[derive(PartialEq)]
enum Domain {
    None,
    /// If points with two coordinates follow. The line.
    Possible(String),
    Passed,
}

struct Reader<'a> {
    hints: &'a Hints,
    most: usize,
    /// The largest number of points, by the lines of the file.
    possible: usize,
    /// Known from the first line of numbers on.
    layout: Option<Layout>,
    /// The lines of words before the first line of numbers.
    titles: Vec<(usize, String)>,
    domain: Domain,
    /// Notices, in sentences.
    notices: Vec<String>,
    points: Option<Points>,
    lines: Vec<u32>,
    breaks: Vec<usize>,
    /// The errors of the last lines, if they are words below the points.
    remarks: Vec<FileError>,
    /// The first of these lines.
    remark: String,
    errors: Vec<FileError>,
    /// The number that marks missing values, if the lines above the points define it.
    no_data: Option<f64>,
}

impl<'a> Reader<'a> {
    fn new(hints: &'a Hints, lines: usize) -> Self {
        let most = hints.most;
        Self {
            hints,
            no_data: None,
            most,
            possible: lines.min(most.saturating_add(1)),
            layout: None,
            titles: Vec::new(),
            domain: Domain::None,
            notices: Vec::new(),
            points: None,
            lines: Vec::new(),
            breaks: Vec::new(),
            remarks: Vec::new(),
            remark: String::new(),
            errors: Vec::new(),
        }
    }

    fn is_full(&self) -> bool {
        self.lines.len() > self.most
    }

    /// Takes all lines of a text, of which the first has this number, if they are points like the first
    /// one of the file, and not too many.
    fn takes_all(&mut self, text: &str, end: char, number: usize) -> bool {
        let settled = self.lines.len() == 1 && !matches!(self.domain, Domain::Possible(_));
        let (Some(layout), Some(points), true) = (&self.layout, &mut self.points, settled) else {
            return false;
        };
        let count = fast_path::count_lines(text, end);
        if self.lines.len() + count > self.most {
            return false;
        }
        let (lines, breaks) = (&mut self.lines, &mut self.breaks);
        let before = (lines.len(), breaks.len());
        let mut first = u32::try_from(number).unwrap_or(u32::MAX);
        let put = |pieces: &[Piece]| {
            // Only once there is a piece: most of a text without one would never be read.
            if lines.len() == before.0 {
                lines.reserve_exact(count);
                points.make_room(count);
            }
            for piece in pieces {
                for place in &piece.breaks {
                    let place = lines.len() + place;
                    if breaks.last() != Some(&place) {
                        breaks.push(place);
                    }
                }
                lines.extend(piece.lines.iter().map(|line| first.saturating_add(*line)));
                first = first.saturating_add(piece.count);
            }
            let lanes = points.lanes_mut().par_iter_mut().enumerate();
            lanes.for_each(|(c, lane)| {
                for piece in pieces {
                    lane.extend_from_slice(piece.lanes.get(c).map_or(&[], Vec::as_slice));
                }
            });
        };
        let all = fast_path::points(text, end, layout, put);
        if all.is_none() {
            points.truncate(before.0);
            lines.truncate(before.0);
            breaks.truncate(before.1);
        }
        all.is_some()
    }

    /// A blank line.
    fn pause(&mut self) {
        let count = self.lines.len();
        if count > 0 && self.breaks.last() != Some(&count) {
            self.breaks.push(count);
        }
    }

    fn line(&mut self, number: usize, line: &str, below: Below<'_>) -> Result<(), FileError> {
        let Some(layout) = &self.layout else {
            return match self.begins(number, line, below)? {
                false => self.words(number, line),
                true => self.line(number, line, below),
            };
        };
        match layout.point(line) {
            Ok(point) => self.point(number, &point),
            Err(_) if self.pass_over_domain(line) => self.line(number, line, below),
            Err(detail) => {
                let error = FileError::at(number, detail);
                if self.remarks.is_empty() && !self.is_remark(line) {
                    return Err(error);
                }
                if self.remarks.is_empty() {
                    line.clone_into(&mut self.remark);
                }
                if self.remarks.len() < MOST_ERRORS {
                    self.remarks.push(error);
                }
                Ok(())
            }
        }
    }

    /// Returns true if the points begin with this line.
    fn begins(&mut self, number: usize, line: &str, below: Below<'_>) -> Result<bool, FileError> {
        let words = self.titles.last();
        let head = Head {
            number,
            line,
            below,
            words: words.map(|(number, words)| (*number, words.as_str())),
        };
        let Some(layout) = Layout::begin(head, self.hints)? else {
            return Ok(false);
        };
        let titles = self.titles.len() - usize::from(layout.named);
        let titles = self.titles.iter().take(titles);
        let broken = titles.filter(|(_, title)| !layout.is_title(title));
        let broken = broken.map(|(number, title)| {
            let detail = layout.point(title).err();
            let above = || format!("{} is above the first line of numbers", quoted(title));
            FileError::at(*number, detail.unwrap_or_else(above))
        });
        self.errors.extend(broken);
        if !self.titles.is_empty() && airfoil::is_domain(&layout.numbers(line)) {
            self.domain = Domain::Possible(line.to_owned());
        }
        self.layout = Some(layout);
        Ok(true)
    }

    fn point(&mut self, number: usize, point: &[f64]) -> Result<(), FileError> {
        if self.domain == Domain::Passed && point == airfoil::NEXT_ELEMENT {
            let detail = "another element of the airfoil begins here (MSES), and a curve is of one: each needs a file of its own";
            return Err(FileError::at(number, detail));
        }
        // Points below them: they were no remarks.
        self.errors.append(&mut self.remarks);
        let points = self.points.get_or_insert_with(|| Points::new(point.len()));
        if self.lines.len() == PREALLOCATION_POINTS {
            // Growth by doubling would need three times the memory during the move.
            let more = self.possible.saturating_sub(PREALLOCATION_POINTS);
            points.make_room(more);
            self.lines.reserve_exact(more);
        }
        points.push(point);
        self.lines.push(u32::try_from(number).unwrap_or(u32::MAX));
        if self.is_full() {
            let detail = format!("there are more than {} points, the limit", self.most);
            return Err(FileError::at(number, detail));
        }
        Ok(())
    }

    /// Removes the first line of numbers if it is the domain of a grid, with this line below it.
    fn pass_over_domain(&mut self, below: &str) -> bool {
        let columns = Notation::of(below).map(|notation| notation.fields(below).count());
        let (Domain::Possible(domain), 1, Some(2)) = (&self.domain, self.lines.len(), columns)
        else {
            return false;
        };
        self.notices.push(format!(
            "The first line of numbers, {}, is the domain of a grid (MSES), which is not read.",
            quoted(domain)
        ));
        self.domain = Domain::Passed;
        (self.layout, self.points) = (None, None);
        self.lines.clear();
        self.breaks.clear();
        true
    }

    /// Returns true if a line that is not a point begins the remarks below the points. Tables with names of columns
    /// have none; other files have them after a blank line, or below a title.
    fn is_remark(&self, line: &str) -> bool {
        let Some(layout) = self.layout.as_ref().filter(|layout| !layout.named) else {
            return false;
        };
        let count = self.lines.len();
        let after_blank = self.breaks.last() == Some(&count);
        let is_word = Layout::begins_with_word(line) && !layout.is_row_with_text(line);
        match after_blank {
            true => is_word || !layout.is_damaged(line),
            false => is_word && !self.titles.is_empty() && count > 0,
        }
    }

    /// A line before the numbers: these name the file or its columns.
    fn words(&mut self, number: usize, line: &str) -> Result<(), FileError> {
        if self.are_units(line) {
            return Ok(());
        }
        if line.trim_start().starts_with(['{', '[']) {
            let detail = "this is JSON, which is sent as application/json";
            return Err(FileError::at(number, detail));
        }
        self.titles.push((number, line.to_owned()));
        if self.titles.len() <= MOST_TITLES {
            return Ok(());
        }
        let unknown = || {
            let detail = format!(
                "{} is no line of numbers, and there are {MOST_TITLES} lines of words above it",
                quoted(line)
            );
            FileError::at(number, detail)
        };
        Err(text_column(&self.titles).unwrap_or_else(unknown))
    }

    /// Returns true if a line has the units of the names in the line above it.
    fn are_units(&self, line: &str) -> bool {
        let above = self.titles.last().map(|(_, words)| words.as_str());
        let count = |line: &str| Notation::of_names(line).fields(line).count();
        let same = above.is_some_and(|above| count(above) == count(line));
        same && count(line) > 1 && names::are_units(Notation::of_names(line).fields(line))
    }

    fn end(self) -> Result<Part, FileErrors> {
        if !self.errors.is_empty() {
            return Err(FileErrors(self.errors));
        }
        let (Some(points), Some(layout)) = (self.points, self.layout) else {
            let error = text_column(&self.titles);
            return Err(error
                .unwrap_or_else(|| FileError::of_file(NO_POINTS))
                .into());
        };
        let mut notices = self.notices;
        let titles = self.titles.len() - usize::from(layout.named);
        if titles > 1 {
            notices.push(format!(
                "There are {titles} lines of words above the points: the first is the name, the others are not read."
            ));
        }
        if let Some(line) = self.remarks.first().and_then(|first| first.line) {
            notices.push(format!(
                "The text after the points, from line {line} on, {}, is skipped.",
                quoted(&self.remark)
            ));
        }
        let mut breaks = self.breaks;
        breaks.retain(|index| *index < points.len());
        let name = self.titles.into_iter().take(titles).next();
        let table = Table {
            layout,
            no_data: self.no_data,
            part: Part {
                breaks,
                name: name.map(|(_, name)| name.trim().replace('\t', " ")),
                notices,
                ..Part::new(points, self.lines)?
            },
        };
        table.part(self.hints)
    }
}
