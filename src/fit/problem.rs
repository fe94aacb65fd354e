//! A fitting problem: from what was asked for to what can be iterated.
//!
//! Everything that can be wrong is found here, so that what comes after can only run out of the
//! range of numbers. In this order: the points are checked, missing ones get a place, the tolerance
//! is resolved, the settings of the method are checked, parameters and knots are computed for each
//! direction, homogeneous coordinates are lifted, a given start is compared with the control grid,
//! and methods that cannot converge are refused.

use std::ops::Deref;
use std::sync::Arc;

use super::collocation::Collocation;
use super::direction::{Direction, DirectionChoice};
use super::ends::line::Fitted;
use super::ends::offsets::Offsets;
use super::extent::Extent;
use super::invalid::{Axis, Invalid};
use super::method::{Method, Scope};
use super::missing::Missing;
use super::parameters::Parametrization;
use super::points::{self, Grid, Points};
use super::scattered::Scattered;
use super::setup::Setup;
use super::sparse::Sparse;
use super::warning::Warning;
use super::weights;

pub use super::request::{Request, Tolerance, Weights};

/// Rounding errors of coordinates, relative to the largest absolute coordinate.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A validated fitting problem: a [`Setup`] with a method. It can be iterated, and every error left
/// is one of arithmetic.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What was asked for; missing points have got a place.
    request: Request,
    setup: Arc<Setup>,
    /// The tolerance in data units, as it was asked for: methods may have a larger one.
    tolerance: f64,
}

impl Deref for Problem {
    type Target = Setup;

    /// What is fitted, whatever the method.
    fn deref(&self) -> &Setup {
        &self.setup
    }
}

impl Problem {
    /// Validates a request, computes parameters and knots and resolves the tolerance.
    ///
    /// # Errors
    ///
    /// The first thing that is wrong, in this order: the points, the tolerance, the settings of the
    /// method, the directions, the weights, the start, and whether the method can converge.
    pub fn new(mut request: Request) -> Result<Self, Invalid> {
        let missing = check_points(&mut request)?;
        let extents = request.points.extents();
        check_finite(&request.points, &extents)?;
        let diagonal = points::diagonal(&extents);
        if !diagonal.is_finite() {
            return Err(Invalid::TooLarge);
        }
        let tolerance =
            resolve_tolerance(request.tolerance, points::magnitude(&extents), diagonal)?;
        check_scattered(&request)?;
        request.method.scheme().check(&scope(&request))?;
        settle(&mut request);
        let (u, v) = match &request.scattered {
            Some(scattered) => scattered_directions(&request, scattered)?,
            None => directions(&request, missing.as_ref())?,
        };
        let lifted = match &request.weights {
            Weights::Homogeneous(values) => Some(Arc::new(weights::lift(&request.points, values)?)),
            _ => None,
        };
        let data = lifted.as_ref().unwrap_or(&request.points);
        let (offsets, target) = constants(&request, data, &u, v.as_ref())?;
        let choices = || std::iter::once(&request.u).chain(&request.v);
        let setup = Setup {
            points: Arc::clone(&request.points),
            grid: request.grid,
            extents: lifted.as_ref().map_or(extents, |it| it.extents()),
            lifted,
            missing,
            scattered: request.scattered.is_some(),
            offsets,
            target,
            u,
            v,
            selected: request.selected.clone(),
            start: request.start.clone(),
            lambda_min: request.lambda_min,
            tolerance: request.method.scheme().tolerance(tolerance),
            max_iterations: request.max_iterations,
            diagonal,
            clustered: choices().any(DirectionChoice::is_clustered),
        };
        check_start(&setup)?;
        request.method.scheme().check_convergence(&setup)?;
        Ok(Self {
            request,
            setup: Arc::new(setup),
            tolerance,
        })
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
        if let (Some(_), Some(v)) = (&request.scattered, self.v()) {
            let lanes = [&self.u().parameters, &v.parameters];
            let pairs = Points::from_lanes(lanes.map(|lane| lane.as_slice()));
            request.scattered = Some(Scattered::Given(Arc::new(pairs)));
            return request;
        }
        let restate = |choice: &mut DirectionChoice, direction: &Direction| {
            if !matches!(choice.parameters, Parametrization::Explicit(_)) {
                choice.parameters = Parametrization::Explicit(direction.explicit_parameters());
            }
        };
        restate(&mut request.u, self.u());
        if let (Some(choice), Some(direction)) = (&mut request.v, self.v()) {
            restate(choice, direction);
        }
        request
    }

