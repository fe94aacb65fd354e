//! What a client has chosen: in the query of a stream, or for all streams of a job.

use super::StreamParameters;
use crate::api::problem::{Kind, Problem};
use crate::api::short::{plain, quoted};

/// A choice, as it is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Given<'a> {
    name: &'static str,
    /// The value.
    pub(super) text: &'a str,
    place: Place,
}

/// Where a choice stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// In the query.
    Query,
    /// In the `stream` object of the job.
    Job,
}

impl Given<'_> {
    /// What is wrong with it.
    pub(super) fn problem(self, detail: impl Into<String>) -> Problem {
        match self.place {
            Place::Query => Problem::at_parameter(self.name, detail),
            Place::Job => at_stream(self.name, detail),
        }
    }

    /// What is wrong with an element of it.
    pub(super) fn problem_at(self, index: usize, detail: String) -> Problem {
        match self.place {
            Place::Query => Problem::at_parameter(self.name, detail),
            Place::Job => at_stream(&format!("{}/{index}", self.name), detail),
        }
    }

    /// The value of this name.
    pub(super) fn one_of<T: Copy>(self, names: &[(&str, T)]) -> Result<T, Problem> {
        let found = names.iter().find(|(name, _)| *name == self.text);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
            let detail = format!(
                "{} is no choice; there are {}",
                quoted(self.text),
                names.join(", ")
            );
            self.problem(detail)
        })
    }

    /// Whether the job sets it, and the query has chosen `other`.
    pub(super) fn is_default_for(self, other: Option<Given<'_>>) -> bool {
        self.place == Place::Job && other.is_some_and(|other| other.place == Place::Query)
    }
}

fn at_stream(field: &str, detail: impl Into<String>) -> Problem {
    Problem::at_pointer(Kind::InvalidFit, format!("/stream/{field}"), detail)
}

/// The parameters of a query and those that the job sets for all of its streams.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sources<'a> {
    query: &'a StreamParameters,
    job: &'a StreamParameters,
}

/// Two choices of which one rules out the other: whether they were made, and why not both.
pub(super) type Conflict = (bool, &'static str, &'static str, &'static str);

impl<'a> Sources<'a> {
    pub(super) fn new(query: &'a StreamParameters, job: &'a StreamParameters) -> Self {
        Self { query, job }
    }

    /// The choice of a parameter: the query wins over the job.
    pub(super) fn get(self, name: &'static str) -> Option<Given<'a>> {
        let given = |parameters: &'a StreamParameters, place| {
            let text = parameters.get(name)?;
            Some(Given { name, text, place })
        };
        given(self.query, Place::Query).or_else(|| given(self.job, Place::Job))
    }

    /// Refuses choices that do not go together. What the query says is to blame before what the
    /// job says.
    pub(super) fn refuse(self, conflicts: &[Conflict]) -> Result<(), Problem> {
        let Some(&(_, one, other, why)) = conflicts.iter().find(|(both, ..)| *both) else {
            return Ok(());
        };
        let (Some(one), Some(other)) = (self.get(one), self.get(other)) else {
            return Ok(());
        };
        let mut detail = format!(
            "{}={} and {}={} do not go together: {why}",
            one.name,
            plain(one.text),
            other.name,
            plain(other.text)
        );
        let (blamed, set) = match (one.place, other.place) {
            (Place::Job, Place::Query) => (other, one),
            _ => (one, other),
        };
        if set.is_default_for(Some(blamed)) {
            let (name, usual) = (set.name, usual(set.name));
            detail.push_str(&format!(
                "; the job sets {name} for its streams, which {name}={usual} overrides"
            ));
        }
        Err(blamed.problem(detail))
    }
}

/// The value that a parameter has if nobody chooses one.
fn usual(name: &str) -> &'static str {
    match name {
        "view" => "control_points",
        "every" => "1",
        "pace" => "all",
        "changed" => "false",
        "encoding" => "json",
        "digits" => "full",
        "on_disconnect" => "continue",
        _ => "",
    }
}
