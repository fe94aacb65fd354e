//! The JSON of vectors at ends: numbers in lists within lists.

use std::cell::RefCell;
use std::sync::Arc;

use serde::de::SeqAccess;

use crate::api::json::read::{Most, Numeral, Of, Read, Reader, Reading};
use crate::fit::points::Points;
use crate::model::shape::MAX_DIMENSION;

/// Numbers in lists within lists, all of a level of the same length.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Vectors {
    values: Vec<f64>,
    /// The lengths of the lists, from the outermost to those of numbers.
    lengths: Vec<usize>,
}

/// The most levels of lists: orders of derivatives, data points of a boundary, coordinates.
const DEEPEST: usize = 3;

impl Reader for Of<Vectors> {
    type Value = Vectors;

    fn expected(&self) -> String {
        "a list of numbers, or of lists of them".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Vectors>, A::Error> {
        let vectors = RefCell::new(Vectors::default());
        let whole = LevelReader(&vectors, 0).list(list, at)?;
        Ok(whole.map(|_| vectors.into_inner()))
    }
}

/// Reads a list of a level, or a number, into vectors; gives whether it was a list.
struct LevelReader<'a>(&'a RefCell<Vectors>, usize);

impl Reader for LevelReader<'_> {
    type Value = bool;

    fn expected(&self) -> String {
        Of::<Vectors>::expected(&Vectors::reader())
    }

    fn null(self, at: &mut Reading) -> Option<bool> {
        f64::reader().null(at).map(|_| false)
    }

    fn number(self, value: Numeral, at: &mut Reading) -> Option<bool> {
        let Self(vectors, level) = self;
        let mut vectors = vectors.borrow_mut();
        // Numbers stand in lists of one level, which is known once a list has ended.
        if !vectors.lengths.is_empty() && vectors.lengths.len() != level {
            at.wrong("a number stands here where others have lists");
            return None;
        }
        vectors.values.push(value.real());
        Some(false)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<bool>, A::Error> {
        let Self(vectors, level) = self;
        if level == DEEPEST {
            at.wrong(format!(
                "there are at most {DEEPEST} lists within each other"
            ));
            return Ok(None);
        }
        let before = vectors.borrow().values.len();
        let most = at.limits().points.saturating_mul(DEEPEST);
        let most = Most::of(most, "numbers").after(before);
        let (mut length, mut of_lists) = (0, None);
        let whole = at.elements(
            list,
            most,
            || LevelReader(vectors, level + 1),
            |is_list, at| {
                length += 1;
                if *of_lists.get_or_insert(is_list) != is_list {
                    at.wrong("numbers stand here beside lists of numbers");
                    return None;
                }
                Some(())
            },
        )?;
        if !whole {
            return Ok(None);
        }
        let end = vectors.borrow_mut().end(level, length, before, at);
        Ok(end.map(|()| true))
    }
}

impl Vectors {
    /// Notes that a list of a level has ended, which has so many entries.
    fn end(&mut self, level: usize, length: usize, before: usize, at: &mut Reading) -> Option<()> {
        let has_numbers = self.values.len() == before + length;
        if self.lengths.is_empty() && has_numbers && length > 0 {
            self.lengths.resize(level + 1, 0);
        }
        let Some(own) = self.lengths.get_mut(level) else {
            at.wrong("a list is empty, or stands where others have numbers");
            return None;
        };
        if *own == 0 {
            *own = length;
        }
        if *own != length {
            at.wrong(format!(
                "this list has {length} entries, the first of its kind has {own}"
            ));
            return None;
        }
        Some(())
    }

    /// The vectors of each order, of a boundary of one data point or of many; none if these are other
    /// lists.
    pub(in super::super) fn orders(
        self,
        is_surface: bool,
        are_many: bool,
    ) -> Option<Vec<Arc<Points>>> {
        let mut lengths = self.lengths.into_iter().rev();
        let dimension = lengths.next()?;
        let boundary = if is_surface { lengths.next()? } else { 1 };
        if are_many {
            lengths.next()?;
        }
        if lengths.next().is_some() || dimension == 0 || dimension > MAX_DIMENSION {
            return None;
        }
        let order = |flat| Arc::new(Points::from_flat(dimension, flat));
        let orders = self.values.chunks_exact(boundary * dimension);
        Some(orders.map(order).collect())
    }
}
