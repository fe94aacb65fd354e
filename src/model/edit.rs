//! A requested edit, and its way from the parent's problem to a new one.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::{ChangePart, OrErrors, SpecPart, ValidationError, ValidationErrors};
use super::iteration::IterationChoice;
use super::job::{LONGEST_NAME, Limits, ValidJob, check_name};
use super::list_limits::for_points;
use super::lists::PointNumbers;
use super::method::MethodInput;
use super::numbers::{NewWeights, Point};
use super::per_direction::PerDirection;
use super::schema;
use super::serde_helpers::object;
use super::settings::Index;
use super::stop::StopRules;
use super::stream::StreamSpec;
use super::weights::{Rational, Resolved, check_unused};
use piad_files::json::Coordinates;
use piad_fit::data::Points;
use piad_fit::engine::{DirectionChoice, Problem, Request, Weights};
use piad_fit::invalid::{self as fit, Invalid};

/// The most characters of the name of a drag.
pub(crate) const LONGEST_SESSION: usize = 100;

/// Changes of a fit. Fields that are not given stay as they are; at least one of `points`, `weights`, `rational`,
/// `method` and `stop` is given.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_edit())]
pub(crate) struct EditRequest {
    /// A name of the new job.
    #[schemars(length(max = LONGEST_NAME), example = &"wing section, thicker")]
    pub name: Option<String>,
    /// The iteration of the parent to start from.
    pub iteration: Option<IterationChoice>,
    /// Data points that go elsewhere or get another weight; none twice.
    #[serde(default, deserialize_with = "for_points")]
    pub points: Option<Vec<Move>>,
    /// New weights of all data points.
    #[schemars(with = "Option<NewWeights>")]
    pub weights: Option<PerDirection<PointNumbers>>,
    /// The use of the weights. It stays as it is where there were weights before.
    pub rational: Option<Rational>,
    /// Another method.
    pub method: Option<MethodInput>,
    /// Other rules when the iteration ends.
    pub stop: Option<StopRules>,
    /// The options of the event streams; default: those of the parent.
    pub stream: Option<StreamSpec>,
    /// The edit is one frame of a drag: it is streamed in the answer, neither stored nor listed, and ends
    /// with its connection.
    #[schemars(extend("default" = false))]
    pub ephemeral: Option<bool>,
    /// Ephemeral edits: a name of the client's choice for the drag. An edit with it replaces the one
    /// before of the same parent and client.
    #[schemars(length(min = 1, max = LONGEST_SESSION), example = &"drag-17")]
    pub session: Option<String>,
}

/// A data point with a new position, a new weight, or both.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_move())]
pub(crate) struct Move {
    /// Which data point.
    pub index: Index,
    /// Its new position.
    #[schemars(with = "Option<Point>")]
    pub point: Option<Coordinates>,
    /// Its new weight, in homogeneous fits.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub weight: Option<f64>,
}

object!(EditRequest, "an object");
object!(Move, "an object with an index and a point or a weight");

/// The start of an edit.
pub(crate) struct ParentFit<'a> {
    /// The problem of the parent.
    pub problem: &'a Problem,
    /// Its control points at the level that the edit starts from.
    pub control_points: &'a Arc<Points>,
    /// The least eigenvalue of its collocation matrix, if it is known.
    pub lambda_min: Option<f64>,
    /// The stream options of the parent.
    pub stream: Option<&'a StreamSpec>,
}

impl EditRequest {
    /// The problem with the changes, starting from the parent's control points.
    pub(crate) fn apply(self, parent: &ParentFit<'_>, limits: Limits) -> OrErrors<ValidJob> {
        let mut errors = ValidationErrors::default();
        errors.keep(check_name(self.name.as_deref()));
        errors.keep(self.check_some());
        errors.keep(self.check_session());
        let mut request = parent.problem.restated();
        let (grid, surface) = (request.grid, request.v.is_some());
        // Fixed weights are a part of the basis.
        let same_matrix = self.weights.is_none() || self.rational == Some(Rational::Homogeneous);
        request.lambda_min = parent.lambda_min.filter(|_| same_matrix);
        errors.keep(set_weights(&mut request, self.weights, self.rational));
        let points = self.points.unwrap_or_default();
        let changed = change_points(points, &mut request, &mut errors);
        let method = self.method.map(|method| method.choice(grid, surface));
        if let Some(method) = errors.keep(method.transpose()).flatten() {
            (request.method, request.selected) = (method.method, method.selected);
            // Least squares has its own knots and ends, and other bases are refused below.
            if request.method.has_fewer_control_points() {
                request.u.unsettle();
                request.v.iter_mut().for_each(DirectionChoice::unsettle);
            } else {
                request.u.unsettle_least_squares();
                let v = request.v.iter_mut();
                v.for_each(DirectionChoice::unsettle_least_squares);
            }
        }
        if let Some(stop) = self.stop {
            (request.tolerance, request.max_iterations) =
                stop.resolve(limits.iterations, &mut errors);
        }
        let stream = self.stream.or_else(|| parent.stream.cloned());
        let fits = stream.as_ref().map(|stream| stream.check(surface));
        errors.keep(fits.transpose());
        if !errors.none() {
            return Err(errors);
        }
        request.start = Some(start(parent, &request)?);
        request.start_breaks = start_breaks(parent, &request)?;
        let problem = errors.fit(request, &limits.admission, |place| in_edit(place, &changed));
        if let Some(problem) = &problem {
            errors.keep(check_bases(problem, parent.problem));
        }
        ValidJob::new(self.name, stream, problem, errors)
    }

