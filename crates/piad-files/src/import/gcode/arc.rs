//! Arcs of G-code, from the place of the tool to another one.

use crate::import::curves::Point;
use crate::import::sampled::{Arc, turn};

/// The radii at both ends of an arc may differ by this part of the larger one; the arc is then part of a spiral.
const LARGEST_DIFFERENCE: f64 = 0.5;

/// The chord of an arc may be longer than its diameter by this part, which rounding makes.
const ROUNDING: f64 = 1e-3;

/// The plane of an arc: the axes in it, and the one across.
pub(super) type Plane = [usize; 3];

/// Where the centre of an arc is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Centre {
    At(Point),
    /// By the radius, which is negative for the longer one of two arcs.
    Radius(f64),
}

/// The points of an arc without its start.
///
/// # Errors
///
/// If there is no such arc.
pub(super) fn points(
    from: Point,
    to: Point,
    centre: Centre,
    plane: Plane,
    clockwise: bool,
) -> Result<Vec<Point>, String> {
    let flat = |point: Point| plane.map(|axis| point.get(axis).copied().unwrap_or_default());
    let ([u0, v0, w0], [u1, v1, w1]) = (flat(from), flat(to));
    let (u, v) = match centre {
        Centre::At(centre) => {
            let [u, v, _] = flat(centre);
            (u, v)
        }
        Centre::Radius(radius) => by_radius([u0, v0], [u1, v1], radius, clockwise)?,
    };
    let radii = [(u0 - u).hypot(v0 - v), (u1 - u).hypot(v1 - v)];
    let largest = radii[0].max(radii[1]);
    let difference = (radii[0] - radii[1]).abs();
    if largest == 0.0 || difference > LARGEST_DIFFERENCE * largest {
        return Err(format!(
            "the ends of this arc are {} and {} away from its centre",
            radii[0], radii[1]
        ));
    }
    let angles = [(v0 - v).atan2(u0 - u), (v1 - v).atan2(u1 - u)];
    // To the same place is a full turn, whatever rounding makes of the angles.
    let angle = if [u0, v0] == [u1, v1] {
        0.0
    } else {
        angles[1] - angles[0]
    };
    let sweep = match clockwise {
        true => -turn(-angle),
        false => turn(angle),
    };
    let arc = Arc {
        centre: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        start: angles[0],
        sweep,
    };
    let point = |part: f64| {
        let between = |start: f64, end: f64| start + part * (end - start);
        let radius = between(radii[0], radii[1]);
        let [x, y, _] = arc.at(part);
        let along = [u + radius * x, v + radius * y, between(w0, w1)];
        let mut point = [0.0; 3];
        for (axis, value) in plane.into_iter().zip(along) {
            if let Some(place) = point.get_mut(axis) {
                *place = value;
            }
        }
        point
    };
    let inner = arc.parts().filter(|part| *part < 1.0).map(point);
    Ok(inner.chain([to]).collect())
}

/// The centre of an arc by its radius.
fn by_radius(
    from: [f64; 2],
    to: [f64; 2],
    radius: f64,
    clockwise: bool,
) -> Result<(f64, f64), String> {
    let [du, dv] = [to[0] - from[0], to[1] - from[1]];
    let chord = du.hypot(dv);
    if chord == 0.0 {
        return Err("an arc with a radius (R) ends elsewhere than it starts".to_owned());
    }
    let half = chord / 2.0 / radius.abs();
    if half.is_nan() || half > 1.0 + ROUNDING {
        return Err(format!(
            "no arc of radius {radius} leads to a place {chord} away"
        ));
    }
    let away = radius.abs() * (1.0 - half * half).max(0.0).sqrt() / chord;
    // The shorter arc to the left has its centre on the left.
    let side = if clockwise == (radius < 0.0) {
        away
    } else {
        -away
    };
    Ok((
        (from[0] + to[0]) / 2.0 - side * dv,
        (from[1] + to[1]) / 2.0 + side * du,
    ))
}
