//! STEP: an ISO 10303-21 file with the schema of AP214, read by nearly all CAD systems.
//!
//! A B-spline needs the whole chain around it to be found by a reader: a product with a
//! definition, its shape, a representation of the shape with units and accuracy, and in it a set
//! that holds the curve or surface. A curve or surface is not allowed directly in a plain shape
//! representation (readers load such a file, and show nothing); its place is in a geometrically
//! bounded wireframe or surface representation (ISO 10303-510 and -507). Trimmed surfaces are faces ([`faces`]).

mod faces;
mod instances;

use crate::export::document::Document;
use crate::export::fitted::GENERATOR;
use crate::export::nurbs::{KnotVector, Nurbs};
use crate::export::options::Unit;
use crate::export::text::Text;
use crate::export::trim::edges;
use instances::{CONTEXT, ORIGIN, SHAPE, knots, real};

/// The number of the first control point.
const FIRST_POINT: usize = 22;

/// The curves and surfaces as a STEP file: one product, whose shape they are.
pub(super) fn write(document: &Document<'_>) -> Vec<u8> {
    let mut text = Text::default();
    let name = string(&document.title);
    header(&mut text, &name, document);
    text.push("DATA;\n");
    let unit = document.options.unit.unwrap_or_default();
    let accuracies = document.shapes.iter().map(|shape| match shape.outline {
        None => shape.nurbs.resolution(),
        Some(_) => edges::tolerance(shape.nurbs),
    });
    product(
        &mut text,
        &name,
        accuracies.fold(f64::INFINITY, f64::min),
        unit,
    );
    let mut next = FIRST_POINT;
    let (mut splines, mut shells) = (Vec::new(), Vec::new());
    for shape in &document.shapes {
        let spline = Spline {
            nurbs: shape.nurbs,
            name: string(shape.title()),
            first: next,
        };
        let number = spline.write(&mut text);
        next = number + 1;
        match shape.outline {
            None => splines.push(number),
            Some(outline) => {
                let trimmed = faces::Trimmed {
                    surface: number,
                    edges: edges::of_loops(shape.nurbs, outline),
                    faces: &outline.faces,
                };
                shells.push(trimmed.write(&mut text, &mut next));
            }
        }
    }
    let has_surface = document.shapes.iter().any(|it| it.nurbs.v.is_some());
    if !splines.is_empty() {
        next = representation(&mut text, &splines, next, has_surface);
    }
    if !shells.is_empty() {
        faces::representation(&mut text, &shells, next);
    }
    text.push("ENDSEC;\nEND-ISO-10303-21;\n");
    text.into_bytes()
}

/// A curve or surface with its control points.
struct Spline<'a> {
    nurbs: &'a Nurbs,
    /// Its name, as a literal.
    name: String,
    /// The number of its first control point.
    first: usize,
}

