//! The JSON of an edit, and its way from the parent's problem to a new one.

use std::collections::HashSet;
use std::sync::Arc;

use schemars::JsonSchema;

use super::invalid::invalid;
use super::iteration::IterationRequest;
use super::job::{LONGEST_NAME, ValidJob, check_name, fitting_stream};
use super::method::MethodRequest;
use super::mistakes::Mistakes;
use super::schema;
use super::settings::Index;
use super::stop::StopRequest;
use super::weights::{RationalRequest, no_weights, surface_weights};
use crate::api::json::numbers::{Coordinates, WeightList};
use crate::api::json::per_direction::PerDirection;
use crate::api::json::read::values::{Element, Number};
use crate::api::json::read::{Limits, object};
use crate::api::json::schema::numbers::{NewWeights, Point};
use crate::api::problem::Problem;
use crate::api::stream::options;
use crate::config::Config;
use crate::fit::invalid::{Invalid, Place};
use crate::fit::points::Points;
use crate::fit::problem::{self as fit, Weights};
use crate::model::stream::StreamSpec;

/// Changes of a fit. Whatever is not given stays as it is; one of `points`, `weights`, `rational`,
/// `method` and `stop` is given.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(example = schema::example_edit())]
pub struct EditRequest {
    /// A name of the new job.
    #[schemars(length(max = LONGEST_NAME), example = &"wing section, thicker")]
    pub(in crate::api) name: Option<String>,
    /// The iteration of the parent to start from.
    pub(in crate::api) iteration: Option<IterationRequest>,
    /// Data points that go elsewhere or get another weight; none twice.
    pub(in crate::api) points: Option<Vec<Move>>,
    /// New weights of all data points.
    #[schemars(with = "Option<NewWeights>")]
    pub(in crate::api) weights: Option<PerDirection<WeightList>>,
    /// How the weights are used. It stays as it is where there were weights before.
    pub(in crate::api) rational: Option<RationalRequest>,
    /// Another method.
    pub(in crate::api) method: Option<MethodRequest>,
    /// Other rules when the iteration ends.
    pub(in crate::api) stop: Option<StopRequest>,
    /// What the event streams are like; without it as those of the parent.
    pub(in crate::api) stream: Option<StreamSpec>,
}

/// A data point that goes elsewhere, gets another weight, or both.
#[derive(Debug, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[schemars(example = schema::example_move())]
pub(in crate::api) struct Move {
    /// Which data point.
    pub(in crate::api) index: Index,
    /// Where it goes.
    #[schemars(with = "Option<Point>")]
    pub(in crate::api) point: Option<Coordinates>,
    /// Its new weight, in homogeneous fits.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) weight: Option<Number>,
}

object!(
    EditRequest,
    "an object",
    [
        name, iteration, points, weights, rational, method, stop, stream
    ]
);
object!(
    Move,
    "an object with an index and a point or a weight",
    [index, point, weight]
);

impl Element for Move {
    const MANY: &'static str = "points";

    fn most(limits: Limits) -> usize {
        limits.points
    }
}

impl EditRequest {
    /// The level of the parent to start from; without one, its last.
    pub fn iteration(&self) -> Option<usize> {
        self.iteration.and_then(|IterationRequest(k)| k)
    }

    /// Streams go as those of the parent, unless the edit says it.
    pub fn inherit(&mut self, stream: Option<&StreamSpec>) {
        self.stream = self.stream.take().or(stream.cloned());
    }

