//! The fixed-format lines of IGES: 80 columns, of which the last eight name the section and number
//! its lines (IGES 5.3, section 2.2.4).

use crate::export::text::Text;

/// Lines are numbered with seven digits.
pub(super) const MOST_LINES: usize = 9_999_999;

/// Columns of text in a line.
const WIDTH: usize = 72;

/// Columns of parameter data in a line; behind them it names its directory entry (section 2.2.4.5).
const DATA_WIDTH: usize = 64;

/// Parameters in free format, packed into lines.
#[derive(Debug)]
pub(super) struct ParameterData {
    file: Text,
    line: Text,
    token: Text,
    /// The number of the last line that was written, from 1 in each section.
    lines: usize,
    /// The number of the lines before the first parameter.
    before: usize,
    section: Section,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Global,
    /// With the number of the directory entry.
    Data(usize),
}

impl ParameterData {
    /// Parameters of the global section.
    pub(super) fn global() -> Self {
        Self::new(Section::Global, 0)
    }

    /// The parameters of the entity with this directory entry, after this number of lines of the entities before it.
    pub(super) fn data(entry: usize, before: usize) -> Self {
        Self::new(Section::Data(entry), before)
    }

    fn new(section: Section, before: usize) -> Self {
        Self {
            file: Text::default(),
            line: Text::default(),
            token: Text::default(),
            lines: before,
            before,
            section,
        }
    }

    /// Appends an integer.
    pub(super) fn integer(&mut self, value: usize) {
        self.separate();
        self.token.put(format_args!("{value}"));
    }

    /// Appends a number that is zero or one.
    pub(super) fn flag(&mut self, value: bool) {
        self.integer(usize::from(value));
    }

    /// Appends a real number of double precision (section 2.2.2.2).
    pub(super) fn real(&mut self, value: f64) {
        self.separate();
        self.token.real(value, 'D');
    }

    /// Appends real numbers.
    pub(super) fn reals(&mut self, values: &[f64]) {
        values.iter().for_each(|&value| self.real(value));
    }

    /// Appends a string of ASCII characters; an empty one is a parameter without a value.
    pub(super) fn text(&mut self, value: &str) {
        self.separate();
        self.token.push(&hollerith(value));
    }

    /// The lines, and how many there are.
    pub(super) fn finish(mut self) -> (String, usize) {
        self.end_token(';');
        self.end_line();
        (self.file.into_string(), self.lines - self.before)
    }

    /// Ends the parameter before the one that follows.
    fn separate(&mut self) {
        if !self.is_new() {
            self.end_token(',');
        }
    }

    fn is_new(&self) -> bool {
        self.lines == self.before && self.line.as_str().is_empty() && self.token.as_str().is_empty()
    }

    /// Numbers stay on one line, with their delimiter; strings that are too long for a line are
    /// broken anywhere (section 2.2.3).
    fn end_token(&mut self, delimiter: char) {
        self.token.put(format_args!("{delimiter}"));
        let width = match self.section {
            Section::Global => WIDTH,
            Section::Data(_) => DATA_WIDTH,
        };
        if self.line.as_str().len() + self.token.as_str().len() > width {
            self.end_line();
        }
        let mut rest = self.token.as_str();
        while rest.len() > width {
            let (head, tail) = rest.split_at(width);
            self.line.push(head);
            self.lines += 1;
            write_line(&mut self.file, &mut self.line, self.section, self.lines);
            rest = tail;
        }
        self.line.push(rest);
        self.token.clear();
    }

    fn end_line(&mut self) {
        if !self.line.as_str().is_empty() {
            self.lines += 1;
            write_line(&mut self.file, &mut self.line, self.section, self.lines);
        }
    }
}

fn write_line(file: &mut Text, line: &mut Text, section: Section, number: usize) {
    let content = line.as_str();
    match section {
        Section::Global => file.put(format_args!("{content:WIDTH$}G{number:7}\n")),
        Section::Data(entry) => {
            file.put(format_args!("{content:DATA_WIDTH$}{entry:8}P{number:7}\n"));
        }
    }
    line.clear();
}

/// A string constant: its length, `H`, its characters (section 2.2.2.3).
fn hollerith(value: &str) -> String {
    match value.len() {
        0 => String::new(),
        length => format!("{length}H{value}"),
    }
}

/// Writes ASCII text in lines of a section, and returns their number.
pub(super) fn fixed_lines(file: &mut Text, section: char, content: &str) -> usize {
    let mut rest = content;
    let mut lines = 0;
    loop {
        let (head, tail) = rest.split_at(rest.len().min(WIDTH));
        lines += 1;
        file.put(format_args!("{head:WIDTH$}{section}{lines:7}\n"));
        rest = tail;
        if rest.is_empty() {
            return lines;
        }
    }
}

