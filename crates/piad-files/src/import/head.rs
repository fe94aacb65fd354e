//! The first row of a table, and the choice of its columns.

use super::choice::{self, Choice, Named};
use super::columns::MOST_COLUMNS;
use super::columns::Names;
use super::error::FileError;
use super::imported::Hints;
use super::names::Meaning;
use super::number_format::Notation;
use super::sample::{Below, Sample, has_width};

/// The most coordinates of points without names.
const MOST_COORDINATES: usize = 3;

/// The first row of a table, and its context.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head<'a> {
    /// The number of its line.
    pub(super) number: usize,
    pub(super) line: &'a str,
    pub(super) below: Below<'a>,
    /// The line of words above, and its number.
    pub(super) words: Option<(usize, &'a str)>,
}

impl Head<'_> {
    /// The number of columns that the line above names.
    pub(super) fn wanted(&self) -> Option<usize> {
        let (_, words) = self.words?;
        Some(Notation::of_names(words).fields(words).count())
    }

    /// Returns true if the words above are separated as the numbers are, and not by blanks.
    fn is_separated(&self, notation: Notation) -> bool {
        let words = self.words.map(|(_, words)| Notation::of_names(words));
        words.is_some_and(|words| words.separates_as(notation))
    }

    /// The separator of the columns: as in a line of numbers, or else the one that gives the most numbers.
    pub(super) fn notation(&self, plain: Option<Notation>) -> Option<Notation> {
        let wanted = self.wanted();
        let Some(plain) = plain else {
            return Notation::of_row(self.line, wanted);
        };
        if plain.separator.is_some() || !self.line.contains('\t') {
            return Some(plain);
        }
        // Several blanks count as one, which loses the gaps between tabs.
        let tabs = Notation::in_row(self.line, Some('\t'));
        let width = plain.fields(self.line).count();
        let named = self.is_separated(tabs)
            && wanted.is_some_and(|wanted| has_width(tabs, self.line, wanted));
        match named || self.below.needs_tabs(width) {
            true => Some(tabs),
            false => Some(plain),
        }
    }

    /// The names of columns in the line above, if it can be a line of names: the same number, and no numbers.
    pub(super) fn names(&self, notation: Notation, width: usize) -> Option<Names> {
        let (line, words) = self.words?;
        let of_names = Notation::of_names(words);
        let fields = |all: bool| -> Vec<String> {
            let fields = match all {
                true => of_names.all_fields(words),
                false => of_names.fields(words),
            };
            fields.take(MOST_COLUMNS + 1).map(str::to_owned).collect()
        };
        let mut both = [false, true].into_iter().map(fields);
        let names = both.find(|names| names.len() == width)?;
        let is_number = |name: &String| notation.number(name).is_some();
        (!names.iter().any(is_number)).then_some(Names { line, names })
    }

    /// The columns to read: those of the hints, or else those that the file shows. `None` if the line is not a row.
    ///
    /// # Errors
    ///
    /// If the file does not have the columns of the hints.
    pub(super) fn chosen(
        &self,
        names: Option<&Names>,
        sample: &Sample<'_>,
        hints: &Hints,
        is_plain: bool,
    ) -> Result<Option<Chosen>, FileError> {
        let Some(columns) = &hints.columns else {
            let names = names.map(|it| &it.names[..]);
            return Ok(Chosen::by_itself(self, names, sample, hints, is_plain));
        };
        match columns.resolved(names, sample, self.number) {
            Ok(choice) => Ok(Some(Chosen {
                named: columns.has_names() || self.is_separated(sample.notation),
                sure: true,
                choice,
            })),
            // A line of words above the rows has other columns, or none.
            Err(_) if !is_plain && !sample.is_table() => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// Columns, and how they were found.
pub(super) struct Chosen {
    pub(super) choice: Choice,
    /// True if the line above has their names.
    pub(super) named: bool,
    /// True if a user or their names determine their kind.
    pub(super) sure: bool,
}

impl Chosen {
    /// The columns that a file shows by itself; `None` if its first line has texts, and is not a row with two numbers.
    fn by_itself(
        head: &Head<'_>,
        names: Option<&[String]>,
        sample: &Sample<'_>,
        hints: &Hints,
        is_plain: bool,
    ) -> Option<Self> {
        let meant = names.map(|names| Named::new(names, sample));
        if let Some(choice) = meant.and_then(Named::choice) {
            return Some(Self {
                choice,
                named: true,
                sure: true,
            });
        }
        // Names without a known meaning, such as a and b, are names only if they are separated as the numbers are.
        // Otherwise they are words, such as those of an airfoil.
        let has_x = meant.is_some_and(|it| it.has(Meaning::X));
        let separated = names.is_some_and(|names| names.len() > 1);
        let named = has_x || (separated && head.is_separated(sample.notation));
        let choice = choice::as_they_stand(names.filter(|_| named), sample, hints);
        let all = || Choice::of_coordinates((0..sample.width.min(MOST_COORDINATES)).collect());
        let choice = match choice {
            None if is_plain => all(),
            choice => choice?,
        };
        Some(Self {
            choice,
            named,
            sure: false,
        })
    }
}
