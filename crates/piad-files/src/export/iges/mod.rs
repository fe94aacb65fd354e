//! IGES 5.3: rational B-spline curves (entity 126) and surfaces (entity 128), also trimmed ones (entity 144).

mod sections;
mod trimmed;

use super::document::{Document, Shape};
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::nurbs::{KnotVector, Nurbs};
use super::options::Unit;
use super::text::{Text, ascii};
use super::trim::edges::tolerance;
use sections::{DirectoryEntry, MOST_LINES, ParameterData, Status, fixed_lines};

/// Characters of the label of an entity.
const LABEL: usize = 8;

/// The curves and surfaces as an IGES file, an entity each.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut entities = Entities::default();
    document.try_each(|shape| {
        let label = Label::of(document, shape, &entities);
        match shape.outline {
            None => {
                let status = Status::Independent;
                entities.add(entity(shape.nurbs), status, &label, |data| {
                    geometry(data, shape.nurbs)
                });
            }
            Some(outline) => trimmed::write(&mut entities, shape.nurbs, outline, &label)?,
        }
        match entities.lines {
            0..=MOST_LINES => Ok(()),
            lines => Err(ExportError::TooManyLines {
                lines,
                most: MOST_LINES,
            }),
        }
    })?;
    let (global, global_lines) = global(document).finish();
    let mut file = Text::default();
    let start_lines = fixed_lines(&mut file, 'S', &start(document));
    file.push(&global);
    file.push(entities.directory.as_str());
    file.push(entities.data.as_str());
    // The numbers of lines of all sections, in fields of eight columns (section 2.2.4.6).
    let counts = format!(
        "S{start_lines:7}G{global_lines:7}D{:7}P{:7}",
        entities.directory_lines(),
        entities.lines
    );
    fixed_lines(&mut file, 'T', &counts);
    Ok(file.into_bytes())
}

/// The entities of a file: their directory and their parameters.
#[derive(Default)]
struct Entities {
    directory: Text,
    data: Text,
    /// The lines of the parameters.
    lines: usize,
}

impl Entities {
    /// The number of lines of the directory, of 80 columns each.
    fn directory_lines(&self) -> usize {
        self.directory.as_str().len() / 81
    }

    /// Adds an entity with these parameters behind its type, and returns the number of its directory entry.
    fn add(
        &mut self,
        entity: usize,
        status: Status,
        label: &Label,
        write: impl FnOnce(&mut ParameterData),
    ) -> usize {
        let number = self.directory_lines() + 1;
        let mut data = ParameterData::data(number, self.lines);
        data.integer(entity);
        write(&mut data);
        let (text, lines) = data.finish();
        let entry = DirectoryEntry {
            number,
            entity,
            first_line: self.lines + 1,
            lines,
            status,
            label: label.text.clone(),
            subscript: label.subscript,
        };
        entry.write(&mut self.directory);
        self.lines += lines;
        self.data.push(&text);
        number
    }
}

/// Parts are labelled with the first characters of their names, and numbered.
struct Label {
    text: String,
    subscript: usize,
}

impl Label {
    fn of(document: &Document<'_>, shape: &Shape<'_>, entities: &Entities) -> Self {
        let kind = || match shape.nurbs.v {
            None => "CURVE".to_owned(),
            Some(_) => "SURFACE".to_owned(),
        };
        let name = shape.name.filter(|_| document.has_parts);
        let number = entities.directory_lines() + 1;
        Self {
            text: name.map_or_else(kind, |name| ascii(name).chars().take(LABEL).collect()),
            subscript: if document.has_parts {
                number.div_ceil(2)
            } else {
                0
            },
        }
    }
}

fn entity(nurbs: &Nurbs) -> usize {
    match nurbs.v {
        None => 126,
        Some(_) => 128,
    }
}

fn geometry(data: &mut ParameterData, nurbs: &Nurbs) {
    match &nurbs.v {
        None => curve(data, nurbs),
        Some(v) => surface(data, nurbs, v),
    }
}

/// What the file is, for people.
fn start(document: &Document<'_>) -> String {
    let title = ascii(&document.title);
    format!("{title}: {}. Written by {GENERATOR}.", document.description)
}

