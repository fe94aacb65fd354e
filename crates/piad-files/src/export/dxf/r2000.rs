//! DXF of AutoCAD R2000: splines are exact, all objects have handles and owners.

use super::groups::{end_section, pair, place, real, section};
use super::layers;
use super::sampled::PolygonMesh;
use super::skeleton::{
    BLOCKS, CLASSES, FIRST_FREE, LAYERS, LINE_TYPES, MODEL_SPACE, OBJECTS, OTHER_TABLES,
    PLOT_STYLE, groups, layouts,
};
use crate::export::document::Document;
use crate::export::error::ExportError;
use crate::export::fitted::GENERATOR;
use crate::export::nurbs::Nurbs;
use crate::export::text::Text;

/// Flags of splines.
const CLOSED: u32 = 1;
const PERIODIC: u32 = 2;
const RATIONAL: u32 = 4;
const PLANAR: u32 = 8;

/// The flag of vertices of meshes.
const MESH_VERTEX: u32 = 64;

/// Gives out handles.
struct Handles {
    next: usize,
}

impl Handles {
    fn take(&mut self) -> usize {
        self.next += 1;
        self.next - 1
    }
}

/// The splines and meshes as a file.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let layers = layers::of_shapes(document, layers::R2000);
    let mut handles = Handles { next: FIRST_FREE };
    let view = Box3::of(document);
    let mut tables = Text::default();
    section(&mut tables, "TABLES");
    view_port(&mut tables, &view);
    groups(&mut tables, LINE_TYPES);
    layer_table(&mut tables, &mut handles, &layers);
    groups(&mut tables, OTHER_TABLES);
    let mut entities = Text::default();
    section(&mut entities, "ENTITIES");
    let mut layer = layers.iter();
    document.try_each(|shape| {
        let layer = encoded(layer.next().map_or(layers::ALWAYS, String::as_str));
        let nurbs = shape.nurbs;
        match &nurbs.v {
            None => spline(&mut entities, &mut handles, &layer, nurbs),
            Some(v) => {
                let mesh = PolygonMesh::new(nurbs, v, &document.options)?;
                surface(&mut entities, &mut handles, &layer, &mesh);
            }
        }
        Ok(())
    })?;
    end_section(&mut entities);
    let mut text = Text::default();
    pair(
        &mut text,
        999,
        format_args!("{GENERATOR}: {}", document.description),
    );
    header(&mut text, &view, handles.next);
    groups(&mut text, CLASSES);
    text.push(tables.as_str());
    groups(&mut text, BLOCKS);
    text.push(entities.as_str());
    groups(&mut text, OBJECTS);
    layouts(&mut text);
    end_section(&mut text);
    pair(&mut text, 0, format_args!("EOF"));
    Ok(text.into_bytes())
}

/// The box around all control points, which curves and surfaces do not leave.
struct Box3 {
    low: [f64; 3],
    high: [f64; 3],
}

impl Box3 {
    fn of(document: &Document<'_>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for shape in &document.shapes {
            for point in (0..shape.nurbs.points.len()).map(|index| shape.nurbs.place(index)) {
                for c in 0..3 {
                    low[c] = low[c].min(point[c]);
                    high[c] = high[c].max(point[c]);
                }
            }
        }
        Self { low, high }
    }

    fn middle(&self, axis: usize) -> f64 {
        self.low[axis] / 2.0 + self.high[axis] / 2.0
    }

    /// A height that fits into a window that is a little wider than high.
    fn height(&self) -> f64 {
        let [width, height] = [0, 1].map(|c| self.high[c] - self.low[c]);
        let all = 1.1 * width.max(height);
        if all > 0.0 && all.is_finite() {
            all
        } else {
            1.0
        }
    }
}

fn header(text: &mut Text, view: &Box3, next_handle: usize) {
    section(text, "HEADER");
    pair(text, 9, format_args!("$ACADVER"));
    pair(text, 1, format_args!("AC1015"));
    pair(text, 9, format_args!("$DWGCODEPAGE"));
    pair(text, 3, format_args!("ANSI_1252"));
    pair(text, 9, format_args!("$HANDSEED"));
    pair(text, 5, format_args!("{next_handle:X}"));
    pair(text, 9, format_args!("$EXTMIN"));
    place(text, view.low);
    pair(text, 9, format_args!("$EXTMAX"));
    place(text, view.high);
    // Coordinates have no unit.
    pair(text, 9, format_args!("$INSUNITS"));
    pair(text, 70, format_args!("0"));
    end_section(text);
}

/// The window, which shows everything from above.
fn view_port(text: &mut Text, view: &Box3) {
    groups(
        text,
        "0 TABLE\n2 VPORT\n5 8\n330 0\n100 AcDbSymbolTable\n70 1\n0 VPORT\n5 29\n330 8\n\
         100 AcDbSymbolTableRecord\n100 AcDbViewportTableRecord\n2 *ACTIVE\n70 0\n\
         10 0.0\n20 0.0\n11 1.0\n21 1.0",
    );
    real(text, 12, view.middle(0));
    real(text, 22, view.middle(1));
    groups(
        text,
        "13 0.0\n23 0.0\n14 1.0\n24 1.0\n15 1.0\n25 1.0\n16 0.0\n26 0.0\n36 1.0\n17 0.0\n27 0.0\n37 0.0",
    );
    real(text, 40, view.height());
    groups(
        text,
        "41 1.5\n42 50.0\n43 0.0\n44 0.0\n50 0.0\n51 0.0\n71 0\n72 100\n73 1\n74 3\n75 0\n76 0\n77 0\n78 0\n0 ENDTAB",
    );
}

