//! The entities of a file, one after the other.

use super::sections::{DirectoryEntry, ParameterData, Status};
use crate::export::text::Text;

/// The entities of a file: their directory and their parameters.
#[derive(Default)]
pub(super) struct Entities {
    /// Two lines for each.
    pub(super) directory: Text,
    /// Their parameters.
    pub(super) data: Text,
    /// The number of lines of the parameters.
    pub(super) lines: usize,
}

impl Entities {
    /// The number of lines of the directory, of 80 columns each.
    pub(super) fn directory_lines(&self) -> usize {
        self.directory.as_str().len() / 81
    }

    /// Adds an entity with these parameters behind its type, and returns the number of its directory entry.
    pub(super) fn add(
        &mut self,
        entity: usize,
        status: Status,
        label: &Label,
        write: impl FnOnce(&mut ParameterData),
    ) -> usize {
        let number = self.directory_lines() + 1;
        let mut data = ParameterData::data(number, self.lines);
        data.integer(entity);
        write(&mut data);
        let (text, lines) = data.finish();
        let entry = DirectoryEntry {
            number,
            entity,
            first_line: self.lines + 1,
            lines,
            status,
            label: label.text.clone(),
            subscript: label.subscript,
        };
        entry.write(&mut self.directory);
        self.lines += lines;
        self.data.push(&text);
        number
    }
}

/// Parts are labelled with the first characters of their names, and numbered.
pub(super) struct Label {
    /// Up to eight characters.
    pub(super) text: String,
    /// A number behind them.
    pub(super) subscript: usize,
}
