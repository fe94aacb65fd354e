//! Points as protobuf messages.

use prost::Message;

use super::super::StoreError;
use super::error::damaged;
use super::fields::number;
use crate::fit::points::Points;

/// Points, coordinate by coordinate.
#[derive(Clone, PartialEq, Message)]
pub(super) struct PointsMessage {
    #[prost(uint32, tag = "1")]
    dimension: u32,
    #[prost(double, repeated, tag = "2")]
    coordinates: Vec<f64>,
}

impl PointsMessage {
    /// Points as a message.
    pub(super) fn new(points: &Points) -> Self {
        Self {
            dimension: u32::try_from(points.dimension()).unwrap_or(u32::MAX),
            coordinates: points.lanes().concat(),
        }
    }

    /// The points of a message.
    pub(super) fn into_points(self) -> Result<Points, StoreError> {
        let dimension = number(self.dimension.into())?;
        if dimension == 0 || !self.coordinates.len().is_multiple_of(dimension) {
            return Err(damaged("coordinates are missing"));
        }
        let lanes = self.coordinates.chunks(self.coordinates.len() / dimension);
        Ok(Points::from_lanes(lanes))
    }
}
