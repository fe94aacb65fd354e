//! A requested surface.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use super::basis::{Basis, Degree, ParametersInput};
use super::corners::Creases;
use super::ends::{DirectionEnds, EndsInput, SurfaceEnds};
use super::errors::{ValidationError, ValidationErrors};
use super::heights::Placement;
use super::lists::PointNumbers;
use super::numbers::{ScatteredPoints, SurfaceWeights};
use super::per_direction::PerDirection;
use super::points::{PointGrid, PointList, SectionList};
use super::scattered::{FootPoints, SurfaceParameters};
use super::schema;
use super::serde_helpers::{Whole, object};
use super::shape::{DirectionInput, check_degree, problem, resolved};
use super::trim::TrimInput;
use super::weights::{self, Rational};
use piad_fit::data::Grid;
use piad_fit::engine::{DirectionChoice, Request};
use piad_fit::invalid::Axis;
use piad_fit::parameters::{Parametrization, Scattered, Sections};

/// A surface through a grid of data points, through sections, or near scattered points, which only least squares fits: one
/// of `points`, `sections` and `scattered` is given. `basis`, `parameters` and `closed` are one value for both
/// directions, or one for each.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_surface())]
pub(crate) struct SurfaceInput {
    /// Rows (u) of columns (v) of data points, or of heights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<PointGrid>,
    /// Heights alone: the steps from column to column along x and from row to row along y, in the units of the heights.
    /// They become points [x, y, z] with it, so that the surface has a place in space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<[f64; 2]>,
    /// With `spacing`: x and y of the first height.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = [0, 0]))]
    pub origin: Option<[f64; 2]>,
    /// Points without rows and columns, for least-squares fits; `parameters` says where each of them is.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<ScatteredPoints>")]
    pub scattered: Option<PointList>,
    /// Curves across the surface: u goes from one to the next, and v along them. They are scattered points whose
    /// `parameters` are `{"sections": […]}`, the number of points of each. Closed sections may start anywhere and go either
    /// way around; without `closed` they are those whose ends are near each other in all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sections: Option<SectionList>,
    /// The bases; without them cubic B-splines, of few sections ones of a lower degree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub basis: Option<PerDirection<Basis>>,
    /// Short for B-splines of this degree, instead of `basis`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<PerDirection<Degree>>")]
    pub degree: Option<PerDirection<Whole>>,
    /// The parameters of the data points; of a grid without them `chord_length`, of heights `uniform`.
    /// Scattered points need them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<SurfaceParameters>,
    /// Weights of the data points, for a rational surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<SurfaceWeights>")]
    pub weights: Option<PerDirection<PointNumbers>>,
    /// True if the directions are periodic.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = false))]
    pub closed: Option<PerDirection<bool>>,
    /// The creases of a surface through a grid of points; default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub creases: Option<Creases>,
    /// The end conditions; one value for both directions, or one for each that is not closed.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "given_ends")]
    #[schemars(with = "Option<SurfaceEnds>")]
    pub ends: Option<PerDirection<DirectionEnds>>,
    /// The trimming to the outline of its data; default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trim: Option<TrimInput>,
}

object!(SurfaceInput, "an object with points");

/// Writes the ends of the directions that have some.
fn given_ends<S: Serializer>(
    ends: &Option<PerDirection<DirectionEnds>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match ends {
        Some(PerDirection::Each { u, v }) => {
            let each = [("u", u), ("v", v)];
            serializer.collect_map(each.into_iter().filter(|(_, ends)| ends.0.is_some()))
        }
        ends => ends.serialize(serializer),
    }
}

/// The data points of a surface, and the rule for their parameters.
struct SurfaceData {
    points: PointGrid,
    /// The rule for scattered points; that of foot points is not resolved yet.
    scattered: Option<Scattered>,
    /// The rule for a grid.
    parameters: Option<PerDirection<ParametersInput>>,
}

