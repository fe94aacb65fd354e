//! Curves as lines of a map: samples in degrees, or unchanged.

use super::error::ExportError;
use super::format::Format;
use super::nurbs::Nurbs;
use super::options::{Options, plane};
use super::sampling::{along_curve, finite};
use crate::wgs84::Plane;

/// The most steps along a curve, unless more are requested.
const MOST_ALONG_CURVE: usize = 1 << 12;

/// The points of a line, the last one of a closed curve equal to the first. The third coordinate is unchanged.
pub(super) fn line(
    nurbs: &Nurbs,
    options: &Options,
    format: Format,
) -> Result<Vec<[f64; 3]>, ExportError> {
    let sites = along_curve(nurbs, options, MOST_ALONG_CURVE)?;
    let mut points = finite(&nurbs.evaluate(&sites, &[]), None)?;
    if let Some(origin) = options.origin {
        in_degrees(&mut points, plane(origin)?, format)?;
    }
    if nurbs.u.closed
        && let Some(&first) = points.first()
        && let Some(last) = points.last_mut()
    {
        *last = first;
    }
    Ok(points)
}

fn in_degrees(points: &mut [[f64; 3]], plane: Plane, format: Format) -> Result<(), ExportError> {
    for point in points {
        let [east, north, _] = *point;
        let Some([longitude, latitude]) = plane.degrees([east, north]) else {
            return Err(ExportError::OffTheEarth {
                format,
                east,
                north,
            });
        };
        [point[0], point[1]] = [longitude, latitude];
    }
    Ok(())
}

/// A number of degrees or metres with the digits that matter and no exponent: nine decimals of a degree are a tenth of a
/// millimetre.
pub(super) fn decimal(value: f64) -> String {
    let text = format!("{value:.9}");
    let digits = text.trim_end_matches('0').trim_end_matches('.');
    match digits {
        "-0" => "0".to_owned(),
        _ => digits.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::decimal;

    #[test]
    fn numbers_have_no_digits_without_meaning() {
        assert_eq!(decimal(-7.850000000012), "-7.85");
        assert_eq!(decimal(180.0), "180");
        assert_eq!(decimal(-1e-12), "0");
        assert_eq!(decimal(0.123456789012), "0.123456789");
    }
}
