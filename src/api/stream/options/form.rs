//! The form in which a level is shown: what of it, and how its numbers are written.

use std::sync::Arc;

use super::given::Given;
use crate::api::problem::Problem;
use crate::api::short::quoted;
use crate::fit::points::Grid;
use crate::fit::problem as fit;

/// What can be shown of a level.
pub const VIEWS: [&str; 3] = ["control_points", "samples", "errors"];

/// How arrays of numbers can be written in JSON.
pub const ENCODINGS: [&str; 3] = ["json", "base64", "base64_f32"];

/// How many digits coordinates can have.
pub const DIGITS: [&str; 2] = ["full", "auto"];

/// How a number of samples of a surface is written.
pub const SAMPLE_GRID: &str = "^[1-9][0-9]{0,5}x[1-9][0-9]{0,5}$";

/// The most points that are sampled.
pub const MOST_SAMPLES: usize = 1_000_000;

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

/// What to show of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The complete control net.
    ControlPoints,
    /// The control points that have moved since the level before.
    Changed,
    /// Points of the curve or surface, so many in each direction.
    Samples(Grid),
    /// The distances from the data alone.
    Errors,
}

/// How arrays of numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Lists of numbers.
    Json,
    /// Little-endian numbers of 64 bits in base64.
    Base64,
    /// Little-endian numbers of 32 bits in base64.
    Base64F32,
    /// Not JSON at all, but a protobuf message.
    Protobuf,
}

/// How many digits coordinates have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// All.
    Full,
    /// As many as the largest distance deserves; the last level has all.
    Auto,
}

/// The form of a level on the wire.
#[derive(Clone, Debug)]
pub struct Form {
    /// What is shown.
    pub view: View,
    /// How arrays of numbers are written.
    pub encoding: Encoding,
    /// How many digits coordinates have.
    pub digits: Digits,
    key: Arc<str>,
}

impl Form {
    /// A form, with its key.
    pub fn new(view: View, encoding: Encoding, digits: Digits) -> Self {
        Self {
            view,
            encoding,
            digits,
            key: format!("{:?}", (view, encoding, digits)).into(),
        }
    }

    /// What tells this form from others: what is made in one form is shared by all who want it.
    pub fn key(&self) -> &Arc<str> {
        &self.key
    }

    /// The same as a protobuf message, in which numbers are written in one way only.
    pub fn in_protobuf(&self) -> Self {
        Self::new(self.view, Encoding::Protobuf, Digits::Full)
    }

    /// Whether it is a protobuf message.
    pub fn is_protobuf(&self) -> bool {
        self.encoding == Encoding::Protobuf
    }

    /// The same with all digits.
    pub fn in_full(&self) -> Self {
        Self::new(self.view, self.encoding, Digits::Full)
    }
}

/// The choice of a view.
pub(super) fn view(
    view: Option<Given<'_>>,
    samples: Option<Given<'_>>,
    surface: bool,
) -> Result<View, Problem> {
    let names = [
        ("control_points", View::ControlPoints),
        (
            "samples",
            View::Samples(if surface {
                SURFACE_SAMPLES
            } else {
                CURVE_SAMPLES
            }),
        ),
        ("errors", View::Errors),
    ];
    let chosen = match view {
        None => View::ControlPoints,
        Some(given) => given.one_of(&names)?,
    };
    match (chosen, samples) {
        (_, None) => Ok(chosen),
        (View::Samples(_), Some(given)) => sample_grid(given, surface).map(View::Samples),
        // A number of samples that the job sets is for those who choose this view.
        (_, Some(given)) if given.is_default_for(view) => Ok(chosen),
        (_, Some(given)) => {
            Err(given.problem("it is given, but the view is not samples: add view=samples"))
        }
    }
}

/// `200` for a curve, `40x40` for a surface.
pub(super) fn sample_grid(given: Given<'_>, surface: bool) -> Result<Grid, Problem> {
    let text = given.text;
    let parsed = match (text.split_once('x'), surface) {
        (None, false) => text.parse().ok().map(|rows| Grid { rows, columns: 1 }),
        (Some((rows, columns)), true) => rows
            .parse()
            .ok()
            .zip(columns.parse().ok())
            .map(|(rows, columns)| Grid { rows, columns }),
        _ => None,
    };
    let least = if surface { 2 } else { 1 };
    parsed
        .filter(|grid| grid.rows >= 2 && grid.columns >= least)
        .filter(|grid| grid.rows.saturating_mul(grid.columns) <= MOST_SAMPLES)
        .ok_or_else(|| {
            let form = if surface { "40x40 for a surface" } else { "200 for a curve" };
            given.problem(format!(
                "{} is not a number of samples such as {form}, at least 2 in each direction and {MOST_SAMPLES} in all",
                quoted(text)
            ))
        })
}

/// The choice of an encoding.
pub(super) fn encoding(given: Option<Given<'_>>) -> Result<Encoding, Problem> {
    match given {
        None => Ok(Encoding::Json),
        Some(given) => given.one_of(&[
            ("json", Encoding::Json),
            ("base64", Encoding::Base64),
            ("base64_f32", Encoding::Base64F32),
        ]),
    }
}

/// Refuses numbers of 32 bits that have no room for the data.
pub(super) fn check_range(
    encoding_given: Option<Given<'_>>,
    problem: &fit::Problem,
) -> Result<(), Problem> {
    let (Some(given), Encoding::Base64F32) = (encoding_given, encoding(encoding_given)?) else {
        return Ok(());
    };
    let mut coordinates = coordinates(problem);
    let smallest = f64::from(f32::MIN_POSITIVE);
    let magnitude = if coordinates.clone().any(|x| x.abs() > LARGEST_F32) {
        "large"
    } else if coordinates.clone().all(|x| x.abs() < smallest) && coordinates.any(|x| x != 0.0) {
        "small"
    } else {
        return Ok(());
    };
    Err(given.problem(format!(
        "the coordinates of the data are too {magnitude} for numbers of 32 bits: they must lie between {smallest:.1e} and {LARGEST_F32:.1e}; use base64"
    )))
}

/// The coordinates of the data points.
fn coordinates(problem: &fit::Problem) -> impl Iterator<Item = f64> + Clone {
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

/// The choice of digits.
pub(super) fn digits(given: Option<Given<'_>>) -> Result<Digits, Problem> {
    match given {
        None => Ok(Digits::Full),
        Some(given) => given.one_of(&[("full", Digits::Full), ("auto", Digits::Auto)]),
    }
}
