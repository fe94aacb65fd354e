//! The last level of a job as it is kept: points, and after them the knots that a fit has chosen.

use std::sync::Arc;

use prost::Message;

use super::super::StoreError;
use super::error::damaged;
use super::points::PointsMessage;
use crate::fit::bases::Bases;
use crate::job::result::LastGeometry;

/// Knots, in the same message as the points, whose fields have the tags 1 and 2.
#[derive(Clone, PartialEq, Message)]
struct BasesMessage {
    #[prost(message, repeated, tag = "3")]
    breaks: Vec<Numbers>,
    #[prost(double, repeated, tag = "4")]
    parameters: Vec<f64>,
}

/// A list of numbers.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Numbers {
    #[prost(double, repeated, tag = "1")]
    values: Vec<f64>,
}

/// Lists as messages.
pub(super) fn numbers(lists: &[Arc<Vec<f64>>]) -> Vec<Numbers> {
    let message = |list: &Arc<Vec<f64>>| Numbers {
        values: list.to_vec(),
    };
    lists.iter().map(message).collect()
}

/// The lists of messages, if there are some.
pub(super) fn lists(messages: Vec<Numbers>) -> Option<Vec<Arc<Vec<f64>>>> {
    let lists = messages.into_iter().map(|it| Arc::new(it.values));
    let lists: Vec<_> = lists.collect();
    (!lists.is_empty()).then_some(lists)
}

/// The bytes of a last level.
pub(super) fn kept(result: &LastGeometry) -> Vec<u8> {
    let mut bytes = PointsMessage::new(&result.control_points).encode_to_vec();
    if let Some(bases) = &result.bases {
        let message = BasesMessage {
            breaks: numbers(&bases.breaks),
            parameters: bases
                .parameters
                .as_ref()
                .map_or(Vec::new(), |it| it.to_vec()),
        };
        bytes.extend(message.encode_to_vec());
    }
    bytes
}

/// The last level of some bytes.
pub(super) fn read(bytes: &[u8]) -> Result<LastGeometry, StoreError> {
    let points = PointsMessage::decode(bytes).map_err(damaged)?;
    let BasesMessage { breaks, parameters } = BasesMessage::decode(bytes).map_err(damaged)?;
    let bases = lists(breaks).map(|breaks| Bases {
        breaks,
        parameters: (!parameters.is_empty()).then(|| Arc::new(parameters)),
    });
    Ok(LastGeometry {
        control_points: points.into_points().map(Arc::new)?,
        bases: bases.map(Arc::new),
    })
}
