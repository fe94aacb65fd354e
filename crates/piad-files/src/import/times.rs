//! Times of points as the parameters of a curve.

use super::error::FileError;
use super::imported::Hints;
use super::part::Part;

/// The parameters of a curve, if they are its times.
///
/// # Errors
///
/// If requested times are missing, or do not increase.
pub(super) fn parameters(part: &mut Part, hints: &Hints) -> Result<Option<Vec<f64>>, FileError> {
    if !hints.times && !part.times_are_parameters {
        return Ok(None);
    }
    let Some(times) = part.times.take() else {
        let detail = "the file has no times, which are requested as parameters";
        return Err(FileError::of_file(detail));
    };
    let back = times.windows(2).position(|pair| match pair {
        [before, after] => after <= before,
        _ => false,
    });
    if let Some(before) = back {
        let detail = "the time of this point is not after that of the point before it, and times are the parameters of the curve";
        let line = part.lines.get(before + 1).map(|line| *line as usize);
        return Err(match line {
            Some(line) => FileError::at(line, detail),
            None => FileError::of_file(format!("point {}: {detail}", before + 1)),
        });
    }
    part.notices.push(format!(
        "The parameters of the curve are its times, {} seconds in all.",
        times.last().unwrap_or(&0.0)
    ));
    Ok(Some(times))
}
