//! GeoJSON (RFC 7946): curves as lines.
//!
//! With an origin coordinates are longitude and latitude, as the standard requires; without one they are those of the
//! data, and map software interprets them in a reference system of its user's choice.

use super::document::{Document, Shape};
use super::error::ExportError;
use super::format::Format;
use super::map::{decimal, line};
use super::text::Text;

/// The curves as a collection of features with their names.
pub(super) fn write(document: &Document<'_>) -> Result<Vec<u8>, ExportError> {
    let mut text = Text::default();
    text.push("{\"type\":\"FeatureCollection\",\"features\":[");
    let mut separator = "\n";
    document.try_each(|shape| {
        text.push(separator);
        separator = ",\n";
        feature(&mut text, document, shape)
    })?;
    text.push("\n]}\n");
    Ok(text.into_bytes())
}

fn feature(text: &mut Text, document: &Document<'_>, shape: &Shape<'_>) -> Result<(), ExportError> {
    let options = &document.options;
    let points = line(shape.nurbs, options, Format::GeoJson)?;
    let name = serde_json::json!(shape.name);
    text.put(format_args!(
        "{{\"type\":\"Feature\",\"properties\":{{\"name\":{name}}},\"geometry\":"
    ));
    let lines = match options.origin {
        None => vec![points],
        Some(_) => cut(&points),
    };
    let is_spatial = shape.nurbs.points.dimension() > 2;
    let position = |text: &mut Text, [x, y, z]: [f64; 3]| {
        match options.origin {
            None => text.put(format_args!("[{x:?},{y:?}")),
            Some(_) => text.put(format_args!("[{},{}", decimal(x), decimal(y))),
        }
        if is_spatial {
            text.put(format_args!(",{z:?}"));
        }
        text.push("]");
    };
    let list = |text: &mut Text, points: &[[f64; 3]]| {
        text.push("[");
        for (index, point) in points.iter().enumerate() {
            text.push(if index > 0 { "," } else { "" });
            position(text, *point);
        }
        text.push("]");
    };
    match lines.as_slice() {
        [only] => {
            text.push("{\"type\":\"LineString\",\"coordinates\":");
            list(text, only);
        }
        several => {
            text.push("{\"type\":\"MultiLineString\",\"coordinates\":[");
            for (index, points) in several.iter().enumerate() {
                text.push(if index > 0 { "," } else { "" });
                list(text, points);
            }
            text.push("]");
        }
    }
    text.push("}}");
    Ok(())
}

/// Cuts a line where it crosses the antimeridian, as RFC 7946 requires (section 3.1.9): otherwise it would go around
/// the whole earth on a map.
fn cut(points: &[[f64; 3]]) -> Vec<Vec<[f64; 3]>> {
    let mut lines = vec![Vec::new()];
    let mut before: Option<[f64; 3]> = None;
    for &point in points {
        if let Some(before) = before
            && (point[0] - before[0]).abs() > 180.0
        {
            // Both ends on one side of the earth, and where between them it is crossed.
            let side = 180.0_f64.copysign(before[0]);
            let end = point[0] + 2.0 * side;
            let part = (side - before[0]) / (end - before[0]);
            let at = |c: usize| before[c] + part * (point[c] - before[c]);
            if let Some(line) = lines.last_mut() {
                line.push([side, at(1), at(2)]);
            }
            lines.push(vec![[-side, at(1), at(2)]]);
        }
        if let Some(line) = lines.last_mut() {
            line.push(point);
        }
        before = Some(point);
    }
    // A line that ends on the meridian leaves a single point behind it.
    lines.retain(|line| line.len() > 1);
    lines
}

#[cfg(test)]
mod tests {
    use super::cut;

    #[test]
    fn lines_are_cut_at_the_antimeridian() {
        let lines = cut(&[[179.0, 10.0, 0.0], [-179.0, 12.0, 4.0], [-178.0, 12.0, 5.0]]);
        assert_eq!(
            lines,
            [
                vec![[179.0, 10.0, 0.0], [180.0, 11.0, 2.0]],
                vec![
                    [-180.0, 11.0, 2.0],
                    [-179.0, 12.0, 4.0],
                    [-178.0, 12.0, 5.0]
                ],
            ]
        );
        assert_eq!(cut(&[[1.0, 2.0, 0.0], [3.0, 4.0, 0.0]]).len(), 1);
    }
}
