//! Decimal numbers as JSON, rounded according to an error: a batch at a time.
//!
//! With k digits behind the decimal point a number x is `n = |x| 10ᵏ`, rounded to an integer, which is cut into
//! three numbers of eight digits: those before the point, and twice those behind it.
//!
//! ```text
//! -12.5078125, k = 5:   n = 1250781   00000012 . 50781000 00000000
//! ```
//!
//! All of a batch are computed at once, with vectors; then their texts are assembled. Integers in floating point are
//! exact below 2⁵³.

use pulp::{Arch, NullaryFnOnce};

use super::decimal::{self, BATCH};

/// The bound of scaled numbers that are rounded: below it, multiplying by a power of ten and parsing the
/// result are each accurate to a hundredth of the last digit.
const LARGEST: f64 = 1e14;

/// Eight digits are numbers below this one.
const EIGHT: f64 = 1e8;

/// The powers of ten that are integers of at most 17 digits.
const POWERS: [f64; 17] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
];

/// Rounding to a power of ten.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounding {
    /// Digits behind the decimal point; negative where tens, hundreds… are left out.
    places: i32,
    /// `10^|places|`.
    power: f64,
}

impl Rounding {
    /// The coarsest rounding that changes no number by more than a hundredth of `error`, with some
    /// margin for the arithmetic: `0.6 · 10^-places ≤ 0.01 · error`. `None` if the error is not a positive
    /// finite number.
    pub(super) fn for_error(error: f64) -> Option<Self> {
        if !(error > 0.0 && error.is_finite()) {
            return None;
        }
        let places = (60_f64.log10() - error.log10()).ceil() as i32;
        // Parsing gives the nearest number, which `powi` does not.
        let power: f64 = format!("1e{}", places.abs()).parse().ok()?;
        power.is_finite().then_some(Self { places, power })
    }

    /// `|x| 10^places`, not rounded yet.
    #[inline(always)]
    fn scaled(self, x: f64) -> f64 {
        match self.places < 0 {
            true => x.abs() / self.power,
            false => x.abs() * self.power,
        }
    }

    /// Writes a number below [`LARGEST`] when it is scaled, with an exponent where that is shorter.
    fn write(self, x: f64, room: &mut [u8]) -> usize {
        let number = (self.scaled(x) + 0.5) as u64;
        if number == 0 {
            room[0] = b'0';
            return 1;
        }
        let sign = usize::from(x < 0.0);
        room[0] = b'-';
        sign + write_short(number, -self.places, &mut room[sign..])
    }
}

/// A batch of numbers with their digits, eight at a time, the first in the lowest byte.
pub(super) struct Batch {
    rounding: Rounding,
    /// `|x| 10^places`, not rounded yet.
    scaled: [f64; BATCH],
    /// The bound of scaled numbers that have eight digits before the point and sixteen behind it, or fewer.
    limit: f64,
    /// The digits before the point.
    whole: [u64; BATCH],
    /// Those behind it.
    part: [[u64; BATCH]; 2],
}

impl Batch {
    /// The space for a batch.
    pub(super) fn new(rounding: Rounding) -> Self {
        let limit = match rounding.places {
            places @ 1..=16 => LARGEST.min(EIGHT * POWERS[places as usize]) - 1.0,
            _ => 0.0,
        };
        Self {
            rounding,
            scaled: [0.0; BATCH],
            limit,
            whole: [0; BATCH],
            part: [[0; BATCH]; 2],
        }
    }

    /// Computes the digits of at most [`BATCH`] numbers.
    pub(super) fn compute(&mut self, numbers: &[f64]) {
        Arch::new().dispatch(Compute(self, numbers));
    }

    /// Returns true if number k is written in full: its rounded text would have too many digits, or it is NaN or
    /// infinite.
    #[inline(always)]
    pub(super) fn is_in_full(&self, k: usize) -> bool {
        self.scaled[k].is_nan() || self.scaled[k] >= LARGEST
    }

    /// Writes the number x, which is number k of the batch, to the start of [`decimal::ROOM`] bytes; returns its
    /// length. `in_full` is its text in full, which is only used if [`Self::is_in_full`] is true.
    #[inline(always)]
    pub(super) fn write(&self, k: usize, x: f64, in_full: &str, room: &mut [u8]) -> usize {
        if self.is_in_full(k) {
            return decimal::copy(in_full, room);
        }
        let joined = (self.scaled[k] < self.limit).then(|| self.join(k, x < 0.0, room));
        joined
            .flatten()
            .unwrap_or_else(|| self.rounding.write(x, room))
    }

