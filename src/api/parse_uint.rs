//! Parsing of whole numbers in paths, queries and headers.

/// The largest whole number in a path or a query: up to it, floating-point numbers are exact.
pub(super) const LARGEST: u64 = (1 << 53) - 1;

/// A whole number in decimal digits, without signs or leading zeros.
pub(super) fn plain_number(text: &str) -> Option<usize> {
    let number: usize = text.parse().ok()?;
    let small = number < usize::MAX / 4 && number as u64 <= LARGEST;
    (small && number.to_string() == text).then_some(number)
}
