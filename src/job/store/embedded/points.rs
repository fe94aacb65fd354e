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
        let count = self.coordinates.len().checked_div(dimension).unwrap_or(0);
        if count == 0 || count * dimension != self.coordinates.len() {
            return Err(damaged("coordinates are missing"));
        }
        let lanes = self.coordinates.chunks(count);
        Ok(Points::from_lanes(lanes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_coordinates_all_of_them_as_many() {
        let read = |dimension, coordinates: &[f64]| {
            let coordinates = coordinates.to_vec();
            let message = PointsMessage {
                dimension,
                coordinates,
            };
            message.into_points().map(|points| points.len())
        };
        assert_eq!(read(2, &[1.0, 2.0, 3.0, 4.0]).unwrap(), 2);
        for (dimension, coordinates) in [(0, &[][..]), (2, &[]), (0, &[1.0]), (2, &[1.0; 3])] {
            assert!(read(dimension, coordinates).is_err(), "{dimension}");
        }
    }
}
