//! A fast parser for the points of large jobs, several times as fast as serde.
//!
//! A large job consists mostly of points: lists of numbers within lists. They are taken out of the body, which is then
//! small, and read with the number parser of `fast_float2`, which gives the same bits as serde_json. Unusual bodies,
//! valid or not, are left to serde, which also reports their errors.

use std::iter;
use std::ops::Range;

use memchr::memmem;
use rayon::prelude::*;

use piad_fit::data::{Grid, MAX_DIMENSION, MAX_SURFACE_DIMENSION, Points};
use piad_fit::parameters::Mesh;

/// The most nested lists that are distinguished.
const DEEP: usize = 4;

/// The number of parts that each thread reads before the results are copied to their place.
const PARTS: usize = 2;

/// The fields that have points. No other field of a job has these names.
const POINTS: &[u8] = b"\"points\"";
const SCATTERED: &[u8] = b"\"scattered\"";

/// Points outside the JSON of a job.
#[derive(Debug)]
pub(crate) enum Data {
    /// Points of a curve.
    Curve(Points),
    /// Points of a surface in rows, and the indices of missing ones.
    Grid(Points, Grid, Vec<usize>),
    /// Points of a surface without rows.
    Scattered(Points),
    /// Points of a surface that are the vertices of a mesh, with its triangles.
    Mesh(Points, Mesh),
}

/// Takes at most `most` points out of the JSON of a job, and leaves an empty list in their place. Lists that are longer
/// than `part`, in bytes, are read in parts by several threads.
pub(super) fn take_out(body: &[u8], part: usize, most: usize) -> Option<(Vec<u8>, Data)> {
    let after = |name: &[u8]| Some(memmem::find(body, name)? + name.len());
    let points = after(POINTS);
    let mut reader = Reader::at(body, points.or_else(|| after(SCATTERED))?);
    reader.eat(b':')?;
    reader.skip_blanks();
    let start = body.len() - reader.rest.len();
    let data = match (reader.lists(part, most)?, points) {
        (Lists::Points(points), Some(_)) => Data::Curve(points),
        (Lists::Points(points), None) => Data::Scattered(points),
        (Lists::Rows(points, grid), Some(_)) => Data::Grid(points, grid, Vec::new()),
        (Lists::Rows(..), None) => return None,
    };
    let end = body.len() - reader.rest.len();
    let fields = [&body[..start], b"[]", &body[end..]].concat();
    Some((fields, data))
}

/// Lists of numbers in lists.
enum Lists {
    /// Of points, which have a few coordinates each.
    Points(Points),
    /// Of rows of points or of heights.
    Rows(Points, Grid),
}

