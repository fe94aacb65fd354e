//! The form of an iteration: its view, and the encoding of its numbers.

use std::sync::Arc;

use super::choices::{ChoiceError, Choices, Conflict};
use super::samples::not_samples;
use super::words::{self as chosen, Choice};
use piad_fit::data::Grid;
use piad_fit::engine::Problem;

pub(crate) use super::words::Digits;

const CURVE_SAMPLES: Grid = Grid {
    rows: 200,
    columns: 1,
};
const SURFACE_SAMPLES: Grid = Grid {
    rows: 40,
    columns: 40,
};

/// The largest coordinate that is sent in 32 bits. Control points go beyond the data, so this is
/// far below the largest number of 32 bits, 3.4e38.
const LARGEST_F32: f64 = 1e35;

/// The view of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// The complete control net.
    ControlPoints,
    /// The control points that have moved since the iteration before.
    Changed,
    /// Points of the curve or surface, this many in each direction.
    Samples(Grid),
    /// The distances from the data alone.
    Errors,
}

/// The encoding of arrays of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Lists of numbers.
    Json,
    /// Little-endian numbers of 64 bits in base64.
    Base64,
    /// Little-endian numbers of 32 bits in base64.
    Base64F32,
    /// Not JSON at all, but a protobuf message.
    Protobuf,
}

/// The form of an iteration on the wire.
#[derive(Clone, Debug)]
pub(crate) struct Form {
    /// The view.
    pub view: View,
    /// The encoding of arrays of numbers.
    pub encoding: Encoding,
    /// The precision of coordinates.
    pub digits: Digits,
    /// True if fits that choose their knots report them.
    pub knots: bool,
    key: Arc<str>,
}

impl Form {
    /// A form, with its key.
    pub(crate) fn new(view: View, encoding: Encoding, digits: Digits) -> Self {
        Self {
            view,
            encoding,
            digits,
            knots: false,
            key: format!("{:?}", (view, encoding, digits)).into(),
        }
    }

    /// The form that was chosen for a curve or a surface.
    pub(super) fn of(choices: Choices<'_>, surface: bool) -> Result<Self, ChoiceError> {
        let view = view(choices, surface)?;
        let encoding = match choices.get(|spec| spec.encoding) {
            None | Some(chosen::Encoding::Json) => Encoding::Json,
            // The form of complete events.
            Some(chosen::Encoding::Base64 | chosen::Encoding::Delta) => Encoding::Base64,
            Some(chosen::Encoding::Base64F32) => Encoding::Base64F32,
        };
        let digits = choices.get(|spec| spec.digits).unwrap_or(Digits::Full);
        let errors = view == View::Errors;
        let binary = encoding != Encoding::Json;
        let rounded = digits == Digits::Auto;
        let conflicts: [Conflict; 3] = [
            (
                errors && binary,
                Choice::Encoding,
                Choice::View,
                "there are no arrays of numbers without geometry",
            ),
            (
                errors && rounded,
                Choice::Digits,
                Choice::View,
                "there are no coordinates to be rounded without geometry",
            ),
            (
                binary && rounded,
                Choice::Digits,
                Choice::Encoding,
                "rounding makes decimal numbers shorter, but not binary ones",
            ),
        ];
        choices.refuse(&conflicts)?;
        Ok(Self::new(view, encoding, digits))
    }

    /// Identifies the form: content made in one form is shared by all readers of that form.
    pub(crate) fn key(&self) -> &Arc<str> {
        &self.key
    }

    /// The same with numbers of 32 bits in base64.
    pub(crate) fn in_32_bits(&self) -> Self {
        let narrow = Self::new(self.view, Encoding::Base64F32, self.digits);
        if self.knots {
            narrow.with_knots()
        } else {
            narrow
        }
    }

    /// The same as a protobuf message, in which numbers are written in one way only.
    pub(crate) fn in_protobuf(&self) -> Self {
        Self::new(self.view, Encoding::Protobuf, Digits::Full)
    }

    /// Returns true if it is a protobuf message.
    pub(crate) fn is_protobuf(&self) -> bool {
        self.encoding == Encoding::Protobuf
    }

    /// The same with all digits.
    pub(crate) fn in_full(&self) -> Self {
        let full = Self::new(self.view, self.encoding, Digits::Full);
        if self.knots { full.with_knots() } else { full }
    }

    /// The same with the knots of fits that choose them.
    pub(crate) fn with_knots(&self) -> Self {
        Self {
            knots: true,
            key: format!("{} with knots", self.key).into(),
            ..self.clone()
        }
    }
}

/// The view that was chosen, with its number of samples.
fn view(choices: Choices<'_>, surface: bool) -> Result<View, ChoiceError> {
    let usual = match surface {
        false => CURVE_SAMPLES,
        true => SURFACE_SAMPLES,
    };
    let view = match choices.get(|spec| spec.view) {
        None | Some(chosen::View::ControlPoints) => View::ControlPoints,
        Some(chosen::View::Samples) => View::Samples(usual),
        Some(chosen::View::Errors) => View::Errors,
    };
    match (view, choices.get(|spec| spec.samples)) {
        (_, None) => Ok(view),
        (View::Samples(_), Some(samples)) => {
            samples.grid(surface).map(View::Samples).ok_or_else(|| {
                choices.error(Choice::Samples, not_samples(&samples.to_string(), surface))
            })
        }
        // A number of samples that the job sets applies only to this view.
        (_, Some(_)) if choices.is_default_for(Choice::Samples, Choice::View) => Ok(view),
        (_, Some(_)) => {
            let detail = "it is given, but the view is not samples: add view=samples";
            Err(choices.error(Choice::Samples, detail))
        }
    }
}

/// Refuses 32-bit numbers that cannot hold the data.
pub(super) fn check_range(choices: Choices<'_>, problem: &Problem) -> Result<(), ChoiceError> {
    if choices.get(|spec| spec.encoding) != Some(chosen::Encoding::Base64F32) {
        return Ok(());
    }
    let mut coordinates = coordinates(problem);
    let smallest = f64::from(f32::MIN_POSITIVE);
    let magnitude = if coordinates.clone().any(|x| x.abs() > LARGEST_F32) {
        "large"
    } else if coordinates.clone().all(|x| x.abs() < smallest) && coordinates.any(|x| x != 0.0) {
        "small"
    } else {
        return Ok(());
    };
    let detail = format!(
        "the coordinates of the data are too {magnitude} for numbers of 32 bits: they must lie between {smallest:.1e} and {LARGEST_F32:.1e}; use base64"
    );
    Err(choices.error(Choice::Encoding, detail))
}

/// The coordinates of the data points.
fn coordinates(problem: &Problem) -> impl Iterator<Item = f64> + Clone {
    let lanes = problem.data().lanes();
    let (lanes, weights) = match lanes.split_last() {
        Some((weights, lanes)) if problem.is_homogeneous() => (lanes, Some(weights)),
        _ => (lanes, None),
    };
    lanes.iter().flat_map(move |lane| {
        let weight = move |i: usize| weights.map_or(1.0, |weights| weights[i]);
        lane.iter().enumerate().map(move |(i, x)| x / weight(i))
    })
}
