use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

fn parts(body: &str, hints: &Hints) -> Result<Vec<Imported>, FileErrors> {
    let text = format!(
        "<?xml version=\"1.0\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><name>all</name>\n{body}</Document></kml>"
    );
    read_parts(text.as_bytes(), hints)
}

fn placemark(name: &str, inner: &str) -> String {
    format!("<Placemark><name>{name}</name>{inner}</Placemark>\n")
}

#[test]
fn lines_and_rings_are_parts() {
    let line = "<LineString><tessellate>1</tessellate><coordinates>\n 11.5,48,500 11.501,48,510\n11.502,48.001,520 </coordinates></LineString>";
    let ring = "<Polygon><outerBoundaryIs><LinearRing><coordinates>11.5,48,0 11.501,48,0 11.501,48.001,0 11.5,48,0</coordinates></LinearRing></outerBoundaryIs></Polygon>";
    let both = format!("<MultiGeometry>{line}{ring}</MultiGeometry>");
    let point = "<Point><coordinates>11.5,48</coordinates></Point>";
    let body = placemark("way &amp; area", &both) + &placemark("place", point);
    let found = parts(&body, &HINTS).unwrap();
    let names: Vec<_> = found.iter().map(|part| part.name.as_deref()).collect();
    assert_eq!(names, [Some("way & area"), Some("way & area 2")]);
    assert_eq!((found[0].closed, found[1].closed), (false, true));
    assert_eq!((found[0].points.len(), found[1].points.len()), (3, 3));
    assert_eq!(found[0].points.lane(2), [500.0, 510.0, 520.0]);
    assert!((found[0].points.lane(0)[1] - 74.6).abs() < 0.1);
    assert!((found[0].points.lane(1)[2] - 111.2).abs() < 0.1);
    assert_eq!(
        found[0].notices,
        [
            "Longitude and latitude are metres east and north of latitude 48, longitude 11.5.",
            "1 points are not read."
        ]
    );
    // Altitudes of 0 count as missing.
    let flat = parts(&placemark("area", ring), &HINTS).unwrap();
    assert_eq!(flat[0].points.dimension(), 2);
    // Points alone are a cloud.
    let points: String = (0..4)
        .map(|i| placemark("p", &point.replace("48", &format!("48.{i}"))))
        .collect();
    let cloud = parts(
        &points,
        &Hints {
            ordered: true,
            ..HINTS
        },
    )
    .unwrap();
    assert_eq!(cloud[0].points.len(), 4);
}

#[test]
fn tracks_have_times() {
    let when = |i: u32| format!("<when>2026-05-01T10:0{i}:00Z</when>");
    let place = |i: u32| format!("<gx:coord>11.5{i} 48.0{i} 50{i}</gx:coord>\n");
    let times: String = (0..4).map(when).collect();
    let places: String = (0..4).map(place).collect();
    let track = |times: &str| placemark("track", &format!("<gx:Track>{times}{places}</gx:Track>"));
    let hints = Hints {
        times: true,
        ..HINTS
    };
    let found = parts(&track(&times), &hints).unwrap().remove(0);
    assert_eq!((found.points.len(), found.points.dimension()), (4, 3));
    let parameters = found.parameters.unwrap();
    assert_eq!(parameters, [0.0, 60.0, 120.0, 180.0]);
    let found = parts(&track(&times), &HINTS).unwrap().remove(0);
    assert!(
        found.notices[1].contains("have times"),
        "{:?}",
        found.notices
    );
    // Times whose number differs from the points are ignored.
    let few: String = (0..3).map(when).collect();
    let found = parts(&track(&few), &HINTS).unwrap().remove(0);
    assert_eq!((found.notices.len(), found.points.len()), (1, 4));
}

#[test]
fn errors_name_their_lines() {
    let line = |text: &str| {
        placemark(
            "a",
            &format!("\n<LineString><coordinates>{text}</coordinates></LineString>"),
        )
    };
    for (body, detail) in [
        (line("11,48 11"), "line 4: \"11\" is no longitude"),
        (line("11,48 11,b"), "line 4: \"11,b\" is no longitude"),
        (line("11,48 11,inf"), "line 4: \"11,inf\" is no longitude"),
        (
            line("11,48 11,48,1,2"),
            "line 4: \"11,48,1,2\" is no longitude",
        ),
        (
            line("11,48 48,98"),
            "line 4: latitude is 98, and not from -90 to 90",
        ),
        (line("11, 48"), "line 4: \"11,\" is no longitude"),
        (line(""), "there are no points in the file"),
        (line("</b>"), "line 4: this is no XML"),
        (
            "<gx:Track><gx:coord>11</gx:coord></gx:Track>".to_owned(),
            "line 3: \"11\" is no longitude",
        ),
    ] {
        let error = parts(&body, &HINTS).unwrap_err().to_string();
        assert!(error.starts_with(detail), "{error}");
    }
    let many = line(&"11,48 ".repeat(HINTS.most + 1));
    let error = parts(&many, &HINTS).unwrap_err().to_string();
    assert!(error.contains("the limit"), "{error}");
}
