//! Refused input, and the names in the errors.

use super::*;
use crate::export::{ExportError, Origin, Style, Version, check_options, check_shape};

fn error(format: Format, parts: &[Part<'_>], options: Options) -> String {
    write_parts(format, parts, &header(options))
        .unwrap_err()
        .to_string()
}

#[test]
fn parts_that_a_format_cannot_hold_are_named() {
    let parts = mixed();
    let plain = Options::default();
    for (format, expected) in [
        (Format::Stl, "part 1 (\"Höhe 5/7\"): stl files hold"),
        (Format::Ply, "part 1 (\"Höhe 5/7\"): ply files hold"),
        (
            Format::GeoJson,
            "part 4 (\"tube\"): geojson files hold curves",
        ),
        (Format::Svg, "part 4 (\"tube\"): svg paths are curves"),
        (
            Format::Csv,
            "part 3: its columns are t,x,y,z and those of the first part t,x,y:",
        ),
    ] {
        let error = error(format, &parts, plain);
        assert!(error.starts_with(expected), "{error}");
    }
    let one = error(Format::Stl, &parts[..1], plain);
    assert!(one.starts_with("stl files hold"), "{one}");
    let mut bad = [part("a", wave()), part("b", arc())];
    bad[1].nurbs.weights = Some(vec![1.0, -1.0, 1.0]);
    for format in Format::ALL {
        let options = Options {
            origin: Some(Origin {
                longitude: 0.0,
                latitude: 0.0,
            }),
            ..plain
        };
        let error = error(format, &bad, options);
        let triangles = matches!(format, Format::Stl | Format::Ply);
        let expected = if triangles {
            "part 1 (\"a\")"
        } else {
            "part 2 (\"b\"): the weight of control point 1 is -1"
        };
        assert!(error.starts_with(expected), "{error}");
    }
    let none = error(Format::Step, &[], plain);
    assert_eq!(none, "there is no curve or surface to write to a step file");
}

#[test]
fn options_of_other_formats_are_refused() {
    let path = Options {
        style: Style::Path,
        ..Options::default()
    };
    let r2000 = Options {
        version: Version::R2000,
        ..Options::default()
    };
    let samples = Some(piad_fit::data::Grid {
        rows: 5,
        columns: 1,
    });
    assert_eq!(
        check_options(Format::Step, false, &path)
            .unwrap_err()
            .to_string(),
        "step files have no style to choose; svg files have"
    );
    assert_eq!(
        check_options(Format::Svg, false, &r2000)
            .unwrap_err()
            .to_string(),
        "svg files have no version to choose; dxf files have"
    );
    let sampled = Options { samples, ..r2000 };
    let no_samples = check_options(Format::Dxf, false, &sampled);
    assert!(matches!(no_samples, Err(ExportError::NoSamples { .. })));
    assert_eq!(check_options(Format::Dxf, true, &sampled), Ok(()));
}

#[test]
fn maps_need_a_place_on_the_earth() {
    let error = |format, longitude, latitude| {
        let options = Options {
            origin: Some(Origin {
                longitude,
                latitude,
            }),
            ..Options::default()
        };
        let far = of_points(line_of(1, &[0.0, 0.0, 1.0, 1.0]), &[[0.0, 0.0], [0.0, 1e7]]);
        error(format, &[part("", far)], options)
    };
    let unplaced = self::error(Format::Gpx, &curves(), Options::default());
    assert!(unplaced.contains("choose an origin"), "{unplaced}");
    assert!(error(Format::Gpx, 8.0, 91.0).contains("latitude 91: they are degrees"));
    assert!(error(Format::GeoJson, f64::NAN, 1.0).contains("longitude NaN"));
    assert!(error(Format::GeoJson, 8.0, 48.0).contains("to the north of the origin, and no place"));
    for format in [Format::GeoJson, Format::Gpx] {
        let surface = check_shape(format, true, 3);
        assert!(matches!(surface, Err(ExportError::NoLine { .. })));
    }
}

#[test]
fn spacings_are_checked() {
    let spaced = |spacing: f64| Options {
        spacing: Some(spacing),
        ..Options::default()
    };
    let refused = |format, surface, options: &Options| {
        let error = check_options(format, surface, options).unwrap_err();
        error.to_string()
    };
    for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(Format::Csv, false, &spaced(spacing));
        assert_eq!(
            error,
            format!("the spacing is {spacing}, and it is a distance between samples, more than 0")
        );
    }
    let surface = refused(Format::Csv, true, &spaced(1.0));
    assert!(surface.contains("are those of curves"), "{surface}");
    let step = refused(Format::Step, false, &spaced(1.0));
    assert!(
        step.starts_with("step files have no spacing to choose"),
        "{step}"
    );
    let both = Options {
        samples: Some(piad_fit::data::Grid {
            rows: 5,
            columns: 1,
        }),
        ..spaced(1.0)
    };
    assert!(refused(Format::Dxf, false, &both).starts_with("spacing and samples"));
    let small = error(Format::Csv, &curves()[..2], spaced(1e-9));
    assert!(
        small.starts_with("part 1 (\"Höhe 5/7\"): the curve is 5.14"),
        "{small}"
    );
    assert!(small.contains("more than 1000000 samples"), "{small}");
}

#[test]
fn splines_have_degrees_of_cad_systems() {
    let knots = [[0.0; 30], [1.0; 30]].concat();
    let places: Vec<[f64; 2]> = (0..30).map(|i| [f64::from(i), 0.0]).collect();
    let steep = [part("steep", of_points(line_of(29, &knots), &places))];
    let r2000 = Options {
        version: Version::R2000,
        ..Options::default()
    };
    assert!(error(Format::Dxf, &steep, r2000).starts_with("the degree is 29"));
    assert!(write_parts(Format::Dxf, &steep, &header(Options::default())).is_ok());
}
