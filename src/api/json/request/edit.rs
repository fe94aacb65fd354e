//! The JSON of an edit.

use bytes::Bytes;
use schemars::JsonSchema;
use serde::Deserialize;

use super::iteration::IterationRequest;
use super::method::MethodRequest;
use super::places::Places;
use super::schema;
use super::settings::Index;
use super::shape::weights;
use super::stop::StopRequest;
use crate::api::json::lists::WeightList;
use crate::api::json::read::parse;
use crate::api::json::schema::numbers::{NewWeights, Point};
use crate::api::problem::Problem;
use crate::fit::points::Grid;
use crate::job::outline::Outline;
use crate::model::edit::{Coordinates, EditSpec, LONGEST_SESSION, PointChange};
use crate::model::either::{PerDirection, object};
use crate::model::job::LONGEST_NAME;
use crate::model::mistakes::{ChangePart, Mistake, SpecPart};
use crate::model::stop::StopSpec;
use crate::model::stream::StreamSpec;
use crate::model::weights::Rational;

/// Changes of a fit. Whatever is not given stays as it is; one of `points`, `weights`, `rational`,
/// `method` and `stop` is given.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
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
    pub(in crate::api) rational: Option<Rational>,
    /// Another method.
    pub(in crate::api) method: Option<MethodRequest>,
    /// Other rules when the iteration ends.
    pub(in crate::api) stop: Option<StopRequest>,
    /// What the event streams are like; without it as those of the parent.
    pub(in crate::api) stream: Option<StreamSpec>,
    /// The edit is one frame of a drag: it is streamed in the answer, neither stored nor listed, and ends
    /// with its connection.
    #[schemars(extend("default" = false))]
    pub(in crate::api) ephemeral: Option<bool>,
    /// Ephemeral edits: a name of the client's choice for the drag. An edit with it replaces the one
    /// before of the same parent and client.
    #[schemars(length(min = 1, max = LONGEST_SESSION), example = &"drag-17")]
    pub(in crate::api) session: Option<String>,
}

/// A data point that goes elsewhere, gets another weight, or both.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(example = schema::example_move())]
pub(in crate::api) struct Move {
    /// Which data point.
    pub(in crate::api) index: Index,
    /// Where it goes.
    #[schemars(with = "Option<Point>")]
    pub(in crate::api) point: Option<Coordinates>,
    /// Its new weight, in homogeneous fits.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::api) weight: Option<f64>,
}

object!(EditRequest, "an object");
object!(Move, "an object with an index and a point or a weight");

/// The edit of a job that a body asks for, and where its parts stand.
pub fn read(body: Bytes, parent: &Outline) -> Result<(EditSpec, Places), Problem> {
    let request: EditRequest = parse(&body)?;
    drop(body);
    Ok(request.spec(parent.grid, parent.surface))
}

impl EditRequest {
    fn spec(self, grid: Grid, surface: bool) -> (EditSpec, Places) {
        let places = Places {
            columns: (surface && grid.is_rows()).then_some(grid.columns),
            weights_each: true,
            method: self
                .method
                .as_ref()
                .map(MethodRequest::form)
                .unwrap_or_default(),
            ..Places::default()
        };
        let points = self.points.unwrap_or_default().into_iter().enumerate();
        let change = |(k, change): (usize, Move)| PointChange {
            index: change.index.of_point(grid, surface).map_err(|detail| {
                Mistake::at(SpecPart::Change(k, ChangePart::Index), detail).into()
            }),
            point: change.point,
            weight: change.weight,
        };
        let method = self.method.map(|method| method.spec(grid, surface));
        let spec = EditSpec {
            name: self.name,
            iteration: self.iteration.and_then(IterationRequest::number),
            ephemeral: self.ephemeral.unwrap_or(false),
            session: self.session,
            points: points.map(change).collect(),
            weights: weights(self.weights, surface),
            rational: Ok(self.rational),
            method: method.transpose(),
            stop: self.stop.map(StopSpec::from),
            stream: Ok(self.stream),
        };
        (spec, places)
    }
}
