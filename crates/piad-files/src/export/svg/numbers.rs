//! Numbers for people.

/// A number with four significant digits.
pub(super) fn rounded(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e6 => decimal(x, 4),
        _ => scientific(x, 4),
    }
}

/// A number with two significant digits.
pub(super) fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-2..1e4 => decimal(x, 2),
        _ => scientific(x, 2),
    }
}

/// A power of ten.
pub(super) fn power(exponent: i64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or_default()).unwrap_or(digit),
    };
    let digits: String = exponent.to_string().chars().map(raised).collect();
    format!("10{digits}")
}

fn decimal(x: f64, digits: i32) -> String {
    let behind = (f64::from(digits - 1) - x.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{x:.behind$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn scientific(x: f64, digits: usize) -> String {
    let text = format!("{x:.*e}", digits - 1);
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
            format!("{mantissa}·{}", power(exponent.parse().unwrap_or_default()))
        }
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (-1.0, "-1"),
            (0.123_456, "0.1235"),
            (99.999_9, "100"),
            (123_456.7, "123457"),
            (1.5e-9, "1.5·10⁻⁹"),
            (-2.5e30, "-2.5·10³⁰"),
        ] {
            assert_eq!(rounded(x), text);
        }
        assert_eq!(
            [0.0123, 7.0, 123.4, 4.56e-7].map(short),
            ["0.012", "7", "123", "4.6·10⁻⁷"]
        );
    }

    #[test]
    fn powers_of_ten_have_raised_digits() {
        assert_eq!(
            [0, 12, -345, -6789].map(power),
            ["10⁰", "10¹²", "10⁻³⁴⁵", "10⁻⁶⁷⁸⁹"]
        );
    }
}