/// Reads from the start of the rest; every part returns `None` for unexpected input.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn at(text: &'a [u8], place: usize) -> Self {
        let rest = text.get(place..).unwrap_or_default();
        Self { rest }
    }

    fn skip_blanks(&mut self) {
        while let [b' ' | b'\t' | b'\n' | b'\r', rest @ ..] = self.rest {
            self.rest = rest;
        }
    }

    /// Skips a character, with the blanks before it.
    fn eat(&mut self, character: u8) -> Option<()> {
        self.skip_blanks();
        self.rest = self.rest.strip_prefix(&[character])?;
        Some(())
    }

    /// Skips the separator after an element of a list; returns true at the end of the list.
    fn has_ended(&mut self) -> Option<bool> {
        self.skip_blanks();
        let (character, rest) = self.rest.split_first()?;
        self.rest = rest;
        self.skip_blanks();
        match character {
            b',' => Some(false),
            b']' => Some(true),
            _ => None,
        }
    }

    /// Reads a list of at least one element; returns their number.
    #[inline(always)]
    fn list(&mut self, mut element: impl FnMut(&mut Self) -> Option<()>) -> Option<usize> {
        self.eat(b'[')?;
        let mut count = 0;
        loop {
            element(self)?;
            count += 1;
            if self.has_ended()? {
                return Some(count);
            }
        }
    }

    /// Reads a finite number in the notation of JSON, which is stricter than that of the parser.
    #[inline(always)]
    fn number(&mut self) -> Option<f64> {
        self.skip_blanks();
        let (x, length) = fast_float2::parse_partial::<f64, _>(self.rest).ok()?;
        let (text, rest) = self.rest.split_at_checked(length)?;
        let digits = text.strip_prefix(b"-").unwrap_or(text);
        let whole = digits.iter().take_while(|it| it.is_ascii_digit()).count();
        let is_whole = whole == 1 || (whole > 1 && !digits.starts_with(b"0"));
        let is_part = digits.get(whole) != Some(&b'.')
            || digits.get(whole + 1).is_some_and(u8::is_ascii_digit);
        self.rest = rest;
        (is_whole && is_part && x.is_finite()).then_some(x)
    }

    /// The nesting depth of the lists that begin here, up to a limit.
    fn depth(&self) -> usize {
        let mut ahead = Reader { rest: self.rest };
        iter::from_fn(|| ahead.eat(b'[')).take(DEEP).count()
    }

    /// Reads lists, all of a level of the same length, with at most `most` points.
    fn lists(&mut self, part: usize, most: usize) -> Option<Lists> {
        let depth = self.depth();
        self.eat(b'[')?;
        let text = self.rest;
        let ranges = ranges(text, depth, part);
        let read = |range: &Range<usize>| Part::read(text, range.clone(), depth, most);
        let mut gathered = None;
        // Only some parts are read at a time, as these are in memory twice.
        for ranges in ranges.chunks(PARTS * rayon::current_num_threads()) {
            // A short list does not wait for other computations of the pool.
            let parts: Vec<Option<Part>> = match ranges {
                [range] => vec![read(range)],
                _ => ranges.par_iter().map(read).collect(),
            };
            // Parts after the end of the list are discarded.
            let last = parts
                .iter()
                .position(|part| part.as_ref().is_none_or(Part::is_last));
            let count = last.map_or(parts.len(), |last| last + 1);
            let parts = parts.into_iter().take(count).collect::<Option<Vec<_>>>()?;
            let end = parts.last()?.end;
            match &mut gathered {
                None => gathered = Some(Gathered::new(&parts, text, most)?),
                Some(gathered) => gathered.add(&parts)?,
            }
            if let Some(end) = end {
                self.rest = text.get(end..)?;
                return gathered.map(Gathered::lists);
            }
        }
        None
    }
}

/// The lists read so far.
struct Gathered {
    points: Points,
    innermost: usize,
    columns: Option<usize>,
    rows: usize,
    /// The most points.
    most: usize,
}

impl Gathered {
    /// The first parts of a text, with room for the points of all of it.
    fn new(parts: &[Part], text: &[u8], most: usize) -> Option<Self> {
        let first = parts.first()?;
        let (innermost, columns) = (first.innermost?, first.columns);
        let dimension = match (columns, innermost) {
            (_, 1..=MAX_SURFACE_DIMENSION) => innermost,
            // Points of a curve or rows of heights: the kind of geometry decides.
            (None, ..=MAX_DIMENSION) => return None,
            // Rows of heights.
            (None, _) => 1,
            _ => return None,
        };
        // A comma is between any two numbers.
        let numbers = memchr::memchr_iter(b',', text).count() + 1;
        let mut gathered = Self {
            points: Points::with_room(dimension, most.min(numbers / dimension)),
            innermost,
            columns,
            rows: 0,
            most,
        };
        gathered.add(parts)?;
        Some(gathered)
    }

    fn add(&mut self, parts: &[Part]) -> Option<()> {
        for part in parts {
            let is_same = part.innermost == Some(self.innermost) && part.columns == self.columns;
            is_same.then_some(())?;
            self.rows += part.rows;
        }
        let numbers: Vec<&[f64]> = parts.iter().map(|part| &part.numbers[..]).collect();
        self.points.extend_from_parts(&numbers);
        (self.points.len() <= self.most).then_some(())
    }

    fn lists(mut self) -> Lists {
        self.points.shrink_to_fit();
        let rows = self.rows;
        match (self.columns, self.innermost) {
            (None, 1..=MAX_SURFACE_DIMENSION) => Lists::Points(self.points),
            (None, columns) => Lists::Rows(self.points, Grid { rows, columns }),
            (Some(columns), _) => Lists::Rows(self.points, Grid { rows, columns }),
        }
    }
}