impl SurfaceData {
    fn new(
        points: Option<PointGrid>,
        scattered: Option<PointList>,
        parameters: Option<SurfaceParameters>,
    ) -> Result<Self, ValidationError> {
        use SurfaceParameters as P;
        let wrong =
            |place: &str, detail| Err(ValidationError::at_text(format!("/surface{place}"), detail));
        let (points, scattered, parameters) = match (points, scattered, parameters) {
            (Some(_), Some(_), _) => {
                return wrong(
                    "/scattered",
                    "the surface has points in a grid, so it cannot have scattered ones as well",
                );
            }
            (None, None, _) => {
                return wrong(
                    "",
                    "the field \"points\" is missing, or \"scattered\" ones, or \"sections\"",
                );
            }
            (Some(_), None, Some(P::Scattered(_) | P::FootPoints(_))) => {
                return wrong(
                    "/parameters",
                    "pairs, projections and foot points are parameters of scattered points; rows and columns have rules or lists of numbers",
                );
            }
            (None, Some(_), Some(P::Grid(_))) => {
                return wrong(
                    "/parameters",
                    "scattered points have no rows and columns: their parameters are [[u, v], …], \"auto\", \"project\", {\"project\": \"xy\"} or {\"foot_points\": {\"job\": …}}",
                );
            }
            (Some(points), None, Some(P::Grid(parameters))) => (points, None, Some(parameters)),
            (Some(points), None, None) => (points, None, None),
            (None, Some(points), Some(P::Scattered(it))) => (points.into(), Some(it), None),
            (None, Some(points), None) => (points.into(), Some(Scattered::Auto), None),
            (None, Some(points), Some(P::FootPoints(_))) => (points.into(), None, None),
        };
        Ok(Self {
            points,
            scattered,
            parameters,
        })
    }
}

impl SurfaceInput {
    /// The arrangement of its points, if there are any.
    pub(crate) fn grid(&self) -> Option<Grid> {
        let sections = self.sections.as_ref().map(|it| &it.points);
        let scattered = self.scattered.as_ref().or(sections).map(PointList::grid);
        let points = self.points.as_ref().map(|points| points.grid);
        points.or(scattered)
    }

    /// The same with sections as scattered points, and with their defaults.
    fn with_sections_scattered(mut self) -> Result<Self, ValidationError> {
        let wrong = |detail| Err(ValidationError::at_text("/surface/sections", detail));
        if let Some(SectionList { points, counts }) = self.sections.take() {
            if self.points.is_some() || self.scattered.is_some() {
                return wrong("the surface has other points, so it cannot have sections as well");
            }
            if self.parameters.is_some() {
                return wrong("sections have parameters of their own: leave parameters out");
            }
            self.scattered = Some(points);
            let sections = Scattered::Sections(Sections::new(counts));
            self.parameters = Some(SurfaceParameters::Scattered(sections));
        }
        if let Some(SurfaceParameters::Scattered(Scattered::Sections(sections))) =
            &mut self.parameters
        {
            let closed = self.closed.map(PerDirection::split);
            sections.closed = closed.map(|(_, v)| v).or(sections.closed);
            if self.degree.is_none() {
                let (u, v) = self.basis.map(PerDirection::split).unwrap_or_default();
                let [p, q] = sections.usual_degrees();
                let (u, v) = (u.or_degree(p), v.or_degree(q));
                self.basis = Some(PerDirection::Each { u, v });
            }
        }
        Ok(self)
    }

    /// The surface of another job on which scattered points have their foot points.
    pub(super) fn base(&self) -> Option<&FootPoints> {
        match &self.parameters {
            Some(SurfaceParameters::FootPoints(base)) => Some(base),
            _ => None,
        }
    }

    /// The problem of fitting it, also if there are errors outside the points; foot points get their parameters later.
    pub(super) fn request(
        self,
        rational: Option<Rational>,
        errors: &mut ValidationErrors,
    ) -> Option<Request> {
        let surface = errors.keep(self.with_sections_scattered())?;
        surface.scattered_request(rational, errors)
    }

