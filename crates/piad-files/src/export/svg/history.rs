//! A plot of the distance from the data, level by level, on a logarithmic scale.

use super::layout::draw_polygon;
use super::numbers::{power, short};
use super::view::{MARGIN, WIDTH};
use crate::export::text::Text;

/// The height of the plot with its labels.
const HEIGHT: f64 = 210.0;

/// Where the plot is, within its height.
const LEFT: f64 = 72.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 174.0;

/// The most levels that are drawn; longer histories are thinned.
const MOST_LEVELS: usize = 2000;

/// The most labels of an axis.
const MOST_LABELS: usize = 7;

/// The content below the caption.
pub(super) enum History<'a> {
    /// A plot of the errors of levels 0, 1, …, and the levels and logarithms that are drawn: errors that
    /// are zero or infinite have no place on the scale.
    Plot(&'a [f64], Vec<(usize, f64)>),
    /// The errors are not known.
    Unknown,
    /// One step, or none, is no history.
    Nothing,
}

impl<'a> History<'a> {
    /// The history of these errors; if there is none, the reason why there is no plot.
    pub(super) fn of(errors: &'a [f64]) -> Self {
        if errors.is_empty() {
            return Self::Unknown;
        }
        let shown: Vec<(usize, f64)> = levels(errors)
            .filter(|(_, error)| *error > 0.0 && error.is_finite())
            .map(|(level, error)| (level, error.log10()))
            .collect();
        match errors.len() > 2 && !shown.is_empty() {
            true => Self::Plot(errors, shown),
            false => Self::Nothing,
        }
    }

    /// The height with labels, in pixels.
    pub(super) fn height(&self) -> f64 {
        match self {
            Self::Plot(..) => HEIGHT,
            Self::Unknown => 28.0,
            Self::Nothing => 0.0,
        }
    }

    /// Draws it below `top`.
    pub(super) fn draw(&self, text: &mut Text, top: f64) {
        match self {
            Self::Plot(errors, shown) => plot(text, errors, shown, top),
            Self::Unknown => text.put(format_args!(
                "<text x=\"{MARGIN}\" y=\"{:.1}\">no plot of the distances: the iterations \
                 would take too long to compute again</text>\n",
                top + 12.0
            )),
            Self::Nothing => {}
        }
    }
}

fn plot(text: &mut Text, errors: &[f64], shown: &[(usize, f64)], top: f64) {
    let logarithms = || shown.iter().map(|(_, y)| *y);
    let low = logarithms().fold(f64::INFINITY, f64::min).floor();
    let high = logarithms().fold(f64::NEG_INFINITY, f64::max);
    let high = high.ceil().max(low + 1.0);
    let last = (errors.len() - 1).max(1);
    let right = WIDTH - MARGIN;
    let x = |level: usize| LEFT + (right - LEFT) * level as f64 / last as f64;
    let y = |log: f64| top + BOTTOM - (BOTTOM - TOP) * (log - low) / (high - low);
    text.put(format_args!(
        "<text x=\"{MARGIN}\" y=\"{:.1}\">largest distance from the data, after each iteration</text>\n",
        top + 18.0
    ));
    let step = ((high - low) / MOST_LABELS as f64).ceil().max(1.0) as usize;
    for decade in (low as i64..=high as i64).step_by(step) {
        let line = y(decade as f64);
        text.put(format_args!(
            "<path class=\"grid\" d=\"M{LEFT} {line:.1}H{right}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
            LEFT - 8.0,
            line + 4.0,
            power(decade),
        ));
    }
    for level in (0..=last).step_by(label_step(last)) {
        let (x, below) = (x(level), top + BOTTOM + 18.0);
        text.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{level}</text>\n"
        ));
    }
    let places: Vec<(f64, f64)> = shown
        .iter()
        .map(|(level, log)| (x(*level), y(*log)))
        .collect();
    draw_polygon(text, "curve", places.iter().copied());
    if let (Some((x, y)), Some((level, _))) = (places.last(), shown.last()) {
        text.put(format_args!(
            "<circle class=\"end\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>\
             <text class=\"end\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n",
            x - 2.0,
            y - 9.0,
            short(errors[*level]),
        ));
    }
}

/// The levels that are drawn, the last one among them.
fn levels(errors: &[f64]) -> impl Iterator<Item = (usize, f64)> + '_ {
    let stride = errors.len().div_ceil(MOST_LEVELS);
    let all = errors.iter().copied().enumerate();
    all.filter(move |(level, _)| level % stride == 0 || level + 1 == errors.len())
}

/// 1, 2 or 5 times a power of ten, so that there are not too many labels.
fn label_step(last: usize) -> usize {
    let mut power = 1;
    loop {
        for factor in [1, 2, 5] {
            if last / (factor * power) <= MOST_LABELS {
                return factor * power;
            }
        }
        power *= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_few_and_round() {
        assert_eq!(
            [1, 7, 8, 40, 149, 1000].map(label_step),
            [1, 1, 2, 10, 20, 200]
        );
    }

    #[test]
    fn errors_without_a_logarithm_are_left_out() {
        let mut text = Text::default();
        History::of(&[1.0, f64::INFINITY, 0.1, 0.0]).draw(&mut text, 0.0);
        assert!(!text.as_str().contains("NaN") && !text.as_str().contains("inf"));
        assert!(matches!(History::of(&[0.0, 0.0, 0.0]), History::Nothing));
    }

    #[test]
    fn a_single_step_has_no_plot() {
        assert!(matches!(History::of(&[1.0, 0.1]), History::Nothing));
        assert!(matches!(History::of(&[1.0, 0.2, 0.1]), History::Plot(..)));
    }

    #[test]
    fn long_histories_are_thinned_and_keep_their_end() {
        let errors = vec![1.0; 123_457];
        let shown: Vec<usize> = levels(&errors).map(|(level, _)| level).collect();
        assert!(shown.len() <= MOST_LEVELS + 1);
        assert_eq!(shown.last(), Some(&123_456));
    }
}