    /// Assembles the text of number k, if it needs no exponent and is not zero. Copies have constant sizes, which is
    /// fast: more bytes are written than count.
    #[inline(always)]
    fn join(&self, k: usize, is_negative: bool, room: &mut [u8]) -> Option<usize> {
        let room: &mut [u8; decimal::ROOM] = room.first_chunk_mut()?;
        let (whole, part) = (self.whole[k], self.part.each_ref().map(|part| part[k]));
        let end = match part {
            [high, 0] => 8 - high.leading_zeros() as usize / 8,
            [_, low] => 16 - low.leading_zeros() as usize / 8,
        };
        let is_small = whole == 0 && part[0] as u32 == 0;
        let zeros = whole.leading_zeros() / 8;
        if is_small || (end == 0 && zeros > 3) {
            return None;
        }
        room[0] = b'-';
        let first = (whole.trailing_zeros() as usize / 8).min(7);
        let start = usize::from(is_negative);
        let point = start + 8 - first;
        let mut put = |at: usize, digits: u64| {
            room[at..at + 8].copy_from_slice(&digits.to_le_bytes());
        };
        put(start, characters(whole) >> (8 * first));
        put(point + 1, characters(part[0]));
        put(point + 9, characters(part[1]));
        room[point] = b'.';
        Some(if end == 0 { point } else { point + 1 + end })
    }
}

/// Computes the digits of a batch.
struct Compute<'a>(&'a mut Batch, &'a [f64]);

impl NullaryFnOnce for Compute<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self(batch, numbers) = self;
        let rounding = batch.rounding;
        let places = batch.scaled.iter_mut().zip(numbers);
        places.for_each(|(scaled, &x)| *scaled = rounding.scaled(x));
        // Near the end of a fit all numbers are written in full.
        if !batch.scaled.iter().any(|&scaled| scaled < batch.limit) {
            return;
        }
        let (count, power) = (rounding.places as usize, rounding.power);
        // Of the digits behind the point, the first eight are `part · up / down`.
        let up = POWERS[8_usize.saturating_sub(count)];
        let (down, scale) = (POWERS[count.saturating_sub(8)], POWERS[16 - count]);
        let mut eights = [[0_u32; BATCH]; 3];
        let [whole, high, low] = &mut eights;
        for (k, &scaled) in batch.scaled.iter().enumerate() {
            let scaled = if scaled < batch.limit { scaled } else { 0.0 };
            let (before, behind) = divide((scaled + 0.5).floor(), power);
            let (first, last) = divide(behind * up, down);
            whole[k] = integer(before);
            high[k] = integer(first);
            low[k] = integer(last * scale);
        }
        let [high_digits, low_digits] = &mut batch.part;
        let digits = [&mut batch.whole, high_digits, low_digits];
        for (digits, eights) in digits.into_iter().zip(&eights) {
            let places = digits.iter_mut().zip(eights);
            places.for_each(|(digits, &number)| *digits = eight_digits(number));
        }
    }
}

/// Quotient and remainder of integers below 2⁵³.
#[inline(always)]
fn divide(number: f64, by: f64) -> (f64, f64) {
    let near = (number * (1.0 / by)).floor();
    let left = number - near * by;
    // The inverse is rounded, so that the quotient may be off by one.
    let quotient = near + f64::from(left >= by) - f64::from(left < 0.0);
    (quotient, number - quotient * by)
}

/// An integer from 0 to 2³² − 1. Added to 2⁵² it is in the lowest bits; `as` also looks for numbers that are out of
/// range, which takes longer than all the rest.
#[inline(always)]
fn integer(x: f64) -> u32 {
    const FIFTY_TWO_BITS: f64 = (1_u64 << 52) as f64;
    (x + FIFTY_TWO_BITS).to_bits() as u32
}

