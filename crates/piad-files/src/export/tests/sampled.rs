//! glTF, STL, PLY, DXF of R12, CSV and lines of maps.

use serde_json::Value;

use super::exact::groups;
use super::*;
use crate::export::Origin;
use crate::import::{Hints, read_parts};
use crate::wgs84::Plane;
use piad_fit::data::Grid;

/// A place near Freiburg.
const ORIGIN: Origin = Origin {
    longitude: 7.85,
    latitude: 47.99,
};

fn samples(rows: usize, columns: usize) -> Options {
    Options {
        samples: Some(Grid { rows, columns }),
        ..Options::default()
    }
}

#[test]
fn gltf_has_a_node_and_a_mesh_for_each() {
    let file = file("mixed", Format::Gltf, &mixed(), samples(5, 4));
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&file[20..20 + number(12)]).unwrap();
    assert_eq!(json["scenes"][0]["name"], "all of it");
    assert_eq!(json["scenes"][0]["nodes"], serde_json::json!([0, 1, 2, 3]));
    for (index, name) in ["Höhe 5/7", "Höhe 5/7", "curve", "tube"].iter().enumerate() {
        assert_eq!(json["nodes"][index]["mesh"], index);
        assert_eq!(json["nodes"][index]["name"], *name);
        assert_eq!(json["meshes"][index]["name"], *name);
        let primitive = &json["meshes"][index]["primitives"][0];
        let position = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
        let count = if index == 3 { 20 } else { 5 };
        assert_eq!(json["accessors"][position]["count"], count);
        // The first position is that of the part.
        let view = &json["bufferViews"][position];
        let start = 28 + number(12) + view["byteOffset"].as_u64().unwrap() as usize;
        let found = [0, 4, 8].map(|at| {
            f64::from(f32::from_le_bytes(
                file[start + at..start + at + 4].try_into().unwrap(),
            ))
        });
        let nurbs = &mixed()[index].nurbs;
        let v: Vec<_> = nurbs.v.iter().map(|v| v.sites(1)[0]).collect();
        let expected = nurbs.evaluate(&[nurbs.u.sites(1)[0]], &v)[0].point;
        assert!(is_near(found, expected, 1e-6), "{found:?}");
    }
    assert_eq!(json["buffers"].as_array().unwrap().len(), 1);
}

#[test]
fn stl_has_the_triangles_of_all() {
    let file = file("surfaces", Format::Stl, &surfaces(), samples(5, 4));
    let count = u32::from_le_bytes(file[80..84].try_into().unwrap()) as usize;
    assert_eq!(count, 2 * 2 * 4 * 3);
    assert_eq!(file.len(), 84 + 50 * count);
}

#[test]
fn ply_has_vertices_in_double_precision() {
    let file = file("surfaces", Format::Ply, &surfaces(), samples(5, 4));
    let end = b"end_header\n";
    let header = file.windows(end.len()).position(|it| it == end).unwrap() + end.len();
    let text = std::str::from_utf8(&file[..header]).unwrap();
    assert!(text.contains("element vertex 40\n") && text.contains("element face 48\n"));
    assert!(text.contains("comment vertices 20 to 39: sheet\n"));
    assert_eq!(file.len(), header + 40 * 36 + 48 * 13);
    let vertices = file[header..].chunks_exact(36).take(20);
    for vertex in vertices {
        let double = |i: usize| f64::from_le_bytes(vertex[8 * i..8 * i + 8].try_into().unwrap());
        let single =
            |i: usize| f32::from_le_bytes(vertex[24 + 4 * i..28 + 4 * i].try_into().unwrap());
        let (x, y) = (double(0), double(1));
        assert!((x.hypot(y) - 2.0).abs() < 1e-14);
        assert!((f64::from(single(0)) - x / 2.0).abs() < 1e-6);
        assert!(single(2).abs() < 1e-6);
    }
    let faces = file[header + 40 * 36..].chunks_exact(13);
    for (index, face) in faces.enumerate() {
        assert_eq!(face[0], 3);
        let corner = |i: usize| i32::from_le_bytes(face[1 + 4 * i..5 + 4 * i].try_into().unwrap());
        let range = if index < 24 { 0..20 } else { 20..40 };
        assert!((0..3).all(|i| range.contains(&corner(i))));
    }
}

#[test]
fn polylines_of_dxf_are_on_layers() {
    let text = text("mixed", Format::Dxf, &mixed(), samples(5, 4));
    let groups = groups(&text);
    let after = |code: u32, value: &str, wanted: u32| -> Vec<&str> {
        let starts = (0..groups.len()).filter(|&i| groups[i] == (code, value));
        let found = starts.map(|i| groups[i..].iter().find(|it| it.0 == wanted).unwrap().1);
        found.collect()
    };
    let layers = ["H_he_5_7", "H_he_5_7_2", "0", "tube"];
    assert_eq!(after(0, "POLYLINE", 8), layers);
    assert_eq!(
        after(0, "LAYER", 2),
        ["0", "H_he_5_7", "H_he_5_7_2", "tube"]
    );
    assert_eq!(after(0, "VERTEX", 8).len(), 5 + 4 + 5 + 20);
}