/// The parts of a list whose elements are lists of this depth less one. Their starts are guesses, which [`Part::read`]
/// verifies.
fn ranges(text: &[u8], depth: usize, part: usize) -> Vec<Range<usize>> {
    let begins = |place: &usize| Reader::at(text, *place).depth() + 1 == depth;
    let first = |(index, bytes): (usize, &[u8])| {
        let mut brackets = memchr::memchr_iter(b'[', bytes).map(|place| index * part + place);
        brackets.find(begins)
    };
    let mut starts = vec![0];
    starts.extend(text.chunks(part).enumerate().skip(1).filter_map(first));
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    iter::zip(&starts, ends)
        .map(|(start, end)| *start..end)
        .collect()
}

/// Elements of a list that follow one another.
struct Part {
    /// Their number.
    rows: usize,
    numbers: Vec<f64>,
    /// The length of the lists of numbers.
    innermost: Option<usize>,
    /// The length of the lists of such lists, if the elements are such.
    columns: Option<usize>,
    /// The end of the list, if it is the last part.
    end: Option<usize>,
}

impl Part {
    /// Reads the elements that begin in this range, up to the end of the list, with at most this many points.
    fn read(text: &[u8], range: Range<usize>, depth: usize, most: usize) -> Option<Self> {
        let mut reader = Reader::at(text, range.start);
        let most = most.saturating_mul(MAX_SURFACE_DIMENSION);
        let commas = memchr::memchr_iter(b',', text.get(range.clone())?).count();
        let mut numbers = Vec::with_capacity(most.min(commas + 1));
        let (mut innermost, mut columns) = (None, None);
        let mut innermost_list = |reader: &mut Reader| {
            let number = |reader: &mut Reader| {
                let x = reader.number()?;
                (numbers.len() < most).then(|| numbers.push(x))
            };
            same(&mut innermost, reader.list(number)?)
        };
        let (mut rows, mut is_last, mut at) = (0, false, range.start);
        while !is_last && at < range.end {
            match depth {
                2 => innermost_list(&mut reader)?,
                3 => same(&mut columns, reader.list(&mut innermost_list)?)?,
                _ => return None,
            }
            rows += 1;
            is_last = reader.has_ended()?;
            at = text.len() - reader.rest.len();
        }
        let is_whole = is_last || at == range.end;
        is_whole.then_some(Self {
            rows,
            numbers,
            innermost,
            columns,
            end: is_last.then_some(at),
        })
    }

    fn is_last(&self) -> bool {
        self.end.is_some()
    }
}