impl Spline<'_> {
    /// The number of the curve or surface, behind its control points.
    fn number(&self) -> usize {
        self.first + self.nurbs.points.len()
    }

    /// Writes it and returns its number.
    fn write(&self, text: &mut Text) -> usize {
        for index in 0..self.nurbs.points.len() {
            text.put(format_args!("#{}=CARTESIAN_POINT('',", self.first + index));
            text.list(self.nurbs.place(index), real);
            text.push(");\n");
        }
        let number = self.number();
        text.put(format_args!("#{number}="));
        match (&self.nurbs.v, &self.nurbs.weights) {
            (None, None) => self.curve(text),
            (None, Some(weights)) => self.rational_curve(text, weights),
            (Some(v), None) => self.surface(text, v),
            (Some(v), Some(weights)) => self.rational_surface(text, v, weights),
        }
        number
    }

    /// ISO 10303-42, `b_spline_curve_with_knots`.
    fn curve(&self, text: &mut Text) {
        text.put(format_args!("B_SPLINE_CURVE_WITH_KNOTS({},", self.name));
        self.curve_attributes(text);
        text.push(",");
        knots(text, &[&self.nurbs.u]);
        text.push(");\n");
    }

    /// A rational curve is a `b_spline_curve_with_knots` and a `rational_b_spline_curve` at once: a
    /// complex instance, whose parts are in alphabetical order (ISO 10303-21, section 11.2.5.3).
    fn rational_curve(&self, text: &mut Text, weights: &[f64]) {
        text.push("(BOUNDED_CURVE()\nB_SPLINE_CURVE(");
        self.curve_attributes(text);
        text.push(")\nB_SPLINE_CURVE_WITH_KNOTS(");
        knots(text, &[&self.nurbs.u]);
        text.push(")\nCURVE()\nGEOMETRIC_REPRESENTATION_ITEM()\nRATIONAL_B_SPLINE_CURVE(");
        text.list(weights.iter().copied(), real);
        text.put(format_args!(")\nREPRESENTATION_ITEM({}));\n", self.name));
    }

    /// ISO 10303-42, `b_spline_surface_with_knots`.
    fn surface(&self, text: &mut Text, v: &KnotVector) {
        text.put(format_args!("B_SPLINE_SURFACE_WITH_KNOTS({},", self.name));
        self.surface_attributes(text, v);
        text.push(",");
        knots(text, &[&self.nurbs.u, v]);
        text.push(");\n");
    }

    fn rational_surface(&self, text: &mut Text, v: &KnotVector, weights: &[f64]) {
        text.push("(BOUNDED_SURFACE()\nB_SPLINE_SURFACE(");
        self.surface_attributes(text, v);
        text.push(")\nB_SPLINE_SURFACE_WITH_KNOTS(");
        knots(text, &[&self.nurbs.u, v]);
        text.push(")\nGEOMETRIC_REPRESENTATION_ITEM()\nRATIONAL_B_SPLINE_SURFACE(");
        text.list(weights.chunks_exact(v.count()), |text, row| {
            text.list(row.iter().copied(), real);
        });
        text.put(format_args!(
            ")\nREPRESENTATION_ITEM({})\nSURFACE());\n",
            self.name
        ));
    }

    /// Degree, control points, form, closed, self-intersecting (`.U.`: unknown).
    fn curve_attributes(&self, text: &mut Text) {
        text.put(format_args!("{},", self.nurbs.u.degree));
        text.list(0..self.nurbs.rows(), |text, index| {
            self.reference(text, index)
        });
        text.put(format_args!(
            ",.UNSPECIFIED.,{},.U.",
            logical(self.nurbs.u.closed)
        ));
    }

    /// The rows of control points run in the u direction, like ours.
    fn surface_attributes(&self, text: &mut Text, v: &KnotVector) {
        text.put(format_args!("{},{},", self.nurbs.u.degree, v.degree));
        text.list(0..self.nurbs.rows(), |text, row| {
            let start = row * v.count();
            text.list(start..start + v.count(), |text, index| {
                self.reference(text, index)
            });
        });
        let (u, v) = (logical(self.nurbs.u.closed), logical(v.closed));
        text.put(format_args!(",.UNSPECIFIED.,{u},{v},.U."));
    }

    fn reference(&self, text: &mut Text, index: usize) {
        text.put(format_args!("#{}", self.first + index));
    }
}

/// The header section (ISO 10303-21, section 8).
fn header(text: &mut Text, name: &str, document: &Document<'_>) {
    let time = document.created.strftime("%Y-%m-%dT%H:%M:%S+00:00");
    text.put(format_args!(
        "ISO-10303-21;\nHEADER;\n\
         FILE_DESCRIPTION(({}),'2;1');\n\
         FILE_NAME({name},'{time}',(''),(''),'{GENERATOR}','{GENERATOR}','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\n\
         ENDSEC;\n",
        string(&document.description),
    ));
}

