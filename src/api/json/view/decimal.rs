//! Decimal numbers as JSON: with all digits, or rounded according to an error.

use std::array;

/// The bound of scaled numbers that are rounded: below it, multiplying by a power of ten and parsing the
/// result are each accurate to a hundredth of the last digit.
const LARGEST: f64 = 1e14;

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

    /// Writes a number rounded, or in full if the rounded one would have too many digits, to the start of
    /// [`ROOM`] bytes; returns how many it takes.
    pub(super) fn write(self, x: f64, room: &mut [u8]) -> usize {
        let scaled = if self.places < 0 {
            x.abs() / self.power
        } else {
            x.abs() * self.power
        };
        if scaled.is_nan() || scaled >= LARGEST {
            return write(x, room);
        }
        let number = (scaled + 0.5) as u64;
        if number == 0 {
            room[0] = b'0';
            return 1;
        }
        let sign = usize::from(x < 0.0);
        room[0] = b'-';
        let room = &mut room[sign..];
        let length = write_fixed(number, self.places, room);
        sign + length.unwrap_or_else(|| write_short(number, -self.places, room))
    }
}

/// Writes `number · 10^-places` for numbers of at most 16 digits, if that takes a decimal point and no
/// exponent; returns how many bytes it is. Copies have constant sizes, which is fast: more is written
/// than counts.
fn write_fixed(number: u64, places: i32, room: &mut [u8]) -> Option<usize> {
    const HALF: u64 = 100_000_000;
    const ZEROS: usize = 8;
    let halves = [number / HALF, number % HALF].map(eight_digits);
    // Where its first digit and the end of its last one that is not 0 are among sixteen, and the point.
    let first = match halves {
        [0, low] => 8 + low.trailing_zeros() as usize / 8,
        [high, _] => high.trailing_zeros() as usize / 8,
    };
    let end = match halves {
        [high, 0] => 8 - high.leading_zeros() as usize / 8,
        [_, low] => 16 - low.leading_zeros() as usize / 8,
    };
    let point = 16_usize.checked_sub(usize::try_from(places).ok()?)?;
    if end <= point || first > point + 3 {
        return None;
    }
    let mut text = [b'0'; 48];
    for (k, half) in halves.into_iter().enumerate() {
        let characters = (half | 0x3030_3030_3030_3030).to_le_bytes();
        text[ZEROS + 8 * k..ZEROS + 8 * k + 8].copy_from_slice(&characters);
    }
    let start = (ZEROS + first).min(ZEROS + point - 1);
    let point = ZEROS + point;
    let before = point - start;
    room[..16].copy_from_slice(&text[start..start + 16]);
    room[before] = b'.';
    room[before + 1..before + 17].copy_from_slice(&text[point..point + 16]);
    Some(before + 1 + ZEROS + end - point)
}

/// The eight decimal digits of a number below 10⁸, the first in the lowest byte: pairs of four, of two and
/// of one digit are divided at the same time.
fn eight_digits(number: u64) -> u64 {
    let fours = (number / 10_000) | ((number % 10_000) << 32);
    let hundreds = ((fours * 10_486) >> 20) & 0x7f_0000_007f;
    let twos = hundreds | ((fours - 100 * hundreds) << 16);
    let tens = ((twos * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | ((twos - 10 * tens) << 8)
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

/// Writes parts one behind the other; returns how many bytes they are.
fn join(room: &mut [u8], parts: [&[u8]; 3]) -> usize {
    let mut at = 0;
    for part in parts {
        room[at..at + part.len()].copy_from_slice(part);
        at += part.len();
    }
    at
}

/// The bytes that are there when a number is written: more than it takes.
pub(super) const ROOM: usize = 40;

/// The most bytes that a number takes.
pub(super) const LONGEST: usize = 2 * HALF + 1;

/// Most numbers have between one and two times this many characters, and none has more.
const HALF: usize = 12;

/// Numbers that are written in full at a time.
pub(super) const BATCH: usize = 96;

/// The texts of numbers, with as many digits as it takes to read them back exactly; `null` for those that
/// are not finite. They are copied once all are there: a text that was only just written takes several
/// times as long to read.
pub(super) fn in_full<R>(numbers: &[f64], use_texts: impl FnOnce(&[&str]) -> R) -> R {
    let mut buffers: [_; BATCH] = array::from_fn(|_| zmij::Buffer::new());
    let mut texts = ["null"; BATCH];
    let places = texts.iter_mut().zip(&mut buffers);
    for ((text, buffer), x) in places.zip(numbers) {
        if x.is_finite() {
            *text = buffer.format_finite(*x);
        }
    }
    use_texts(&texts[..numbers.len().min(BATCH)])
}

/// Writes a text of a number to the start of [`ROOM`] bytes; returns how many it takes.
#[inline(always)]
pub(super) fn copy(text: &str, room: &mut [u8]) -> usize {
    let digits = text.as_bytes();
    let length = digits.len();
    if (HALF..=2 * HALF).contains(&length) {
        // Two overlapping copies of a constant size are faster than one of variable size.
        room[..HALF].copy_from_slice(&digits[..HALF]);
        room[length - HALF..length].copy_from_slice(&digits[length - HALF..]);
    } else {
        room[..length].copy_from_slice(digits);
    }
    length
}

/// Writes one number in full to the start of [`ROOM`] bytes; returns how many it takes.
pub(super) fn write(x: f64, room: &mut [u8]) -> usize {
    match x.is_finite() {
        true => copy(zmij::Buffer::new().format_finite(x), room),
        false => copy("null", room),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(write: impl FnOnce(&mut [u8]) -> usize) -> String {
        let mut json = [0; ROOM];
        let length = write(&mut json);
        String::from_utf8(json[..length].to_vec()).unwrap()
    }

    fn rounded(x: f64, error: f64) -> String {
        match Rounding::for_error(error) {
            Some(rounding) => text(|json| rounding.write(x, json)),
            None => text(|json| write(x, json)),
        }
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
            let digits = (eight_digits(number) | 0x3030_3030_3030_3030).to_le_bytes();
            assert_eq!(format!("{number:08}").as_bytes(), digits);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn rounding_costs_a_hundredth_of_the_error_and_no_bytes((x, error) in number_and_error()) {
            prop_assume!(x.is_finite());
            let short = rounded(x, error);
            let full = text(|json| write(x, json));
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
