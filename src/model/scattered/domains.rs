//! The extents of the directions of explicit parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::model::serde_helpers::object;
use piad_fit::parameters::Domain;

/// The extents of the directions of pairs, if these do not end at the data.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "ParameterDomains")]
#[schemars(example = json!({"u": {"period": 94.2}}))]
pub(super) struct Domains {
    /// The extent of u; default: from the least to the largest parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    u: Option<DomainInput>,
    /// The extent of v.
    #[serde(skip_serializing_if = "Option::is_none")]
    v: Option<DomainInput>,
}

object!(Domains, "an object with u or v");

/// The extent of a direction: a period, or both ends.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(remote = "Self", deny_unknown_fields)]
#[schemars(rename = "ParameterDomain")]
#[schemars(example = json!({"ends": [-39.3, 39.3], "poles": [true, true]}))]
pub(super) struct DomainInput {
    /// The direction is closed, and repeats after this length.
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    /// The ends of the direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    ends: Option<[f64; 2]>,
    /// Of v: the ends that are poles, at which all control points coincide. With `control_points`
    /// "auto".
    #[serde(skip_serializing_if = "Option::is_none")]
    poles: Option<[bool; 2]>,
}

object!(DomainInput, "an object with a period or with ends");

impl DomainInput {
    fn domain(self) -> Result<Domain, &'static str> {
        match (self.period, self.ends, self.poles) {
            (None, None, None) => Ok(Domain::Data),
            (Some(period), None, None) => Ok(Domain::Closed(period)),
            (None, Some(ends), poles) => Ok(Domain::Between {
                ends,
                poles: poles.unwrap_or_default(),
            }),
            (Some(_), ..) => Err("a direction with a period has neither ends nor poles"),
            (None, None, Some(_)) => Err("poles are at ends: give both ends"),
        }
    }

    fn of(domain: Domain) -> Option<Self> {
        match domain {
            Domain::Data => None,
            Domain::Closed(period) => Some(Self {
                period: Some(period),
                ..Self::default()
            }),
            Domain::Between { ends, poles } => Some(Self {
                ends: Some(ends),
                poles: (poles != [false; 2]).then_some(poles),
                ..Self::default()
            }),
        }
    }
}

impl Domains {
    pub(super) fn domains(self) -> Result<[Domain; 2], &'static str> {
        let [u, v] = [self.u, self.v].map(|it| it.unwrap_or_default().domain());
        Ok([u?, v?])
    }

    pub(super) fn of([u, v]: [Domain; 2]) -> Self {
        let [u, v] = [u, v].map(DomainInput::of);
        Self { u, v }
    }
}
