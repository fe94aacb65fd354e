//! Robust fits: outliers are left out, and the other points are fitted alone.

use std::sync::Arc;

use super::admission::Admission;
use super::request::{Request, Tolerance, Weights};
use crate::basis::choice::{Corners, DirectionChoice};
use crate::basis::direction::Direction;
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::outliers::{Along, Cloud, FEWEST_POINTS, find, isolated};
use crate::data::points::{Points, ROUNDING};
use crate::invalid::{Axis, Invalid, Place, Setting};
use crate::method::{At, Constraint, LeastSquares, Method};
use crate::parameters::scattered::nearest_to_their_plane;
use crate::parameters::{Parametrization, Scattered, parameters};

/// The cost, in multiplications, of comparing a point with its neighbours in all rounds.
const MULTIPLICATIONS: usize = 10_000;

/// Bytes that a point takes meanwhile, with its neighbours.
const BYTES: usize = 256;

/// The points of a fit that are neither outliers nor missing.
#[derive(Clone, Debug)]
pub(crate) struct Inliers {
    /// Their indices, which increase.
    pub indices: Vec<usize>,
    /// The others.
    pub outliers: Arc<[usize]>,
    pub points: Arc<Points>,
}

impl Inliers {
    /// Those of a request; `None` if it is not for a robust fit, or has no outliers.
    ///
    /// # Errors
    ///
    /// Settings that a robust fit cannot be combined with, or too many outliers.
    pub(super) fn of(request: &Request, admission: &Admission) -> Result<Option<Self>, Invalid> {
        let Method::LeastSquares(settings) = &request.method else {
            return Ok(None);
        };
        if !settings.robust {
            return Ok(None);
        }
        check(request, settings)?;
        let count = request.points.len();
        let [bytes, multiplications] = [BYTES, MULTIPLICATIONS].map(|it| count.saturating_mul(it));
        admission.check(bytes, 0, multiplications)?;
        let known = request
            .outliers
            .as_ref()
            .filter(|it| it.iter().all(|&it| it < count));
        let outliers = match known {
            Some(known) => known.to_vec(),
            None => outliers(request, settings)?,
        };
        if 2 * outliers.len() > count {
            let detail = format!(
                "{} of {count} points lie far from where their neighbours predict them: a fit without more than half of its points is refused",
                outliers.len()
            );
            return Err(Invalid::at(Place::Points, detail));
        }
        Ok(Missing::new(&outliers, count).map(|it| Self::without(&it, &request.points)))
    }

    /// All points but some.
    pub(super) fn without(missing: &Missing, points: &Points) -> Self {
        let (outliers, indices): (Vec<usize>, Vec<usize>) =
            (0..points.len()).partition(|&index| missing.contains(index));
        Self {
            points: Arc::new(points.selected(indices.iter().copied())),
            outliers: outliers.into(),
            indices,
        }
    }

    /// The outliers as missing points.
    pub(super) fn missing(&self) -> Option<Missing> {
        Missing::new(&self.outliers, self.indices.len() + self.outliers.len())
    }

    /// The index of a point among those that are left; of an outlier that of the next one.
    fn place(&self, index: usize) -> usize {
        self.indices.partition_point(|&it| it < index)
    }

    /// The same fit of these points alone.
    pub(super) fn alone(&self, request: &Request) -> Request {
        let of_points =
            |values: &[f64]| self.indices.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let mut u = request.u.clone();
        if let Parametrization::Explicit(values) = &request.u.parameters {
            let end = request.u.closed.then(|| values[values.len() - 1]);
            let values = of_points(values).into_iter().chain(end).collect();
            u.parameters = Parametrization::Explicit(Arc::new(values));
        }
        if let Some(Corners::At(corners)) = &request.u.corners {
            u.corners = Some(Corners::At(
                corners.iter().map(|&it| self.place(it)).collect(),
            ));
        }
        let mut method = request.method.clone();
        if let Method::LeastSquares(settings) = &mut method {
            settings.robust = false;
            settings.data_weights = settings
                .data_weights
                .as_deref()
                .map(|it| of_points(it).into());
            let moved = |constraint: &Constraint| Constraint {
                at: match constraint.at {
                    At::Index(index) => At::Index(self.place(index)),
                    at => at,
                },
                wanted: constraint.wanted.clone(),
            };
            settings.constraints = settings.constraints.iter().map(moved).collect();
        }
        Request {
            points: Arc::clone(&self.points),
            grid: Grid {
                rows: self.indices.len(),
                columns: 1,
            },
            scattered: request.scattered.as_ref().map(|scattered| match scattered {
                Scattered::Given(pairs) => Scattered::Given(pairs.of(self.indices.iter().copied())),
                Scattered::Sections(sections) => Scattered::Sections(sections.of(&self.indices)),
                rule => rule.clone(),
            }),
            u,
            method,
            ..request.clone()
        }
    }

