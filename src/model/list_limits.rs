//! Limits on the length of the lists of a request while they are read.
//!
//! Readers of serde take no arguments, so the limits are those of the thread.

use std::cell::Cell;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};

use super::serde_helpers::below;
use piad_files::json::ListLimits;
use piad_fit::basis::MAX_DEGREE;

/// Knot vectors, and weights of control points, are longer than lists with a number for each data point by at
/// most as many numbers as this.
pub(crate) const EXTRA: usize = 2 * (MAX_DEGREE + 1);

thread_local! {
    static CURRENT: Cell<ListLimits> = const { Cell::new(ListLimits::NONE) };
}

/// Restores the previous limits, also if the stack is unwound.
struct Scope(ListLimits);

impl Drop for Scope {
    fn drop(&mut self) {
        CURRENT.set(self.0);
    }
}

/// Reads something within these limits.
pub(crate) fn within<T>(limits: ListLimits, read: impl FnOnce() -> T) -> T {
    let _scope = Scope(CURRENT.replace(limits));
    read()
}

/// The limits of this thread.
pub(super) fn current() -> ListLimits {
    CURRENT.get()
}

/// The most numbers of a list that has `each` of them for a data point.
pub(super) fn most_numbers(limits: ListLimits, each: usize) -> usize {
    limits.points.saturating_mul(each).saturating_add(EXTRA)
}

/// The error for a list that is too long.
pub(super) fn too_many(most: usize) -> String {
    format!("there are more than {most} of them, the most that can be given here")
}

/// Reads a list of at most one element for each data point, if it is there.
pub(super) fn for_points<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<T>>, D::Error> {
    struct ForPoints<T>(Vec<T>);

    impl<'de, T: Deserialize<'de>> Deserialize<'de> for ForPoints<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            for_all_points(deserializer).map(Self)
        }
    }

    let list = Option::<ForPoints<T>>::deserialize(deserializer)?;
    Ok(list.map(|list| list.0))
}

/// Reads a list of at most one element for each data point.
pub(super) fn for_all_points<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    read(deserializer, current().points)
}

/// Reads a list with a number for each data point, and maybe some more, as knots are.
pub(super) fn numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    read(deserializer, most_numbers(current(), 1))
}

/// Reads a list of at most `MAX` elements.
fn read<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
    most: usize,
) -> Result<Vec<T>, D::Error> {
    struct ListVisitor<T>(usize, PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for ListVisitor<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a sequence")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let (limits, most) = (current(), self.0);
            let mut elements = Vec::new();
            while let Some(element) = list.next_element()? {
                if elements.len() == most {
                    return Err(below(&format!("/{most}"), too_many(most)));
                }
                limits.make_room(&mut elements, most);
                elements.push(element);
            }
            elements.shrink_to_fit();
            Ok(elements)
        }
    }

    deserializer.deserialize_seq(ListVisitor(most, PhantomData))
}

#[cfg(test)]
mod tests {
    use piad_files::json::LIMITED_LENGTH;
    use serde_json::Deserializer as Json;

    use super::*;

    fn read_numbers(text: &str, points: usize) -> Result<Vec<f64>, String> {
        let limits = ListLimits::new(text.as_bytes(), points);
        let read = || numbers(&mut Json::from_str(text)).map_err(|error| error.to_string());
        within(limits, read)
    }

    #[test]
    fn a_long_list_takes_as_much_memory_as_its_text_can_need() {
        let text = format!("[1{}]", ",1".repeat(9_999));
        let numbers = read_numbers(&text, 10_000).unwrap();
        assert_eq!((numbers.len(), numbers.capacity()), (10_000, 10_000));
        let limits = ListLimits::new(text.as_bytes(), 10_000);
        let mut list = vec![0.0; LIMITED_LENGTH];
        limits.make_room(&mut list, most_numbers(limits, 1));
        assert_eq!(list.capacity(), 10_000);
        // Without limits it grows freely.
        current().make_room(&mut list, usize::MAX);
        assert_eq!(current().points, usize::MAX);
    }

    #[test]
    fn a_list_ends_at_its_limit() {
        let most = 3 + EXTRA;
        let text = format!("[1{}]", ",1".repeat(most - 1));
        assert_eq!(read_numbers(&text, 3).unwrap().len(), most);
        let error = read_numbers(&text, 2).unwrap_err();
        assert!(error.contains(&too_many(most - 1)), "{error}");
    }
}
