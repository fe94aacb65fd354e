//! Powers of two that bring numbers to the order of one.
//!
//! Squares of lengths above 10¹⁵⁴ overflow, and those below 10⁻¹⁵⁴ lose digits. So lengths are
//! scaled before they are squared, by a power of two, which changes no digit.

/// A power of two near `1 / length`: squares of lengths like this neither over- nor underflow, and
/// multiplying with it is exact. It is 1 if the length is zero or NaN.
pub(super) fn normalizing_scale(length: f64) -> f64 {
    if length > 0.0 {
        (-length.log2().floor()).clamp(-1022.0, 1022.0).exp2()
    } else {
        1.0
    }
}
