//! Longitude and latitude as metres in a plane.

use super::curves::{Curves, Point};

/// The larger semi-axis of the ellipsoid of WGS84, in metres.
const RADIUS: f64 = 6_378_137.0;

/// Its flattening.
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// The square of its eccentricity.
const ECCENTRICITY: f64 = FLATTENING * (2.0 - FLATTENING);

/// Points are left in degrees if one is further from the first one than the angle of this cosine, 60°: no plane shows
/// them as they lie.
const FARTHEST: f64 = 0.5;

/// The plane shortens distances by this part, at 1.8° or 200 km, before it is said.
const SHORTENED: f64 = 5e-4;

/// The plane that touches the ellipsoid at a place, with axes to the east and to the north.
#[derive(Debug)]
pub(super) struct Plane {
    /// In radians.
    longitude: f64,
    /// Sine and cosine of the latitude.
    sine: f64,
    cosine: f64,
    /// Where the place is in the plane of its meridian: its distance from the axis of the earth and its height above
    /// the equator.
    place: (f64, f64),
}

impl Plane {
    /// The plane at a place in degrees.
    pub(super) fn new(longitude: f64, latitude: f64) -> Self {
        let (sine, cosine) = latitude.to_radians().sin_cos();
        Self {
            longitude: longitude.to_radians(),
            sine,
            cosine,
            place: in_meridian(sine, cosine),
        }
    }

    /// How far to the east and to the north of the place another one is in the plane, straight below or above it.
    pub(super) fn metres(&self, longitude: f64, latitude: f64) -> [f64; 2] {
        let (sine, cosine) = latitude.to_radians().sin_cos();
        let (radius, height) = in_meridian(sine, cosine);
        let (east, along) = (longitude.to_radians() - self.longitude).sin_cos();
        let north =
            (height - self.place.1) * self.cosine - (radius * along - self.place.0) * self.sine;
        [radius * east, north]
    }

    /// Cosine of the angle between the plane and that at another place.
    fn tilt(&self, longitude: f64, latitude: f64) -> f64 {
        let (sine, cosine) = latitude.to_radians().sin_cos();
        let along = (longitude.to_radians() - self.longitude).cos();
        self.sine * sine + self.cosine * cosine * along
    }
}

/// Where a point of the ellipsoid is in the plane of its meridian, by sine and cosine of its latitude.
fn in_meridian(sine: f64, cosine: f64) -> (f64, f64) {
    let normal = RADIUS / (1.0 - ECCENTRICITY * sine * sine).sqrt();
    (normal * cosine, normal * (1.0 - ECCENTRICITY) * sine)
}

/// Makes longitudes and latitudes metres to the east and to the north of the first point of the file, and says so.
pub(super) fn to_metres(curves: &mut Curves) -> Vec<String> {
    let Some([longitude, latitude, _]) = curves.points().next().copied() else {
        return Vec::new();
    };
    let plane = Plane::new(longitude, latitude);
    let tilts = curves.points().map(|[x, y, _]| plane.tilt(*x, *y));
    let least = tilts.fold(1.0, f64::min);
    if least < FARTHEST {
        let detail = "Longitude and latitude are kept as degrees: the points lie too far from each other for a plane.";
        return vec![detail.to_owned()];
    }
    for point in curves.points_mut() {
        let [x, y, z]: Point = *point;
        let [east, north] = plane.metres(x, y);
        *point = [east, north, z];
    }
    let mut notices = vec![format!(
        "Longitude and latitude are metres east and north of latitude {latitude}, longitude {longitude}."
    )];
    if 1.0 - least > SHORTENED {
        notices.push(format!(
            "The farthest point is {:.0} km away, where the plane shortens distances by up to {:.2} %.",
            least.acos() * RADIUS / 1000.0,
            (1.0 - least) * 100.0
        ));
    }
    notices
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates in space, as every book has them.
    fn in_space(longitude: f64, latitude: f64) -> [f64; 3] {
        let (b, a) = (6_356_752.314_245_179, 6_378_137.0_f64);
        let (sl, cl) = longitude.to_radians().sin_cos();
        let (s, c) = latitude.to_radians().sin_cos();
        let n = a * a / (a * a * c * c + b * b * s * s).sqrt();
        [n * c * cl, n * c * sl, b * b / (a * a) * n * s]
    }

    #[test]
    fn metres_are_the_coordinates_along_east_and_north() {
        for (longitude, latitude) in [(11.5, 48.0), (-70.6, -33.4), (179.9, 0.0), (0.0, 89.99)] {
            let plane = Plane::new(longitude, latitude);
            let origin = in_space(longitude, latitude);
            let (sl, cl) = f64::to_radians(longitude).sin_cos();
            let (s, c) = f64::to_radians(latitude).sin_cos();
            for (dx, dy) in [(0.0, 0.0), (0.01, -0.02), (-3.0, 4.0), (0.5, 0.0)] {
                let [x, y, z] = in_space(longitude + dx, latitude + dy);
                let [x, y, z] = [x - origin[0], y - origin[1], z - origin[2]];
                let expected = [-sl * x + cl * y, -s * cl * x - s * sl * y + c * z];
                let found = plane.metres(longitude + dx, latitude + dy);
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-8, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn short_distances_are_those_of_the_radii_of_curvature() {
        // A degree of latitude at 45° is 111,131.745 m of the meridian, one of longitude 78,846.806 m.
        for (latitude, north, east) in
            [(45.0, 111_131.78, 78_846.81), (0.0, 110_574.28, 111_319.49)]
        {
            let plane = Plane::new(8.0, latitude);
            let step = 1e-5;
            let [_, found] = plane.metres(8.0, latitude + step);
            assert!((found / step - north).abs() < 0.05, "{}", found / step);
            let [found, _] = plane.metres(8.0 + step, latitude);
            assert!((found / step - east).abs() < 0.05, "{}", found / step);
        }
    }

    #[test]
    fn the_antimeridian_is_no_border() {
        let plane = Plane::new(179.999, -17.0);
        let [east, _] = plane.metres(-179.999, -17.0);
        let [same, _] = plane.metres(180.001, -17.0);
        assert!(
            (east - same).abs() < 1e-6 && (east - 212.9).abs() < 0.1,
            "{east}"
        );
    }
}
