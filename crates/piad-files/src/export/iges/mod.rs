//! IGES 5.3: rational B-spline curves (entity 126) and surfaces (entity 128), also trimmed ones (entity 144).

mod entities;
mod sections;
mod splines;
mod trimmed;

use super::document::{Document, Shape};
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::options::Unit;
use super::text::{Text, ascii};
use super::trim::edges::tolerance;
use entities::{Entities, Label};
use sections::{MOST_LINES, ParameterData, Status, fixed_lines};
use splines::{entity, geometry};

/// Characters of the label of an entity.
const LABEL: usize = 8;

/// The curves and surfaces as an IGES file, an entity each.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut entities = Entities::default();
    document.try_each(|shape| {
        let label = label(document, shape, &entities);
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

/// Parts are labelled with the first characters of their names, and numbered.
fn label(document: &Document<'_>, shape: &Shape<'_>, entities: &Entities) -> Label {
    let kind = || match shape.nurbs.v {
        None => "CURVE".to_owned(),
        Some(_) => "SURFACE".to_owned(),
    };
    let name = shape.name.filter(|_| document.has_parts);
    let number = entities.directory_lines() + 1;
    Label {
        text: name.map_or_else(kind, |name| ascii(name).chars().take(LABEL).collect()),
        subscript: if document.has_parts {
            number.div_ceil(2)
        } else {
            0
        },
    }
}

/// The description of the file, for people.
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
