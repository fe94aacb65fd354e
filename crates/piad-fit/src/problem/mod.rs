//! A fitting problem: from the request to what can be iterated.
//!
//! All validation errors are found here, so that later only numeric overflow is possible. In this order: the points are
//! checked, missing ones get a place, the tolerance is resolved, the settings of the method are checked, parameters and
//! knots are computed for each direction, homogeneous coordinates are lifted, a given start is compared with the
//! control grid, and methods that cannot converge are refused.

mod adaptive_knots;
pub(crate) mod admission;
mod automatic;
mod checks;
mod construction;
mod corners;
mod cost;
mod creases;
mod fairness;
mod first;
mod gaps;
mod order;
mod pieces;
mod polyline;
mod repeated;
pub(crate) mod request;
mod robust;
mod scattered;
mod unfolding;

pub(crate) use robust::Inliers;

use std::ops::Deref;
use std::sync::Arc;

use super::ends::line::Fitted;
use super::ends::offsets::Offsets;
use super::invalid::{Axis, Invalid};
use super::method::Method;
use super::parameters::Parametrization;
use super::setup::Setup;
use super::warning::Warning;
use crate::basis::choice::DirectionChoice;
use crate::basis::direction::Direction;
use crate::data::grid::Grid;
use crate::data::missing::Missing;
use crate::data::points::{self, Points};
use crate::data::weights;
use crate::geometry::outline::Outline;
use crate::parameters::{FoldedTriangles, Pairs, Scattered};
use admission::Admission;

use checks::{
    check_dimension, check_finite, check_points, check_scattered, check_start, resolve_tolerance,
    scope,
};

use request::{Request, Tolerance, Weights};
use unfolding::{chosen, pairs, unfolded};

/// A validated fitting problem: a `Setup` with a method. It can be iterated, and every error left
/// is one of arithmetic.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The request; missing points have got a place.
    request: Request,
    setup: Arc<Setup>,
    /// The requested tolerance in data units: methods may have a larger one.
    tolerance: f64,
    /// The points that are fitted, where others are outliers or missing.
    kept: Option<Kept>,
    /// The rule for the parameters of scattered points, if the fit has chosen it.
    chosen: Option<Scattered>,
    /// The outline of the data, of a surface that is trimmed.
    outline: Option<Arc<Outline>>,
    /// The triangles of a mesh that its parameters turn over.
    folded: Option<FoldedTriangles>,
}

/// The points of a fit that are not outliers of a robust one, and not missing where it chooses its knots.
#[derive(Clone, Debug)]
struct Kept {
    inliers: Arc<Inliers>,
    /// The same fit of these points alone, if it chooses its knots.
    alone: Option<Arc<Problem>>,
}

impl Deref for Problem {
    type Target = Setup;

    /// The setup, independent of the method.
    fn deref(&self) -> &Setup {
        &self.setup
    }
}

impl Problem {
    /// Validates a request, computes parameters and knots and resolves the tolerance.
    ///
    /// # Errors
    ///
    /// The first validation error, in this order: the points, the tolerance, the settings of the method, the
    /// directions, the weights, the start, and whether the method can converge.
    pub fn new(request: Request) -> Result<Self, Invalid> {
        Self::admitted(request, &Admission::ANY)
    }