    /// Refuses an edit that changes nothing.
    fn check_some(&self) -> OrErrors<()> {
        let nothing = self.points.as_ref().is_none_or(Vec::is_empty)
            && self.weights.is_none()
            && self.rational.is_none()
            && self.method.is_none()
            && self.stop.is_none();
        if nothing {
            let detail = "an edit changes something: points, weights, method or stop";
            return Err(ValidationError::at(SpecPart::Whole, detail).into());
        }
        Ok(())
    }

    fn check_session(&self) -> OrErrors<()> {
        let wrong = |detail: String| Err(ValidationError::at(SpecPart::Session, detail).into());
        match &self.session {
            None => Ok(()),
            Some(_) if self.ephemeral != Some(true) => {
                wrong("only ephemeral edits are parts of a session".to_owned())
            }
            Some(name) if name.is_empty() || name.chars().count() > LONGEST_SESSION => {
                wrong(format!("a name has 1 to {LONGEST_SESSION} characters"))
            }
            Some(_) => Ok(()),
        }
    }
}

/// Changes single points; returns the entry of each that was changed.
fn change_points(
    changes: Vec<Move>,
    request: &mut Request,
    errors: &mut ValidationErrors,
) -> HashMap<usize, usize> {
    let mut changed = HashMap::with_capacity(changes.len());
    let mut placed = HashSet::new();
    for (k, change) in changes.into_iter().enumerate() {
        if errors.full() {
            break;
        }
        let goes = change.point.is_some();
        let Some(index) = errors.keep(change.apply(k, request)) else {
            continue;
        };
        if changed.contains_key(&index) {
            let detail = "this point has been moved before, by the same edit";
            errors.push(ValidationError::at(
                SpecPart::Change(k, ChangePart::Index),
                detail,
            ));
        }
        changed.entry(index).or_insert(k);
        if goes {
            placed.insert(index);
        }
    }
    request.missing.retain(|index| !placed.contains(index));
    changed
}

impl Move {
    /// Moves the point; returns its index.
    fn apply(self, k: usize, request: &mut Request) -> Result<usize, ValidationError> {
        let wrong =
            |part, detail: String| Err(ValidationError::at(SpecPart::Change(k, part), detail));
        let index = self.index.of_point(request.grid, request.v.is_some());
        let index = index.or_else(|detail| wrong(ChangePart::Index, detail))?;
        let count = request.grid.count();
        if index >= count {
            let detail = format!("{index} is not one of the {count} points");
            return wrong(ChangePart::Index, detail);
        }
        if self.point.is_none() && self.weight.is_none() {
            return wrong(
                ChangePart::Whole,
                "a point or a weight is needed".to_owned(),
            );
        }
        let weights = match &mut request.weights {
            Weights::Homogeneous(weights) => Some(weights),
            _ => None,
        };
        match (self.weight, weights) {
            (None, _) => {}
            (Some(weight), Some(weights)) => weights[index] = weight,
            (Some(_), None) => {
                let detail = "only points of homogeneous fits have weights of their own";
                return wrong(ChangePart::Weight, detail.to_owned());
            }
        }
        if let Some(point) = self.point {
            let dimension = request.points.dimension();
            let point = point.as_slice();
            if point.len() != dimension {
                let given = point.len();
                let detail =
                    format!("{given} coordinates, but the points of this fit have {dimension}");
                return wrong(ChangePart::Point, detail);
            }
            let coordinates = point.iter().copied();
            Arc::make_mut(&mut request.points).set(index, coordinates);
        }
        Ok(index)
    }
}

