//! Tracks of GPX and KML: points in degrees, with elevations and times where there are some.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

use super::curves::{Curve, Curves};
use super::degrees;
use super::error::FileErrors;
use super::imported::Hints;
use super::part::Parts;

/// The parts of a file with these tracks, in metres. Single points are a part if there is nothing
/// else.
pub(super) fn finish(
    mut curves: Curves,
    single: Curve,
    called: &str,
    hints: &Hints,
) -> Result<Parts, FileErrors> {
    let mut notices = Vec::new();
    let singles = single.points.len();
    if curves.count() == 0 {
        curves.push(single)?;
    } else if singles > 0 {
        notices.push(format!("{singles} {called} are not read."));
    }
    let heights = curves.points().filter(|[_, _, z]| z.is_finite()).count();
    let count = curves.count();
    if heights > 0 && heights < count {
        notices.push(format!(
            "{} of {count} points have no elevation, which is left out.",
            count - heights
        ));
    }
    notices.splice(0..0, degrees::to_metres(&mut curves));
    let dimension = if heights == count { 3 } else { 2 };
    let mut parts = curves.finish(dimension, notices)?;
    if parts.parts.iter().any(|part| part.times.is_some()) && !hints.times {
        let notice = "The points have times, which are not used; curve.parameters=time uses them.";
        parts.notices.push(notice.to_owned());
    }
    Ok(parts)
}

/// A time in ISO 8601. One without an offset from UTC, which GPX does not allow, is taken as UTC.
pub(super) fn timestamp(text: &str) -> Option<Timestamp> {
    let with_offset = text.parse().ok();
    with_offset.or_else(|| {
        let local: DateTime = text.parse().ok()?;
        TimeZone::UTC.to_timestamp(local).ok()
    })
}