    /// The problem with the changes, starting from the parent's control points. `lambda_min` is what
    /// is known of the parent's collocation matrix.
    pub fn apply(
        self,
        parent: &fit::Problem,
        control_points: &Arc<Points>,
        lambda_min: Option<f64>,
        config: &Config,
    ) -> Result<ValidJob, Problem> {
        let mut mistakes = Mistakes::default();
        mistakes.keep(check_name(self.name.as_deref()));
        if self.points.as_ref().is_none_or(Vec::is_empty)
            && self.weights.is_none()
            && self.rational.is_none()
            && self.method.is_none()
            && self.stop.is_none()
        {
            let detail = "an edit changes something: points, weights, method or stop";
            mistakes.keep::<()>(Err(invalid("", detail)));
        }
        let mut request = parent.restated();
        let moved = self.points.unwrap_or_default();
        let mut places = EditPlaces {
            surface: request.v.is_some(),
            columns: request.grid.columns,
            moved: Vec::with_capacity(moved.len()),
            control_points_each: false,
            transform_each: false,
        };
        let mut seen = HashSet::with_capacity(moved.len());
        let mut placed = HashSet::new();
        let rational = self.rational;
        // Fixed weights are a part of the basis.
        let same_matrix = self.weights.is_none() || rational == Some(RationalRequest::Homogeneous);
        request.lambda_min = lambda_min.filter(|_| same_matrix);
        mistakes.keep(set_weights(&mut request, self.weights, rational));
        for (k, change) in moved.into_iter().enumerate() {
            let goes = change.point.is_some();
            if mistakes.full() {
                break;
            }
            let Some(index) = mistakes.keep(change.apply(k, &mut request)) else {
                continue;
            };
            if !seen.insert(index) {
                let detail = "this point has been moved before, by the same edit";
                mistakes.keep::<()>(Err(invalid(&format!("/points/{k}/index"), detail)));
            }
            places.moved.push(index);
            if goes {
                placed.insert(index);
            }
        }
        request.missing.retain(|index| !placed.contains(index));
        if let Some(method) = self.method {
            places.control_points_each = method.has_control_points_each();
            places.transform_each = method.has_transform_each();
            let method = method.method(request.grid, request.v.is_some());
            if let Some((method, selected)) = mistakes.keep(method) {
                (request.method, request.selected) = (method, selected);
            }
        }
        let rules = self.stop.map(|stop| stop.rules(config.max_iterations));
        if let Some(rules) = mistakes.keep(rules.transpose()).flatten() {
            (request.tolerance, request.max_iterations) = rules;
        }
        let stream = self.stream.as_ref();
        let stream = stream.map(|it| options::check(it, places.surface));
        mistakes.keep(stream.transpose().map_err(Problem::from));
        if !mistakes.none() {
            return Err(mistakes.problem());
        }
        request.start = Some(start(parent, &request, control_points)?);
        let problem = mistakes.fit(request, |error| places.pointer(error));
        let Some(problem) = problem.filter(|_| mistakes.none()) else {
            return Err(mistakes.problem());
        };
        let bases = |problem: &fit::Problem| -> Vec<_> {
            let bases = problem
                .directions()
                .map(|direction| direction.basis.clone());
            bases.collect()
        };
        if bases(&problem) != bases(parent) {
            let detail = "the fit would have another basis than its parent, whose control points mean nothing in it: post a new job";
            return Err(invalid("/method", detail));
        }
        Ok(ValidJob {
            name: self.name,
            stream: fitting_stream(self.stream, &problem)?,
            problem,
        })
    }
}