    /// What is fitted, whatever the method.
    pub(super) fn setup(&self) -> &Arc<Setup> {
        &self.setup
    }

    /// The tolerance in data units as it was asked for: at most that of the fit.
    pub(super) fn asked_tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The method.
    pub fn method(&self) -> &Method {
        &self.request.method
    }

    /// Whether the bases of a surface's directions were asked for separately.
    pub fn bases_differ(&self) -> bool {
        let v = self.request.v.as_ref();
        v.is_some_and(|v| v.basis != self.request.u.basis)
    }

    /// What is doubtful about the problem as it is asked for.
    pub fn warnings(&self) -> Vec<Warning> {
        let Request { u, v, .. } = &self.request;
        // Fewer control points have knots of their own, which are not at the data.
        if self.method().scheme().control_points().is_some() {
            return Vec::new();
        }
        let mut warnings = Warning::of_direction(u, self.u(), Axis::U);
        if let (Some(choice), Some(direction)) = (v, self.v()) {
            warnings.extend(Warning::of_direction(choice, direction, Axis::V));
        }
        warnings
    }

    /// How many bytes iterating this problem once takes, the data included: vectors of n points,
    /// collocation matrices and their factorizations. It is an upper bound by what the method
    /// demands, for admission.
    pub fn memory(&self) -> usize {
        let points = self.grid().count();
        let demand = self.method().scheme().demand();
        // Data, control points, residual and what the method needs besides; scratch on surfaces.
        let given = usize::from(self.is_homogeneous()) + usize::from(self.start().is_some());
        let shifted = usize::from(self.offsets().is_some());
        let vectors = 3 + given + shifted + demand.vectors;
        let scratch = usize::from(self.v().is_some());
        let arrays = (vectors * self.data().dimension() + scratch) * points * size_of::<f64>();
        if let (true, Some(v)) = (self.is_scattered(), self.v()) {
            let matrix = Sparse::memory(self.u(), v);
            return arrays + matrix + demand.bytes;
        }
        let directions = self.directions().map(|direction| {
            2 * direction.parameters.len() * size_of::<f64>()
                + demand.matrices * Collocation::memory(direction)
        });
        let offsets = self.offsets().map_or(0, Offsets::numbers) * size_of::<f64>();
        directions.sum::<usize>() + arrays + offsets + demand.bytes
    }

    /// Multiplications of one iteration: the measure of how long a step takes, for fair shares of
    /// time.
    pub fn step_cost(&self) -> usize {
        self.residual_cost() + self.method().scheme().step_cost(self)
    }

    /// About how many multiplications prepare the first iteration: evaluating bases,
    /// factorizations, eigenvalues.
    pub fn start_cost(&self) -> usize {
        let method = self.method().scheme().start_cost(self);
        self.preparation_cost().saturating_add(method)
    }
}

/// What the settings of a method are checked against.
fn scope(request: &Request) -> Scope<'_> {
    Scope {
        grid: request.grid,
        is_surface: request.v.is_some(),
        is_scattered: request.scattered.is_some(),
        dimension: request.points.dimension(),
        is_homogeneous: matches!(request.weights, Weights::Homogeneous(_)),
        selected: request.selected.as_deref(),
    }
}

