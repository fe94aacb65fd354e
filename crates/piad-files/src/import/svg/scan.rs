//! Contents of SVG attributes: numbers, lengths and transforms.

/// The numbers and letters of a text.
#[derive(Clone, Copy)]
pub(super) struct Scanner<'a> {
    pub(super) rest: &'a str,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text }
    }

    /// Passes blanks and commas.
    fn skip(&mut self) {
        let is_between = |c: char| c.is_ascii_whitespace() || c == ',';
        self.rest = self.rest.trim_start_matches(is_between);
    }

    pub(super) fn is_at_end(&mut self) -> bool {
        self.skip();
        self.rest.is_empty()
    }

    /// The next number, which must be finite.
    pub(super) fn number(&mut self) -> Option<f64> {
        self.skip();
        let bare = self.rest.strip_prefix('+').unwrap_or(self.rest);
        let unsigned = self.rest.strip_prefix(['+', '-']).unwrap_or(self.rest);
        if !unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return None;
        }
        let (number, length) = fast_float2::parse_partial::<f64, _>(bare).ok()?;
        self.rest = bare.get(length..)?;
        number.is_finite().then_some(number)
    }

    /// This many numbers.
    pub(super) fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    /// A flag of an arc, which needs no blank behind it.
    pub(super) fn flag(&mut self) -> Option<bool> {
        self.skip();
        let flag = self.rest.chars().next()?;
        self.rest = self.rest.get(1..)?;
        match flag {
            '0' => Some(false),
            '1' => Some(true),
            _ => None,
        }
    }

    /// The next letter.
    pub(super) fn letter(&mut self) -> Option<char> {
        self.skip();
        let letter = self.rest.chars().next()?;
        let is_letter = letter.is_ascii_alphabetic();
        is_letter.then(|| self.rest = self.rest.get(1..).unwrap_or_default())?;
        Some(letter)
    }

    /// The text up to a character, which is passed.
    fn until(&mut self, end: char) -> Option<&'a str> {
        let (text, rest) = self.rest.split_once(end)?;
        self.rest = rest;
        Some(text)
    }
}

/// The number of pixels of a unit.
const UNITS: [(&str, f64); 8] = [
    ("", 1.0),
    ("px", 1.0),
    ("in", 96.0),
    ("cm", 96.0 / 2.54),
    ("mm", 96.0 / 25.4),
    ("q", 96.0 / 101.6),
    ("pt", 96.0 / 72.0),
    ("pc", 16.0),
];

/// A length in pixels; `None` in units that depend on the window or on fonts.
pub(super) fn length(text: &str) -> Option<f64> {
    let mut scanner = Scanner::new(text);
    let number = scanner.number()?;
    let unit = scanner.rest.trim().to_ascii_lowercase();
    let (_, pixels) = UNITS.iter().find(|(name, _)| *name == unit)?;
    Some(number * pixels)
}

/// An affine map: `x' = a x + c y + e`, `y' = b x + d y + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform([f64; 6]);

impl Transform {
    pub(super) const IDENTITY: Self = Self([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    /// Replaces y by its difference from a height.
    pub(super) fn turned_over(height: f64) -> Self {
        Self([1.0, 0.0, 0.0, -1.0, 0.0, height])
    }

    pub(super) fn shifted(x: f64, y: f64) -> Self {
        Self::scaled(1.0, x, y)
    }

    /// Scaled first, and then shifted.
    pub(super) fn scaled(scale: f64, x: f64, y: f64) -> Self {
        Self([scale, 0.0, 0.0, scale, x, y])
    }

    pub(super) fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d, e, f] = self.0;
        [a * x + c * y + e, b * x + d * y + f]
    }

    /// First the other one, then this one.
    pub(super) fn after(&self, first: Self) -> Self {
        let [a, b, c, d, e, f] = self.0;
        let [p, q, r, s, t, u] = first.0;
        let [x, y] = [a * t + c * u + e, b * t + d * u + f];
        Self([
            a * p + c * q,
            b * p + d * q,
            a * r + c * s,
            b * r + d * s,
            x,
            y,
        ])
    }

