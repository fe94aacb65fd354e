//! Lists with a limit.

use serde::de::SeqAccess;

use super::reader::{Anything, Reader, Seed};
use super::reading::{Most, PathStep, Reading};

/// The most mistakes that are told of one list.
const MOST_OF_LIST: usize = 3;

impl Reading {
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
}
