//! Longitude and latitude as metres in a plane.

use super::curves::{Curves, Point};
use crate::wgs84::Plane;

/// Points are left in degrees if one is further from the first one than the angle of this cosine, 60°: no plane shows
/// them as they lie.
const FARTHEST: f64 = 0.5;

/// The relative shortening of distances by the plane, at 1.8° or 200 km, from which a notice is given.
const SHORTENED: f64 = 5e-4;

/// The mean radius of the earth, in kilometres.
const RADIUS: f64 = 6371.0;

/// Converts longitudes and latitudes to metres east and north of the first point of the file, with a notice.
pub(super) fn to_metres(curves: &mut Curves) -> Vec<String> {
    let places: Vec<[f64; 2]> = curves.points().map(|[x, y, _]| [*x, *y]).collect();
    let (plane, notices) = plane(&places);
    curves.origin = plane.map(|plane| plane.place());
    if let Some(plane) = plane {
        for point in curves.points_mut() {
            let [x, y, z]: Point = *point;
            let [east, north] = plane.metres(x, y);
            *point = [east, north, z];
        }
    }
    notices
}

/// The plane in which these longitudes and latitudes are metres, if there is one, and the notice about it.
pub(super) fn plane(places: &[[f64; 2]]) -> (Option<Plane>, Vec<String>) {
    let Some(&[longitude, latitude]) = places.first() else {
        return (None, Vec::new());
    };
    let plane = Plane::new(longitude, latitude);
    let tilts = places
        .iter()
        .map(|[longitude, latitude]| plane.tilt(*longitude, *latitude));
    let least = tilts.fold(1.0, f64::min);
    if least < FARTHEST {
        let detail = "Longitude and latitude are kept as degrees: the points lie too far from each other for a plane.";
        return (None, vec![detail.to_owned()]);
    }
    let mut notices = vec![format!(
        "Longitude and latitude are metres east and north of latitude {latitude}, longitude {longitude}."
    )];
    if 1.0 - least > SHORTENED {
        notices.push(format!(
            "The farthest point is {:.0} km away, where the plane shortens distances by up to {:.2} %.",
            least.acos() * RADIUS,
            (1.0 - least) * 100.0
        ));
    }
    (Some(plane), notices)
}
