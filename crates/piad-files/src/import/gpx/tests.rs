use proptest::prelude::*;

use crate::import::tests::HINTS;
use crate::import::{FileErrors, Hints, Imported, read_parts};

fn parts(body: &str, hints: &Hints) -> Result<Vec<Imported>, FileErrors> {
    let text = format!("<?xml version=\"1.0\"?>\n<gpx version=\"1.1\">\n{body}</gpx>");
    read_parts(text.as_bytes(), hints)
}

fn point(tag: &str, i: u32, more: &str) -> String {
    let (lat, lon) = (48.0 + f64::from(i) * 1e-4, 11.5 + f64::from(i * i) * 1e-5);
    format!("<{tag} lat=\"{lat}\" lon='{lon}'>{more}</{tag}>\n")
}

fn points(tag: &str, more: impl Fn(u32) -> String) -> String {
    (0..4).map(|i| point(tag, i, &more(i))).collect()
}

fn timed(i: u32) -> String {
    format!(
        "<ele>{}</ele><time>2026-05-01T10:0{i}:00.5+02:00</time>",
        500 + i
    )
}

#[test]
fn segments_and_routes_are_parts() {
    let segment = format!("<trkseg>\n{}</trkseg>", points("trkpt", timed));
    let body = format!(
        "<metadata><name>no</name></metadata><wpt lat='1' lon='1'/>\n<trk><name>A &amp; B</name>{segment}\n<trkseg/>{segment}</trk>\n<rte>{}</rte>",
        points("rtept", timed)
    );
    let parts = parts(&body, &HINTS).unwrap();
    let names = parts.iter().map(|part| part.name.as_deref());
    let names: Vec<_> = names.collect();
    assert_eq!(names, [Some("A & B"), Some("A & B 2"), None]);
    let part = &parts[0];
    assert_eq!((part.points.dimension(), part.points.len()), (3, 4));
    assert_eq!(part.lines, [5, 6, 7, 8]);
    assert_eq!(part.points.lane(2), [500.0, 501.0, 502.0, 503.0]);
    assert!((part.points.lane(1)[1] - 11.12).abs() < 0.01);
    assert!((part.points.lane(0)[1] - 0.746).abs() < 0.001);
    assert_eq!(
        part.notices,
        [
            "Longitude and latitude are metres east and north of latitude 48, longitude 11.5.",
            "1 waypoints are not read.",
            "Part 2 of the file has fewer than 2 different points, and is left out.",
            "The points have times, which are not used; curve.parameters=time uses them.",
        ]
    );
}

#[test]
fn times_are_parameters_on_request() {
    let times = Hints {
        times: true,
        ..HINTS
    };
    let body = |more: fn(u32) -> String| {
        format!(
            "<wpt lat='48' lon='11'/><trk><trkseg>{}</trkseg></trk>",
            points("trkpt", more)
        )
    };
    let part = parts(&body(timed), &times).unwrap().remove(0);
    assert_eq!(part.parameters, Some(vec![0.0, 60.0, 120.0, 180.0]));
    assert!(part.notices.iter().all(|it| !it.contains("not used")));
    // A missing and an invalid one.
    for more in [
        (|i| if i == 2 { String::new() } else { timed(i) }) as fn(u32) -> String,
        |i| timed(i).replace("T10:02", "T30:02"),
    ] {
        let error = parts(&body(more), &times).unwrap_err();
        assert!(error.to_string().contains("no times"), "{error}");
    }
    // Without an offset, as some devices write it.
    let local = |i| format!("<time>2026-05-01T08:00:0{i}</time>");
    let part = parts(&body(local), &times).unwrap().remove(0);
    assert_eq!(part.parameters, Some(vec![0.0, 1.0, 2.0, 3.0]));
}

#[test]
fn elevations_and_waypoints_are_used_if_there_is_nothing_else() {
    let some = |i| match i {
        0 => String::new(),
        _ => timed(i),
    };
    let body = format!("<trk><trkseg>{}</trkseg></trk>", points("trkpt", some));
    let part = parts(&body, &HINTS).unwrap().remove(0);
    assert_eq!(part.points.dimension(), 2);
    let notice = "1 of 4 points have no elevation, which is left out.";
    assert_eq!(part.notices[1], notice);
    let waypoints = points("wpt", |_| String::new());
    let part = parts(&waypoints, &HINTS).unwrap().remove(0);
    assert_eq!((part.points.len(), part.points.dimension()), (4, 2));
}

