//! The earth by the WGS 84 ellipsoid: longitudes and latitudes, and metres in the plane that touches it at a place.
//!
//! Points of the ellipsoid go to the plane along the direction that is up at its origin, and back the same way, both
//! in closed form. Near the origin distances in the plane are those on the ground: 10 km away they are shorter by
//! a millionth, 100 km away by one part in 10,000.

/// The semi-major axis in metres, and the flattening (NIMA TR8350.2).
const A: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// The square of the first eccentricity.
const E2: f64 = FLATTENING * (2.0 - FLATTENING);

/// A place on the earth, by the WGS 84 ellipsoid. The first two coordinates of points are metres to the east and to
/// the north in the plane that touches the ellipsoid there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// In degrees, to the east.
    pub longitude: f64,
    /// In degrees, to the north.
    pub latitude: f64,
}

/// The plane that touches the ellipsoid at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    place: Origin,
    /// In coordinates from the centre of the earth: x towards longitude 0, z towards the north pole.
    origin: [f64; 3],
    east: [f64; 3],
    north: [f64; 3],
    up: [f64; 3],
}

impl Plane {
    /// The plane at a longitude and latitude in degrees.
    pub fn new(longitude: f64, latitude: f64) -> Self {
        let (sin_l, cos_l) = longitude.to_radians().sin_cos();
        let (sin_b, cos_b) = latitude.to_radians().sin_cos();
        Self {
            place: Origin {
                longitude,
                latitude,
            },
            origin: from_centre(longitude, latitude),
            east: [-sin_l, cos_l, 0.0],
            north: [-sin_b * cos_l, -sin_b * sin_l, cos_b],
            up: [cos_b * cos_l, cos_b * sin_l, sin_b],
        }
    }

    /// The origin, where it touches the ellipsoid.
    pub fn place(&self) -> Origin {
        self.place
    }

    /// Metres to the east and to the north of the origin, of a place in degrees.
    pub fn metres(&self, longitude: f64, latitude: f64) -> [f64; 2] {
        let place = from_centre(longitude, latitude);
        let offset = [0, 1, 2].map(|c| place[c] - self.origin[c]);
        [dot(offset, self.east), dot(offset, self.north)]
    }

    /// Cosine of the angle between the plane and that at another place.
    pub fn tilt(&self, longitude: f64, latitude: f64) -> f64 {
        dot(self.up, Self::new(longitude, latitude).up)
    }

    /// Longitude and latitude in degrees of the place on the ellipsoid that is straight above or below a point of the
    /// plane; `None` if there is none, farther from the origin than the radius of the earth.
    pub fn degrees(&self, [east, north]: [f64; 2]) -> Option<[f64; 2]> {
        let axes = [0, 1, 2];
        let foot = axes.map(|c| self.origin[c] + east * self.east[c] + north * self.north[c]);
        // foot + h up on x² + y² + z² / (1 − e²) = a²: the larger one of both h, on the near side of the earth.
        let stretch = [1.0, 1.0, 1.0 / (1.0 - E2)];
        let product = |a: [f64; 3], b: [f64; 3]| dot(axes.map(|c| a[c] * stretch[c]), b);
        let quadratic = product(self.up, self.up);
        let linear = product(foot, self.up);
        let constant = product(foot, foot) - A * A;
        let discriminant = linear * linear - quadratic * constant;
        if !(discriminant >= 0.0 && discriminant.is_finite()) {
            return None;
        }
        // Without cancellation, as `linear` is positive on this side.
        let h = -constant / (linear + discriminant.sqrt());
        let [x, y, z] = axes.map(|c| foot[c] + h * self.up[c]);
        let latitude = z.atan2((1.0 - E2) * x.hypot(y));
        let place = [y.atan2(x).to_degrees(), latitude.to_degrees()];
        place.iter().all(|it| it.is_finite()).then_some(place)
    }
}

/// A place of the ellipsoid from the centre of the earth.
fn from_centre(longitude: f64, latitude: f64) -> [f64; 3] {
    let (sin_l, cos_l) = longitude.to_radians().sin_cos();
    let (sin_b, cos_b) = latitude.to_radians().sin_cos();
    let normal = A / (1.0 - E2 * sin_b * sin_b).sqrt();
    [
        normal * cos_b * cos_l,
        normal * cos_b * sin_l,
        (1.0 - E2) * normal * sin_b,
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nanometres: the coordinates from the centre of the earth have no more digits.
    #[test]
    fn metres_and_degrees_are_inverse() {
        for (longitude, latitude) in [
            (0.0, 0.0),
            (7.85, 47.99),
            (-122.4, 37.8),
            (179.999, -16.5),
            (25.0, 89.9),
            (0.0, -90.0),
        ] {
            let plane = Plane::new(longitude, latitude);
            let [east, north] = plane.metres(longitude, latitude);
            assert!(east.abs() < 1e-8 && north.abs() < 1e-8);
            for place in [
                [0.0, 0.0],
                [12.5, -3.25],
                [-4e3, 9e3],
                [1e5, 2e5],
                [-3e6, 1e6],
            ] {
                let [x, y] = plane.degrees(place).unwrap();
                let [east, north] = plane.metres(x, y);
                let off = (east - place[0]).hypot(north - place[1]);
                assert!(off < 1e-8, "{longitude} {latitude} {place:?}: {off:e}");
            }
        }
    }

    /// The radii of curvature of the ellipsoid, at 48° north (Torge, Geodesy, section 4.1).
    #[test]
    fn a_second_of_arc_has_its_length() {
        let plane = Plane::new(8.0, 48.0);
        let second = 1.0 / 3600.0;
        let sin2 = 48_f64.to_radians().sin().powi(2);
        let w = (1.0 - E2 * sin2).sqrt();
        let [east, _] = plane.metres(8.0 + second, 48.0);
        let expected = second.to_radians() * A / w * 48_f64.to_radians().cos();
        assert!((east - expected).abs() < 1e-6);
        let [_, north] = plane.metres(8.0, 48.0 + second);
        let expected = second.to_radians() * A * (1.0 - E2) / w.powi(3);
        assert!((north - expected).abs() < 1e-6);
    }

    #[test]
    fn beyond_the_earth_there_is_no_place() {
        let plane = Plane::new(8.0, 48.0);
        assert_eq!(plane.degrees([7e6, 0.0]), None);
        assert_eq!(plane.degrees([f64::NAN, 0.0]), None);
        assert!(plane.degrees([6e6, 0.0]).is_some());
    }
}
