use proptest::prelude::*;

use super::is_geojson;
use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

fn parts(text: &str) -> Result<Vec<Imported>, FileErrors> {
    read_parts(text.as_bytes(), &HINTS)
}

fn collection(features: &[&str]) -> String {
    format!(
        "\u{feff}\n {{\"type\": \"FeatureCollection\", \"features\": [{}]}}",
        features.join(",\n")
    )
}

fn feature(properties: &str, kind: &str, coordinates: &str) -> String {
    format!(
        "{{\"type\": \"Feature\", \"properties\": {properties}, \"geometry\": {}}}",
        geometry(kind, coordinates)
    )
}

fn geometry(kind: &str, coordinates: &str) -> String {
    // The type may stand behind.
    format!("{{\"coordinates\": {coordinates}, \"type\": \"{kind}\"}}")
}

const LINE: &str = "[[223.0, 100], [222.5, 103.5], [220.7, 106.7]]";
const RING: &str = "[[0, 0], [400, 0], [400, 300], [0, 0]]";

#[test]
fn lines_and_rings_are_parts() {
    let text = collection(&[
        &feature("{\"ID\": 7, \"elev\": 10}", "LineString", LINE),
        &feature("{\"elev\": 10.5, \"name\": null}", "LineString", LINE),
        &feature("null", "MultiLineString", &format!("[{LINE}, {LINE}]")),
        &feature(
            "{\"name\": \"lake\"}",
            "Polygon",
            &format!("[{RING}, {RING}]"),
        ),
        &feature(
            "{\"id\": 3}",
            "MultiPolygon",
            &format!("[[{RING}], [{RING}]]"),
        ),
        "{\"type\": \"Feature\", \"geometry\": null, \"properties\": {\"a\": [{}]}}",
        &feature("{}", "Point", "[1, 2]"),
        &feature("{}", "MultiPoint", "[[3, 4], [5, 7]]"),
    ]);
    let parts = parts(&text).unwrap();
    let names: Vec<_> = parts.iter().map(|part| part.name.as_deref()).collect();
    assert_eq!(
        names,
        [
            Some("elev 10"),
            Some("elev 10.5"),
            None,
            None,
            Some("lake"),
            Some("lake 2"),
            Some("3"),
            Some("3 2"),
            None
        ]
    );
    let counts: Vec<_> = parts.iter().map(|part| part.points.len()).collect();
    assert_eq!(counts, [3; 9]);
    let closed: Vec<_> = parts.iter().map(|part| part.closed).collect();
    assert_eq!(
        closed,
        [false, false, false, false, true, true, true, true, false]
    );
    assert_eq!(parts[8].points.to_flat(), [1.0, 2.0, 3.0, 4.0, 5.0, 7.0]);
    assert!(parts[0].lines.is_empty());
    assert!(parts[0].notices[0].contains("taken as they are"));
}

#[test]
fn degrees_are_metres() {
    let line = "[[11.5, 48], [11.5001, 48], [11.5001, 48.0001]]";
    let alone = parts(&geometry("LineString", line)).unwrap().remove(0);
    assert!((alone.points.lane(0)[1] - 7.46).abs() < 0.01);
    assert!(alone.notices[0].contains("east and north of latitude 48, longitude 11.5"));
    for (name, notice) in [
        ("urn:ogc:def:crs:OGC:1.3:CRS84", "east and north"),
        ("urn:ogc:def:crs:EPSG::4326", "east and north"),
        ("EPSG:25832", "in the units of \\\"EPSG:25832\\\""),
    ] {
        let crs = format!("{{\"type\": \"name\", \"properties\": {{\"name\": \"{name}\"}}}}");
        let object = format!(
            "{{\"crs\": {crs}, \"type\": \"GeometryCollection\", \"geometries\": [{}]}}",
            geometry("LineString", line)
        );
        let part = parts(&object).unwrap().remove(0);
        let notice = notice.replace('\\', "");
        assert!(part.notices[0].contains(&notice), "{:?}", part.notices);
    }
}

