//! The projection from space to the page.

use crate::export::error::ExportError;
use crate::export::nurbs::Nurbs;
use crate::export::text::Text;
use piad_fit::engine::vectors::{cross, dot};

/// The width of the drawing.
pub(super) const WIDTH: f64 = 800.0;
/// Free space on all sides.
pub(super) const MARGIN: f64 = 24.0;

/// The greatest and the least height of a drawing.
const MOST_HEIGHT: f64 = 620.0;
const LEAST_HEIGHT: f64 = 120.0;

/// The shown part of the control net beyond the curve and the data, as a fraction of their extent.
const NET_BEYOND: f64 = 0.3;

/// The direction of view, in degrees: the azimuth around z from the x axis, and the elevation.
const AZIMUTH: f64 = -60.0;
const ELEVATION: f64 = 28.0;

/// A parallel projection onto the page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
}

/// A place on the page in units of the data, with y upwards, and its depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected {
    /// To the right.
    pub(super) x: f64,
    /// Upwards.
    pub(super) y: f64,
    /// Towards the reader.
    pub(super) depth: f64,
}

impl Projection {
    /// The view from the top for geometry in a plane of constant z, an oblique view for all other.
    pub(super) fn of(nurbs: &Nurbs) -> Self {
        let height = nurbs.place(0)[2];
        let flat = (0..nurbs.points.len()).all(|index| nurbs.place(index)[2] == height);
        if flat {
            return Self {
                right: [1.0, 0.0, 0.0],
                up: [0.0, 1.0, 0.0],
                toward: [0.0, 0.0, 1.0],
            };
        }
        let (sin_a, cos_a) = AZIMUTH.to_radians().sin_cos();
        let (sin_e, cos_e) = ELEVATION.to_radians().sin_cos();
        let right = [-sin_a, cos_a, 0.0];
        let toward = [cos_e * cos_a, cos_e * sin_a, sin_e];
        Self {
            right,
            up: cross(toward, right),
            toward,
        }
    }

    /// Returns true if the page is not the xy plane.
    pub(super) fn is_spatial(&self) -> bool {
        self.toward[2] < 1.0
    }

    /// The place of a point on the page.
    pub(super) fn project(&self, place: [f64; 3]) -> Projected {
        Projected {
            x: dot(place, self.right),
            y: dot(place, self.up),
            depth: dot(place, self.toward),
        }
    }

    /// How much light falls on a plane with this unit normal, from 0 to 1, on either side: it comes
    /// from the upper left of the reader.
    pub(super) fn light(&self, normal: [f64; 3]) -> f64 {
        let [x, y, z] = [self.right, self.up, self.toward].map(|axis| dot(normal, axis));
        (-0.4 * x + 0.6 * y + 0.7 * z).abs().min(1.0)
    }

    /// The directions of x, y and z, around a point of the page.
    pub(super) fn draw_axes(&self, text: &mut Text, (x0, y0): (f64, f64)) {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let (dx, dy) = (26.0 * self.right[axis], -26.0 * self.up[axis]);
            text.put(format_args!(
                "<path class=\"axis\" d=\"M{x0:.1} {y0:.1}l{dx:.1} {dy:.1}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>\n",
                x0 + 1.35 * dx,
                y0 + 1.35 * dy + 4.0,
            ));
        }
    }
}

/// The part of the page for the drawing, and the scale from data to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Canvas {
    scale: f64,
    left: f64,
    top: f64,
    height: f64,
}

impl Canvas {
    /// The largest scale at which all these places are on the page, with the part of the control net that
    /// is not far out: for high degrees the net can be a hundred times as large as the curve.
    pub(super) fn fit(
        places: impl Iterator<Item = Projected>,
        net: impl Iterator<Item = Projected>,
    ) -> Result<Self, ExportError> {
        let seen = Bounds::of(places);
        let bounds = seen.with(&Bounds::of(net).within(&seen.grown()));
        let [width, height] = bounds.size();
        if !(width.is_finite() && height.is_finite()) {
            return Err(ExportError::Extent);
        }
        let (page, most) = (WIDTH - 2.0 * MARGIN, MOST_HEIGHT - 2.0 * MARGIN);
        let scale = (page / width).min(most / height);
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let drawn = (scale * height + 2.0 * MARGIN).max(LEAST_HEIGHT);
        let [x, y] = bounds.low;
        Ok(Self {
            scale,
            left: WIDTH / 2.0 - scale * (x + width / 2.0),
            top: drawn / 2.0 + scale * (y + height / 2.0),
            height: drawn,
        })
    }

