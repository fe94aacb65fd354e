use crate::import::tests::HINTS;
use crate::import::{Hints, Imported, Kind, read as read_file};

fn surface(bytes: &[u8]) -> Result<Imported, String> {
    let kind = Some(Kind::Surface);
    read_file(bytes, &Hints { kind, ..HINTS }).map_err(|errors| errors.to_string())
}

const HEAD: &str = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb x _ z y\nSIZE 4 4 1 2 8\nTYPE F F U I F\nCOUNT 1 1 3 1 1\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ";

const POINTS: [f64; 9] = [1.5, 0.1, -3.0, -2.0, 1e30, 4.0, 0.0, 0.25, 7.0];

fn of(data: &str, body: &[u8]) -> Vec<u8> {
    [format!("{HEAD}{data}\n").as_bytes(), body].concat()
}

/// The bytes of each field of the points, of which the second has no coordinates.
fn fields() -> Vec<[Vec<u8>; 5]> {
    let record = |point: &[f64]| {
        [
            vec![b'\n'; 4],
            (point[0] as f32).to_le_bytes().to_vec(),
            vec![1, 2, 3],
            (point[2] as i16).to_le_bytes().to_vec(),
            point[1].to_le_bytes().to_vec(),
        ]
    };
    let mut records: Vec<_> = POINTS.chunks(3).map(record).collect();
    records.insert(1, record(&[f64::NAN, f64::NAN, 0.0]));
    records
}

/// Compressed data of runs alone.
fn compressed() -> Vec<u8> {
    let records = fields();
    let columns = (0..5).flat_map(|field| records.iter().flat_map(move |it| it[field].clone()));
    let plain: Vec<u8> = columns.collect();
    let mut data = Vec::new();
    for run in plain.chunks(32) {
        data.push(run.len() as u8 - 1);
        data.extend_from_slice(run);
    }
    let sizes = [data.len() as u32, plain.len() as u32].map(u32::to_le_bytes);
    [&sizes.concat(), &data[..]].concat()
}

const TEXT: &str = "9 1.5 0 0 0 -3 0.1\n9 nan 0 0 0 0 nan\n9 -2 0 0 0 4 1e30\n\n9 0 0 0 0 7 .25\n";

#[test]
fn points_are_read_however_they_are_stored() {
    let text = surface(&of("ascii", TEXT.as_bytes())).unwrap();
    assert_eq!(text.points.to_flat(), POINTS);
    assert_eq!(
        (text.lines.as_slice(), text.unordered),
        (&[12, 14, 16][..], true)
    );
    assert_eq!(
        text.notices[..3],
        [
            "The points are the 3 points of a cloud (PCD).",
            "Fields of the points that are not read: \"rgb\".",
            "1 point has no coordinates and is left out."
        ]
    );
    let windows = String::from_utf8(of("ascii", TEXT.as_bytes()))
        .unwrap()
        .replace('\n', "\r\n");
    assert_eq!(surface(windows.as_bytes()).unwrap(), text);
    let binary = fields().concat().concat();
    for (data, body) in [("binary", binary), ("binary_compressed", compressed())] {
        let file = surface(&of(data, &body)).unwrap();
        assert_eq!(file.points, text.points, "{data}");
        assert_eq!(
            (file.lines.is_empty(), &file.notices),
            (true, &text.notices)
        );
    }
}

