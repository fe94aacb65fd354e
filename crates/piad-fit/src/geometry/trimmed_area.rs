//! The area of the part of a surface inside of an outline.
//!
//! Lines of constant u, equally many in each knot span, are cut by the loops. Between cuts |S_u × S_v| is integrated along
//! them by the Gauss–Legendre rule in each knot span, and over the lines by the midpoint rule.

use super::arc_length::{NODES, WEIGHTS};
use super::curvature::area::area;
use super::nurbs::sampling::SpanParameter;
use super::nurbs::{KnotVector, Nurbs};
use super::outline::Outline;
use crate::data::vectors::{cross, length};

/// The fewest and the most lines, and about how many pieces they have in all: across a loop where it is parallel to them the sum
/// is accurate to the width of a strip to the power of 1.5.
const LINES: [usize; 2] = [1024, 4096];
const PIECES: usize = 1 << 18;

/// The steps along loops, as a part of the extents of the surface.
const STEP: f64 = 1.0 / 2048.0;

/// The area of a surface inside of an outline; NaN if numbers overflow, and `None` of what lies in no space.
pub fn trimmed_area(nurbs: &Nurbs, outline: &Outline) -> Option<f64> {
    let across = nurbs.v.as_ref()?;
    if !(2..=3).contains(&nurbs.points.dimension()) {
        return None;
    }
    if outline.is_whole() {
        return Some(area(nurbs, across));
    }
    let spans = across.spans();
    let [least, most] = LINES;
    let lines = lines(&nurbs.u, (PIECES / spans.len()).clamp(least, most));
    let cuts = cuts(&lines, &outline.polygons(nurbs, STEP));
    let along = lines.iter().zip(cuts).map(|(line, mut cuts)| {
        cuts.sort_by(f64::total_cmp);
        let between = cuts.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        line.width * integral(nurbs, line.site, (across, &spans), between)
    });
    Some(along.sum())
}

/// A line of constant u, and the width of the strip around it.
struct Line {
    site: SpanParameter,
    width: f64,
}

fn lines(knots: &KnotVector, wanted: usize) -> Vec<Line> {
    let spans = knots.spans();
    let count = wanted.div_ceil(spans.len());
    let lines = spans.into_iter().flat_map(|span| {
        (0..count).map(move |k| {
            let site = knots.site(span, (k as f64 + 0.5) / count as f64);
            let width = knots.width(site) / count as f64;
            Line { site, width }
        })
    });
    lines.collect()
}

/// Where polygons cut each line.
fn cuts(lines: &[Line], polygons: &[Vec<[f64; 2]>]) -> Vec<Vec<f64>> {
    let mut cuts = vec![Vec::new(); lines.len()];
    for pair in polygons.iter().flat_map(|polygon| polygon.windows(2)) {
        let [from, to] = [pair[0], pair[1]];
        let first = |u: f64| lines.partition_point(|line| line.site.t < u);
        for k in first(from[0].min(to[0]))..first(from[0].max(to[0])) {
            let part = (lines[k].site.t - from[0]) / (to[0] - from[0]);
            cuts[k].push(from[1] + part * (to[1] - from[1]));
        }
    }
    cuts
}

/// The integral along a line over these intervals of v.
fn integral(
    nurbs: &Nurbs,
    line: SpanParameter,
    (across, spans): (&KnotVector, &[usize]),
    intervals: impl Iterator<Item = [f64; 2]>,
) -> f64 {
    let (mut sites, mut weights) = (Vec::new(), Vec::new());
    for [from, to] in intervals {
        let first = spans.partition_point(|span| across.knots[span + 1] <= from);
        for &span in &spans[first..] {
            let [low, high] = [from.max(across.knots[span]), to.min(across.knots[span + 1])];
            if low >= high {
                break;
            }
            let place = |node: f64| SpanParameter::new(span, low + node * (high - low));
            sites.extend(NODES.map(place));
            weights.extend(WEIGHTS.map(|weight| weight * (high - low)));
        }
    }
    let jets = nurbs.evaluate(&[line], &sites);
    let parts = jets.iter().zip(weights);
    let areas = parts.map(|(jet, weight)| weight * length(cross(jet.du, jet.dv)));
    areas.sum()
}