    /// A direction of these points as one of all: outliers have parameters at equal steps between those of their
    /// neighbours, or beside an end that of the end. The parameters of scattered ones do not matter.
    pub(crate) fn with_outliers(&self, direction: &Direction, is_scattered: bool) -> Direction {
        let t = &direction.parameters;
        let count = self.indices.len() + self.outliers.len();
        let parameter = |index: usize| {
            let after = self.place(index);
            let (before, end, place) = match (after.checked_sub(1), self.indices.get(after)) {
                (_, Some(&place)) if place == index || after == 0 || is_scattered => {
                    return t[after];
                }
                (Some(before), Some(&place)) => (before, t[after], place),
                (before, None) => match (before, direction.period()) {
                    (Some(before), Some(period)) => {
                        (before, t[0] + period, self.indices[0] + count)
                    }
                    _ => return t[after - 1],
                },
                (None, _) => return t[0],
            };
            let from = self.indices[before];
            let part = (index - from) as f64 / (place - from) as f64;
            (1.0 - part) * t[before] + part * end
        };
        direction.with_parameters((0..count).map(parameter).collect())
    }
}

fn wrong(detail: impl Into<String>) -> Invalid {
    Invalid::at(Place::Setting(Setting::Robust), detail.into())
}

/// Refuses settings that a robust fit cannot be combined with.
fn check(request: &Request, settings: &LeastSquares) -> Result<(), Invalid> {
    let is_weighted = |choice: &DirectionChoice| choice.weights.is_some();
    let count = request.points.len();
    let found = match &request.scattered {
        _ if request.weights != Weights::None || is_weighted(&request.u) => {
            "a rational fit is not robust: leave weights out"
        }
        _ if request.polyline => {
            "the edges of a polyline are data, so that none of its points is left out"
        }
        None if request.v.is_some() => {
            "outliers are found among the points of curves and among scattered ones: pass those of the grid as scattered points"
        }
        _ if count < FEWEST_POINTS => {
            return Err(wrong(format!(
                "{count} points do not show which of them are wrong: give {FEWEST_POINTS} at least"
            )));
        }
        _ => return settings.check_weights(count),
    };
    Err(wrong(found))
}

/// The indices of the outliers. Points at given corners and constraints are none.
fn outliers(request: &Request, settings: &LeastSquares) -> Result<Vec<usize>, Invalid> {
    let points = &*request.points;
    let rounding = points.magnitude() * ROUNDING;
    let least = match request.tolerance {
        Some(Tolerance::Absolute(tolerance)) if tolerance.is_finite() => tolerance.max(rounding),
        _ => rounding,
    };
    let corners = request.u.corners.as_ref().map_or(&[][..], Corners::indices);
    let is_kept = |index: usize| {
        let is_at = |it: &Constraint| it.at == At::Index(index);
        corners.contains(&index) || settings.constraints.iter().any(is_at)
    };
    if let Some(rule) = &request.scattered {
        let is_isolated = isolated(points);
        let rule = match rule {
            Scattered::Auto => {
                let others = (0..points.len()).filter(|&i| !is_isolated[i]);
                rule.chosen(&points.selected(others))?
            }
            rule => rule.chosen(points)?,
        };
        let some: Vec<usize> = match rule {
            Scattered::Plane => nearest_to_their_plane(points)?,
            _ => (0..points.len()).collect(),
        };
        let pairs = rule.parameters_by(points, &some, [false; 2])?;
        let parameters = [0, 1].map(|axis| pairs.direction(axis).0);
        let cloud = Cloud::new(points, &parameters, &is_isolated);
        return Ok(find(&cloud, least, is_kept));
    }
    let choice = request.u.parameters.clone();
    let is_given = matches!(choice, Parametrization::Explicit(_));
    let given = is_given.then(|| {
        parameters(
            choice,
            points,
            request.grid,
            None,
            Axis::U,
            request.u.closed,
        )
    });
    let given = given.transpose()?.map(|it| {
        let end = it.values[0] + it.period;
        it.values
            .iter()
            .copied()
            .chain(request.u.closed.then_some(end))
            .collect::<Vec<_>>()
    });
    let along = Along {
        points,
        parameters: given.as_deref(),
        closed: request.u.closed,
    };
    Ok(find(&along, least, is_kept))
}

#[cfg(test)]
mod tests;