/// The global section (section 2.2.4.3): 26 parameters, the delimiters first. Fitted points have no
/// unit; IGES needs one, and millimetres are the usual one.
fn global(document: &Document<'_>) -> ParameterData {
    let title = ascii(&document.title);
    let time = document.created.strftime("%Y%m%d.%H%M%S").to_string();
    let mut global = ParameterData::global();
    global.text(",");
    global.text(";");
    for name in [&title, &format!("{title}.igs"), GENERATOR, GENERATOR] {
        global.text(name);
    }
    // Bits of integers; powers of ten and digits of single and of double precision.
    for number in [32, 38, 6, 308, 17] {
        global.integer(number);
    }
    global.text(&title);
    // Model space is as large as the model; units have a number and a name.
    global.real(1.0);
    let (flag, unit) = match document.options.unit.unwrap_or_default() {
        Unit::Millimetre => (2, "MM"),
        Unit::Metre => (6, "M"),
        Unit::Inch => (1, "IN"),
    };
    global.integer(flag);
    global.text(unit);
    // Gradations of line weight, and the width of the widest line.
    global.integer(1);
    global.real(1.0);
    global.text(&time);
    let all = || document.shapes.iter().map(|shape| shape.nurbs);
    let accuracies = document.shapes.iter().map(|shape| match shape.outline {
        None => shape.nurbs.resolution(),
        Some(_) => tolerance(shape.nurbs),
    });
    global.real(accuracies.fold(f64::INFINITY, f64::min));
    let magnitudes = all().map(|nurbs| nurbs.points.magnitude());
    global.real(magnitudes.fold(0.0, f64::max));
    global.text("");
    global.text("");
    // Version 5.3, no drafting standard; when the model was made; no application protocol.
    global.integer(11);
    global.integer(0);
    global.text(&time);
    global.text("");
    global
}

/// Entity 126 (section 4.23).
fn curve(data: &mut ParameterData, nurbs: &Nurbs) {
    let u = &nurbs.u;
    let plane = plane(nurbs);
    data.integer(nurbs.rows() - 1);
    data.integer(u.degree);
    data.flag(plane.is_some());
    data.flag(u.closed);
    data.flag(nurbs.weights.is_none());
    data.flag(u.is_periodic());
    data.reals(&u.knots);
    net(data, nurbs, 0..nurbs.rows());
    domain(data, u);
    data.reals(&plane.unwrap_or_default());
}

/// Entity 128 (section 4.24). Control points run fastest in the first direction.
fn surface(data: &mut ParameterData, nurbs: &Nurbs, v: &KnotVector) {
    let u = &nurbs.u;
    let (rows, columns) = (nurbs.rows(), nurbs.columns());
    data.integer(rows - 1);
    data.integer(columns - 1);
    data.integer(u.degree);
    data.integer(v.degree);
    data.flag(u.closed);
    data.flag(v.closed);
    data.flag(nurbs.weights.is_none());
    data.flag(u.is_periodic());
    data.flag(v.is_periodic());
    data.reals(&u.knots);
    data.reals(&v.knots);
    let order = (0..columns).flat_map(|column| (0..rows).map(move |row| row * columns + column));
    net(data, nurbs, order);
    domain(data, u);
    domain(data, v);
}

/// All weights, then all control points. Polynomial ones have equal weights (section 4.23).
fn net(data: &mut ParameterData, nurbs: &Nurbs, order: impl Iterator<Item = usize> + Clone) {
    let factor = weight_factor(nurbs);
    for index in order.clone() {
        data.real(factor * nurbs.weight(index));
    }
    for index in order {
        data.reals(&nurbs.place(index));
    }
}

/// A power of two by which all weights are multiplied, which does not change the geometry, so that none is
/// below 10⁻⁹: OpenCASCADE would read the file as polynomial.
fn weight_factor(nurbs: &Nurbs) -> f64 {
    let weights = nurbs.weights.as_deref().unwrap_or_default();
    let smallest = weights.iter().copied().fold(1.0, f64::min);
    let largest = weights.iter().copied().fold(1.0, f64::max);
    let wanted = (1e-8 / smallest).log2().ceil();
    // One less, as logarithms are rounded.
    let possible = (f64::MAX / largest).log2().floor() - 1.0;
    wanted.min(possible).max(0.0).exp2()
}

/// Where the parameter starts and ends.
fn domain(data: &mut ParameterData, direction: &KnotVector) {
    let (low, high) = direction.domain();
    data.reals(&[low, high]);
}

/// The unit normal of the plane that a curve is in, if that is a plane of constant z.
fn plane(nurbs: &Nurbs) -> Option<[f64; 3]> {
    let height = nurbs.place(0)[2];
    let planar = (0..nurbs.rows()).all(|index| nurbs.place(index)[2] == height);
    planar.then_some([0.0, 0.0, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_weights_are_multiplied_by_a_power_of_two() {
        let mut nurbs = crate::export::cylinder::cylinder();
        assert_eq!(weight_factor(&nurbs), 1.0);
        for (smallest, largest) in [
            (1e-12, 1.0),
            (1e-200, 1e-190),
            (1e-300, 1e300),
            (5e-324, 1.0),
        ] {
            nurbs.weights = Some(vec![1.0, smallest, largest, 1.0, 1.0, 1.0]);
            let factor = weight_factor(&nurbs);
            assert_eq!(factor.log2().fract(), 0.0);
            assert!(factor > 1.0 && (factor * largest).is_finite());
            assert!(factor * smallest > 1e-9 || largest == 1e300 || smallest == 5e-324);
        }
        nurbs.weights = None;
        assert_eq!(weight_factor(&nurbs), 1.0);
    }
}