    /// The transform of an attribute.
    pub(super) fn of_text(text: &str) -> Option<Self> {
        let mut scanner = Scanner::new(text);
        let mut all = Self::IDENTITY;
        while !scanner.is_at_end() {
            let name = scanner.until('(')?.trim();
            let mut inner = Scanner::new(scanner.until(')')?);
            let mut numbers = Vec::new();
            while !inner.is_at_end() && numbers.len() < 6 {
                numbers.push(inner.number()?);
            }
            if !inner.is_at_end() {
                return None;
            }
            all = all.after(Self::of_function(name, &numbers)?);
        }
        Some(all)
    }

    fn of_function(name: &str, numbers: &[f64]) -> Option<Self> {
        let shift = Self::shifted;
        Some(match (name, numbers) {
            ("matrix", &[a, b, c, d, e, f]) => Self([a, b, c, d, e, f]),
            ("translate", &[x]) => shift(x, 0.0),
            ("translate", &[x, y]) => shift(x, y),
            ("scale", &[x]) => Self([x, 0.0, 0.0, x, 0.0, 0.0]),
            ("scale", &[x, y]) => Self([x, 0.0, 0.0, y, 0.0, 0.0]),
            ("rotate", &[angle]) => {
                let (sine, cosine) = angle.to_radians().sin_cos();
                Self([cosine, sine, -sine, cosine, 0.0, 0.0])
            }
            ("rotate", &[angle, x, y]) => {
                let turned = Self::of_function("rotate", &[angle])?;
                shift(x, y).after(turned).after(shift(-x, -y))
            }
            ("skewX", &[angle]) => Self([1.0, 0.0, angle.to_radians().tan(), 1.0, 0.0, 0.0]),
            ("skewY", &[angle]) => Self([1.0, angle.to_radians().tan(), 0.0, 1.0, 0.0, 0.0]),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_need_little_between_them() {
        let mut scanner = Scanner::new(" 1-2.5.5,+3e-1\n.5e1em");
        let found: Vec<f64> = std::iter::from_fn(|| scanner.number()).collect();
        assert_eq!(found, [1.0, -2.5, 0.5, 0.3, 5.0]);
        assert_eq!(scanner.rest, "em");
        for text in [
            "", "nan", "inf", "-inf", "1e999", "+-1", "++1", "-", "é", ".",
        ] {
            assert_eq!(Scanner::new(text).number(), None, "{text}");
        }
        let mut flags = Scanner::new("01 ,1é");
        let found: Vec<bool> = std::iter::from_fn(|| flags.flag()).collect();
        assert_eq!(found, [false, true, true]);
    }

    #[test]
    fn lengths_are_pixels() {
        for (text, expected) in [
            ("1", Some(1.0)),
            (" 2.5px ", Some(2.5)),
            ("25.4mm", Some(96.0)),
            ("1in", Some(96.0)),
            ("72pt", Some(96.0)),
            ("50%", None),
            ("1em", None),
            ("", None),
        ] {
            let length = length(text);
            assert_eq!(
                length.map(|it| (it * 1e9).round() / 1e9),
                expected,
                "{text}"
            );
        }
    }

    #[test]
    fn transforms_follow_each_other() {
        for (text, expected) in [
            ("", [1.0, 2.0]),
            ("translate(3)", [4.0, 2.0]),
            ("scale(2, 3) translate(10 20)", [22.0, 66.0]),
            ("translate(10 20),scale(2 3)", [12.0, 26.0]),
            ("rotate(90)", [-2.0, 1.0]),
            ("rotate(180 1 1)", [1.0, 0.0]),
            ("skewX(45) skewY ( -45 )", [2.0, 1.0]),
            ("matrix(1 2 3 4 5 6)", [12.0, 16.0]),
        ] {
            let found = Transform::of_text(text).unwrap().apply([1.0, 2.0]);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{text}: {found}");
            }
        }
        for text in [
            "scale",
            "scale()",
            "scale(1 2 3)",
            "turn(1)",
            "scale(a)",
            "matrix(1 2 3 4 5 6 7)",
        ] {
            assert_eq!(Transform::of_text(text), None, "{text}");
        }
    }
}