/// The eight decimal digits of a number below 10⁸, the first in the lowest byte: pairs of four, of two and
/// of one digit are divided at the same time.
#[inline(always)]
fn eight_digits(number: u32) -> u64 {
    let four = ((u64::from(number) * 3_518_437_209) >> 45) as u32;
    let fours = u64::from(four) | (u64::from(number - 10_000 * four) << 32);
    let hundreds = ((fours * 10_486) >> 20) & 0x7f_0000_007f;
    let twos = hundreds | ((fours - 100 * hundreds) << 16);
    let tens = ((twos * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | ((twos - 10 * tens) << 8)
}

/// Digits as characters.
fn characters(digits: u64) -> u64 {
    digits | 0x3030_3030_3030_3030
}

/// Writes `number · 10^exponent`, without an exponent where that is short.
fn write_short(mut number: u64, mut exponent: i32, room: &mut [u8]) -> usize {
    while number.is_multiple_of(10) {
        number /= 10;
        exponent += 1;
    }
    let mut digits = [0; 20];
    let mut start = digits.len();
    while number > 0 {
        start -= 1;
        digits[start] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    let digits = &digits[start..];
    // Digits before the decimal point.
    let before = digits.len() as i32 + exponent;
    match (exponent, before) {
        (0..=3, _) => join(room, [digits, &b"000"[..exponent as usize], b""]),
        (..0, 1..) => {
            let (whole, part) = digits.split_at(before as usize);
            join(room, [whole, b".", part])
        }
        (..0, -3..=0) => {
            let zeros = &b"0.000"[..2 + before.unsigned_abs() as usize];
            join(room, [zeros, digits, b""])
        }
        _ => {
            let exponent = format!("e{exponent}");
            join(room, [digits, exponent.as_bytes(), b""])
        }
    }
}

/// Writes parts one behind the other; returns the number of bytes.
fn join(room: &mut [u8], parts: [&[u8]; 3]) -> usize {
    let mut at = 0;
    for part in parts {
        room[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    }
    at
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(write: impl FnOnce(&mut [u8]) -> usize) -> String {
        let mut json = [0; decimal::ROOM];
        let length = write(&mut json);
        String::from_utf8(json[..length].to_vec()).unwrap()
    }

    fn in_full(x: f64) -> String {
        decimal::in_full(&[x], |_| true, |texts| texts[0].to_owned())
    }

    fn rounded(x: f64, error: f64) -> String {
        let Some(rounding) = Rounding::for_error(error) else {
            return in_full(x);
        };
        let mut batch = Batch::new(rounding);
        batch.compute(&[x]);
        let written = text(|json| batch.write(0, x, &in_full(x), json));
        if !batch.is_in_full(0) {
            assert_eq!(written, text(|json| rounding.write(x, json)));
        }
        written
    }

    #[test]
    fn numbers_have_the_digits_that_the_error_deserves() {
        for (x, error, expected) in [
            (1.0 / 3.0, 1.0, "0.33"),
            (1.0 / 3.0, 0.6, "0.33"),
            (1.0 / 3.0, 0.599, "0.333"),
            (-2.0 / 3.0, 1e-3, "-0.66667"),
            (3.0, 1e-3, "3"),
            (-0.0, 1e-3, "0"),
            (-1e-9, 1e-3, "0"),
            (0.999_999, 1e-3, "1"),
            (123_456.789, 1e5, "123000"),
            (123_456.789, 1e7, "1e5"),
            (49_999.0, 1e7, "0"),
            (5.4321e-9, 1e-9, "543e-11"),
            (0.000_123_4, 1e-5, "0.0001234"),
            (1.234_567e300, 1e297, "123457e295"),
            (1.234_567e-300, 1e-303, "123457e-305"),
            (1.0 / 3.0, 1e-13, "0.3333333333333333"),
            (1.0 / 3.0, 0.0, "0.3333333333333333"),
            (1.0 / 3.0, f64::INFINITY, "0.3333333333333333"),
            (f64::NAN, 1.0, "null"),
            (f64::NAN, 1e7, "null"),
            (f64::INFINITY, 1.0, "null"),
        ] {
            assert_eq!(rounded(x, error), expected, "{x} {error}");
        }
    }

    /// Numbers near each other, and any numbers.
    fn number_and_error() -> impl Strategy<Value = (f64, f64)> {
        let near = (-320..300_i32, -20..20_i32, -10.0..10.0, 1.0..10.0);
        let near = near.prop_map(|(e, difference, x, error)| {
            (
                x * 10f64.powi(e),
                error * 10f64.powi((e + difference).min(307)),
            )
        });
        let any = (any::<f64>(), any::<f64>()).prop_map(|(x, error)| (x, error.abs()));
        prop_oneof![4 => near, 1 => any]
    }

    #[test]
    fn eight_digits_are_those_of_the_number() {
        let numbers = (0..10_000).flat_map(|k| [k, 9_999 - k + 10_000 * k, 99_999_999 - k]);
        for number in numbers.chain([12_345_678, 90_000_000]) {
            let digits = characters(eight_digits(number)).to_le_bytes();
            assert_eq!(format!("{number:08}").as_bytes(), digits);
        }
    }

    /// Each number of a batch is written as it would be alone.
    #[test]
    fn numbers_of_a_batch_do_not_depend_on_each_other() {
        let numbers = [
            1.0 / 3.0,
            -2e15,
            f64::NAN,
            -0.0,
            1e-9,
            123_456.789,
            -7.0,
            120_000.0,
            1e13,
        ];
        for error in [1e-9, 1e-3, 1.0, 1e3] {
            let mut batch = Batch::new(Rounding::for_error(error).unwrap());
            batch.compute(&[0.123; BATCH]);
            batch.compute(&numbers);
            for (k, &x) in numbers.iter().enumerate() {
                let written = text(|json| batch.write(k, x, &in_full(x), json));
                assert_eq!(written, rounded(x, error), "{x} {error}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn rounding_costs_a_hundredth_of_the_error_and_no_bytes((x, error) in number_and_error()) {
            prop_assume!(x.is_finite());
            let short = rounded(x, error);
            let full = in_full(x);
            let read: f64 = serde_json::from_str(&short).unwrap();
            let read_in_full: f64 = serde_json::from_str(&full).unwrap();
            prop_assert_eq!(read_in_full.to_bits(), x.to_bits());
            prop_assert!(short.len() <= full.len(), "{} {}", short, full);
            prop_assert!(short != "-0");
            if error.is_finite() && error > 0.0 {
                prop_assert!((read - x).abs() <= 0.01 * error, "{} {} {}", short, x, error);
            } else {
                prop_assert_eq!(short, full);
            }
        }
    }
}