#[test]
fn errors_name_the_reason() {
    let error = |bytes: &[u8]| surface(bytes).unwrap_err();
    let good = String::from_utf8(of("ascii", TEXT.as_bytes())).unwrap();
    for (from, to, expected) in [
        (
            "9 0 0 0 0 7 .25\n",
            "",
            "the file has 3 points, and says that it has 4 (PCD)",
        ),
        (
            "9 0 0 0 0 7 .25",
            "9 0 0 0 7 .25",
            "line 16: 6 values here, and the fields of a point have 7 (PCD)",
        ),
        (
            "9 0 0 0 0 7 .25",
            "9 0 0 0 0 7 oops",
            "line 16: y: \"oops\" is no number",
        ),
        (
            "POINTS 4",
            "POINTS 5",
            "POINTS of the header is not WIDTH times HEIGHT (PCD)",
        ),
        (
            "POINTS 4",
            "POINTS -4",
            "line 10: \"POINTS -4\" is not a line of a PCD header",
        ),
        (
            "POINTS 4",
            "NUMBER 4",
            "line 10: \"NUMBER 4\" is not a line of a PCD header",
        ),
        (
            "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\n",
            "",
            "the header has no line POINTS (PCD)",
        ),
        (
            "SIZE 4 4",
            "SIZE 4",
            "the lines FIELDS, SIZE, TYPE and COUNT of the header are not of one length (PCD)",
        ),
        (
            "SIZE 4 4",
            "SIZE 4 3",
            "the points have no fields x and y that are numbers (PCD)",
        ),
        (
            "COUNT 1 1 3",
            "COUNT 1 2 2",
            "the points have no fields x and y that are numbers (PCD)",
        ),
        (
            "rgb x",
            "rgb q",
            "the points have no fields x and y that are numbers (PCD)",
        ),
        (
            "DATA ascii",
            "DATA ebcdic",
            "line 11: \"DATA ebcdic\" is not a line of a PCD header",
        ),
        (
            "COUNT 1 1 3 1 1",
            "COUNT 1 1 18446744073709551615 18446744073709551615 1",
            "line 12: 7 values here, and the fields of a point have 18446744073709551615 (PCD)",
        ),
        (
            "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\n",
            "POINTS 1000000000000000000\n",
            "the file has 4 points, and says that it has 1000000000000000000 (PCD)",
        ),
    ] {
        assert_eq!(error(good.replacen(from, to, 1).as_bytes()), expected);
    }
    let head = good.split_once("DATA").unwrap().0;
    assert_eq!(error(head.as_bytes()), "the header has no line DATA (PCD)");
    let few = Hints { most: 2, ..HINTS };
    for (data, body, line) in [
        ("ascii", TEXT.as_bytes().to_vec(), "line 16: "),
        ("binary", fields().concat().concat(), ""),
        ("binary_compressed", compressed(), ""),
    ] {
        let many = read_file(&of(data, &body), &few).unwrap_err();
        assert_eq!(
            many.to_string(),
            format!("{line}there are more than 2 points, the limit")
        );
    }
}

#[test]
fn binary_files_may_be_damaged() {
    let error = |bytes: &[u8]| surface(bytes).unwrap_err();
    let binary = fields().concat().concat();
    let early = of("binary", &binary[..binary.len() - 1]);
    assert_eq!(
        error(&early),
        "the file has 3 points, and says that it has 4 (PCD)"
    );
    let huge =
        String::from_utf8_lossy(&early).replace("COUNT 1 1 3", "COUNT 1 1 9223372036854775807");
    assert_eq!(
        error(huge.replace("SIZE 4 4 1", "SIZE 4 4 8").as_bytes()),
        "the fields of a point are too large (PCD)"
    );
    let body = compressed();
    let changed = |at: usize, value: u8| {
        let mut body = body.clone();
        body[at] = value;
        error(&of("binary_compressed", &body))
    };
    assert_eq!(
        error(&of("binary_compressed", &body[..7])),
        "the file ends within its compressed data (PCD)"
    );
    assert_eq!(
        error(&of("binary_compressed", &body[..40])),
        "the file ends within its compressed data (PCD)"
    );
    assert_eq!(
        changed(3, 255),
        "the file ends within its compressed data (PCD)"
    );
    assert_eq!(
        changed(4, 83),
        "the compressed data have 83 bytes, which are not 4 points (PCD)"
    );
    assert_eq!(changed(0, 20), "the compressed data are damaged (PCD)");
    assert_eq!(changed(8, 255), "the compressed data are damaged (PCD)");
}