    /// The same, unless it exceeds the limits, which is checked before any long computation.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new), and limits that are exceeded.
    pub fn admitted(mut request: Request, admission: &Admission) -> Result<Self, Invalid> {
        check_dimension(&request)?;
        let missing = check_points(&mut request)?;
        check_finite(&request.points, &request.points.extents())?;
        order::resolve(&mut request)?;
        repeated::merge(&mut request)?;
        check_scattered(&request)?;
        let mesh = unfolded(&request, admission)?;
        // What follows sees pairs; the request stays what it was.
        let meshed = mesh
            .as_ref()
            .map(|mesh| Scattered::Given(mesh.pairs.clone()));
        let meshed = meshed.and_then(|pairs| request.scattered.replace(pairs));
        let inliers = Inliers::of(&request, admission)?.map(Arc::new);
        let fitted = |it: &Arc<Inliers>| Arc::clone(&it.points);
        let fitted = inliers.as_ref().map_or(Arc::clone(&request.points), fitted);
        let extents = fitted.extents();
        let diagonal = points::diagonal(&extents);
        if !diagonal.is_finite() {
            return Err(Invalid::too_large());
        }
        let tolerance =
            resolve_tolerance(request.tolerance, points::magnitude(&extents), diagonal)?;
        imply_control_points(&mut request)?;
        fairness::settle(&mut request);
        polyline::resolve(&mut request)?;
        match request.v {
            Some(_) => creases::resolve(&mut request)?,
            None => corners::resolve(&mut request, inliers.as_deref())?,
        }
        request.method.algorithm().check(&scope(&request))?;
        automatic::check_request(&request)?;
        adaptive_knots::check(&request)?;
        settle(&mut request);
        let alone = inliers.as_ref().map(|it| it.alone(&request));
        let chosen = chosen(alone.as_ref().unwrap_or(&request))?;
        let pairs = pairs(alone.as_ref().unwrap_or(&request), chosen.as_ref())?;
        let (u, v) = match inliers.as_ref().zip(alone.as_ref()) {
            None => all_directions(&request, pairs.as_ref(), missing.as_ref())?,
            Some((inliers, alone)) => {
                alone.method.algorithm().check(&scope(alone))?;
                let (u, v) = all_directions(alone, pairs.as_ref(), None)?;
                let with_outliers = |it: &Direction| inliers.with_outliers(it, v.is_some());
                (with_outliers(&u), v.as_ref().map(with_outliers))
            }
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
            missing: missing.or_else(|| inliers.as_ref()?.missing()),
            scattered: pairs.map(|pairs| pairs.domains),
            sections: match &alone.as_ref().unwrap_or(&request).scattered {
                Some(Scattered::Sections(sections)) => Some(Arc::clone(&sections.counts)),
                _ => None,
            },
            polyline: request.polyline,
            offsets,
            target,
            u,
            v,
            selected: request.selected.clone(),
            start: request.start.clone(),
            lambda_min: request.lambda_min,
            tolerance: request.method.algorithm().tolerance(tolerance),
            max_iterations: request.max_iterations,
            diagonal,
            clustered: choices().any(DirectionChoice::is_clustered),
        };
        if meshed.is_some() {
            request.scattered = meshed;
        }
        let mut problem = Self {
            request,
            setup: Arc::new(setup),
            tolerance,
            kept: None,
            outline: None,
            folded: mesh.as_ref().and_then(|mesh| mesh.folded),
            chosen: mesh.map(|mesh| mesh.rule).or(chosen),
        };
        admission.check(problem.memory(), problem.step_cost(), problem.start_cost())?;
        check_start(&problem.setup)?;
        if let Some(placed) = adaptive_knots::placed(&problem.request, &problem.setup)? {
            problem.setup = Arc::new(placed);
        }
        fairness::choose(&mut problem.request, &problem.setup, problem.tolerance)?;
        while let Err(error) = problem.method().algorithm().check_convergence(&problem) {
            let finer = first::finer(&problem.setup, &problem.request);
            problem.setup = Arc::new(finer.ok_or(error)?);
        }
        let kept = match problem.is_automatic() {
            true => gaps::present(&problem.request, &problem.setup),
            false => None,
        };
        let kept = kept.map(|(present, alone)| (Arc::new(present), alone));
        problem.kept = match kept.or(inliers.zip(alone)) {
            Some((inliers, alone)) => {
                let alone = problem.is_automatic().then_some(alone);
                let alone = alone.map(|alone| Self::admitted(alone, admission));
                let alone = alone.transpose()?.map(Arc::new);
                Some(Kept { inliers, alone })
            }
            None => {
                problem.pieces()?;
                None
            }
        };
        Ok(problem)
    }

    /// The request. Missing points have the place of a neighbour.
    pub fn request(&self) -> &Request {
        &self.request
    }

    /// The rule for the parameters of scattered points, if the fit has chosen it.
    pub fn chosen_parameters(&self) -> Option<&Scattered> {
        self.chosen.as_ref()
    }

    /// The outline of the data in the parameters of a trimmed surface.
    pub fn outline(&self) -> Option<&Arc<Outline>> {
        self.outline.as_ref()
    }

    /// The same with the outline of its data.
    pub(crate) fn with_outline(self, outline: Arc<Outline>) -> Self {
        Self {
            outline: Some(outline),
            ..self
        }
    }

    /// The triangles of a mesh that its parameters turn over, if there are some.
    pub fn folded_triangles(&self) -> Option<FoldedTriangles> {
        self.folded
    }

