//! Interprets blocks as a machine does.

use std::collections::BTreeMap;

use super::arc::{self, Centre, Plane};
use super::words::Word;
use crate::import::curves::{Curve, Curves, Point};
use crate::import::error::FileError;
use crate::import::sampled::SAMPLED;

/// The letters of the axes.
const AXES: [char; 3] = ['X', 'Y', 'Z'];

/// The letters of the centre of an arc.
const CENTRE: [char; 3] = ['I', 'J', 'K'];

/// The letters of axes that are not read.
const OTHER_AXES: [char; 6] = ['A', 'B', 'C', 'U', 'V', 'W'];

/// How the tool moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Not by coordinates alone: a cycle, or none yet.
    None,
    Rapid,
    Line,
    Arc {
        clockwise: bool,
    },
}

/// The units of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Units {
    Inches,
    Millimetres,
}

/// A machine, and the paths that its tool passed.
pub(super) struct Machine {
    pub(super) curves: Curves,
    pub(super) units: Option<Units>,
    /// The number of occurrences of each skipped word.
    pub(super) unread: BTreeMap<String, usize>,
    /// True if moves straight up or down were left out.
    pub(super) plunges: bool,
    /// True if only moves that feed material (E) are paths.
    feeds: bool,
    place: Point,
    /// True if the coordinates of the place are known.
    known: [bool; 3],
    motion: Motion,
    plane: Plane,
    is_relative: bool,
    is_centre_absolute: bool,
    /// The path since the last rapid move.
    curve: Curve,
    moved: bool,
}

/// The content of a block beside the modes of the machine.
#[derive(Default)]
struct Block {
    /// Its coordinates are not a target.
    is_no_move: bool,
    /// True if the position is unknown from now on.
    is_lost: bool,
    /// The coordinates redefine the current position.
    is_renamed: bool,
}

impl Machine {
    /// A machine whose paths have at most `most` points.
    pub(super) fn new(most: usize, feeds: bool) -> Self {
        Self {
            curves: Curves::new(most),
            units: None,
            unread: BTreeMap::new(),
            plunges: false,
            feeds,
            place: [0.0; 3],
            known: [false; 3],
            motion: Motion::None,
            plane: [0, 1, 2],
            is_relative: false,
            is_centre_absolute: false,
            curve: Curve::new(None),
            moved: false,
        }
    }

    /// Executes a block.
    ///
    /// # Errors
    ///
    /// If the block is invalid, or not supported.
    pub(super) fn block(&mut self, words: &[Word], line: u32) -> Result<(), FileError> {
        let mut block = Block::default();
        for word in words {
            match word.letter {
                'G' => self.code(word.number, &mut block, line)?,
                'M' if word.number == 98.0 => self.leave("M98"),
                letter if OTHER_AXES.contains(&letter) => {
                    self.leave(letter.encode_utf8(&mut [0; 4]));
                }
                _ => {}
            }
        }
        let axes = AXES.map(|axis| value(words, axis));
        let has_axes = axes.iter().any(Option::is_some);
        if block.is_renamed && has_axes {
            self.rename(axes)?;
        }
        if block.is_lost {
            self.end_path()?;
            self.known = [false; 3];
        }
        if block.is_no_move || self.motion == Motion::None {
            return Ok(());
        }
        let is_arc = matches!(self.motion, Motion::Arc { .. });
        let is_full_turn = is_arc && CENTRE.iter().any(|it| value(words, *it).is_some());
        match has_axes || is_full_turn {
            true => self.go(axes, words, line),
            false => Ok(()),
        }
    }

    /// Sets the modes of a code.
    fn code(&mut self, number: f64, block: &mut Block, line: u32) -> Result<(), FileError> {
        match (number * 10.0).round() as i64 {
            0 => self.motion = Motion::Rapid,
            10 => self.motion = Motion::Line,
            20 => self.motion = Motion::Arc { clockwise: true },
            30 => self.motion = Motion::Arc { clockwise: false },
            40 => block.is_no_move = true,
            170 => self.plane = [0, 1, 2],
            180 => self.plane = [2, 0, 1],
            190 => self.plane = [1, 2, 0],
            200 => self.set_units(Units::Inches, line)?,
            210 => self.set_units(Units::Millimetres, line)?,
            // Home, and the coordinates of the machine.
            280 | 300 | 530 => {
                block.is_no_move = true;
                block.is_lost = true;
            }
            // Probing, threads, splines and cycles.
            50 | 51 | 330..=339 | 380..=389 | 730 | 740 | 760 | 810..=890 => {
                self.motion = Motion::None;
                self.leave(&format!("G{number}"));
            }
            800 => self.motion = Motion::None,
            900 => self.is_relative = false,
            910 => self.is_relative = true,
            901 => self.is_centre_absolute = true,
            911 => self.is_centre_absolute = false,
            920 => {
                block.is_no_move = true;
                block.is_renamed = true;
            }
            100 | 520 => {
                block.is_no_move = true;
                self.leave(&format!("G{number}"));
            }
            // Offsets of tools and pieces, speeds, and other words without motion.
            80
            | 150
            | 290
            | 400
            | 430..=439
            | 490
            | 500
            | 540..=599
            | 610..=649
            | 690
            | 930..=999 => {}
            _ => self.leave(&format!("G{number}")),
        }
        Ok(())
    }