/// Notes the length of a list, which is that of the others.
fn same(known: &mut Option<usize>, length: usize) -> Option<()> {
    (*known.get_or_insert(length) == length).then_some(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::job::{read_by_serde, read_quickly};

    /// A part of a few points.
    const PART: usize = 40;

    /// More points than any of these bodies has.
    const MAX_POINTS: usize = 300;

    /// Numbers as programs write them, and others that are JSON: large, tiny, or with many digits.
    fn number() -> impl Strategy<Value = String> {
        prop_oneof![
            4 => any::<f64>().prop_filter_map("finite", |x| x.is_finite().then(|| format!("{x:?}"))),
            2 => (-1e3..1e3).prop_map(|x: f64| format!("{x:?}")),
            1 => any::<i64>().prop_map(|x| x.to_string()),
            1 => any::<u64>().prop_map(|x| x.to_string()),
            1 => (-1e300..1e300).prop_map(|x: f64| format!("{x:E}")),
            1 => "-?(0|[1-9][0-9]{0,25})(\\.[0-9]{1,30})?([eE][+-]?[0-9]{1,2})?",
        ]
    }

    /// Separators between numbers and brackets.
    fn blank() -> impl Strategy<Value = &'static str> {
        prop_oneof![4 => Just(""), 1 => Just(" "), 1 => Just("\r\n\t ")]
    }

    fn list(elements: Vec<String>, blank: &str) -> String {
        format!(
            "[{blank}{}{blank}]",
            elements.join(&format!("{blank},{blank}"))
        )
    }

    fn lists(
        element: impl Strategy<Value = String>,
        count: usize,
    ) -> impl Strategy<Value = String> {
        let elements = prop::collection::vec(element, count);
        (elements, blank()).prop_map(|(elements, blank)| list(elements, blank))
    }

    /// A job of which nothing is unusual.
    fn usual() -> impl Strategy<Value = String> {
        let counts = (1..=3_usize, 2..12_usize, 2..6_usize);
        let curve = counts
            .clone()
            .prop_flat_map(|(d, n, _)| lists(lists(number(), d), n));
        let rows = counts
            .clone()
            .prop_flat_map(|(d, n, m)| lists(lists(lists(number(), d), m), n));
        let heights = counts.prop_flat_map(|(_, n, m)| {
            lists(lists(number(), m + piad_fit::data::MAX_DIMENSION), n)
        });
        prop_oneof![
            curve
                .clone()
                .prop_map(|list| format!(r#"{{"curve":{{"degree":2,"points":{list}}}}}"#)),
            curve.prop_map(|list| format!(
                r#"{{"surface":{{"scattered" : {list},"degree":2}},"name":"[[1]]"}}"#
            )),
            prop_oneof![rows, heights].prop_map(|list| format!(
                r#"{{ "surface": {{ "points" :{list} }} , "method": "global"}}"#
            )),
        ]
    }

    /// The same by serde, if it is accepted.
    fn agrees(body: &str) -> bool {
        let Some(quick) = read_quickly(body.as_bytes(), PART, MAX_POINTS) else {
            return false;
        };
        let read = read_by_serde(body.as_bytes(), MAX_POINTS).unwrap();
        assert_eq!(
            serde_json::to_string(&quick).unwrap(),
            serde_json::to_string(&read).unwrap()
        );
        true
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        #[test]
        fn usual_bodies_are_read_to_the_bit(body in usual()) {
            prop_assert!(agrees(&body), "{}", body);
        }

        #[test]
        fn any_change_is_read_as_by_serde(
            body in usual(),
            at in any::<prop::sample::Index>(),
            length in 0..3_usize,
            put in "[-+0-9.eE,\\[\\]{}\" :a-z\\\\]{0,3}",
        ) {
            let at = at.index(body.len());
            let end = body.len().min(at + length);
            agrees(&format!("{}{put}{}", &body[..at], &body[end..]));
        }
    }

    #[test]
    fn unusual_bodies_are_read_by_serde() {
        for body in [
            // Other numbers than JSON has.
            r#"{"curve":{"points":[[01,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[1.,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[.5,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[+5,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[nan,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[-inf,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[1e,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[1e999,2],[3,4]]}}"#,
            // Other lists.
            r#"{"curve":{"points":[]}}"#,
            r#"{"curve":{"points":[[]]}}"#,
            r#"{"curve":{"points":[[1,2],[3]]}}"#,
            r#"{"curve":{"points":[[1,2],[3,4],]}}"#,
            r#"{"curve":{"points":[[1,2,3,4],[3,4,5,6]]}}"#,
            r#"{"curve":{"points":[[[1,2]],[[3,4]]]}}"#,
            r#"{"surface":{"points":[[1,2],[3,4]]}}"#,
            r#"{"surface":{"points":[[[1],[2]],[[3]]]}}"#,
            r#"{"surface":{"points":[[[1],null],[[3],[4]]]}}"#,
            r#"{"surface":{"scattered":[[1,2,3,4],[3,4,5,6]]}}"#,
            r#"{"surface":{"points":[[[[1]]]]}}"#,
            // Other places.
            r#"{"name":"\"points\":[[1,2],[3,4]]","curve":{"points":[]}}"#,
            r#"{"points":[[1,2],[3,4]],"curve":{"points":[]}}"#,
            r#"{"curve":{"points":[]},"method":{"points":[[1,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[1,2],[3,4]],"points":[[1,2],[3,4]]}}"#,
            r#"{"curve":{"points":[[1,2],[3,4]]},"surface":{"points":[]}}"#,
            r#"{"curve":{"points":[[1,2],[3,4]]"#,
            r#"{"curve":{"points""#,
        ] {
            assert!(!agrees(body), "{body}");
        }
    }
}
