//! Numbers of answers, and how far they are apart.

use serde_json::Value;

/// All numbers of nested lists, one after the other.
pub fn numbers(value: &Value) -> Vec<f64> {
    let numbers = flat(value);
    assert!(!numbers.iter().any(|x| x.is_nan()), "{value}");
    numbers
}

/// The same, with NaN for null.
pub fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(flat).collect(),
        Value::Null => vec![f64::NAN],
        value => vec![value.as_f64().unwrap()],
    }
}

/// The largest difference of two nested lists of the same shape.
pub fn largest_difference(a: &Value, b: &Value) -> f64 {
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}