/// The use of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    /// Geometry by itself.
    Independent,
    /// A part of another entity.
    Dependent,
    /// A part of another entity in parameters of a surface.
    InParameters,
}

/// The directory entry of an entity.
#[derive(Clone, Debug)]
pub(super) struct DirectoryEntry {
    /// Its number, that of its first line: entries have two.
    pub(super) number: usize,
    /// The type of the entity.
    pub(super) entity: usize,
    /// The number of its first line of parameter data.
    pub(super) first_line: usize,
    /// The number of these lines.
    pub(super) lines: usize,
    /// Its use.
    pub(super) status: Status,
    /// Up to eight characters.
    pub(super) label: String,
    /// A number behind the label.
    pub(super) subscript: usize,
}

impl DirectoryEntry {
    /// Writes twenty fields of eight columns in two lines (section 2.2.4.4). The entity is visible, drawn with solid lines, on level 0.
    pub(super) fn write(&self, file: &mut Text) {
        let Self {
            entity,
            first_line,
            lines,
            label,
            subscript,
            ..
        } = self;
        let none = 0;
        let (first, second) = (self.number, self.number + 1);
        // Type, first line of data, structure, line font, level, view, transformation, label display.
        file.put(format_args!(
            "{entity:8}{first_line:8}{none:8}{font:8}{none:8}{none:8}{none:8}{none:8}{status}D{first:7}\n",
            font = 1,
            status = match self.status {
                Status::Independent => "00000000",
                Status::Dependent => "00010000",
                Status::InParameters => "00010500",
            },
        ));
        // Type, line weight, colour, lines of data, form, two reserved fields, label, subscript.
        file.put(format_args!(
            "{entity:8}{none:8}{none:8}{lines:8}{none:8}{empty:8}{empty:8}{label:>8}{subscript:8}D{second:7}\n",
            empty = "",
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_lines_have_80_columns() {
        let mut data = ParameterData::data(1, 0);
        data.integer(126);
        for i in 0..100 {
            data.real(f64::from(i) / 7.0);
        }
        let (text, count) = data.finish();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), count);
        for (i, line) in lines.iter().enumerate() {
            assert_eq!(line.len(), 80);
            assert_eq!(&line[64..72], "       1");
            assert_eq!(line[72..], format!("P{:7}", i + 1));
            let content = line[..64].trim_end();
            let end = if i + 1 == count { ';' } else { ',' };
            assert!(content.ends_with(end), "{line}");
        }
        assert!(lines[0].starts_with("126,0.0,0.14285714285714285,"));
    }

    #[test]
    fn long_strings_are_broken_and_numbers_are_not() {
        let mut global = ParameterData::global();
        global.text(",");
        global.text(";");
        global.text(&"x".repeat(200));
        global.text("");
        global.real(1e-7);
        let (text, count) = global.finish();
        let joined: String = text.lines().map(|line| &line[..72]).collect();
        assert_eq!(joined.trim_end().replace(' ', ""), {
            let name = "x".repeat(200);
            format!("1H,,1H;,200H{name},,1.D-7;")
        });
        assert_eq!(text.lines().count(), count);
        assert!(text.lines().all(|line| line.len() == 80));
    }

    #[test]
    fn directory_entries_have_fields_of_eight_columns() {
        let mut file = Text::default();
        let entry = DirectoryEntry {
            number: 1,
            entity: 128,
            first_line: 1,
            lines: 1234,
            status: Status::Independent,
            label: "SURFACE".to_owned(),
            subscript: 0,
        };
        entry.write(&mut file);
        let lines: Vec<&str> = file.as_str().lines().collect();
        assert!(lines.iter().all(|line| line.len() == 80));
        let field = |line: usize, i: usize| lines[line][8 * i..8 * i + 8].trim();
        assert_eq!(
            [field(0, 0), field(0, 1), field(0, 8)],
            ["128", "1", "00000000"]
        );
        assert_eq!(
            [field(1, 0), field(1, 3), field(1, 7)],
            ["128", "1234", "SURFACE"]
        );
        assert_eq!([field(0, 9), field(1, 9)], ["D      1", "D      2"]);
    }

    #[test]
    fn strings_say_how_long_they_are() {
        assert_eq!(hollerith("a,b;c"), "5Ha,b;c");
        assert_eq!(hollerith(""), "");
    }

    #[test]
    fn text_fills_72_columns() {
        let mut file = Text::default();
        assert_eq!(fixed_lines(&mut file, 'S', &"y".repeat(73)), 2);
        assert_eq!(fixed_lines(&mut file, 'T', ""), 1);
        assert!(file.as_str().lines().all(|line| line.len() == 80));
    }
}