#[test]
fn errors_name_their_lines() {
    let good = points("trkpt", |_| String::new());
    for (wrong, line, detail) in [
        ("<trkpt lat='1'/>", 8, "this point has no lon"),
        (
            "<trkpt lat='91' lon='0'/>",
            8,
            "lat is \"91\", and not a number from -90 to 90",
        ),
        (
            "<trkpt lat='1,5' lon='0'/>",
            8,
            "lat is \"1,5\", and not a number from -90 to 90",
        ),
        (
            "<trkpt lat='1' lon='nan'/>",
            8,
            "lon is \"nan\", and not a number from -180 to 180",
        ),
    ] {
        let body = format!("<trk><trkseg>\n{good}{wrong}</trkseg></trk>");
        let error = parts(&body, &HINTS).unwrap_err().0.remove(0);
        assert_eq!((error.line, &*error.detail), (Some(line), detail));
    }
    let body = format!("<trk><trkseg>{good}");
    assert!(parts(&body, &HINTS).is_err());
    let few = Hints { most: 6, ..HINTS };
    let body = format!("<trk><trkseg>\n{good}</trkseg><trkseg>\n{good}</trkseg></trk>");
    let error = parts(&body, &few).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 11: there are more than 6 points, the limit"
    );
    assert!(
        parts("", &HINTS)
            .unwrap_err()
            .to_string()
            .contains("no points")
    );
    let cut = read_parts(b"<gpx><trk><trkseg><trkpt lat='1' lon='2'>", &HINTS);
    assert!(cut.unwrap_err().to_string().contains("cut off"));
}

#[test]
fn points_around_the_world_stay_degrees() {
    let far = [(0.0, 0.0), (20.0, 100.0), (0.0, -170.0)];
    let far = far.map(|(lat, lon)| format!("<rtept lat='{lat}' lon='{lon}'/>"));
    let part = parts(&format!("<rte>{}</rte>", far.concat()), &HINTS);
    let part = part.unwrap().remove(0);
    assert_eq!(part.points.lane(0), [0.0, 100.0, -170.0]);
    assert!(part.notices[0].contains("kept as degrees"));
}

#[test]
fn deep_and_wide_files_take_no_more_than_their_size() {
    let deep = format!(
        "<gpx>{}{}</gpx>",
        "<a>".repeat(200_000),
        "</a>".repeat(200_000)
    );
    assert!(read_parts(deep.as_bytes(), &HINTS).is_err());
    let wide: String = (0..200_000)
        .map(|i| format!(" a{i}='' xmlns:b{i}=''"))
        .collect();
    let wide = format!("<gpx><wpt{wide} lat='1' lon='1'/></gpx>");
    assert!(read_parts(wide.as_bytes(), &HINTS).is_err());
    let entities: String = (1..60)
        .map(|i| format!("<!ENTITY a{i} '&a{};&a{};'>", i - 1, i - 1))
        .collect();
    let bomb = format!(
        "<!DOCTYPE gpx [<!ENTITY a0 'aaaaaaaa'>{entities}]><gpx><trk><name>&a59;</name></trk></gpx>"
    );
    assert!(read_parts(bomb.as_bytes(), &HINTS).is_err());
    // In Latin 1: the letter is lost, but not the points.
    let route = points("rtept", |_| String::new());
    let mut latin = b"<gpx><rte><name>\xe4</name>".to_vec();
    latin.extend(route.bytes().chain(*b"</rte></gpx>"));
    assert_eq!(read_parts(&latin, &HINTS).unwrap()[0].points.len(), 4);
}

proptest! {
    #[test]
    fn no_text_panics(body in "(<(/?)(trk|trkseg|trkpt lat='1' lon='[0-9]'|ele|time|name|rte|rtept)/?>|[0-9&;<!\\[\\-]|\n){0,40}") {
        let _ = parts(&body, &HINTS);
    }
}