/// Refuses grids with fewer than 2 points in a direction, and gives missing points a place. Returns
/// which are missing.
fn check_points(request: &mut Request) -> Result<Option<Missing>, Invalid> {
    let grid = request.grid;
    let has_columns = request.v.is_some() && request.scattered.is_none();
    if grid.rows < 2 || (has_columns && grid.columns < 2) {
        let count = if grid.rows < 2 {
            grid.rows
        } else {
            grid.columns
        };
        return Err(Invalid::TooFewPoints { count });
    }
    let missing = Missing::new(&request.missing, grid.count());
    if let Some(missing) = &missing {
        if request.missing.len() == grid.count() {
            return Err(Invalid::NoPoints);
        }
        if let (false, Some(&index)) = (
            request.method.scheme().fits_holes(),
            request.missing.first(),
        ) {
            return Err(Invalid::MissingPoint { index });
        }
        missing.fill(Arc::make_mut(&mut request.points), grid);
    }
    Ok(missing)
}

/// Scattered points are those of a surface, for a method that fits them, and without weights.
fn check_scattered(request: &Request) -> Result<(), Invalid> {
    if request.scattered.is_none() {
        return Ok(());
    }
    let weighted = |choice: &DirectionChoice| choice.weights.is_some();
    let mut choices = std::iter::once(&request.u).chain(&request.v);
    if !request.method.scheme().fits_scattered() || request.v.is_none() {
        let method = request.method.scheme().about().name;
        return Err(Invalid::ScatteredMethod { method });
    }
    if request.weights != Weights::None || choices.any(weighted) {
        return Err(Invalid::ScatteredWeights);
    }
    Ok(())
}

/// The directions of scattered points.
fn scattered_directions(
    request: &Request,
    scattered: &Scattered,
) -> Result<(Direction, Option<Direction>), Invalid> {
    let [along, across] = scattered.parameters(&request.points)?;
    let counts = request.method.scheme().control_points();
    let (rows, columns) = counts.unwrap_or_default();
    let u = Direction::scattered(&request.u, (along, rows), Axis::U)?;
    let v = request.v.as_ref();
    let v = v.map(|v| Direction::scattered(v, (across, columns), Axis::V));
    Ok((u, v.transpose()?))
}

/// A given start has the number and the coordinates of the control points.
fn check_start(setup: &Setup) -> Result<(), Invalid> {
    let Some(start) = setup.start() else {
        return Ok(());
    };
    let (given, expected) = (start.len(), setup.control_grid().count());
    if given != expected || start.dimension() != setup.data().dimension() {
        return Err(Invalid::StartCount { given, expected });
    }
    Ok(())
}

/// The directions of what was asked for, with fixed weights from a grid separated, and with as many
/// control points as the method has.
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
    if let Some((u, v)) = request.method.scheme().control_points() {
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

/// Names what is usual where nothing is said.
fn settle(request: &mut Request) {
    if request.method.has_fewer_control_points() {
        request.u.settle_least_squares();
        if let Some(v) = &mut request.v {
            v.settle_least_squares();
        }
    } else {
        let Grid { rows, columns } = request.grid;
        request.u.settle(rows);
        if let Some(v) = &mut request.v {
            v.settle(columns);
        }
    }
}

/// The constants of control points at the ends, and the data without their share.
fn constants(
    request: &Request,
    data: &Arc<Points>,
    u: &Direction,
    v: Option<&Direction>,
) -> Result<(Option<Arc<Offsets>>, Arc<Points>), Invalid> {
    let fitted = Fitted {
        points: data,
        grid: request.grid,
        homogeneous: matches!(request.weights, Weights::Homogeneous(_)),
    };
    let across = v.zip(request.v.as_ref());
    let across = across.map(|(direction, choice)| (direction, choice.ends.as_ref()));
    let offsets = Offsets::new(fitted, (u, request.u.ends.as_ref()), across)?;
    let Some(offsets) = offsets else {
        return Ok((None, Arc::clone(data)));
    };
    let mut target = Points::clone(data);
    let across = v.map(|v| (v, &v.parameters[..]));
    offsets.add(-1.0, (u, &u.parameters), across, target.lanes_mut());
    Ok((Some(Arc::new(offsets)), Arc::new(target)))
}

/// Refuses coordinates that are infinite or NaN, and names the first one.
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

/// The tolerance in data units: a relative one is a multiple of the `diagonal`, but never below the
/// rounding of coordinates of this `magnitude`, unless it is zero.
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
