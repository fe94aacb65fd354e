//! JSON read to the letter: objects are objects, names are names, counts are whole numbers.
//!
//! What is wrong is noted with its place, and reading goes on, so that one answer tells all of it.
//! Lists end where a limit says so, while they are read; what is not understood is passed over and
//! costs nothing.
//!
//! - `reading`: what was found so far; `reader`: what can be read, and from which kinds of values;
//! - `lists`: lists with a limit; `members`, `object`: objects with their fields;
//! - [`values`]: numbers, counts, names and texts;
//! - `syntax`: what is no JSON.

mod lists;
pub(in crate::api) mod members;
pub(in crate::api) mod object;
pub(in crate::api) mod reader;
pub(in crate::api) mod reading;
mod syntax;
pub mod values;

use serde::de::DeserializeSeed;
use serde_json::Deserializer as Json;

use crate::api::problem::Problem;
use crate::api::text;
pub use members::Members;
pub use object::Field;
pub(in crate::api) use object::object;
use reader::Seed;
pub use reader::{Anything, Numeral, Of, Read, Reader};
pub use reading::{ListLimits, Most, Reading};
pub(in crate::api) use values::{choices, names};

/// Reads a body.
pub fn parse<T>(body: &[u8], limits: ListLimits) -> Result<T, Problem>
where
    T: Read,
{
    let body = text::utf8(body)?;
    let mut reading = Reading::new(limits);
    let mut json = Json::from_slice(body);
    let read = Seed(T::reader(), &mut reading).deserialize(&mut json);
    let read = read.and_then(|value| json.end().map(|()| value));
    match read {
        Ok(Some(value)) if reading.mistakes.is_empty() => Ok(value),
        Err(error) if !reading.stopped => Err(reading.broken(body, &error)),
        Ok(_) | Err(_) => Err(reading.problem()),
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