#[test]
fn tables_are_read_back_as_parts() {
    let parts = [part("a", wave()), part("b", ring())];
    let file = file("curves", Format::Csv, &parts, samples(7, 1));
    let text = std::str::from_utf8(&file).unwrap();
    assert!(text.starts_with("t,x,y\n# a\n0.0,0.0,0.0\n"), "{text}");
    assert!(text.contains("\n\n# b\n"));
    let hints = Hints::default();
    let read = read_parts(&file, &hints).unwrap();
    assert_eq!(read.len(), 2);
    for (read, part) in read.iter().zip(&parts) {
        let nurbs = &part.nurbs;
        let last = read.points.len() - 1;
        for (index, t) in [(0, 0.0), (1, 1.0 / 6.0), (last, last as f64 / 6.0)] {
            let found: Vec<f64> = read.points.point(index).collect();
            let expected = point(nurbs, t);
            let [x, y] = [found[found.len() - 2], found[found.len() - 1]];
            assert!(
                is_near([x, y, 0.0], expected, 1e-14),
                "{found:?} {expected:?}"
            );
        }
    }
    let mut four = wave();
    let lanes = (0..4).map(|c| vec![f64::from(c), 1.0, 2.0, 3.0, 4.0]);
    four.points = Points::from_lanes(lanes);
    let text = self::text("four", Format::Csv, &[part("4", four)], samples(3, 1));
    assert!(
        text.starts_with("t,x1,x2,x3,x4\n0.0,0.0,1.0,2.0,3.0\n"),
        "{text}"
    );
    assert!(text.ends_with("\n1.0,4.0,4.0,4.0,4.0\n"), "{text}");
}

#[test]
fn geojson_has_lines_as_they_are() {
    let text = text("plane", Format::GeoJson, &curves(), samples(5, 1));
    let json: Value = serde_json::from_str(&text).unwrap();
    let features = json["features"].as_array().unwrap();
    assert_eq!(features.len(), 3);
    assert_eq!(features[0]["properties"]["name"], "Höhe 5/7");
    assert_eq!(features[2]["properties"]["name"], Value::Null);
    for (feature, part) in features.iter().zip(&curves()) {
        let line = feature["geometry"]["coordinates"].as_array().unwrap();
        assert_eq!(feature["geometry"]["type"], "LineString");
        assert_eq!(line.len(), 5);
        assert_eq!(part.nurbs.u.closed, line[0] == line[4]);
        assert_eq!(
            line[0].as_array().unwrap().len(),
            part.nurbs.points.dimension()
        );
        let first = point(&part.nurbs, part.nurbs.u.domain().0);
        assert_eq!(line[0][0].as_f64(), Some(first[0]));
        assert_eq!(line[0][1].as_f64(), Some(first[1]));
    }
}

/// Degrees go back to metres.
#[test]
fn maps_have_degrees() {
    let options = Options {
        origin: Some(ORIGIN),
        ..samples(5, 1)
    };
    let json = text("map", Format::GeoJson, &curves(), options);
    let json: Value = serde_json::from_str(&json).unwrap();
    let gpx = text("map", Format::Gpx, &curves(), options);
    assert_eq!(gpx.matches("<trk><name>").count(), 3);
    assert!(gpx.contains("<trk><name>Höhe 5/7</name><trkseg>\n"));
    assert_eq!(gpx.matches("<ele>1.5</ele>").count(), 5);
    let plane = Plane::new(ORIGIN.longitude, ORIGIN.latitude);
    let mut tracks = gpx.lines().filter(|line| line.starts_with("<trkpt"));
    for (feature, part) in json["features"].as_array().unwrap().iter().zip(&curves()) {
        for (index, place) in feature["geometry"]["coordinates"]
            .as_array()
            .unwrap()
            .iter()
            .enumerate()
        {
            let [longitude, latitude] = [0, 1].map(|c| place[c].as_f64().unwrap());
            let [x, y] = plane.metres(longitude, latitude);
            let sites = part.nurbs.u.sites(4);
            let [east, north, _] = part.nurbs.evaluate(&sites[index..=index], &[])[0].point;
            assert!((x - east).abs() < 2e-4 && (y - north).abs() < 2e-4);
            let track = tracks.next().unwrap();
            let expected = format!("<trkpt lat=\"{latitude}\" lon=\"{longitude}\">");
            assert!(track.starts_with(&expected), "{track}");
        }
    }
}

/// The arc is a circle, so that equal distances are equal angles, in all formats.
#[test]
fn samples_are_equally_far_apart() {
    let parts = [part("arc", arc())];
    let by_length = Options {
        by_length: true,
        ..samples(11, 1)
    };
    // 7.85 long: sixteen steps.
    let spaced = Options {
        spacing: Some(0.5),
        ..Options::default()
    };
    for (options, count) in [(by_length, 11), (spaced, 17)] {
        let csv = text("spaced", Format::Csv, &parts, options);
        let rows: Vec<Vec<f64>> = csv
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows.len(), count);
        assert_eq!(rows[0], [0.0, 5.0, 0.0, 1.5]);
        assert_eq!(rows[count - 1][0], 1.0);
        for (i, row) in rows.iter().enumerate() {
            let angle = row[2].atan2(row[1]) / std::f64::consts::FRAC_PI_2;
            assert!((angle - i as f64 / (count - 1) as f64).abs() < 1e-12);
        }
        let json = text("spaced", Format::GeoJson, &parts, options);
        let json: Value = serde_json::from_str(&json).unwrap();
        let line = &json["features"][0]["geometry"]["coordinates"];
        assert_eq!(line.as_array().unwrap().len(), count);
        assert_eq!(line[3][1].as_f64(), Some(rows[3][2]));
        let dxf = text("spaced", Format::Dxf, &parts, options);
        assert_eq!(dxf.matches("VERTEX").count(), count);
    }
}
