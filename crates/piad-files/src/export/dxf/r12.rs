//! DXF of AutoCAD R12.

use super::groups::{end_section, pair, place, section};
use super::layers;
use super::sampled::{PolygonMesh, Polyline, SPATIAL};
use crate::export::document::Document;
use crate::export::error::ExportError;
use crate::export::fitted::GENERATOR;
use crate::export::text::Text;

/// The flags of vertices of polylines in space, and of meshes.
const SPATIAL_VERTEX: u32 = 4 * SPATIAL;
const MESH_VERTEX: u32 = 64;

/// The polylines and meshes as a file.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let layers = layers::of_shapes(document, layers::R12);
    let mut text = Text::default();
    pair(
        &mut text,
        999,
        format_args!("{GENERATOR}: {}", document.description),
    );
    section(&mut text, "HEADER");
    pair(&mut text, 9, format_args!("$ACADVER"));
    pair(&mut text, 1, format_args!("AC1009"));
    end_section(&mut text);
    let declared = layers::declared(&layers);
    if declared.clone().next().is_some() {
        tables(&mut text, declared);
    }
    section(&mut text, "ENTITIES");
    let mut layer = layers.iter();
    document.try_each(|shape| {
        let layer = layer.next().map_or(layers::ALWAYS, String::as_str);
        let nurbs = shape.nurbs;
        match &nurbs.v {
            None => curve(&mut text, layer, &Polyline::new(nurbs, &document.options)?),
            Some(v) => {
                let mesh = PolygonMesh::new(nurbs, v, &document.options)?;
                surface(&mut text, layer, &mesh);
            }
        }
        Ok(())
    })?;
    end_section(&mut text);
    pair(&mut text, 0, format_args!("EOF"));
    Ok(text.into_bytes())
}

/// The layers, and the type of lines that they have.
fn tables<'a>(text: &mut Text, layers: impl Iterator<Item = &'a str> + Clone) {
    section(text, "TABLES");
    table(text, "LTYPE", 1);
    pair(text, 0, format_args!("LTYPE"));
    pair(text, 2, format_args!("CONTINUOUS"));
    pair(text, 70, format_args!("0"));
    pair(text, 3, format_args!("Solid line"));
    // The alignment, always `A`, the number of dashes, and their length.
    pair(text, 72, format_args!("65"));
    pair(text, 73, format_args!("0"));
    pair(text, 40, format_args!("0.0"));
    pair(text, 0, format_args!("ENDTAB"));
    table(text, "LAYER", 1 + layers.clone().count());
    for name in [layers::ALWAYS].into_iter().chain(layers) {
        pair(text, 0, format_args!("LAYER"));
        pair(text, 2, format_args!("{name}"));
        pair(text, 70, format_args!("0"));
        pair(text, 62, format_args!("7"));
        pair(text, 6, format_args!("CONTINUOUS"));
    }
    pair(text, 0, format_args!("ENDTAB"));
    end_section(text);
}

fn table(text: &mut Text, name: &str, count: usize) {
    pair(text, 0, format_args!("TABLE"));
    pair(text, 2, format_args!("{name}"));
    pair(text, 70, format_args!("{count}"));
}

fn curve(text: &mut Text, layer: &str, curve: &Polyline) {
    polyline(text, layer, curve.flags);
    let flags = (!curve.is_planar).then_some(SPATIAL_VERTEX);
    for point in &curve.vertices {
        vertex(text, layer, *point, flags);
    }
    entity(text, "SEQEND", layer);
}

fn surface(text: &mut Text, layer: &str, mesh: &PolygonMesh) {
    polyline(text, layer, mesh.flags);
    pair(text, 71, format_args!("{}", mesh.rows));
    pair(text, 72, format_args!("{}", mesh.columns));
    for point in &mesh.vertices {
        vertex(text, layer, *point, Some(MESH_VERTEX));
    }
    entity(text, "SEQEND", layer);
}

fn polyline(text: &mut Text, layer: &str, flags: u32) {
    entity(text, "POLYLINE", layer);
    // Vertices follow; the place of the polyline itself is not used.
    pair(text, 66, format_args!("1"));
    place(text, [0.0; 3]);
    pair(text, 70, format_args!("{flags}"));
}

fn vertex(text: &mut Text, layer: &str, point: [f64; 3], flags: Option<u32>) {
    entity(text, "VERTEX", layer);
    place(text, point);
    if let Some(flags) = flags {
        pair(text, 70, format_args!("{flags}"));
    }
}

fn entity(text: &mut Text, kind: &str, layer: &str) {
    pair(text, 0, format_args!("{kind}"));
    pair(text, 8, format_args!("{layer}"));
}
