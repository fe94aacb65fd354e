//! What was found so far while a body is read: where the reader stands, and what is wrong.

use serde::de::Error;

use super::syntax;
use crate::api::problem::{Kind, Problem};
use crate::model::mistakes::MOST_MISTAKES;
use crate::model::short::{cut, quoted};

/// How long the lists of a request may be.
#[derive(Clone, Copy, Debug)]
pub struct ListLimits {
    /// The most data points.
    pub points: usize,
}

/// The most elements of a list.
#[derive(Clone, Copy, Debug)]
pub struct Most<'a> {
    pub(super) left: usize,
    pub(super) all: usize,
    pub(super) things: &'a str,
}

impl<'a> Most<'a> {
    /// So many `things`.
    pub fn of(all: usize, things: &'a str) -> Self {
        let left = all;
        Self { left, all, things }
    }

    /// As many as there are: they are not kept.
    pub fn any() -> Self {
        Self::of(usize::MAX, "elements")
    }

    /// So many of them were in other lists.
    pub fn after(self, count: usize) -> Self {
        let left = self.all.saturating_sub(count);
        Self { left, ..self }
    }
}

/// What was found so far while a body is read.
#[derive(Debug)]
pub struct Reading {
    limits: ListLimits,
    /// Where the value is that is read.
    pub(super) path: Vec<PathStep>,
    /// In how many lists and objects it stands.
    depth: usize,
    pub(super) mistakes: Vec<Noted>,
    /// There is no use in reading on.
    pub(super) stopped: bool,
}

/// A step from a value to one within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathStep {
    Field(&'static str),
    Element(usize),
}

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Noted {
    /// The same without places in lists.
    field: Vec<PathStep>,
    pointer: String,
    detail: String,
    /// The name of a field that there is not.
    unknown: Option<String>,
}

impl Reading {
    /// Nothing has been read yet.
    pub(super) fn new(limits: ListLimits) -> Self {
        Self {
            limits,
            path: Vec::new(),
            depth: 0,
            mistakes: Vec::new(),
            stopped: false,
        }
    }

    /// How long lists may be.
    pub fn limits(&self) -> ListLimits {
        self.limits
    }

    /// The value that is read is wrong.
    pub fn wrong(&mut self, detail: impl Into<String>) {
        let pointer = self.pointer();
        self.note(pointer, detail.into());
    }

    /// A field of the object that is read is wrong, or should not be there.
    pub fn wrong_field(&mut self, name: &str, detail: impl Into<String>) {
        let name = name.replace('~', "~0").replace('/', "~1");
        let pointer = format!("{}/{name}", self.pointer());
        self.note(pointer, detail.into());
    }

    /// A field of the object that is read is none of those that there are.
    pub(super) fn unknown_field(&mut self, name: &str, names: &[&str]) {
        let before = self.mistakes.len();
        self.wrong_field(name, unknown(name, names));
        let noted = self.mistakes.get_mut(before..).into_iter().flatten();
        noted.for_each(|noted| noted.unknown = Some(name.to_owned()));
    }

    /// The object that is read has these fields, as is known once it has been read.
    pub(in crate::api) fn there_are(&mut self, names: &[&str]) {
        let own = self.pointer();
        for noted in &mut self.mistakes {
            let within = noted.pointer.strip_prefix(&own);
            if let (Some(name), Some(1)) =
                (&noted.unknown, within.map(|it| it.matches('/').count()))
            {
                noted.detail = unknown(name, names);
            }
        }
    }

    /// The value that is read is of another kind.
    pub fn mismatch(&mut self, expected: &str, found: &str) {
        self.wrong(format!("expected {expected}, found {found}"));
    }

    fn note(&mut self, pointer: String, detail: String) {
        let last_field = self
            .path
            .iter()
            .rposition(|step| matches!(step, PathStep::Field(_)));
        let field = self.path.iter().take(last_field.map_or(0, |last| last + 1));
        let field: Vec<PathStep> = field.copied().collect();
        // The same mistake in another element of a list is told once.
        let in_list = matches!(self.path.last(), Some(PathStep::Element(_)));
        let known = self
            .mistakes
            .iter()
            .any(|it| it.detail == detail && it.field == field);
        if !(in_list && known) {
            self.mistakes.push(Noted {
                field,
                pointer,
                detail,
                unknown: None,
            });
        }
    }

    /// Ends reading if nothing is to be gained by going on.
    pub(super) fn check<E: Error>(&mut self) -> Result<(), E> {
        if self.mistakes.len() >= MOST_MISTAKES {
            return self.stop();
        }
        Ok(())
    }

    /// Ends reading.
    pub fn stop<T, E: Error>(&mut self) -> Result<T, E> {
        self.stopped = true;
        Err(E::custom("what follows is of no use"))
    }

    /// Reads a value within the one that is read.
    pub(super) fn within<T, E>(
        &mut self,
        step: PathStep,
        read: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<T, E> {
        self.path.push(step);
        let value = read(self)?;
        // After an error the path stays: it says where.
        self.path.pop();
        Ok(value)
    }

    /// Reads a list or an object.
    pub(super) fn deeper<T, E: Error>(
        &mut self,
        deepest: usize,
        read: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<T, E> {
        if self.depth == deepest {
            self.wrong(format!(
                "lists and objects stand within one another more than {deepest} times"
            ));
            return self.stop();
        }
        self.depth += 1;
        let value = read(self)?;
        self.depth -= 1;
        Ok(value)
    }

    /// The JSON pointer (RFC 6901) to the value that is read.
    fn pointer(&self) -> String {
        let steps = self.path.iter().map(|step| match step {
            PathStep::Field(name) => format!("/{name}"),
            PathStep::Element(index) => format!("/{index}"),
        });
        steps.collect()
    }

    /// The body is no JSON.
    pub(super) fn broken(&self, body: &[u8], error: &serde_json::Error) -> Problem {
        let (kind, detail) = syntax::explain(body, error);
        if kind == Kind::NotJson && body.is_empty() {
            return Problem::new(kind, detail);
        }
        Problem::at_pointer(kind, self.pointer(), cut(&detail, 200))
    }

    /// All mistakes.
    pub(super) fn problem(self) -> Problem {
        let mistakes = self.mistakes.into_iter();
        let problems = mistakes.map(
            |Noted {
                 pointer, detail, ..
             }| { Problem::at_pointer(Kind::InvalidFit, pointer, detail) },
        );
        let missing = || Problem::new(Kind::InvalidFit, "the body is not understood");
        Problem::of_all(problems).unwrap_or_else(missing)
    }
}

/// A field that there is not, beside those that there are.
fn unknown(name: &str, names: &[&str]) -> String {
    format!(
        "unknown field {}; there are {}",
        quoted(name),
        names.join(", ")
    )
}