/// New weights. They stay of the kind that they were: control points of homogeneous fits have a
/// coordinate more.
fn set_weights(
    request: &mut Request,
    weights: Option<PerDirection<PointNumbers>>,
    rational: Option<Rational>,
) -> OrErrors<()> {
    let before = Rational::of(request);
    let kind = rational.or(before);
    if before.is_some() && kind != before {
        let detail = "the weights of a fit stay homogeneous or fixed, as those of its parent";
        return Err(ValidationError::at(SpecPart::Rational, detail).into());
    }
    let Some(weights) = weights else {
        return check_unused(rational);
    };
    let resolved = Resolved::new(weights, kind, request.grid, request.v.is_some())?;
    // Single ones may change next.
    if let Weights::Homogeneous(weights) = &resolved.weights {
        let (given, expected) = (weights.len(), request.grid.count());
        if given != expected {
            let error = Invalid::weight_count(given, expected);
            return Err(
                ValidationError::at(SpecPart::Fit(fit::Place::Weights), error.to_string()).into(),
            );
        }
    }
    request.weights = resolved.weights;
    request.u.weights = resolved.u;
    if let Some(v) = &mut request.v {
        v.weights = resolved.v;
    }
    Ok(())
}

/// The parent's control points. Where data points get other weights, so do their control points, without moving: the
/// old weights would interpolate the data as well, and be kept.
fn start(parent: &ParentFit<'_>, request: &Request) -> OrErrors<Arc<Points>> {
    let ParentFit {
        problem,
        control_points,
        ..
    } = parent;
    let Weights::Homogeneous(new) = &request.weights else {
        return Ok(Arc::clone(control_points));
    };
    let ones = vec![1.0; request.grid.count()];
    let old = match &problem.request().weights {
        Weights::Homogeneous(old) => old,
        _ => &ones,
    };
    if old == new && problem.is_homogeneous() {
        return Ok(Arc::clone(control_points));
    }
    if control_points.len() != old.len() {
        let detail = "the control points of a least-squares fit do not belong to single data points, so that its weights cannot be edited: post a new job";
        return Err(ValidationError::at(SpecPart::Fit(fit::Place::Weights), detail).into());
    }
    let mut lanes = control_points.lanes().to_vec();
    if !problem.is_homogeneous() {
        lanes.push(ones.as_slice().into());
    }
    for lane in &mut lanes {
        for (x, (new, old)) in lane.iter_mut().zip(new.iter().zip(old)) {
            *x *= new / old;
        }
    }
    Ok(Arc::new(Points::from_lanes(lanes)))
}

/// The initial knots of a fit that chooses its knots: those of its parent.
fn start_breaks(parent: &ParentFit<'_>, request: &Request) -> OrErrors<Option<Vec<Arc<Vec<f64>>>>> {
    if !request.places_knots() {
        return Ok(None);
    }
    let breaks = parent.problem.breaks();
    breaks.map(Some).ok_or_else(other_basis)
}

/// Refuses a method with other bases.
fn check_bases(problem: &Problem, parent: &Problem) -> OrErrors<()> {
    let bases = problem.directions().map(|direction| &direction.basis);
    if bases.eq(parent.directions().map(|direction| &direction.basis)) {
        return Ok(());
    }
    Err(other_basis())
}

fn other_basis() -> ValidationErrors {
    let detail = "the fit would have another basis than its parent, whose control points mean nothing in it: post a new job";
    ValidationError::at(SpecPart::Fit(fit::Place::Method), detail).into()
}

/// The location in an edit of a part of the problem, which has changed these points by these entries.
fn in_edit(place: fit::Place, changed: &HashMap<usize, usize>) -> SpecPart {
    use fit::Place as P;
    let entry = |index, part| changed.get(&index).map(|k| SpecPart::Change(*k, part));
    match place {
        P::Point(index) => entry(index, ChangePart::Whole).unwrap_or(SpecPart::Whole),
        P::Weight(index) => entry(index, ChangePart::Weight).unwrap_or(SpecPart::Fit(place)),
        P::AxisWeights(_) | P::AxisWeight(..) => SpecPart::Fit(P::Weights),
        // The unchanged parts of an edit were valid in the parent.
        P::Section(_)
        | P::Line(..)
        | P::Degree(_)
        | P::Basis(_)
        | P::Knots(_)
        | P::Knot(..)
        | P::Parameters(_)
        | P::Parameter(..)
        | P::Closed(_) => SpecPart::Whole,
        place => SpecPart::Fit(place),
    }
}
