//! The shape of a surface.

use super::area::area;
use super::degenerate::{MOST_DEGENERATE, Vanishing};
use super::extremes::{Best, Bracket, Extreme, Extremes};
use super::lines::{KnotLine, lines};
use super::principal::principal;
use crate::geometry::nurbs::sampling::SpanParameter;
use crate::geometry::nurbs::{KnotVector, Nurbs};

/// About the number of parameters of each direction at which extremes are searched for.
const PARAMETERS: usize = 512;

/// The least number of steps in a knot span, if there are few spans.
const USUAL_STEPS: usize = 16;

/// The places that are evaluated at a time.
const TOGETHER: usize = 1 << 14;

/// Each of these rounds halves both sides of the rectangle that holds an extreme.
const ROUNDS: usize = 32;
const ROUND_STEPS: usize = 4;

/// The shape of a surface of the plane or of space.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceShape {
    /// The area; NaN if numbers overflow.
    pub area: f64,
    /// Where the larger and the smaller principal curvature, the Gaussian and the mean curvature are least and largest.
    pub extremes: [Extremes; 4],
    /// Parameters at which there is no normal, and near which curvatures may be unbounded: at most [`MOST_DEGENERATE`]
    /// of those at which it was searched for.
    pub degenerate: Vec<[f64; 2]>,
    /// The number of inner knots in each direction, with that where a closed one returns to its start.
    pub line_counts: [usize; 2],
    /// The continuity across the lines at these knots.
    pub lines: [Vec<KnotLine>; 2],
    /// Points and curvatures.
    pub samples: SurfaceSamples,
}

/// Principal curvatures of a surface on a grid of parameters, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceSamples {
    /// The parameters of the rows and of the columns.
    pub parameters: [Vec<f64>; 2],
    /// The coordinates of the points, point by point.
    pub points: Vec<f64>,
    /// The larger and the smaller principal curvature; NaN where the normal is undefined.
    pub principal: [Vec<f64>; 2],
}

/// A surface with what its curvatures need.
#[derive(Clone, Copy)]
struct Measured<'a> {
    nurbs: &'a Nurbs,
    across: &'a KnotVector,
    vanishing: [&'a Vanishing; 2],
}

impl SurfaceShape {
    /// The shape of a surface, with samples at these parameters; `None` for a curve. Its weights are positive, and its
    /// control points finite.
    pub fn new(nurbs: &Nurbs, u: &[SpanParameter], v: &[SpanParameter]) -> Option<Self> {
        let across = nurbs.v.as_ref()?;
        let (in_u, in_v) = (Vanishing::along(nurbs), Vanishing::across(nurbs, across));
        let measured = Measured {
            nurbs,
            across,
            vanishing: [&in_u, &in_v],
        };
        let (extremes, degenerate) = measured.extremes();
        let [(lines_u, count_u), (lines_v, count_v)] = lines(nurbs, across, measured.vanishing);
        Some(Self {
            area: area(nurbs, across),
            extremes,
            degenerate,
            line_counts: [count_u, count_v],
            lines: [lines_u, lines_v],
            samples: measured.samples(u, v),
        })
    }
}

/// A place of a surface, and the rectangle around it in which the value may be better.
type Place = ([SpanParameter; 2], Option<[Bracket; 2]>);

/// The larger and the smaller principal curvature, the Gaussian and the mean curvature.
fn quantities([larger, smaller]: [f64; 2]) -> [f64; 4] {
    [larger, smaller, larger * smaller, 0.5 * (larger + smaller)]
}

