//! A fitting problem: from what was asked for to what can be iterated.

use std::sync::Arc;

use super::collocation::Collocation;
use super::direction::{Direction, DirectionChoice};
use super::extent::Extent;
use super::invalid::{Axis, Invalid};
use super::method::{LeastSquares, Method, Variant};
use super::missing::Missing;
use super::parameters::Parametrization;
use super::points::{self, Grid, Points};
use super::spectrum;
use super::weights;

/// Rounding errors of coordinates, relative to the largest.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The least eigenvalue takes some eliminations, and the method one more.
const ELIMINATIONS: usize = 8;

/// When to stop, as asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// In data units.
    Absolute(f64),
    /// In units of the diagonal of the data's bounding box.
    Relative(f64),
}

/// The weights of a rational fit, as asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Weights {
    /// None: the curve is polynomial in each span.
    None,
    /// One for each data point: the fit is made in homogeneous coordinates (Lin10, section 2.1).
    Homogeneous(Vec<f64>),
    /// Fixed weights of the directions are in their [`DirectionChoice`]s; these are a grid of
    /// fixed weights of a surface, to be separated.
    FixedGrid(Vec<f64>),
}

/// A fitting problem as asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The data points; of a surface row by row.
    pub points: Arc<Points>,
    /// Their arrangement.
    pub grid: Grid,
    /// Indices of points that are not known, for least-squares fits; their coordinates are not
    /// looked at.
    pub missing: Vec<usize>,
    /// The direction of a curve, or u of a surface.
    pub u: DirectionChoice,
    /// The second direction of a surface.
    pub v: Option<DirectionChoice>,
    /// Weights that are not of a single direction.
    pub weights: Weights,
    /// The method.
    pub method: Method,
    /// Local fits: the indices of the control points that move; all of them if there are none.
    pub selected: Option<Vec<usize>>,
    /// The free control points of level 0, in homogeneous coordinates if the fit is; without them
    /// the method says where to start.
    pub start: Option<Arc<Points>>,
    /// The least eigenvalue of the collocation matrix, if it is known from a fit with the same one:
    /// of many points it takes longer to compute than a local fit.
    pub lambda_min: Option<f64>,
    /// The largest allowed distance of the curve from a data point.
    pub tolerance: Tolerance,
    /// The last level that is computed.
    pub max_iterations: usize,
}

/// A validated fitting problem. It can be iterated, and every error left is one of arithmetic.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What was asked for; missing points have got a place.
    request: Request,
    /// The data in homogeneous coordinates.
    lifted: Option<Arc<Points>>,
    /// Of the coordinates of the data.
    extents: Vec<Extent>,
    missing: Option<Missing>,
    u: Direction,
    v: Option<Direction>,
    tolerance: f64,
    diagonal: f64,
}

impl Problem {
    /// Validates a request, computes parameters and knots and resolves the tolerance.
    pub fn new(mut request: Request) -> Result<Self, Invalid> {
        let grid = request.grid;
        if grid.rows < 2 || (request.v.is_some() && grid.columns < 2) {
            let count = if grid.rows < 2 {
                grid.rows
            } else {
                grid.columns
            };
            return Err(Invalid::TooFewPoints { count });
        }
        let missing = Missing::new(&request.missing, grid.count());
        if let Some(missing) = &missing {
            check_missing(&request)?;
            missing.fill(Arc::make_mut(&mut request.points), grid);
        }
        let extents = request.points.extents();
        check_finite(&request.points, &extents)?;
        let diagonal = points::diagonal(&extents);
        if !diagonal.is_finite() {
            return Err(Invalid::TooLarge);
        }
        let tolerance =
            resolve_tolerance(request.tolerance, points::magnitude(&extents), diagonal)?;
        check_method(&request)?;
        let (u, v) = directions(&request, missing.as_ref())?;
        let lifted = match &request.weights {
            Weights::Homogeneous(values) => Some(Arc::new(weights::lift(&request.points, values)?)),
            _ => None,
        };
        let extents = lifted.as_ref().map_or(extents, |it| it.extents());
        let problem = Self {
            request,
            lifted,
            extents,
            missing,
            u,
            v,
            tolerance,
            diagonal,
        };
        problem.check_start()?;
        spectrum::check_convergence(&problem)?;
        Ok(problem)
    }

    /// What was asked for. Missing points have the place of a neighbour.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The same problem as it would be asked for with all that was derived from its points:
    /// parameters and tolerance stay as they are when points move.
    pub fn restated(&self) -> Request {
        let mut request = self.request.clone();
        request.tolerance = Tolerance::Absolute(self.tolerance);
        let restate = |choice: &mut DirectionChoice, direction: &Direction| {
            if !matches!(choice.parameters, Parametrization::Explicit(_)) {
                choice.parameters = Parametrization::Explicit(direction.explicit_parameters());
            }
        };
        restate(&mut request.u, &self.u);
        if let (Some(choice), Some(direction)) = (&mut request.v, &self.v) {
            restate(choice, direction);
        }
        request
    }

