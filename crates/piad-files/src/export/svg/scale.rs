//! The colours of distances from the data, and their legend.

use super::numbers::short;
use super::view::MARGIN;
use crate::export::text::Text;

/// The height of the legend.
pub(super) const HEIGHT: f64 = 42.0;

/// The place and the width of the bar.
const LEFT: f64 = MARGIN + 150.0;
const WIDTH: f64 = 320.0;

/// The positions of the numbers of the legend, as parts of the largest distance.
const TICKS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Colours at equal steps, from no distance to the largest: distinct also for red–green colour blindness, and none of
/// them dark, so that shades can show the shape.
const COLOURS: [[f64; 3]; 5] = [
    [92.0, 149.0, 214.0],
    [126.0, 196.0, 208.0],
    [245.0, 225.0, 138.0],
    [244.0, 151.0, 75.0],
    [214.0, 48.0, 49.0],
];

/// The number of colour steps.
const STEPS: u8 = 32;

/// A distance as a part of the largest one, in steps of colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Heat(u8);

impl Heat {
    /// The step of a distance; `None` where it is unknown.
    pub(super) fn of(distance: f64, most: f64) -> Self {
        let part = (distance / most).clamp(0.0, 1.0);
        Self((part * f64::from(STEPS)).round() as u8)
    }

    /// Red, green and blue, from 0 to 255.
    pub(super) fn colour(self) -> [f64; 3] {
        let place = f64::from(self.0) / f64::from(STEPS) * (COLOURS.len() - 1) as f64;
        let index = (place as usize).min(COLOURS.len() - 2);
        let part = place - index as f64;
        [0, 1, 2].map(|c| COLOURS[index][c] * (1.0 - part) + COLOURS[index + 1][c] * part)
    }
}

/// A colour in the form of XML attributes.
pub(super) fn hexadecimal(colour: [f64; 3]) -> String {
    let [red, green, blue] = colour.map(|it| it as u32);
    format!("#{:06x}", red << 16 | green << 8 | blue)
}

/// The colours with the distances that they mean, below `top`.
pub(super) fn draw_legend(text: &mut Text, most: f64, top: f64) {
    let (bar, below) = (top + 4.0, top + 30.0);
    text.put(format_args!(
        "<text x=\"{MARGIN}\" y=\"{:.1}\">distance from the data</text>\n<g class=\"legend\">\n",
        bar + 9.0
    ));
    let width = WIDTH / f64::from(STEPS);
    for step in 0..STEPS {
        // The next part covers the gap that renderers leave.
        let (x, more) = (
            LEFT + f64::from(step) * width,
            if step + 1 < STEPS { 0.5 } else { 0.0 },
        );
        let middle = (f64::from(step) + 0.5) / f64::from(STEPS);
        text.put(format_args!(
            "<path fill=\"{}\" d=\"M{x:.1} {bar:.1}h{:.1}v10H{x:.1}Z\"/>\n",
            hexadecimal(Heat::of(middle, 1.0).colour()),
            width + more,
        ));
    }
    text.push("</g>\n");
    for tick in TICKS {
        let x = LEFT + tick * WIDTH;
        text.put(format_args!(
            "<path class=\"axis\" d=\"M{x:.1} {:.1}v4\"/>\
             <text x=\"{x:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{}</text>\n",
            bar + 10.0,
            short(tick * most),
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_go_from_no_distance_to_the_largest() {
        assert_eq!(Heat::of(0.0, 2.0).colour(), COLOURS[0]);
        assert_eq!(Heat::of(1.0, 2.0).colour(), COLOURS[2]);
        assert_eq!(Heat::of(2.0, 2.0).colour(), COLOURS[4]);
        assert_eq!(Heat::of(5.0, 2.0).colour(), COLOURS[4]);
        assert_eq!(Heat::of(f64::NAN, 2.0), Heat::of(0.0, 2.0));
        assert_eq!(hexadecimal([255.0, 0.4, 16.9]), "#ff0010");
    }
}
