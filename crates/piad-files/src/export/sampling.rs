//! Samples along curves, for all formats that have them.

use super::error::{ExportError, NetIndex};
use super::nurbs::Nurbs;
use super::options::Options;
use piad_fit::engine::nurbs::{Jet, SpanParameter, steps_between};

/// The sites of samples along a curve, from one end to the other: as many as are requested, or as suit it, with at
/// most this number of steps.
pub(super) fn along_curve(
    nurbs: &Nurbs,
    options: &Options,
    most: usize,
) -> Result<Vec<SpanParameter>, ExportError> {
    let samples = options.samples.map(|grid| grid.rows);
    let steps = samples.map_or_else(|| nurbs.u.steps(most), steps_between);
    Ok(nurbs.u.sites(steps))
}

/// The points of samples. Those that are not finite are refused: sums can overflow although the control points do
/// not.
pub(super) fn finite(jets: &[Jet], columns: Option<usize>) -> Result<Vec<[f64; 3]>, ExportError> {
    let points: Vec<[f64; 3]> = jets.iter().map(|jet| jet.point).collect();
    for (index, point) in points.iter().enumerate() {
        let coordinates = point.iter().enumerate();
        if let Some((coordinate, &value)) = coordinates.into_iter().find(|(_, x)| !x.is_finite()) {
            return Err(ExportError::NotFinite {
                what: "sample",
                place: NetIndex::new(index, columns),
                coordinate,
                value,
            });
        }
    }
    Ok(points)
}