    /// The points that the iteration approaches; of a surface row by row. In homogeneous fits they
    /// are `(w_i P_i, w_i)`, with one coordinate more than the data.
    pub fn data(&self) -> &Arc<Points> {
        self.lifted.as_ref().unwrap_or(&self.request.points)
    }

    /// The extent of each coordinate of [`data`](Self::data).
    pub fn extents(&self) -> &[Extent] {
        &self.extents
    }

    /// Whether the last coordinate of data and control points is a weight.
    pub fn is_homogeneous(&self) -> bool {
        self.lifted.is_some()
    }

    /// The points of which there are no data.
    pub fn missing(&self) -> Option<&Missing> {
        self.missing.as_ref()
    }

    /// The number of coordinates of the data points.
    pub fn dimension(&self) -> usize {
        self.request.points.dimension()
    }

    /// The arrangement of the data points.
    pub fn grid(&self) -> Grid {
        self.request.grid
    }

    /// The arrangement of the free control points.
    pub fn control_grid(&self) -> Grid {
        Grid {
            rows: self.u.free(),
            columns: self.v.as_ref().map_or(1, Direction::free),
        }
    }

    /// The direction of a curve, or u of a surface.
    pub fn u(&self) -> &Direction {
        &self.u
    }

    /// The second direction of a surface.
    pub fn v(&self) -> Option<&Direction> {
        self.v.as_ref()
    }

    /// One direction or both.
    pub fn directions(&self) -> impl Iterator<Item = &Direction> + Clone {
        std::iter::once(&self.u).chain(&self.v)
    }

    /// Whether the bases of a surface's directions were asked for separately.
    pub fn bases_differ(&self) -> bool {
        let v = self.request.v.as_ref();
        v.is_some_and(|v| v.basis != self.request.u.basis)
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.request.method
    }

    /// Local fits: the indices of the control points that move; all of them if there are none.
    pub fn selected(&self) -> Option<&[usize]> {
        self.request.selected.as_deref()
    }

    /// The free control points of level 0, if they do not follow from the data.
    pub fn start(&self) -> Option<&Arc<Points>> {
        self.request.start.as_ref()
    }

    /// The largest allowed distance of the curve from a data point, in data units.
    pub fn tolerance(&self) -> f64 {
        match self.method() {
            // Points that are nearer than the threshold are left alone.
            Method::Adaptive { threshold } => self.tolerance.max(threshold),
            _ => self.tolerance,
        }
    }

    /// The last level that is computed.
    pub fn max_iterations(&self) -> usize {
        self.request.max_iterations
    }

    /// The diagonal of the data's bounding box, in data units.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// Bytes that iterating this problem once takes, the data included.
    pub fn memory(&self) -> usize {
        let points = self.grid().count();
        // Data, control points, residual and what the method needs besides; scratch on surfaces.
        let given = usize::from(self.is_homogeneous()) + usize::from(self.start().is_some());
        let vectors = 3
            + given
            + match self.method() {
                Method::Global | Method::Weighted { .. } => 0,
                Method::LeastSquares(_) => 3,
                Method::Chebyshev => 2,
                _ => 1,
            };
        let factors = match self.method() {
            Method::Global | Method::Convex => 1,
            _ => 4,
        };
        let scratch = usize::from(self.v.is_some());
        let arrays = (vectors * self.data().dimension() + scratch) * points * size_of::<f64>();
        let directions = self.directions().map(|direction| {
            2 * direction.parameters.len() * size_of::<f64>()
                + factors * Collocation::memory(direction)
        });
        directions.sum::<usize>() + arrays
    }

    /// Multiplications of one iteration: the measure of how long a step takes.
    pub fn step_cost(&self) -> usize {
        let widths = self
            .directions()
            .map(|direction| direction.basis.support_width());
        self.data().dimension() * self.grid().count() * widths.sum::<usize>()
    }

    /// About how many multiplications prepare the first iteration: evaluating the basis, and the
    /// eliminations that the spectrum and the method need.
    pub fn start_cost(&self) -> usize {
        let each = self.directions().map(|direction| {
            let width = direction.basis.support_width();
            let elimination = direction.parameters.len().saturating_mul(width * width);
            elimination.saturating_mul(ELIMINATIONS)
        });
        each.fold(0, usize::saturating_add)
    }

    /// A given start fits the problem.
    fn check_start(&self) -> Result<(), Invalid> {
        let Some(start) = self.start() else {
            return Ok(());
        };
        let (given, expected) = (start.len(), self.control_grid().count());
        if given != expected || start.dimension() != self.data().dimension() {
            return Err(Invalid::StartCount { given, expected });
        }
        Ok(())
    }
}

