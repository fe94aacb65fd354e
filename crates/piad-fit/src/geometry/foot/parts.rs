//! Parts of a Bézier patch: its quarters, their quarters and so on, and how near they can be to a point.

/// A point in homogeneous coordinates `(w x, w y, w z, w)`.
pub(super) type Homogeneous = [f64; 4];

/// The number of times that a patch is halved, in each direction.
pub(super) const DEEPEST: usize = 3;

/// A part of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// How often the patch was quartered.
    pub(super) depth: usize,
    /// No point of it is nearer, as a squared distance.
    pub(super) nearest: f64,
    /// Its least parameters, and how much of [0, 1] it has in each direction.
    low: [f64; 2],
    size: f64,
    /// The number of its control net.
    net: usize,
}

impl Part {
    /// Returns true if it has the point at these parameters.
    pub(super) fn has(&self, at: [f64; 2]) -> bool {
        let has = |k: usize| (self.low[k]..=self.low[k] + self.size).contains(&at[k]);
        has(0) && has(1)
    }

    /// The parameters in its middle.
    pub(super) fn middle(&self) -> [f64; 2] {
        self.low.map(|low| low + 0.5 * self.size)
    }
}

/// Room for the control nets of parts.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    rows: usize,
    columns: usize,
    /// Those of the patch, of its quarters, of the quarters of one of them and so on.
    nets: Vec<Vec<Homogeneous>>,
    /// Those of two halves.
    halves: [Vec<Homogeneous>; 2],
}

impl Parts {
    /// Parts of patches of these degrees.
    pub(super) fn new(degrees: [usize; 2]) -> Self {
        let [rows, columns] = degrees.map(|degree| degree + 1);
        let net = vec![[0.0; 4]; rows * columns];
        Self {
            rows,
            columns,
            nets: vec![net.clone(); 1 + 4 * DEEPEST],
            halves: [net.clone(), net],
        }
    }

    /// All of the patch with this control net.
    pub(super) fn whole(&mut self, net: &[Homogeneous]) -> Part {
        self.nets[0].copy_from_slice(net);
        Part {
            depth: 0,
            nearest: 0.0,
            low: [0.0; 2],
            size: 1.0,
            net: 0,
        }
    }

    /// The quarters of a part, those first that can be nearest to a point. They take the place of those of
    /// other parts of its depth.
    pub(super) fn quarters(&mut self, part: &Part, point: [f64; 3]) -> [Part; 4] {
        let first = 1 + 4 * part.depth;
        self.divide(part.net, first);
        let mut quarters = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| {
            let size = 0.5 * part.size;
            let net = first + 2 * i + j;
            Part {
                depth: part.depth + 1,
                nearest: nearest_by(&self.nets[net], point),
                low: [part.low[0] + size * i as f64, part.low[1] + size * j as f64],
                size,
                net,
            }
        });
        quarters.sort_by(|a, b| a.nearest.total_cmp(&b.nearest));
        quarters
    }

    /// Divides a control net into those of its quarters, from a number on.
    fn divide(&mut self, net: usize, first: usize) {
        let (rows, columns) = (self.rows, self.columns);
        let [low, high] = &mut self.halves;
        for j in 0..columns {
            let line = (j..).step_by(columns).take(rows);
            halve(&self.nets[net], low, high, line);
        }
        let quarters = self.nets[first..first + 4].chunks_exact_mut(2);
        for (half, quarters) in self.halves.iter().zip(quarters) {
            if let [low, high] = quarters {
                let lines = (0..rows).map(|i| i * columns..(i + 1) * columns);
                lines.for_each(|line| halve(half, low, high, line));
            }
        }
    }
}

/// A squared distance that no point of a patch with this control net is nearer than: it lies beyond the
/// plane in front of its control points, as seen towards the middle of its corners.
fn nearest_by(net: &[Homogeneous], point: [f64; 3]) -> f64 {
    let towards =
        |[x, y, z, w]: Homogeneous| [x / w - point[0], y / w - point[1], z / w - point[2]];
    let sum = net.iter().fold([0.0; 3], |sum, &place| {
        let to = towards(place);
        [0, 1, 2].map(|c| sum[c] + to[c])
    });
    let length = dot(sum, sum).sqrt();
    let least = net
        .iter()
        .map(|&place| dot(sum, towards(place)))
        .fold(f64::INFINITY, f64::min);
    match least > 0.0 {
        true => (least / length).powi(2),
        false => 0.0,
    }
}

/// Divides a line of control points at these places of a net in the middle (de Casteljau).
fn halve(
    net: &[Homogeneous],
    low: &mut [Homogeneous],
    high: &mut [Homogeneous],
    line: impl Iterator<Item = usize> + Clone,
) {
    line.clone().for_each(|place| high[place] = net[place]);
    let count = line.clone().count();
    for (r, to) in line.clone().enumerate() {
        let mut places = line.clone().take(count - r);
        let Some(mut before) = places.next() else {
            continue;
        };
        low[to] = high[before];
        for place in places {
            high[before] = [0, 1, 2, 3].map(|c| 0.5 * (high[before][c] + high[place][c]));
            before = place;
        }
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