#[test]
fn heights_are_read_where_all_have_them() {
    let with = "[[200, 1, 5], [201, 2, 6]]";
    let more = "[[200, 1, 5, 9], [201, 2, 6, 9]]";
    let without = "[[200, 1], [201, 2]]";
    for (lines, dimension, said) in [
        ([with, with], 3, None),
        ([with, more], 3, Some("more than 3 numbers")),
        ([with, without], 2, Some("have no height")),
        ([without, without], 2, None),
    ] {
        let features = lines.map(|line| feature("{}", "LineString", line));
        let features = features.each_ref().map(String::as_str);
        let part = parts(&collection(&features)).unwrap().remove(0);
        assert_eq!(part.points.dimension(), dimension, "{lines:?}");
        let found = part.notices.get(1).map(String::as_str).unwrap_or_default();
        assert!(found.contains(said.unwrap_or_default()), "{found}");
    }
}

#[test]
fn bad_coordinates_are_named() {
    let good = feature("{}", "LineString", LINE);
    for (kind, coordinates, detail) in [
        (
            "LineString",
            "[[1, 2], [3]]",
            "position 1: it has 1 numbers",
        ),
        ("LineString", "[[1, 2], []]", "a position has no numbers"),
        (
            "LineString",
            "[[1, 2], [3, null]]",
            "position 1: null is no",
        ),
        (
            "LineString",
            "[[1, 2], [3, \"a\"]]",
            "position 1: \"a\" is no",
        ),
        ("LineString", "[[1, 2], 3]", "position 1: numbers and lists"),
        ("LineString", "[[1, 2], {}]", "position 1: a number is"),
        ("LineString", "\"1,2\"", "position 0: \"1,2\" is no number"),
        ("LineString", "7", "position 0: the coordinates are no list"),
        (
            "LineString",
            "[[[1, 2], [3, 4]]]",
            "its coordinates are nested 3",
        ),
        (
            "Polygon",
            LINE,
            "its coordinates are nested 2 lists deep, and 3",
        ),
        (
            "Polygon",
            "[[[1, 2]], [3, 4]]",
            "position 1: it is not in as",
        ),
        (
            "LineString",
            "[[1e300, 2], [3, 4], [-1e999, 2]]",
            "number out of",
        ),
    ] {
        let error = parts(&collection(&[&good, &feature("{}", kind, coordinates)])).unwrap_err();
        let error = &error.0[0];
        let detail = match detail.starts_with("number") {
            true => format!("this is no GeoJSON: {detail}"),
            false => format!("feature 1: {detail}"),
        };
        assert!(error.detail.starts_with(&detail), "{coordinates}: {error}");
    }
    let few = Hints { most: 4, ..HINTS };
    let error = read_parts(collection(&[&good, &good]).as_bytes(), &few).unwrap_err();
    assert!(error.to_string().contains("more than 4 points"), "{error}");
}

#[test]
fn damaged_and_deep_files_are_refused() {
    let whole = collection(&[&feature("{}", "LineString", LINE)]);
    for end in (40..whole.len() - 1).step_by(7) {
        let error = parts(&whole[..end]).unwrap_err();
        assert!(error.0[0].line.is_some(), "{error}");
    }
    let deep = "[".repeat(100_000);
    assert!(parts(&geometry("LineString", &deep)).is_err());
    let deep = "{\"type\":\"GeometryCollection\",\"geometries\":[".repeat(100_000);
    assert!(parts(&deep).is_err());
    for empty in ["[]", "[[]]"] {
        let error = parts(&geometry("MultiLineString", empty)).unwrap_err();
        assert_eq!(error.to_string(), "there are no points in the file");
    }
    assert!(parts("{\"type\": \"Feature\"}").is_err());
}

#[test]
fn jobs_are_no_geojson() {
    for (text, expected) in [
        ("{\"type\": \"Point\", \"coordinates\": [", true),
        (
            "\u{feff} {\"a\": {\"type\": 1}, \"type\": \"Feature\"}",
            true,
        ),
        ("{\"curve\": {\"type\": \"Point\"}}", false),
        ("{\"type\": \"job\"}", false),
        ("{\"type\": 7}", false),
        ("[{\"type\": \"Point\"}]", false),
        ("{", false),
        ("", false),
    ] {
        assert_eq!(is_geojson(text.as_bytes()), expected, "{text}");
    }
}

proptest! {
    #[test]
    fn no_coordinates_panic(text in "[\\[\\],0-9.e{}\":-]{0,60}") {
        let _ = parts(&geometry("MultiPolygon", &text));
        let _ = parts(&format!("{{\"type\": \"LineString\", \"coordinates\": [[1, 2], {text}]]}}"));
    }
}
