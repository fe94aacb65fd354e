use crate::import::tests::HINTS;
use crate::import::{Hints, Imported, Kind, read as read_file};
use piad_fit::data::Grid;

fn read(text: &str) -> Result<Imported, String> {
    read_file(text.as_bytes(), &HINTS).map_err(|errors| errors.to_string())
}

const HEAD: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 50\ncellsize 10\nNODATA_value -1\n";

#[test]
fn heights_are_rows_of_points() {
    let rows = "1 2 3\n4 -1 6.5\n";
    let plain = read(&format!("{HEAD}{rows}")).unwrap();
    assert_eq!(
        plain.grid,
        Some(Grid {
            rows: 2,
            columns: 3
        })
    );
    assert_eq!(
        plain.points.lane(0),
        [105.0, 115.0, 125.0, 105.0, 115.0, 125.0]
    );
    assert_eq!(plain.points.lane(1), [65.0, 65.0, 65.0, 55.0, 55.0, 55.0]);
    assert_eq!(plain.points.lane(2), [1.0, 2.0, 3.0, 4.0, 0.0, 6.5]);
    assert_eq!(
        (&plain.missing[..], &plain.lines[..]),
        (&[4][..], &[7, 7, 7, 8, 8, 8][..])
    );
    let notice =
        "The file is a grid of 2 rows of 3 heights, 10 apart (ESRI); 1 of them is missing.";
    assert_eq!(plain.notices, [notice]);
    for other in [
        "NROWS 2\nNCOLS 3\nDX 10\nDY 10\nyllcenter 55\nxllcenter 105\nnodata -1\n1 2 3 4 -1.0 6.5",
        "ncols 3\r\nnrows 2\r\nxllcorner 100,0\r\nyllcorner 50,0\r\ncellsize 10\r\nnodata_value nan\r\n1\r\n\r\n2 3 4 nan\r\n6,5\r\n",
        "ncols 3 nrows 2 cellsize 1e1 xllcorner 100 yllcorner 50\r1 2 3\r4 -9999 6.5\r",
        "\n\nncols\t3\nnrows\t2\nxllcorner\t100\nyllcorner\t50\ncellsize\t10\nNODATA_value\t-3.4028234663852886e+38\n1 2 3 4 -3.40282e+38 6.5\n",
    ] {
        let file = read(other).unwrap();
        assert_eq!(
            (&file.points, &file.missing),
            (&plain.points, &plain.missing),
            "{other:?}"
        );
    }
    // East times south points down, so that north to south and then east is right.
    let point = |i: usize| plain.points.point(i).collect::<Vec<f64>>();
    let (start, down, right) = (point(0), point(3), point(1));
    let [u, v] = [down, right].map(|it| [it[0] - start[0], it[1] - start[1]]);
    assert!(u[0] * v[1] - u[1] * v[0] > 0.0);
    let oblong = HEAD.replace("cellsize 10", "dx 10\ndy 2.5");
    let oblong = read(&format!("{oblong}1 2 3 4 5 6")).unwrap();
    assert_eq!(oblong.points.lane(1)[2..4], [53.75, 51.25]);
    assert!(oblong.notices[0].contains("10 and 2.5 apart (ESRI); none of them is missing"));
}

#[test]
fn errors_name_their_lines() {
    let good = format!("{HEAD}1 2 3\n4 -1 6.5\n");
    for (from, to, expected) in [
        (
            "ncols 3\n",
            "",
            "the header of the grid has no ncols (ESRI)",
        ),
        (
            "cellsize 10\n",
            "",
            "the header of the grid has no cellsize (ESRI)",
        ),
        (
            "xllcorner 100\n",
            "",
            "the header of the grid has no xllcorner (ESRI)",
        ),
        (
            "ncols 3",
            "ncols 2.5",
            "line 1: ncols is 2.5, and not a whole number above 0",
        ),
        (
            "nrows 2",
            "nrows nan",
            "line 2: nrows is NaN, and not a whole number above 0",
        ),
        (
            "nrows 2",
            "nrows 1000000000000000000",
            "there are more than 100 points, the limit",
        ),
        (
            "nrows 2",
            "nrows",
            "line 3: nrows: \"xllcorner\" is no number",
        ),
        (
            "cellsize 10",
            "cellsize -10",
            "line 5: cellsize is -10, and not a number above 0",
        ),
        (
            "xllcorner 100",
            "xllcorner inf",
            "line 3: xllcorner is inf, and not a number",
        ),
        (
            "xllcorner 100",
            "left 100",
            "line 3: \"left\" is not a header line of a grid (ESRI)",
        ),
        ("4 -1 6.5", "4 oops 6.5", "line 8: \"oops\" is no height"),
        (
            "4 -1 6.5",
            "4 1e999 6.5",
            "line 8: \"1e999\" is out of range",
        ),
        (
            "4 -1 6.5",
            "4 -1",
            "line 8: 2 heights here, and the grid has rows of 3 (ESRI)",
        ),
        (
            "4 -1 6.5",
            "4 -1 6.5 7",
            "line 8: 4 heights here, and the grid has rows of 3 (ESRI)",
        ),
        (
            "4 -1 6.5",
            "",
            "line 7: the file ends after 3 heights, and the grid has 2 rows of 3 (ESRI)",
        ),
        (
            "4 -1 6.5",
            "4 -1 6.5\n7",
            "line 9: here is more than the 2 rows of 3 heights of the grid (ESRI)",
        ),
        (
            "1 2 3\n4 -1 6.5\n",
            "",
            "the file ends after 0 heights, and the grid has 2 rows of 3 (ESRI)",
        ),
        (
            "1 2 3\n4 -1 6.5\n",
            "-1 -1 -1 -1 -1 -1",
            "all heights of the grid are missing",
        ),
    ] {
        assert_eq!(
            read(&good.replacen(from, to, 1)).unwrap_err(),
            expected,
            "{to}"
        );
    }
    let curve = Hints {
        kind: Some(Kind::Curve),
        ..HINTS
    };
    let curve = read_file(good.as_bytes(), &curve).unwrap_err();
    assert!(curve.to_string().contains("rows of a surface"));
    // A table that has such names.
    assert_eq!(read("dx dy\n1 2\n3 4\n").unwrap().points.len(), 2);
}
