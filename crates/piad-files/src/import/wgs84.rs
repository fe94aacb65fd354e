//! Longitude and latitude as metres in a plane (WGS84).

/// The half major axis of the ellipsoid, in metres.
const MAJOR: f64 = 6_378_137.0;

/// The square of its first eccentricity.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;

/// The plane that touches the ellipsoid at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Longitude and latitude of the point, in degrees.
    origin: [f64; 2],
}

impl Plane {
    /// The plane at a point, in degrees.
    pub(super) fn new(longitude: f64, latitude: f64) -> Self {
        Self {
            origin: [longitude, latitude],
        }
    }

    /// How far east and north of the origin a point is, in metres of the plane.
    pub(super) fn metres(&self, longitude: f64, latitude: f64) -> [f64; 2] {
        let [from, at] = [self.origin, [longitude, latitude]].map(earth_centred);
        let [x, y, z] = [0, 1, 2].map(|c| at[c] - from[c]);
        let [(sin_east, cos_east), (sin_north, cos_north)] =
            self.origin.map(|degrees| degrees.to_radians().sin_cos());
        let east = cos_east * y - sin_east * x;
        let outward = cos_east * x + sin_east * y;
        [east, cos_north * z - sin_north * outward]
    }
}

/// Coordinates from the centre of the earth of a point at height 0.
fn earth_centred([longitude, latitude]: [f64; 2]) -> [f64; 3] {
    let (sin_east, cos_east) = longitude.to_radians().sin_cos();
    let (sin_north, cos_north) = latitude.to_radians().sin_cos();
    let radius = MAJOR / (1.0 - ECCENTRICITY_SQUARED * sin_north * sin_north).sqrt();
    [
        radius * cos_north * cos_east,
        radius * cos_north * sin_east,
        radius * (1.0 - ECCENTRICITY_SQUARED) * sin_north,
    ]
}
