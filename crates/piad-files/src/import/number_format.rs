//! What separates the columns of a file, and the decimals of its numbers.

/// How numbers are written in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Notation {
    /// What separates columns; blanks if there is nothing.
    pub(super) separator: Option<char>,
    /// Decimals may follow a comma: it separates no columns, and no point was seen.
    comma: bool,
}

impl Notation {
    /// What separates columns; the first that fits is taken. `1,5 2,5` is only understood with decimal
    /// commas, and `1,5` are two numbers unless there are semicolons. Tabs are blanks.
    const SEPARATORS: [Option<char>; 3] = [Some(';'), Some(','), None];

    /// The notation in which a line consists of numbers, if there is one.
    pub(super) fn of(line: &str) -> Option<Self> {
        let mut notations = Self::SEPARATORS.into_iter().map(|separator| Self {
            separator,
            comma: separator != Some(',') && !line.contains('.'),
        });
        let fits = |notation: &Self| {
            notation.separator.is_none_or(|it| line.contains(it))
                && notation
                    .fields(line)
                    .all(|field| notation.number(field).is_some())
        };
        notations.find(fits)
    }

    /// How names of columns are separated in a line.
    pub(super) fn of_names(line: &str) -> Self {
        let separator = [';', ',', '\t'].into_iter().find(|it| line.contains(*it));
        Self {
            separator,
            comma: false,
        }
    }

    /// How fields are written in a line that has texts among its numbers.
    pub(super) fn of_fields(line: &str) -> Self {
        let separator = Self::of_names(line).separator.filter(|it| *it != '\t');
        Self {
            separator,
            comma: separator != Some(',') && !line.contains('.'),
        }
    }

    /// Whether columns are separated by the same character, and not by blanks.
    pub(super) fn separates_as(self, other: Self) -> bool {
        self.separator.is_some() && self.separator == other.separator
    }

    /// The columns of a line. A separator at its end, as spreadsheets and old programs write it, does
    /// not begin one more.
    pub(super) fn fields<'a>(self, line: &'a str) -> Box<dyn Iterator<Item = &'a str> + 'a> {
        let bare = |field: &'a str| field.trim().trim_matches('"').trim();
        match self.separator {
            None => Box::new(line.split_whitespace().map(bare)),
            Some(separator) => {
                let line = line.trim().strip_suffix(separator).unwrap_or(line);
                Box::new(line.split(separator).map(bare))
            }
        }
    }

    /// The number of a field; also with the exponents of Fortran (`1.5D+00`).
    pub(super) fn number(self, field: &str) -> Option<f64> {
        let begins = |c: char| c.is_ascii_digit() || "+-.,".contains(c);
        if !field.starts_with(begins) {
            return None;
        }
        let plain = field.parse().ok();
        let number: f64 = plain.or_else(|| {
            let with_e = field.replace(['d', 'D'], "e");
            let text = match self.comma && !with_e.contains('.') {
                true => with_e.replacen(',', ".", 1),
                false => with_e,
            };
            text.parse().ok()
        })?;
        number.is_finite().then_some(number)
    }
}