/// What does not depend on the geometry: the product, the units and the coordinate system. Fitted
/// points have no unit; STEP needs one, and millimetres are the usual one.
fn product(text: &mut Text, name: &str, resolution: f64, unit: Unit) {
    text.put(format_args!(
        "#1=APPLICATION_CONTEXT('core data for automotive mechanical design processes');\n\
         #2=APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#1);\n\
         #3=PRODUCT_CONTEXT('',#1,'mechanical');\n\
         #4=PRODUCT({name},{name},'',(#3));\n\
         #5=PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#4));\n\
         #6=PRODUCT_DEFINITION_FORMATION('','',#4);\n\
         #7=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');\n\
         #8=PRODUCT_DEFINITION('design','',#6,#7);\n\
         #{SHAPE}=PRODUCT_DEFINITION_SHAPE('','',#8);\n\
         #10={};\n\
         #11=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n\
         #12=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n\
         #13=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(",
        length_unit(unit),
    ));
    text.real(resolution, 'E');
    text.put(format_args!(
        "),#10,'distance_accuracy_value','confusion accuracy');\n\
         #{CONTEXT}=(GEOMETRIC_REPRESENTATION_CONTEXT(3)\
         GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#13))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT((#10,#11,#12))\
         REPRESENTATION_CONTEXT('','3D'));\n\
         #{ORIGIN}=AXIS2_PLACEMENT_3D('',#16,#17,#18);\n\
         #16=CARTESIAN_POINT('',(0.,0.,0.));\n\
         #17=DIRECTION('',(0.,0.,1.));\n\
         #18=DIRECTION('',(1.,0.,0.));\n\
         #19={};\n\
         #20=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#19);\n\
         #21=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n",
        length_unit(Unit::Millimetre),
    ));
}

/// The unit of length. An inch is defined by millimetres, in the instances behind the fixed ones.
fn length_unit(unit: Unit) -> &'static str {
    match unit {
        Unit::Millimetre => "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))",
        Unit::Metre => "(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))",
        Unit::Inch => "(CONVERSION_BASED_UNIT('INCH',#20)LENGTH_UNIT()NAMED_UNIT(#21))",
    }
}

/// The set of the curves and surfaces, with this number, and its tie to the product; the next number.
fn representation(
    text: &mut Text,
    splines: &[usize],
    set_number: usize,
    has_surface: bool,
) -> usize {
    // A set of curves holds nothing else; the other one holds curves, too.
    let (set, kind) = if has_surface {
        ("GEOMETRIC_SET", "SURFACE")
    } else {
        ("GEOMETRIC_CURVE_SET", "WIREFRAME")
    };
    text.put(format_args!("#{set_number}={set}('',"));
    text.list(splines, |text, number| text.put(format_args!("#{number}")));
    let (shape, tie) = (set_number + 1, set_number + 2);
    text.put(format_args!(
        ");\n\
         #{shape}=GEOMETRICALLY_BOUNDED_{kind}_SHAPE_REPRESENTATION('',(#{ORIGIN},#{set_number}),#{CONTEXT});\n\
         #{tie}=SHAPE_DEFINITION_REPRESENTATION(#{SHAPE},#{shape});\n"
    ));
    tie + 1
}

fn logical(value: bool) -> &'static str {
    if value { ".T." } else { ".F." }
}

/// A string literal (ISO 10303-21, section 6.4.3): printable ASCII as it is, apostrophes and
/// backslashes doubled, everything else as hexadecimal digits of UTF-16 (`\X2\`) or UTF-32
/// (`\X4\`) between control directives.
fn string(value: &str) -> String {
    let mut literal = String::from("'");
    let mut open = None;
    for c in value.chars() {
        let directive = match c {
            ' '..='~' => None,
            '\0'..='\u{ffff}' => Some("\\X2\\"),
            _ => Some("\\X4\\"),
        };
        if directive != open {
            if open.is_some() {
                literal.push_str("\\X0\\");
            }
            literal.push_str(directive.unwrap_or_default());
            open = directive;
        }
        match c {
            '\'' | '\\' => literal.extend([c, c]),
            ' '..='~' => literal.push(c),
            '\0'..='\u{ffff}' => literal.push_str(&format!("{:04X}", u32::from(c))),
            _ => literal.push_str(&format!("{:08X}", u32::from(c))),
        }
    }
    if open.is_some() {
        literal.push_str("\\X0\\");
    }
    literal.push('\'');
    literal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_ascii() {
        assert_eq!(string("wing"), "'wing'");
        assert_eq!(string("it's C:\\x"), "'it''s C:\\\\x'");
        assert_eq!(
            string("Flügel 翼"),
            "'Fl\\X2\\00FC\\X0\\gel \\X2\\7FFC\\X0\\'"
        );
        assert_eq!(string("üß"), "'\\X2\\00FC00DF\\X0\\'");
        assert_eq!(
            string("é\u{1f6e9}"),
            "'\\X2\\00E9\\X0\\\\X4\\0001F6E9\\X0\\'"
        );
        assert_eq!(string("a\nb"), "'a\\X2\\000A\\X0\\b'");
        assert_eq!(string(""), "''");
    }
}