    /// The same problem as a request that includes all that was derived from its points. Parameters, a requested
    /// tolerance, and the choice of points to leave out stay as they are when points move.
    pub fn restated(&self) -> Request {
        let mut request = self.request.clone();
        request.tolerance = request
            .tolerance
            .and(Some(Tolerance::Absolute(self.tolerance)));
        request.outliers = Some(self.outliers().into());
        if let (Some(domains), Some(v)) = (self.scattered, self.v()) {
            let lanes = [&self.u().parameters, &v.parameters];
            let values = Points::from_lanes(lanes.map(|lane| lane.as_slice()));
            let values = Arc::new(values);
            request.scattered = Some(Scattered::Given(Pairs { values, domains }));
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

    /// The same with other directions, one for each that it has.
    pub(super) fn with_directions(&self, directions: impl IntoIterator<Item = Direction>) -> Self {
        let mut setup = Setup::clone(&self.setup);
        let places = std::iter::once(&mut setup.u).chain(&mut setup.v);
        places
            .zip(directions)
            .for_each(|(place, direction)| *place = direction);
        Self {
            setup: Arc::new(setup),
            ..self.clone()
        }
    }

    /// The points that a robust fit leaves out, by index.
    pub fn outliers(&self) -> &[usize] {
        let robust = self
            .kept
            .as_ref()
            .filter(|_| self.request.missing.is_empty());
        robust.map_or(&[], |it| &it.inliers.outliers)
    }

    /// The fit that chooses its knots of the points that are neither outliers nor missing, and which these are.
    pub(crate) fn alone(&self) -> Option<(&Arc<Self>, &Arc<Inliers>)> {
        let Kept { inliers, alone } = self.kept.as_ref()?;
        Some((alone.as_ref()?, inliers))
    }

    /// Returns true if the fit chooses its knots, so that each level has knots of its own.
    pub fn is_automatic(&self) -> bool {
        self.method().is_automatic()
    }

    /// The setup, independent of the method.
    pub fn setup(&self) -> &Arc<Setup> {
        &self.setup
    }

    /// The requested tolerance in data units: at most that of the fit.
    pub(super) fn requested_tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns true if a fit that ends above the tolerance has missed its goal: the tolerance was requested, or it
    /// determines the number of control points.
    pub(super) fn has_goal(&self) -> bool {
        self.request.tolerance.is_some() || self.is_automatic()
    }

    /// The method.
    pub fn method(&self) -> &Method {
        &self.request.method
    }

    /// Returns true if the bases of a surface's directions were requested separately.
    pub fn bases_differ(&self) -> bool {
        let v = self.request.v.as_ref();
        v.is_some_and(|v| v.basis != self.request.u.basis)
    }

    /// Warnings about the problem as requested.
    pub fn warnings(&self) -> Vec<Warning> {
        let Request { u, v, .. } = &self.request;
        let mut warnings = Vec::new();
        let absolute = matches!(self.request.tolerance, Some(Tolerance::Absolute(_)));
        if !absolute && self.tolerance > 0.0 {
            let size = (self.diagonal(), self.tolerance);
            warnings.extend(Warning::of_points(&self.points, size));
        }
        let request = &self.request;
        warnings.extend(match v {
            None => Warning::of_curve(&request.points),
            Some(_) if request.grid.is_rows() => {
                Warning::of_grid(&request.points, &request.missing)
            }
            Some(_) => None,
        });
        if let (Method::LeastSquares(settings), None) = (self.method(), v)
            && !settings.robust
            && !request.polyline
        {
            let spikes = Warning::of_spikes(&request.points, u.closed);
            let corners = || Warning::of_corners(&request.points, u.closed);
            let is_round = corners::rounds(request);
            warnings.extend(spikes.or_else(|| is_round.then(corners).flatten()));
        }
        // Fewer control points have knots of their own, which are not at the data.
        if self.method().algorithm().control_points().is_some() {
            return warnings;
        }
        warnings.extend(Warning::of_direction(u, self.u(), Axis::U));
        if let (Some(choice), Some(direction)) = (v, self.v()) {
            warnings.extend(Warning::of_direction(choice, direction, Axis::V));
        }
        warnings
    }
}

/// The requested directions.
fn all_directions(
    request: &Request,
    pairs: Option<&Pairs>,
    missing: Option<&Missing>,
) -> Result<(Direction, Option<Direction>), Invalid> {
    match (pairs, request.method.automatic()) {
        (_, Some(settings)) => first::first_directions(request, (pairs, missing), settings),
        (Some(pairs), None) => scattered_directions(request, pairs),
        (None, None) => directions(request, missing),
    }
}

/// The directions of scattered points.
fn scattered_directions(
    request: &Request,
    pairs: &Pairs,
) -> Result<(Direction, Option<Direction>), Invalid> {
    let counts = request.method.algorithm().control_points();
    let (rows, columns) = counts.unwrap_or_default();
    let u = Direction::scattered(&request.u, pairs.direction(0), rows, Axis::U)?;
    let v = request.v.as_ref();
    let v = v.map(|v| Direction::scattered(v, pairs.direction(1), columns, Axis::V));
    Ok((u, v.transpose()?))
}

/// The directions of curves and grids, with fixed weights from a grid separated, and with as many
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
    if let Some((u, v)) = request.method.algorithm().control_points() {
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

/// Fills in the numbers of control points of least squares that explicit knots imply.
fn imply_control_points(request: &mut Request) -> Result<(), Invalid> {
    if let Method::LeastSquares(settings) = &request.method {
        let choices = std::iter::once(&request.u).chain(&request.v);
        let settings = settings.with_counts(choices.map(|choice| &choice.basis))?;
        request.method = Method::LeastSquares(settings);
    }
    Ok(())
}

/// Fills in defaults.
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
