//! Query parameters that say what to show of a fit, and how a stream goes.

use serde::Deserialize;

use super::problem::Problem;
use crate::fit::points::Grid;

/// The most points that are sampled.
const MOST_SAMPLES: usize = 1_000_000;

const CURVE_SAMPLES: Grid = Grid {
    rows: 200,
    columns: 1,
};
const SURFACE_SAMPLES: Grid = Grid {
    rows: 40,
    columns: 40,
};

/// What to show of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The complete control net.
    ControlPoints,
    /// Points of the curve or surface, so many in each direction.
    Samples(Grid),
    /// The distances from the data alone.
    Errors,
}

/// `view` and `samples`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewParameters {
    view: Option<String>,
    samples: Option<String>,
}

/// The parameters of event streams.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StreamParameters {
    /// For clients that cannot set the header.
    pub last_event_id: Option<String>,
    view: Option<String>,
    samples: Option<String>,
    every: Option<String>,
    pace: Option<String>,
    on_disconnect: Option<String>,
}

/// How a stream goes.
#[derive(Clone, Copy, Debug)]
pub struct StreamOptions {
    /// What each event shows.
    pub view: View,
    /// Only iterations that are multiples of this, and the last.
    pub every: usize,
    /// A slow client skips to the newest iteration.
    pub latest: bool,
    /// The job ends with its client.
    pub cancels: bool,
}

impl ViewParameters {
    /// The view of a curve or a surface.
    pub fn view(&self, surface: bool) -> Result<View, Problem> {
        view(self.view.as_deref(), self.samples.as_deref(), surface)
    }
}

impl StreamParameters {
    /// The name of a parameter that is given, if there is one.
    pub fn given(&self) -> Option<&'static str> {
        let parameters = [
            ("last_event_id", &self.last_event_id),
            ("view", &self.view),
            ("samples", &self.samples),
            ("every", &self.every),
            ("pace", &self.pace),
            ("on_disconnect", &self.on_disconnect),
        ];
        let given = |(name, value): (_, &Option<String>)| value.as_ref().map(|_| name);
        parameters.into_iter().find_map(given)
    }

    /// The options for a curve or a surface.
    pub fn options(&self, surface: bool) -> Result<StreamOptions, Problem> {
        let every = match self.every.as_deref() {
            None => 1,
            Some(text) => text
                .parse()
                .ok()
                .filter(|every| (1..=usize::MAX / 4).contains(every))
                .ok_or_else(|| {
                    Problem::at_parameter("every", format!("{text:?} is no positive whole number"))
                })?,
        };
        Ok(StreamOptions {
            view: view(self.view.as_deref(), self.samples.as_deref(), surface)?,
            every,
            latest: choice("pace", self.pace.as_deref(), "all", "latest")?,
            cancels: choice(
                "on_disconnect",
                self.on_disconnect.as_deref(),
                "continue",
                "cancel",
            )?,
        })
    }
}

/// Whether the second of two choices is made; the first is the default.
fn choice(name: &str, given: Option<&str>, no: &str, yes: &str) -> Result<bool, Problem> {
    match given {
        None => Ok(false),
        Some(given) if given == no => Ok(false),
        Some(given) if given == yes => Ok(true),
        Some(given) => Err(Problem::at_parameter(
            name,
            format!("{given:?} is no choice; there are {no} and {yes}"),
        )),
    }
}

/// `samples` is `200` for a curve, `40x40` for a surface.
fn view(view: Option<&str>, samples: Option<&str>, surface: bool) -> Result<View, Problem> {
    let view = match view {
        None | Some("control_points") => View::ControlPoints,
        Some("errors") => View::Errors,
        Some("samples") => {
            let usual = if surface {
                SURFACE_SAMPLES
            } else {
                CURVE_SAMPLES
            };
            return match samples {
                None => Ok(View::Samples(usual)),
                Some(text) => sample_grid(text, surface).map(View::Samples),
            };
        }
        Some(other) => {
            let detail =
                format!("{other:?} is not a view; there are control_points, samples and errors");
            return Err(Problem::at_parameter("view", detail));
        }
    };
    match samples {
        None => Ok(view),
        Some(_) => Err(Problem::at_parameter(
            "samples",
            "it is given, but the view is not samples: add view=samples",
        )),
    }
}

fn sample_grid(text: &str, surface: bool) -> Result<Grid, Problem> {
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
            let detail = format!(
                "{text:?} is not a number of samples such as {form}, at least 2 in each direction and {MOST_SAMPLES} in all"
            );
            Problem::at_parameter("samples", detail)
        })
}