/// The directions of what was asked for.
fn directions(
    request: &Request,
    missing: Option<&Missing>,
) -> Result<(Direction, Option<Direction>), Invalid> {
    let (mut choice_u, mut choice_v) = (request.u.clone(), request.v.clone());
    if let (Weights::FixedGrid(values), Some(v)) = (&request.weights, &mut choice_v) {
        let (rows, columns) = weights::separate(values, request.grid)?;
        choice_u.weights = Some(rows);
        v.weights = Some(columns);
    }
    if let Method::LeastSquares(LeastSquares { u, v, .. }) = request.method {
        choice_u.control_points = Some(u);
        if let Some(choice) = &mut choice_v {
            choice.control_points = Some(v);
        }
    }
    let direction =
        |choice, axis| Direction::new(choice, &request.points, request.grid, missing, axis);
    let u = direction(choice_u, Axis::U)?;
    let v = choice_v.map(|choice| direction(choice, Axis::V));
    Ok((u, v.transpose()?))
}

fn check_finite(points: &Points, extents: &[Extent]) -> Result<(), Invalid> {
    let lanes = points.lanes().iter().zip(extents);
    for (coordinate, (lane, _)) in lanes.enumerate().filter(|(_, (_, it))| !it.is_finite) {
        if let Some(index) = lane.iter().position(|x| !x.is_finite()) {
            return Err(Invalid::NotFinite {
                index,
                coordinate,
                value: lane[index],
            });
        }
    }
    Ok(())
}

fn check_missing(request: &Request) -> Result<(), Invalid> {
    if request.missing.len() == request.grid.count() {
        return Err(Invalid::NoPoints);
    }
    match (&request.method, request.missing.first()) {
        (Method::LeastSquares(_), _) | (_, None) => Ok(()),
        (_, Some(&index)) => Err(Invalid::MissingPoint { index }),
    }
}

fn resolve_tolerance(tolerance: Tolerance, magnitude: f64, diagonal: f64) -> Result<f64, Invalid> {
    let (value, relative) = match tolerance {
        Tolerance::Absolute(value) => (value, false),
        Tolerance::Relative(value) => (value, true),
    };
    if !(value.is_finite() && value >= 0.0) {
        return Err(Invalid::Tolerance { value, relative });
    }
    // Relative to points that are nearly equal, rounding of their coordinates would be too much.
    let rounding = magnitude * ROUNDING;
    let tolerance = match relative {
        true if value > 0.0 => (value * diagonal).max(rounding),
        true => 0.0,
        false => value,
    };
    if tolerance.is_finite() {
        Ok(tolerance)
    } else {
        Err(Invalid::ToleranceTooLarge { value, diagonal })
    }
}

fn check_method(request: &Request) -> Result<(), Invalid> {
    let positive = |name, value: f64| {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            Err(Invalid::NotPositive { name, value })
        }
    };
    match &request.method {
        Method::Weighted { omega: Some(value) } if !(*value > 0.0 && *value < 2.0) => {
            Err(Invalid::Omega { value: *value })
        }
        Method::Adaptive { threshold } => positive("threshold", *threshold),
        Method::LeastSquares(LeastSquares {
            variant: Variant::Lspia { mu: Some(mu) },
            ..
        }) => positive("mu", *mu),
        Method::Local { row_by_row: true } if request.v.is_none() => Err(Invalid::RowsOfCurve),
        Method::Local { .. } => match &request.selected {
            None => Ok(()),
            Some(indices) => check_indices(indices, request.grid.count()),
        },
        Method::Convex => check_planar(request),
        _ => Ok(()),
    }
}

fn check_indices(indices: &[usize], count: usize) -> Result<(), Invalid> {
    if indices.is_empty() {
        return Err(Invalid::NoIndices);
    }
    let mut seen = vec![false; count];
    for (index, &value) in indices.iter().enumerate() {
        match seen.get_mut(value) {
            None => {
                return Err(Invalid::IndexOutside {
                    index,
                    value,
                    count,
                });
            }
            Some(true) => return Err(Invalid::IndexRepeated { index }),
            Some(seen) => *seen = true,
        }
    }
    Ok(())
}

fn check_planar(request: &Request) -> Result<(), Invalid> {
    let found = if request.v.is_some() {
        "this is a surface"
    } else if request.points.dimension() != 2 {
        "the points have not two coordinates"
    } else if matches!(request.weights, Weights::Homogeneous(_)) {
        "the weights are homogeneous"
    } else {
        return Ok(());
    };
    Err(Invalid::NotPlanar {
        method: "convex",
        found,
    })
}
