//! Reads knots, parameters and weights from JSON straight into the arrays that are computed with.

use std::cell::RefCell;

use serde::de::SeqAccess;

use super::read::{ListLimits, Most, Numeral, Of, Read, Reader, Reading};
use crate::fit::basis::MAX_DEGREE;

/// A rule that has a name, or explicit numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum RuleOrNumbers<R> {
    /// A rule.
    Rule(R),
    /// Numbers.
    Numbers(Vec<f64>),
}

impl<R> Reader for Of<RuleOrNumbers<R>>
where
    R: Read,
{
    type Value = RuleOrNumbers<R>;

    fn expected(&self) -> String {
        format!("{}; or a list of numbers", R::reader().expected())
    }

    fn text(self, name: &str, at: &mut Reading) -> Option<RuleOrNumbers<R>> {
        R::reader().text(name, at).map(RuleOrNumbers::Rule)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<RuleOrNumbers<R>>, A::Error> {
        let mut numbers = Vec::new();
        let most = most_numbers(at.limits());
        let whole = at.elements(list, most, f64::reader, |x, _| {
            numbers.push(x);
            Some(())
        })?;
        numbers.shrink_to_fit();
        Ok(whole.then_some(RuleOrNumbers::Numbers(numbers)))
    }
}

/// The most numbers that belong to data points: of knots there are the most.
pub(in crate::api) fn most_numbers(limits: ListLimits) -> Most<'static> {
    let ends = 2 * (MAX_DEGREE + 1);
    Most::of(limits.points.saturating_add(ends), "numbers")
}

/// Weights: a list of numbers, or rows of them.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightList {
    /// A list.
    Line(Vec<f64>),
    /// Rows of equal length.
    Grid {
        /// The weights, row by row.
        values: Vec<f64>,
        /// The length of the rows.
        columns: usize,
    },
}

impl Reader for Of<WeightList> {
    type Value = WeightList;

    fn expected(&self) -> String {
        "a list of weights, or rows of them".to_owned()
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<WeightList>, A::Error> {
        let values = RefCell::new(Vec::new());
        let mut columns = None;
        let most = most_numbers(at.limits());
        let whole = at.elements(
            list,
            most,
            || WeightReader(&values),
            |length, at| {
                if *columns.get_or_insert(length) != length {
                    at.wrong("all rows must have the same length");
                    return None;
                }
                Some(())
            },
        )?;
        let values = values.into_inner();
        Ok(whole.then_some(match columns.flatten() {
            None => WeightList::Line(values),
            Some(columns) => WeightList::Grid { values, columns },
        }))
    }
}

/// A weight, or a row of weights, of which the length is given.
struct WeightReader<'a>(&'a RefCell<Vec<f64>>);

impl Reader for WeightReader<'_> {
    type Value = Option<usize>;

    fn expected(&self) -> String {
        "a number or a row of numbers".to_owned()
    }

    fn null(self, at: &mut Reading) -> Option<Option<usize>> {
        f64::reader().null(at).map(|_| None)
    }

    fn number(self, value: Numeral, _: &mut Reading) -> Option<Option<usize>> {
        self.0.borrow_mut().push(value.real());
        Some(None)
    }

    fn list<'de, A: SeqAccess<'de>>(
        self,
        list: A,
        at: &mut Reading,
    ) -> Result<Option<Option<usize>>, A::Error> {
        let before = self.0.borrow().len();
        let most = most_numbers(at.limits()).after(before);
        let whole = at.elements(list, most, f64::reader, |x, _| {
            self.0.borrow_mut().push(x);
            Some(())
        })?;
        let length = self.0.borrow().len() - before;
        Ok(whole.then_some(Some(length)))
    }
}
