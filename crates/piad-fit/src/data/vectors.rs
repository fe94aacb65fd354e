//! Vectors of space.

/// `a × b`
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The Euclidean length.
pub fn length(a: [f64; 3]) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// `a / ‖a‖`, if that is finite.
pub fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = length(a);
    let unit = a.map(|x| x / length);
    unit.iter().all(|x| x.is_finite()).then_some(unit)
}

/// `a − b`
pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a · b`
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The place of a point in space: points of the plane have z = 0.
pub fn in_space(coordinates: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut place = [0.0; 3];
    for (x, coordinate) in place.iter_mut().zip(coordinates) {
        *x = coordinate;
    }
    place
}
