//! Groups: a code that gives the meaning of a value, and the value, each on a line.

use std::fmt::Arguments;

use crate::export::text::Text;

/// Appends a group.
pub(super) fn pair(text: &mut Text, code: u32, value: Arguments<'_>) {
    text.put(format_args!("{code:3}\n"));
    text.put(value);
    text.push("\n");
}

/// Appends a group with a real number.
pub(super) fn real(text: &mut Text, code: u32, value: f64) {
    text.put(format_args!("{code:3}\n"));
    text.real(value, 'E');
    text.push("\n");
}

/// Appends the coordinates of a point.
pub(super) fn place(text: &mut Text, point: [f64; 3]) {
    for (code, x) in [10, 20, 30].into_iter().zip(point) {
        real(text, code, x);
    }
}

/// Starts a section.
pub(super) fn section(text: &mut Text, name: &str) {
    pair(text, 0, format_args!("SECTION"));
    pair(text, 2, format_args!("{name}"));
}

/// Ends a section.
pub(super) fn end_section(text: &mut Text) {
    pair(text, 0, format_args!("ENDSEC"));
}
