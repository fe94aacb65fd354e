//! Writes files of all formats for jobs of all kinds, and checks what can be checked without the
//! software that reads them. `tests/python/export_check.py` reads them with other people's.
//!
//! The files are in `target/tmp/export`, or in the folder that `PIAD_EXPORT_DIR` names: for each
//! case the job, its result as the API gives it, and a file in each format.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    missing_docs,
    unreachable_pub,
    reason = "tests fail by panicking, and have no users"
)]

mod cases;
mod fitting;
mod layout;

use std::path::PathBuf;
use std::sync::Arc;

use fitting::Fit;
use piad_files::export::{self, ExportError, Format};
use serde_json::{Value, json};

fn folder() -> PathBuf {
    let given = std::env::var_os("PIAD_EXPORT_DIR").map(PathBuf::from);
    let folder = given.unwrap_or_else(|| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("export"));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn every_kind_of_fit_is_written_in_every_format() {
    let folder = folder();
    for case in cases::all() {
        let fit = Fit::new(&case.job);
        let path = |end: &str| folder.join(format!("{}.{end}", case.file));
        std::fs::write(path("job.json"), case.job.to_string()).unwrap();
        std::fs::write(path("result.json"), fit.result().to_string()).unwrap();
        for format in Format::ALL {
            let file = export::write(format, &fit.fitted());
            let refused = match (case.file, format) {
                ("bernstein_29", Format::Step | Format::Iges) => Some("up to degree 25"),
                (_, Format::Stl | Format::Ply) if fit.problem.v().is_none() => {
                    Some("a curve has none")
                }
                (_, Format::GeoJson) if fit.problem.v().is_some() => Some("a surface is none"),
                (_, Format::Gpx) => Some("choose an origin"),
                _ => None,
            };
            if let Some(reason) = refused {
                let error = file.unwrap_err().to_string();
                assert!(error.contains(reason), "{error}");
                continue;
            }
            let file = file.unwrap_or_else(|error| panic!("{} {format}: {error}", case.file));
            layout::check(format, &file);
            assert_eq!(export::write(format, &fit.fitted()).unwrap(), file);
            std::fs::write(path(format.extension()), file).unwrap();
        }
    }
}

/// The B-spline of an export, evaluated by its own knots and control points, is the fitted curve.
#[test]
fn the_exported_spline_is_the_fit() {
    for case in cases::all() {
        let fit = Fit::new(&case.job);
        let nurbs = piad_files::export::nurbs::checked(&fit.problem, &fit.control_points).unwrap();
        let worst = fit.largest_difference(&nurbs);
        assert!(worst < 1e-13, "{}: {worst:e}", case.file);
    }
}

#[test]
fn values_of_functions_have_no_place_in_space() {
    let fit = Fit::new(
        &json!({"curve": {"points": [[0.0], [1.0], [0.5], [2.0]], "parameters": "uniform"}}),
    );
    for format in Format::ALL.into_iter().filter(|it| *it != Format::Gpx) {
        let file = export::write(format, &fit.fitted());
        if format == Format::Csv {
            let text = String::from_utf8(file.unwrap()).unwrap();
            assert!(text.starts_with("t,x\n0.0,0.0\n"), "{text}");
        } else {
            let error = file.unwrap_err();
            assert_eq!(error, ExportError::OneCoordinate { format });
            assert!(error.to_string().starts_with(format.name()));
        }
    }
}

#[test]
fn weights_that_are_not_positive_are_refused() {
    let mut fit = Fit::new(
        &cases::all()
            .into_iter()
            .find(|it| it.file == "surface_homogeneous")
            .unwrap()
            .job,
    );
    // Free control point (1, 2); with cubic knots at the data it is (2, 3) of the complete net.
    Arc::make_mut(&mut fit.control_points).lanes_mut()[3][9 + 2] = -0.5;
    // Maps hold no surfaces.
    let others = [Format::Csv, Format::GeoJson, Format::Gpx];
    for format in Format::ALL.into_iter().filter(|it| !others.contains(it)) {
        let error = export::write(format, &fit.fitted()).unwrap_err();
        let ExportError::Weight { place, weight } = error else {
            panic!("{error}");
        };
        assert_eq!((place.row, place.column, weight), (2, Some(3), -0.5));
        assert!(error.to_string().contains("control point [2, 3] is -0.5"));
    }
}

#[test]
fn overflow_is_refused() {
    let mut fit = Fit::new(&cases::all()[0].job);
    Arc::make_mut(&mut fit.control_points).lanes_mut()[1][4] = f64::INFINITY;
    for format in Format::ALL.into_iter().filter(|it| *it != Format::Gpx) {
        let error = export::write(format, &fit.fitted()).unwrap_err();
        let is_said = match error {
            ExportError::NotFinite { coordinate, .. } => coordinate == 1,
            // A curve has no triangles, whatever its numbers are.
            ExportError::NoTriangles { .. } => matches!(format, Format::Stl | Format::Ply),
            _ => false,
        };
        assert!(is_said, "{error}");
    }
}

#[test]
fn meshes_are_single_precision() {
    let points = json!([[0, 0], [1e150, 1e150], [3e150, 0]]);
    let fit = Fit::new(&json!({"curve": {"points": points}}));
    for format in Format::ALL {
        let file = export::write(format, &fit.fitted());
        let refused = matches!(file, Err(ExportError::SinglePrecision { .. }));
        assert_eq!(refused, format == Format::Gltf, "{format}");
    }
}

#[test]
fn samples_have_the_requested_number() {
    let fit = Fit::new(
        &cases::all()
            .into_iter()
            .find(|it| it.file == "peaks")
            .unwrap()
            .job,
    );
    let mut fitted = fit.fitted();
    fitted.options.samples = Some(piad_fit::data::Grid {
        rows: 3,
        columns: 5,
    });
    let csv = String::from_utf8(export::write(Format::Csv, &fitted).unwrap()).unwrap();
    assert_eq!(csv.lines().count(), 1 + 15);
    assert_eq!(csv.lines().next(), Some("u,v,x,y,z"));
    let glb = export::write(Format::Gltf, &fitted).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    assert_eq!(json["accessors"][0]["count"], 15);
    assert_eq!(json["accessors"][2]["count"], 3 * 2 * 2 * 4);
}
