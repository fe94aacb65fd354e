//! JSON read to the letter: objects are objects, names are names, counts are whole numbers.
//!
//! What is wrong is noted with its place, and reading goes on, so that one answer tells all of it.
//! Lists end where a limit says so, while they are read; what is not understood is passed over and
//! costs nothing.
//!
//! - `reader`: what can be read, and from which kinds of values;
//! - `object`: objects with their fields;
//! - [`values`]: numbers, counts, names and texts;
//! - `syntax`: what is no JSON.

mod object;
mod reader;
mod syntax;
pub mod values;

use serde::de::{DeserializeSeed, Error, SeqAccess};
use serde_json::Deserializer as Json;

use crate::api::problem::{Kind, Problem};
use crate::api::text;
use crate::model::mistakes::MOST_MISTAKES;
use crate::model::short::cut;
pub(in crate::api) use object::object;
pub use object::{Field, Members};
use reader::Seed;
pub use reader::{Anything, Numeral, Of, Read, Reader};
pub(in crate::api) use values::{choices, names};

/// The most mistakes that are told of one list.
const MOST_OF_LIST: usize = 3;

/// How long the lists of a request may be.
#[derive(Clone, Copy, Debug)]
pub struct ListLimits {
    /// The most data points.
    pub points: usize,
}

/// The most elements of a list.
#[derive(Clone, Copy, Debug)]
pub struct Most<'a> {
    left: usize,
    all: usize,
    things: &'a str,
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
    path: Vec<PathStep>,
    /// In how many lists and objects it stands.
    depth: usize,
    mistakes: Vec<Noted>,
    /// There is no use in reading on.
    stopped: bool,
}

/// A step from a value to one within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PathStep {
    Field(&'static str),
    Element(usize),
}

/// What is wrong, and where.
#[derive(Debug)]
struct Noted {
    /// The same without places in lists.
    field: Vec<PathStep>,
    pointer: String,
    detail: String,
}

/// Reads a body.
pub fn parse<T>(body: &[u8], limits: ListLimits) -> Result<T, Problem>
where
    T: Read,
{
    let body = text::utf8(body)?;
    let mut reading = Reading {
        limits,
        path: Vec::new(),
        depth: 0,
        mistakes: Vec::new(),
        stopped: false,
    };
    let mut json = Json::from_slice(body);
    let read = Seed(T::reader(), &mut reading).deserialize(&mut json);
    let read = read.and_then(|value| json.end().map(|()| value));
    match read {
        Ok(Some(value)) if reading.mistakes.is_empty() => Ok(value),
        Err(error) if !reading.stopped => Err(reading.broken(body, &error)),
        Ok(_) | Err(_) => Err(reading.problem()),
    }
}

impl Reading {
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
            });
        }
    }

    /// Ends reading if nothing is to be gained by going on.
    fn check<E: Error>(&mut self) -> Result<(), E> {
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
    fn within<T, E>(
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
    fn deeper<T, E: Error>(
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

    /// Reads the elements of a list of at most so many `things`, each with a reader of its own; `take`
    /// gets those that are right. Tells whether all are.
    pub fn elements<'de, R: Reader, A: SeqAccess<'de>>(
        &mut self,
        mut list: A,
        most: Most<'_>,
        reader: impl Fn() -> R,
        mut take: impl FnMut(R::Value, &mut Self) -> Option<()>,
    ) -> Result<bool, A::Error> {
        let mut wrong = 0;
        self.path.push(PathStep::Element(0));
        for index in 0.. {
            if let Some(last) = self.path.last_mut() {
                *last = PathStep::Element(index);
            }
            if index == most.left {
                if list.next_element_seed(Seed(Anything, self))?.is_some() {
                    let Most { all, things, .. } = most;
                    self.wrong(format!("at most {all} {things} can be given here"));
                    return self.stop();
                }
                break;
            }
            if wrong == MOST_OF_LIST {
                while list.next_element_seed(Seed(Anything, self))?.is_some() {}
                break;
            }
            let Some(element) = list.next_element_seed(Seed(reader(), self))? else {
                break;
            };
            if element.and_then(|element| take(element, self)).is_none() {
                wrong += 1;
            }
            self.check()?;
        }
        self.path.pop();
        Ok(wrong == 0)
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
    fn broken(&self, body: &[u8], error: &serde_json::Error) -> Problem {
        let (kind, detail) = syntax::explain(body, error);
        if kind == Kind::NotJson && body.is_empty() {
            return Problem::new(kind, detail);
        }
        Problem::at_pointer(kind, self.pointer(), cut(&detail, 200))
    }

    /// All mistakes.
    fn problem(self) -> Problem {
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

#[cfg(test)]
mod tests {
    use super::values::LONGEST_TEXT;
    use super::*;
    use crate::api::problem::Location;

    #[derive(Debug, PartialEq)]
    struct Thing {
        count: usize,
        name: Option<String>,
        flags: Option<Vec<usize>>,
    }

    object!(Thing, "a thing", [count, name, flags]);

    impl values::Element for usize {
        const MANY: &'static str = "counts";

        fn most(limits: ListLimits) -> usize {
            limits.points
        }
    }

    fn read(body: &str) -> Result<Thing, Vec<(String, String)>> {
        parse(body.as_bytes(), ListLimits { points: 3 }).map_err(|problem| {
            let errors = problem.errors().iter();
            let pointer = |place: &Location| match place {
                Location::Pointer(pointer) => pointer.clone(),
                _ => String::new(),
            };
            errors
                .map(|error| (pointer(&error.place), error.detail.clone()))
                .collect()
        })
    }

    #[test]
    fn fields_are_read_and_mistakes_are_gathered() {
        let thing = read(r#"{"flags": [1, 2.0, 3], "count": 7, "name": null}"#).unwrap();
        assert_eq!((thing.count, thing.name), (7, None));
        assert_eq!(thing.flags, Some(vec![1, 2, 3]));
        let wrong = read(r#"{"flags": [1, "2", [3]], "name": {"a": [{}]}, "a~/b": [[]]}"#);
        let pointers: Vec<_> = wrong.unwrap_err().into_iter().map(|it| it.0).collect();
        assert_eq!(pointers, ["/flags/1", "/flags/2", "/name", "/a~0~1b", ""]);
    }

    #[test]
    fn lists_end_at_their_limit_and_texts_are_cut() {
        let wrong = read(r#"{"flags": [1, 2, 3, 4, "and so on"#).unwrap_err();
        let detail = "at most 3 counts can be given here".to_owned();
        assert_eq!(wrong, [("/flags/3".to_owned(), detail)]);
        let long = "λ".repeat(LONGEST_TEXT + 1);
        let wrong = read(&format!(r#"{{"count": 1, "name": "{long}"}}"#)).unwrap_err();
        assert_eq!(wrong[0].0, "/name");
        let wrong = read(&format!(r#"{{"count": "{long}"}}"#)).unwrap_err();
        assert!(wrong[0].1.chars().count() < 170, "{wrong:?}");
    }
}