impl Move {
    /// Puts the point elsewhere; gives its index.
    fn apply(self, k: usize, request: &mut fit::Request) -> Result<usize, Problem> {
        let wrong =
            |field: &str, detail: String| Err(invalid(&format!("/points/{k}{field}"), detail));
        let surface = request.v.is_some();
        let index = match self.index.of_point(request.grid, surface) {
            Ok(index) if index < request.grid.count() => index,
            Ok(index) => {
                let count = request.grid.count();
                return wrong(
                    "/index",
                    format!("{index} is not one of the {count} points"),
                );
            }
            Err(detail) => return wrong("/index", detail),
        };
        if self.point.is_none() && self.weight.is_none() {
            return wrong("", "a point or a weight is needed".to_owned());
        }
        let weights = match &mut request.weights {
            Weights::Homogeneous(weights) => Some(weights),
            _ => None,
        };
        match (self.weight, weights) {
            (None, _) => {}
            (Some(Number(weight)), Some(weights)) => weights[index] = weight,
            (Some(_), None) => {
                let detail = "only points of homogeneous fits have weights of their own";
                return wrong("/weight", detail.to_owned());
            }
        }
        if let Some(point) = self.point {
            let dimension = request.points.dimension();
            let point = point.as_slice();
            if point.len() != dimension {
                let given = point.len();
                let detail =
                    format!("{given} coordinates, but the points of this fit have {dimension}");
                return wrong("/point", detail);
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
    request: &mut fit::Request,
    weights: Option<PerDirection<WeightList>>,
    rational: Option<RationalRequest>,
) -> Result<(), Problem> {
    let before = if matches!(request.weights, Weights::Homogeneous(_)) {
        Some(RationalRequest::Homogeneous)
    } else if request.u.weights.is_some() || matches!(request.weights, Weights::FixedGrid(_)) {
        Some(RationalRequest::Fixed)
    } else {
        None
    };
    let kind = rational.or(before);
    if before.is_some() && kind != before {
        let detail = "the weights of a fit stay homogeneous or fixed, as those of its parent";
        return Err(invalid("/rational", detail));
    }
    let Some(weights) = weights else {
        return match rational {
            None => Ok(()),
            Some(_) => Err(no_weights()),
        };
    };
    if let Some(v) = &mut request.v {
        let (weights, fixed) = surface_weights(Some(weights), kind, request.grid, "/weights")?;
        request.weights = weights;
        (request.u.weights, v.weights) = fixed.unzip();
        return Ok(());
    }
    let PerDirection::Both(WeightList::Line(weights)) = weights else {
        let detail = "the weights of a curve are a list of numbers";
        return Err(invalid("/weights", detail));
    };
    if kind == Some(RationalRequest::Fixed) {
        request.u.weights = Some(weights);
        return Ok(());
    }
    // Single ones may change next.
    let (given, expected) = (weights.len(), request.grid.count());
    if given != expected {
        let error = Invalid::WeightCount { given, expected };
        return Err(invalid("/weights", error.to_string()));
    }
    request.weights = Weights::Homogeneous(weights);
    Ok(())
}

/// The parent's control points. Where data points get other weights, so do their control points,
/// which stay where they are: the old weights would go through the data as well, and be kept.
fn start(
    parent: &fit::Problem,
    request: &fit::Request,
    control_points: &Arc<Points>,
) -> Result<Arc<Points>, Problem> {
    let Weights::Homogeneous(new) = &request.weights else {
        return Ok(Arc::clone(control_points));
    };
    let ones = vec![1.0; request.grid.count()];
    let old = match &parent.request().weights {
        Weights::Homogeneous(old) => old,
        _ => &ones,
    };
    if old == new && parent.is_homogeneous() {
        return Ok(Arc::clone(control_points));
    }
    if control_points.len() != old.len() {
        let detail = "the control points of a least-squares fit do not belong to single data points, so that its weights cannot be edited: post a new job";
        return Err(invalid("/weights", detail));
    }
    let mut lanes = control_points.lanes().to_vec();
    if !parent.is_homogeneous() {
        lanes.push(ones.as_slice().into());
    }
    for lane in &mut lanes {
        for (x, (new, old)) in lane.iter_mut().zip(new.iter().zip(old)) {
            *x *= new / old;
        }
    }
    Ok(Arc::new(Points::from_lanes(lanes)))
}

/// Where in an edit the parts of a problem stand.
struct EditPlaces {
    surface: bool,
    columns: usize,
    /// The points that are moved, in the order of the edit.
    moved: Vec<usize>,
    control_points_each: bool,
    transform_each: bool,
}

impl EditPlaces {
    fn pointer(&self, error: &Invalid) -> String {
        match error.place() {
            Place::Point(index) => self.entry(index),
            Place::Weight(index) => match self.entry(index) {
                entry if entry.is_empty() && self.surface => {
                    format!("/weights/{}/{}", index / self.columns, index % self.columns)
                }
                entry if entry.is_empty() => format!("/weights/{index}"),
                entry => format!("{entry}/weight"),
            },
            Place::Points => "/points".to_owned(),
            Place::Weights | Place::AxisWeights(_) | Place::AxisWeight(..) => "/weights".to_owned(),
            Place::Method => "/method".to_owned(),
            Place::Setting(setting) => format!("/method/{}", setting.name()),
            place @ (Place::Transform(_) | Place::TransformRow(..) | Place::TransformEntry(..)) => {
                super::places::transform(place, self.transform_each)
            }
            Place::Index(index) => format!("/method/indices/{index}"),
            Place::ControlPoints(axis) => format!(
                "/method/control_points{}",
                super::places::direction(self.control_points_each, axis)
            ),
            Place::Tolerance => "/stop/tolerance".to_owned(),
            Place::RelativeTolerance => "/stop/relative_tolerance".to_owned(),
            // Of what cannot be edited nothing can be wrong by an edit.
            _ => String::new(),
        }
    }

    /// The entry that moves a point.
    fn entry(&self, index: usize) -> String {
        let place = self.moved.iter().position(|&moved| moved == index);
        place.map_or(String::new(), |k| format!("/points/{k}"))
    }
}