    /// Refuses places that are not finite on the page: sums of coordinates can overflow although the
    /// coordinates do not.
    pub(super) fn check(
        &self,
        mut places: impl Iterator<Item = Projected>,
    ) -> Result<(), ExportError> {
        let on_page = |place| {
            let (x, y) = self.pixel(place);
            x.is_finite() && y.is_finite()
        };
        match places.all(on_page) {
            true => Ok(()),
            false => Err(ExportError::Extent),
        }
    }

    /// The height of the drawing.
    pub(super) fn height(&self) -> f64 {
        self.height
    }

    /// Pixels from the left and from the top.
    pub(super) fn pixel(&self, place: Projected) -> (f64, f64) {
        (
            self.left + self.scale * place.x,
            self.top - self.scale * place.y,
        )
    }
}

/// A rectangle, in units of the data.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    fn of(places: impl Iterator<Item = Projected>) -> Self {
        let mut bounds = Self {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        };
        for Projected { x, y, .. } in places {
            bounds = bounds.with(&Self {
                low: [x, y],
                high: [x, y],
            });
        }
        bounds
    }

    fn size(&self) -> [f64; 2] {
        [0, 1].map(|c| self.high[c] - self.low[c])
    }

    /// The bounding rectangle of both.
    fn with(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|c| self.low[c].min(other.low[c])),
            high: [0, 1].map(|c| self.high[c].max(other.high[c])),
        }
    }

    /// The intersection of both, which must overlap.
    fn within(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|c| self.low[c].max(other.low[c])),
            high: [0, 1].map(|c| self.high[c].min(other.high[c])),
        }
    }

    /// The rectangle with a margin on all sides, a fraction of the longer side.
    fn grown(&self) -> Self {
        let [width, height] = self.size();
        let more = NET_BEYOND * width.max(height);
        Self {
            low: self.low.map(|x| x - more),
            high: self.high.map(|x| x + more),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_on_the_page() {
        for (w, h) in [
            (1.0, 1.0),
            (1e-9, 3e-10),
            (1e12, 1.0),
            (1.0, 1e6),
            (0.0, 0.0),
        ] {
            let corners = [(5.0, -7.0), (5.0 + w, -7.0 + h)];
            let corners = corners.map(|(x, y)| Projected { x, y, depth: 0.0 });
            let canvas = Canvas::fit(corners.into_iter(), std::iter::empty()).unwrap();
            assert!((LEAST_HEIGHT..=MOST_HEIGHT + 1e-9).contains(&canvas.height()));
            for corner in corners {
                let (x, y) = canvas.pixel(corner);
                let slack = 1e-3;
                assert!((MARGIN - slack..=WIDTH - MARGIN + slack).contains(&x));
                assert!((MARGIN - slack..=canvas.height() - MARGIN + slack).contains(&y));
            }
        }
    }

    #[test]
    fn control_points_far_out_do_not_shrink_the_curve() {
        let place = |x: f64, y: f64| Projected { x, y, depth: 0.0 };
        let curve = [place(0.0, 0.0), place(1.0, 1.0)];
        let net = [place(-0.2, 0.5), place(0.5, 1000.0)];
        let canvas = Canvas::fit(curve.into_iter(), net.into_iter()).unwrap();
        let (left, bottom) = canvas.pixel(curve[0]);
        let (right, top) = canvas.pixel(curve[1]);
        assert!(right - left > 400.0 && bottom - top > 400.0);
        assert!(canvas.pixel(net[0]).0 >= MARGIN);
        assert!(canvas.pixel(net[1]).1 < 0.0);
    }
}
