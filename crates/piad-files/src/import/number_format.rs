//! Separators of columns and decimals of numbers.

/// The number format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Notation {
    /// The separator of columns; `None` for blanks.
    pub(super) separator: Option<char>,
    /// Decimals may follow a comma: it does not separate columns, and no decimal point was seen.
    comma: bool,
}

impl Notation {
    /// Number formats in order of preference. `1,5 2,5` is only understood with decimal commas, and `1,5` are two
    /// numbers unless there are semicolons. Tabs are blanks.
    const SEPARATORS: [Option<char>; 3] = [Some(';'), Some(','), None];

    /// The separators in lines that have texts or gaps. Blanks occur in texts, so tabs are not blanks here.
    const ROW_SEPARATORS: [Option<char>; 4] = [Some(';'), Some(','), Some('\t'), None];

    /// The number format in which a line consists of numbers, if there is one.
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

    /// The number format in which a line has the most numbers, among texts and gaps; if some give the wanted number of
    /// columns, among those.
    pub(super) fn of_row(line: &str, wanted: Option<usize>) -> Option<Self> {
        let notations = Self::ROW_SEPARATORS.into_iter();
        let notations = notations.filter(|it| it.is_none_or(|it| line.contains(it)));
        let rank = |notation: &Self| {
            let (mut numbers, mut width) = (0, 0);
            for field in notation.fields(line) {
                width += 1;
                numbers += usize::from(notation.number(field).is_some());
            }
            let wide = [width, width + usize::from(notation.ends_empty(line))];
            (wanted.is_some_and(|it| wide.contains(&it)), numbers)
        };
        // Of equals the first, which `max_by_key` would not give.
        notations
            .map(|separator| Self::in_row(line, separator))
            .rev()
            .max_by_key(rank)
    }

    /// The number format of a line with texts, with this separator.
    pub(super) fn in_row(line: &str, separator: Option<char>) -> Self {
        let plain = Self {
            separator,
            comma: false,
        };
        let mut fields = plain.fields(line);
        let has_point = fields.any(|field| field.contains('.') && plain.number(field).is_some());
        Self {
            separator,
            comma: separator != Some(',') && !has_point,
        }
    }

    /// The separator of the names of columns in a line.
    pub(super) fn of_names(line: &str) -> Self {
        let separator = [';', ',', '\t'].into_iter().find(|it| line.contains(*it));
        Self {
            separator,
            comma: false,
        }
    }

    /// Returns true if columns are separated by the same character, and not by blanks.
    pub(super) fn separates_as(self, other: Self) -> bool {
        self.separator.is_some() && self.separator == other.separator
    }

    /// Returns true if this byte is a blank between columns, and no separator.
    pub(super) fn is_blank(self, byte: u8) -> bool {
        byte.is_ascii_whitespace() && self.separator.map(u32::from) != Some(u32::from(byte))
    }

    /// The columns of a line. A separator at its end, as spreadsheets and old programs write it, does
    /// not begin one more.
    pub(super) fn fields(self, line: &str) -> Fields<'_> {
        let whole = self.all_fields(line);
        let rest = whole.rest.and_then(|line| match self.separator {
            Some(separator) => Some(line.strip_suffix(separator).unwrap_or(line)),
            None => (!line.is_empty()).then_some(line),
        });
        Fields { rest, ..whole }
    }

    /// The columns of a line, with the empty one behind a separator at its end.
    pub(super) fn all_fields(self, line: &str) -> Fields<'_> {
        let blank = |c: char| c.is_whitespace() && self.separator != Some(c);
        Fields {
            rest: Some(line.trim_matches(blank)),
            separator: self.separator,
        }
    }

    /// Returns true if a separator ends a line.
    pub(super) fn ends_empty(self, line: &str) -> bool {
        self.separator.is_some_and(|it| {
            let line = line.trim_end_matches(|c: char| c.is_whitespace() && c != it);
            line.ends_with(it)
        })
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

/// The columns of a line, without the blanks and the quotes around them.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a> {
    rest: Option<&'a str>,
    separator: Option<char>,
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let text = self.rest?;
        let end = column_end(text, self.separator);
        let (field, rest) = text.split_at_checked(end).unwrap_or((text, ""));
        self.rest = match self.separator {
            Some(separator) => rest.strip_prefix(separator),
            None => Some(rest.trim_start()).filter(|rest| !rest.is_empty()),
        };
        Some(field.trim().trim_matches('"').trim())
    }
}

/// Where the column ends that a text begins with: at the first separator that is not between quotes.
pub(super) fn column_end(text: &str, separator: Option<char>) -> usize {
    let start = quoted_length(text, separator);
    let rest = text.get(start..).unwrap_or_default();
    let end = match separator {
        Some(separator) => rest.find(separator),
        None => rest.find(char::is_whitespace),
    };
    end.map_or(text.len(), |end| start + end)
}

/// The length of a quoted text at the beginning of a text, and 0 if no quote ends before a separator: then it is an
/// unquoted text that contains a quote. A quote in a quoted text is doubled.
fn quoted_length(text: &str, separator: Option<char>) -> usize {
    let is_blank = |c: char| c.is_whitespace() && separator != Some(c);
    let bare = match separator {
        Some(_) => text.trim_start_matches(is_blank),
        None => text,
    };
    if !bare.starts_with('"') {
        return 0;
    }
    let before = text.len() - bare.len();
    let mut quotes = bare.match_indices('"').map(|(at, _)| at).skip(1).peekable();
    while let Some(quote) = quotes.next() {
        if quotes.next_if_eq(&(quote + 1)).is_some() {
            continue;
        }
        let rest = bare.get(quote + 1..).unwrap_or_default();
        let closes = match separator {
            Some(separator) => {
                let rest = rest.trim_start_matches(is_blank);
                rest.is_empty() || rest.starts_with(separator)
            }
            None => rest.is_empty() || rest.starts_with(char::is_whitespace),
        };
        if closes {
            return before + quote + 1;
        }
    }
    0
}

/// Returns true if a field marks a missing number.
pub(super) fn is_gap(field: &str) -> bool {
    let gaps = ["", "nan", "-nan", "+nan", "null", "na", "n/a"];
    gaps.iter().any(|gap| gap.eq_ignore_ascii_case(field))
}