fn layer_table(text: &mut Text, handles: &mut Handles, layers: &[String]) {
    let declared = layers::declared(layers);
    pair(text, 0, format_args!("TABLE"));
    pair(text, 2, format_args!("LAYER"));
    pair(text, 5, format_args!("{LAYERS}"));
    pair(text, 330, format_args!("0"));
    pair(text, 100, format_args!("AcDbSymbolTable"));
    pair(text, 70, format_args!("{}", 1 + declared.clone().count()));
    layer(text, "10", layers::ALWAYS);
    for name in declared {
        let handle = format!("{:X}", handles.take());
        layer(text, &handle, &encoded(name));
    }
    pair(text, 0, format_args!("ENDTAB"));
}

fn layer(text: &mut Text, handle: &str, name: &str) {
    pair(text, 0, format_args!("LAYER"));
    pair(text, 5, format_args!("{handle}"));
    pair(text, 330, format_args!("{LAYERS}"));
    pair(text, 100, format_args!("AcDbSymbolTableRecord"));
    pair(text, 100, format_args!("AcDbLayerTableRecord"));
    pair(text, 2, format_args!("{name}"));
    pair(text, 70, format_args!("0"));
    pair(text, 62, format_args!("7"));
    pair(text, 6, format_args!("Continuous"));
    // The usual width of lines.
    pair(text, 370, format_args!("-3"));
    pair(text, 390, format_args!("{PLOT_STYLE}"));
}

/// Writes the common beginning of all entities; returns the handle.
fn entity(text: &mut Text, handles: &mut Handles, kind: &str, owner: &str, layer: &str) -> usize {
    let handle = handles.take();
    pair(text, 0, format_args!("{kind}"));
    pair(text, 5, format_args!("{handle:X}"));
    pair(text, 330, format_args!("{owner}"));
    pair(text, 100, format_args!("AcDbEntity"));
    pair(text, 8, format_args!("{layer}"));
    handle
}

/// A B-spline with all of its numbers.
fn spline(text: &mut Text, handles: &mut Handles, layer: &str, nurbs: &Nurbs) {
    entity(text, handles, "SPLINE", MODEL_SPACE, layer);
    pair(text, 100, format_args!("AcDbSpline"));
    let height = nurbs.place(0)[2];
    let is_planar = (0..nurbs.rows()).all(|index| nurbs.place(index)[2] == height);
    if is_planar {
        for (code, x) in [(210, 0.0), (220, 0.0), (230, 1.0)] {
            real(text, code, x);
        }
    }
    let flags = [
        (nurbs.u.closed, CLOSED),
        (nurbs.u.is_periodic(), PERIODIC),
        (nurbs.weights.is_some(), RATIONAL),
        (is_planar, PLANAR),
    ];
    let flags: u32 = flags.iter().filter(|it| it.0).map(|it| it.1).sum();
    pair(text, 70, format_args!("{flags}"));
    pair(text, 71, format_args!("{}", nurbs.u.degree));
    pair(text, 72, format_args!("{}", nurbs.u.knots.len()));
    pair(text, 73, format_args!("{}", nurbs.rows()));
    // No fit points; below these distances knots, control points are the same.
    pair(text, 74, format_args!("0"));
    real(text, 42, 1e-10);
    real(text, 43, nurbs.resolution());
    for &knot in &nurbs.u.knots {
        real(text, 40, knot);
    }
    for &weight in nurbs.weights.as_deref().unwrap_or_default() {
        real(text, 41, weight);
    }
    for index in 0..nurbs.rows() {
        place(text, nurbs.place(index));
    }
}

fn surface(text: &mut Text, handles: &mut Handles, layer: &str, mesh: &PolygonMesh) {
    let handle = entity(text, handles, "POLYLINE", MODEL_SPACE, layer);
    let owner = format!("{handle:X}");
    pair(text, 100, format_args!("AcDbPolygonMesh"));
    pair(text, 66, format_args!("1"));
    place(text, [0.0; 3]);
    pair(text, 70, format_args!("{}", mesh.flags));
    pair(text, 71, format_args!("{}", mesh.rows));
    pair(text, 72, format_args!("{}", mesh.columns));
    for &point in &mesh.vertices {
        entity(text, handles, "VERTEX", &owner, layer);
        pair(text, 100, format_args!("AcDbVertex"));
        pair(text, 100, format_args!("AcDbPolygonMeshVertex"));
        place(text, point);
        pair(text, 70, format_args!("{MESH_VERTEX}"));
    }
    entity(text, handles, "SEQEND", &owner, layer);
}

/// Text of a file whose characters are ASCII: others are escaped.
fn encoded(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            ' '..='~' => text.push(c),
            _ => text.push_str(&format!("\\U+{:04X}", u32::from(c))),
        }
    }
    text
}