    /// Counts a word that is skipped.
    fn leave(&mut self, word: &str) {
        *self.unread.entry(word.to_owned()).or_default() += 1;
    }

    fn set_units(&mut self, units: Units, line: u32) -> Result<(), FileError> {
        if self.moved && self.units.is_some_and(|it| it != units) {
            let detail = "the units change here, between inches (G20) and millimetres (G21): use one of them in a file";
            return Err(FileError::at(line as usize, detail));
        }
        self.units = Some(units);
        Ok(())
    }

    /// Gives the place other coordinates.
    fn rename(&mut self, axes: [Option<f64>; 3]) -> Result<(), FileError> {
        self.end_path()?;
        if self.moved {
            self.leave("G92");
        }
        self.put(axes);
        Ok(())
    }

    fn put(&mut self, axes: [Option<f64>; 3]) {
        let places = self.place.iter_mut().zip(&mut self.known);
        for ((place, known), value) in places.zip(axes) {
            if let Some(value) = value {
                (*place, *known) = (value, true);
            }
        }
    }

    /// Moves the tool.
    fn go(&mut self, axes: [Option<f64>; 3], words: &[Word], line: u32) -> Result<(), FileError> {
        let mut to = self.place;
        for (place, value) in to
            .iter_mut()
            .zip(axes)
            .filter_map(|(place, value)| Some((place, value?)))
        {
            *place = if self.is_relative {
                *place + value
            } else {
                value
            };
        }
        let travels = self.feeds && value(words, 'E').is_none();
        if self.motion == Motion::Rapid || travels {
            self.end_path()?;
        } else {
            // Where the tool is before the first move is not known, but with relative ones it does not matter.
            let is_known = self.is_relative || matches!(self.known, [true, true, _]);
            if self.curve.points.is_empty() && is_known {
                self.curve.push(self.place, line);
            }
            self.cut(to, words, line)?;
            self.curves.check_room(&self.curve)?;
        }
        self.moved = true;
        let known = axes.map(|value| value.is_some());
        self.place = to;
        for (all, known) in self.known.iter_mut().zip(known) {
            *all |= known;
        }
        Ok(())
    }

    /// Continues the path.
    fn cut(&mut self, to: Point, words: &[Word], line: u32) -> Result<(), FileError> {
        let Motion::Arc { clockwise } = self.motion else {
            self.curve.push(to, line);
            return Ok(());
        };
        let wrong = |detail: String| FileError::at(line as usize, detail);
        let centre = self.centre(words);
        let centre = centre.ok_or_else(|| wrong("this arc has no centre".to_owned()))?;
        let points = arc::points(self.place, to, centre, self.plane, clockwise);
        for point in points.map_err(wrong)? {
            self.curve.push(point, line);
        }
        if value(words, 'P').is_some_and(|turns| turns > 1.0) {
            self.leave("turns of arcs (P)");
        }
        if self.curve.notices.is_empty() {
            self.curve.notices.push(SAMPLED.to_owned());
        }
        Ok(())
    }

    /// Where the centre of an arc is.
    fn centre(&self, words: &[Word]) -> Option<Centre> {
        if let Some(radius) = value(words, 'R') {
            return Some(Centre::Radius(radius));
        }
        let offsets = CENTRE.map(|letter| value(words, letter));
        offsets.iter().find(|it| it.is_some())?;
        let mut centre = self.place;
        for (place, offset) in centre.iter_mut().zip(offsets) {
            match (offset, self.is_centre_absolute) {
                (Some(offset), true) => *place = offset,
                (Some(offset), false) => *place += offset,
                (None, _) => {}
            }
        }
        Some(Centre::At(centre))
    }

    /// Ends the path, without the moves straight up or down at its ends.
    ///
    /// # Errors
    ///
    /// If there are more points than the limit.
    pub(super) fn end_path(&mut self) -> Result<(), FileError> {
        let mut curve = std::mem::replace(&mut self.curve, Curve::new(None));
        let count = curve.points.len();
        let same = |[a, b, c]: &Point, [x, y, z]: &Point| a == x && b == y && c != z;
        let first = curve
            .points
            .windows(2)
            .take_while(|it| same(&it[0], &it[1]));
        let first = first.count();
        curve.points.drain(..first);
        curve.lines.drain(..first);
        let last = curve.points.windows(2).rev();
        let last = last.take_while(|it| same(&it[0], &it[1])).count();
        curve.points.truncate(count - first - last);
        curve.lines.truncate(count - first - last);
        self.plunges |= first + last > 0;
        if curve.points.len() > 1 {
            self.curves.push(curve)?;
        }
        Ok(())
    }
}

/// The number of the last word of a letter.
pub(super) fn value(words: &[Word], letter: char) -> Option<f64> {
    let mut words = words.iter().rev();
    words
        .find(|word| word.letter == letter)
        .map(|word| word.number)
}