impl Measured<'_> {
    /// Points and principal curvatures on a grid, row by row, with the index of each.
    fn each(
        self,
        u: &[SpanParameter],
        v: &[SpanParameter],
        mut visit: impl FnMut(usize, [f64; 3], [f64; 2]),
    ) {
        let block = (TOGETHER / v.len().max(1)).max(1);
        for (index, rows) in u.chunks(block).enumerate() {
            let start = index * block * v.len();
            let jets = self.nurbs.second_jets(0, rows, v);
            let sites = rows.iter().flat_map(|u| v.iter().map(move |v| (*u, *v)));
            for (k, (jet, (u, v))) in jets.iter().zip(sites).enumerate() {
                let limits = [self.vanishing[0].limit(u), self.vanishing[1].limit(v)];
                visit(start + k, jet.jet.point, principal(jet, limits));
            }
        }
    }

    fn samples(self, u: &[SpanParameter], v: &[SpanParameter]) -> SurfaceSamples {
        let dimension = self.nurbs.points.dimension();
        let parameters = [u, v].map(|sites| sites.iter().map(|site| site.t).collect());
        let mut samples = SurfaceSamples {
            parameters,
            ..SurfaceSamples::default()
        };
        let [larger, smaller] = &mut samples.principal;
        let points = &mut samples.points;
        self.each(u, v, |_, point, [k1, k2]| {
            points.extend(point.into_iter().take(dimension));
            larger.push(k1);
            smaller.push(k2);
        });
        samples
    }

    /// The places of the least and the largest curvatures, and those where they are undefined.
    fn extremes(self) -> ([Extremes; 4], Vec<[f64; 2]>) {
        let mut bests = [(); 4].map(|()| Best::<Place>::both());
        let mut degenerate = Vec::new();
        let (u, v) = (Steps::new(&self.nurbs.u), Steps::new(self.across));
        let columns = v.sites.len();
        let mut values = Vec::with_capacity(columns * (u.count + 1));
        // All rows of a knot span are there before its places are examined, so that the places beside them are known.
        for (span, rows) in u.sites.chunks(u.count + 1).enumerate() {
            values.clear();
            self.each(rows, &v.sites, |_, _, principal| values.push(principal));
            for (index, &principal) in values.iter().enumerate() {
                let (i, j) = (index / columns, index % columns);
                let sites = [rows[i], v.sites[j]];
                if principal[0].is_nan() && degenerate.len() < MOST_DEGENERATE {
                    degenerate.push(sites.map(|site| site.t));
                }
                let place = || {
                    let brackets = [u.around(span * (u.count + 1) + i), v.around(j)];
                    let near = near(&values, columns, i, v.near(j));
                    (sites, near.then_some(brackets))
                };
                for (bests, value) in bests.iter_mut().zip(quantities(principal)) {
                    bests.iter_mut().for_each(|best| best.offer(value, &place));
                }
            }
        }
        degenerate.dedup();
        let refined = [0, 1, 2, 3].map(|quantity| {
            let [smallest, largest] = bests[quantity].map(|best| self.refined(best, quantity));
            Extremes { smallest, largest }
        });
        (refined, degenerate)
    }

    /// The best value near the one that was found.
    fn refined(self, mut best: Best<Place>, quantity: usize) -> Option<Extreme> {
        for _ in 0..ROUNDS {
            let Some((_, (_, Some([u, v])))) = best.found else {
                break;
            };
            let sites = |bracket: Bracket| {
                let steps = bracket.steps(ROUND_STEPS);
                steps.map(move |t| SpanParameter::new(bracket.span, t))
            };
            let (rows, columns): (Vec<_>, Vec<_>) = (sites(u).collect(), sites(v).collect());
            let mut round = best.again();
            self.each(&rows, &columns, |index, _, principal| {
                let (i, j) = (index / columns.len(), index % columns.len());
                let around = || {
                    let brackets = [u.around(i, ROUND_STEPS), v.around(j, ROUND_STEPS)];
                    ([rows[i], columns[j]], Some(brackets))
                };
                round.offer(quantities(principal)[quantity], around);
            });
            if !best.improve(&round) {
                break;
            }
        }
        let (value, ([u, v], _)) = best.found?;
        let jet = self.nurbs.second_jets(0, &[u], &[v]).into_iter().next()?;
        let dimension = self.nurbs.points.dimension();
        Some(Extreme {
            u: u.t,
            v: Some(v.t),
            point: jet.jet.point.into_iter().take(dimension).collect(),
            value,
        })
    }
}

/// Parameters of a direction: equally many steps in each knot span, with both ends of each.
struct Steps {
    count: usize,
    brackets: Vec<Bracket>,
    sites: Vec<SpanParameter>,
}

impl Steps {
    fn new(knots: &KnotVector) -> Self {
        let spans = knots.spans();
        let most = (3 * (knots.degree + 1)).max(USUAL_STEPS);
        let count = (PARAMETERS / spans.len().max(1)).clamp(1, most);
        let brackets = spans.iter().map(|&span| Bracket {
            span,
            low: knots.knots[span],
            high: knots.knots[span + 1],
        });
        let brackets: Vec<Bracket> = brackets.collect();
        let sites = brackets.iter().flat_map(|bracket| {
            let steps = bracket.steps(count);
            steps.map(|t| SpanParameter::new(bracket.span, t))
        });
        Self {
            count,
            sites: sites.collect(),
            brackets,
        }
    }

    /// The interval around a parameter.
    fn around(&self, index: usize) -> Bracket {
        let width = self.count + 1;
        self.brackets[index / width].around(index % width, self.count)
    }

    /// The parameters beside one, in its span.
    fn near(&self, index: usize) -> std::ops::Range<usize> {
        let width = self.count + 1;
        let start = index / width * width;
        index.saturating_sub(1).max(start)..(index + 2).min(start + width)
    }
}

/// Returns true if there are curvatures at all places beside one: beside others they may be unbounded.
fn near(values: &[[f64; 2]], columns: usize, i: usize, across: std::ops::Range<usize>) -> bool {
    let rows = i.saturating_sub(1)..(i + 2).min(values.len() / columns);
    let mut places = rows.flat_map(|i| across.clone().map(move |j| i * columns + j));
    places.all(|index| values[index][0].is_finite())
}
