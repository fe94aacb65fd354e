//! Times as ISO 8601 writes them.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// The expected form of a field of times.
pub(super) const EXPECTED: &str = "a number, or ISO 8601 such as 2026-01-31T12:00:00Z";

/// The time of a field such as `2026-01-31T12:00:00.25+01:00`, a date alone too. Without a zone it is UTC: only
/// differences are used.
pub(super) fn timestamp(field: &str) -> Option<Timestamp> {
    // Most other fields are rejected at once.
    let is_begun = field.len() >= 8 && field.starts_with(|c: char| c.is_ascii_digit());
    if !is_begun || !field.contains('-') {
        return None;
    }
    let with_zone = field.parse().ok();
    with_zone.or_else(|| {
        let civil: DateTime = field.parse().ok()?;
        let zoned = civil.to_zoned(TimeZone::UTC).ok()?;
        Some(zoned.timestamp())
    })
}

/// Seconds from one time to another.
pub(super) fn seconds(from: Timestamp, to: Timestamp) -> f64 {
    to.duration_since(from).as_secs_f64()
}
