//! GPX 1.1: curves as tracks.

use super::document::{Document, Shape};
use super::error::ExportError;
use super::fitted::GENERATOR;
use super::format::Format;
use super::map::{decimal, line};
use super::text::{Text, escape};

/// The curves as tracks of one segment each, with their names.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut text = Text::default();
    let time = document.created.strftime("%Y-%m-%dT%H:%M:%SZ");
    text.put(format_args!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <gpx version=\"1.1\" creator=\"{GENERATOR}\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n\
         <metadata><name>{}</name><desc>{}</desc><time>{time}</time></metadata>\n",
        escape(&document.title),
        document.description,
    ));
    document.try_each(|shape| track(&mut text, document, shape))?;
    text.push("</gpx>\n");
    Ok(text.into_bytes())
}

fn track(text: &mut Text, document: &Document<'_>, shape: &Shape<'_>) -> Result<(), ExportError> {
    let points = line(shape.nurbs, &document.options, Format::Gpx)?;
    let is_spatial = shape.nurbs.points.dimension() > 2;
    text.put(format_args!(
        "<trk><name>{}</name><trkseg>\n",
        escape(shape.title())
    ));
    for [longitude, latitude, height] in points {
        let (longitude, latitude) = (decimal(longitude), decimal(latitude));
        text.put(format_args!(
            "<trkpt lat=\"{latitude}\" lon=\"{longitude}\">"
        ));
        if is_spatial {
            // Decimal numbers of XML have no exponents.
            text.put(format_args!("<ele>{}</ele>", decimal(height)));
        }
        text.push("</trkpt>\n");
    }
    text.push("</trkseg></trk>\n");
    Ok(())
}