    /// The same where sections are scattered points.
    fn scattered_request(
        self,
        rational: Option<Rational>,
        errors: &mut ValidationErrors,
    ) -> Option<Request> {
        let is_scattered = self.scattered.is_some();
        let placement = errors.keep(Placement::new(self.spacing, self.origin, is_scattered))?;
        let data = SurfaceData::new(self.points, self.scattered, self.parameters);
        let SurfaceData {
            points: given,
            scattered,
            parameters,
        } = errors.keep(data)?;
        let grid = given.grid;
        let weights = resolved(self.weights, rational, (grid, true), errors);
        check_degree(
            self.degree.is_some() && self.basis.is_some(),
            "/surface",
            errors,
        );
        let of_degree = |Whole(degree)| Basis::of_degree(degree);
        let bases = self
            .basis
            .or(self.degree.map(|degree| degree.map(of_degree)));
        let (basis_u, basis_v) = bases.map(PerDirection::split).unzip();
        let (parameters_u, parameters_v) = parameters.map(PerDirection::split).unzip();
        let (closed_u, closed_v) = self.closed.map(PerDirection::split).unzip();
        let (ends_u, ends_v) = self.ends.map(PerDirection::split).unzip();
        let u = DirectionInput {
            basis: basis_u,
            parameters: parameters_u,
            closed: closed_u,
            ends: ends_u.and_then(|ends| ends.0),
        };
        let v = DirectionInput {
            basis: basis_v,
            parameters: parameters_v,
            closed: closed_v,
            ends: ends_v.and_then(|ends| ends.0),
        };
        // Heights have the parameters of heights, wherever they are.
        let usual = || Parametrization::usual_of_surface(&given.points);
        let u = u.choice(Axis::U, usual(), true, errors);
        let v = v.choice(Axis::V, usual(), true, errors);
        let (mut u, mut v) = u.zip(v)?;
        [u.corners, v.corners] = self.creases.unwrap_or_default().corners();
        let is_closed = u.closed || v.closed;
        let placed = match placement {
            None => given,
            Some(placement) => errors.keep(placement.points(given, is_closed))?,
        };
        Some(Request {
            missing: placed.missing,
            scattered,
            trim: self.trim.and_then(|TrimInput(trim)| trim),
            ..problem(placed.points, grid, (u, Some(v)), weights)
        })
    }

    /// The surface of a problem with these directions in the form of a request.
    pub(super) fn of(request: &Request, v: &DirectionChoice) -> Self {
        let u = &request.u;
        let points = Arc::clone(&request.points);
        let ends = |choice: &DirectionChoice| {
            let ends = choice.ends.as_ref();
            DirectionEnds(ends.map(|it| EndsInput::of(it, true)))
        };
        let parameters = || {
            let [u, v] = [u, v].map(|it| ParametersInput(it.parameters.clone()));
            PerDirection::of(u, Some(v))
        };
        // Without a setting, sections are closed where their ends are near each other.
        let is_decided = match &request.scattered {
            Some(Scattered::Sections(sections)) => sections.closed.is_some(),
            _ => true,
        };
        let (points, scattered, parameters) = match &request.scattered {
            None => {
                let points = PointGrid {
                    points,
                    missing: request.missing.clone(),
                    grid: request.grid,
                };
                (Some(points), None, SurfaceParameters::Grid(parameters()))
            }
            Some(scattered) => {
                let parameters = SurfaceParameters::Scattered(scattered.clone());
                (None, Some(PointList(points)), parameters)
            }
        };
        let has_ends = u.ends.is_some() || v.ends.is_some();
        Self {
            points,
            scattered,
            sections: None,
            basis: Some(PerDirection::of(
                Basis::from(&u.basis),
                Some(Basis::from(&v.basis)),
            )),
            degree: None,
            parameters: Some(parameters),
            weights: weights::requested(request),
            closed: is_decided.then(|| PerDirection::of(u.closed, Some(v.closed))),
            creases: Creases::of(u, v),
            spacing: None,
            origin: None,
            ends: has_ends.then(|| PerDirection::of(ends(u), Some(ends(v)))),
            trim: request.trim.map(|trim| TrimInput(Some(trim))),
        }
    }
}
