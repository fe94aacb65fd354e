//! Distances of the drawing from the data: at them, and between them.

use crate::export::deviation::Deviations;
use crate::export::fitted::Fitted;
use crate::export::nurbs::Nurbs;
use piad_fit::engine::between::excesses;

/// Distances from the data, and the largest of them.
pub(super) struct Measured {
    pub(super) deviations: Deviations,
    /// The deviation in each gap between neighbouring data; `None` for scattered data.
    pub(super) between: Vec<f64>,
    pub(super) most: f64,
}

impl Measured {
    /// `None` where all distances are zero, or one is infinite.
    pub(super) fn of(fitted: &Fitted<'_>, nurbs: &Nurbs) -> Option<Self> {
        let deviations = Deviations::of(fitted.problem, nurbs);
        let between = excesses(fitted.problem, fitted.control_points);
        let most = between.iter().copied().fold(deviations.most(), f64::max);
        (most > 0.0 && most.is_finite()).then_some(Self {
            deviations,
            between,
            most,
        })
    }
}
