//! Tables for people: names, texts, times, gaps.

use super::Columns;
use crate::import::tests::HINTS;
use crate::import::{FileError, Hints, Imported, Kind, read};
use piad_fit::data::Grid;
use proptest::prelude::*;

fn hints(columns: &str) -> Hints {
    Hints {
        columns: Some(Columns::of_text(columns).unwrap()),
        ..HINTS
    }
}

fn imported(text: &str) -> Imported {
    read(text.as_bytes(), &HINTS).unwrap()
}

fn chosen(text: &str, columns: &str) -> Imported {
    read(text.as_bytes(), &hints(columns)).unwrap()
}

fn errors(text: &str, hints: &Hints) -> Vec<FileError> {
    read(text.as_bytes(), hints).unwrap_err().0
}

/// The rows of a table, with # for 0, 1, 2, …
fn rows(count: usize, row: &str) -> String {
    let row = |i: usize| format!("{}\n", row.replace('#', &i.to_string()));
    (0..count).map(row).collect()
}

fn first(imported: &Imported) -> Vec<f64> {
    imported.points.point(0).collect()
}

#[test]
fn names_select_coordinate_columns() {
    for (head, expected) in [
        ("x,y,q", vec![1.0, 2.0]),
        ("X (m),Y (m),Z [m]", vec![1.0, 2.0, 3.0]),
        ("pos_z,pos_x,pos_y", vec![2.0, 3.0, 1.0]),
        ("x_mm,y_mm,z_mm", vec![1.0, 2.0, 3.0]),
        ("x[mm],y[mm],n", vec![1.0, 2.0]),
        ("PosX,PosY,speed", vec![1.0, 2.0]),
        ("position.x,position.y,velocity.x", vec![1.0, 2.0]),
        ("N,E,elev_m", vec![2.0, 1.0, 3.0]),
        ("Northing,Height,Easting", vec![3.0, 1.0, 2.0]),
        ("u,v,altitude", vec![1.0, 2.0, 3.0]),
        ("u,v,w", vec![1.0, 2.0, 3.0]),
        ("x,y,w", vec![1.0, 2.0]),
        ("x,h,code", vec![1.0, 2.0]),
        ("t,x,y", vec![2.0, 3.0]),
        ("t,a,b", vec![2.0, 3.0]),
        ("id,a,b", vec![2.0, 3.0]),
        (",a,b", vec![1.0, 2.0, 3.0]),
        ("a,b,c", vec![1.0, 2.0, 3.0]),
        ("vx,vy,vz", vec![1.0, 2.0, 3.0]),
        ("\"x\" ; \"y\" ; \"q\"", vec![1.0, 2.0]),
    ] {
        let separator = if head.contains(';') { ";" } else { "," };
        let row = "1,2,3\n5,7,4\n".replace(',', separator);
        let read = imported(&format!("{head}\n{row}"));
        assert_eq!(first(&read), expected, "{head}");
        assert_eq!(read.name, None, "{head}");
        assert_eq!(read.notices.is_empty(), expected.len() == 3, "{head}");
    }
    // Two columns are taken whatever their names.
    for head in ["t,value", "t,x", "id,value", "x,f", "w,h", "N,depth", "a,b"] {
        let read = imported(&format!("{head}\n1,2\n5,7\n"));
        assert_eq!((first(&read), read.notices), (vec![1.0, 2.0], vec![]));
    }
}

#[test]
fn units_may_stand_below_names() {
    for text in [
        "N,E\n[m],[m]\n2,1\n5,4\n",
        "N;E\n(m);(m)\n2;1\n5;4\n",
        "N\tE\nm\tm\n2\t1\n5\t4\n",
    ] {
        let read = imported(text);
        assert_eq!((first(&read), read.name), (vec![1.0, 2.0], None), "{text}");
    }
}

#[test]
fn one_notice_lists_skipped_columns() {
    for (text, notice) in [
        (
            "FID,X (m),Y (m)\n1,5,6\n2,7,9\n",
            "Columns 2 (X (m)) and 3 (Y (m)) are the coordinates; column 1 (FID) is not read.",
        ),
        (
            "P,N,E,Z,D\n7,1,2,3,\"kerb, low\"\n8,2,4,5,\"EP\"\n",
            "Columns 3 (E), 2 (N) and 4 (Z) are the coordinates; column 5 (D) is text, which is not read, column 1 (P) is not read.",
        ),
        (
            "id;easting;northing;elev\np0;0,5;1,5;2\np1;1;2,5;3\n",
            "Columns 2 (easting), 3 (northing) and 4 (elev) are the coordinates; column 1 (id) is text, which is not read.",
        ),
        (
            "t,x,y,w\n0,1,2,1\n1,2,5,1\n",
            "Columns 2 (x) and 3 (y) are the coordinates; column 1 (t) has times, which are not used, column 4 (w) is not read.",
        ),
        (
            "1 2 EP\n3 5 EP\n",
            "Columns 1 and 2 are the coordinates; column 3 is text, which is not read.",
        ),
    ] {
        assert_eq!(imported(text).notices, [notice]);
    }
}

#[test]
fn separators_in_quotes_separate_nothing() {
    let quoted = imported("x,y,what\n1,2,\"kerb, low #2\"\n3,5,\"a \"\"b\"\", c\"\n6,7,\n");
    assert_eq!(quoted.points.to_flat(), [1.0, 2.0, 3.0, 5.0, 6.0, 7.0]);
    let blanks = imported("\"a b\" 1 2\n\"c d\" 3 5\nkerb 6 7\n");
    assert_eq!(blanks.points.to_flat(), quoted.points.to_flat());
    let tabs = imported("x\ty\twhat\n1\t2\tkerb low\n3\t5\t\n6\t7\ta b c\n");
    assert_eq!(tabs.points.to_flat(), quoted.points.to_flat());
}

#[test]
fn times_are_parameters_where_they_are_chosen_or_columns_are_numbered() {
    let joints = "time (ms),j1 (rad),j2 (rad),j3,j4\n500,1,2,3,4\n750,2,4,6,8\n1500,0,1,0,1\n";
    let read_joints = imported(joints);
    assert_eq!(read_joints.points.dimension(), 4);
    assert_eq!(read_joints.parameters, Some(vec![0.0, 0.25, 1.0]));
    assert_eq!(
        read_joints.notices[0],
        "Columns 2 (j1 (rad)) to 5 (j4) are the coordinates; column 1 (time (ms)) has the times."
    );
    // Not on request alone.
    let track = "t,x,y\n2026-01-31T12:00:00Z,0,1\n2026-01-31T13:00:01.5+01:00,2,3\n2026-01-31 12:00:04,5,3\n";
    let unused = imported(track);
    assert_eq!(unused.parameters, None);
    assert!(unused.notices[0].contains("column 1 (t) has times, which are not used"));
    let times = Hints {
        times: true,
        ..HINTS
    };
    let used = read(track.as_bytes(), &times).unwrap();
    assert_eq!(used.parameters, Some(vec![0.0, 1.5, 4.0]));
    assert!(used.notices[0].contains("column 1 (t) has the times"));
    assert_eq!(chosen(track, "x,y,t").parameters, used.parameters);
    // Over one column of values they are coordinates, but if they are wanted.
    let values = "time,value\n2026-01-31,3\n2026-02-01,4\n";
    assert_eq!(imported(values).points.to_flat(), [0.0, 3.0, 86400.0, 4.0]);
    let used = read(values.as_bytes(), &times).unwrap();
    assert_eq!(used.points.to_flat(), [3.0, 4.0]);
    assert_eq!(used.parameters, Some(vec![0.0, 86400.0]));
    // With two groups of numbers the names do not decide.
    let both = imported("time,q1,q2,dq1,dq2\n0,1,2,3,4\n1,2,4,6,8\n");
    assert_eq!((first(&both), both.parameters), (vec![1.0, 2.0, 3.0], None));
    for (text, line, detail) in [
        ("t,q1,q2\n0,1,2\n0,2,3\n", 3, "the time of this point"),
        ("t,q1,q2\n0,1,2\nnoon,2,3\n", 3, "column 1: \"noon\" is no"),
    ] {
        let wrong = errors(text, &HINTS);
        assert_eq!(wrong[0].line, Some(line));
        assert!(wrong[0].detail.starts_with(detail), "{wrong:?}");
    }
}

#[test]
fn columns_are_chosen_by_numbers_and_names() {
    let text = "t,id,q1,q2,q3,note\n0,7,1,2,3,a\n2,8,2,4,6,b\n";
    for (columns, expected, times) in [
        ("3,4", vec![1.0, 2.0], false),
        ("3:5", vec![1.0, 2.0, 3.0], false),
        ("Q3, q1", vec![3.0, 1.0], false),
        ("t,q1:q3", vec![1.0, 2.0, 3.0], true),
        ("x=q2,y=3,t=1", vec![2.0, 1.0], true),
        ("time=t,q2", vec![2.0], true),
        ("1,2", vec![0.0, 7.0], false),
        ("x=3,y=4,z=2", vec![1.0, 2.0, 7.0], false),
    ] {
        let read = chosen(text, columns);
        assert_eq!(first(&read), expected, "{columns}");
        let parameters = times.then(|| vec![0.0, 2.0]);
        assert_eq!(read.parameters, parameters, "{columns}");
        assert!(read.notices[0].contains("6 (note) is text"), "{columns}");
    }
    // Names without units, with a colon, and no names.
    let read = chosen("A (mm),P:0,P:1\n1,2,3\n4,5,7\n", "p:1,a");
    assert_eq!(first(&read), [3.0, 1.0]);
    assert_eq!(first(&chosen("1 kerb 2 3\n4 low 5 7\n", "4,1")), [3.0, 1.0]);
    let cloud = chosen("1 2 3 255\n4 5 7 0\n", "1:3").notices;
    assert_eq!(
        cloud,
        ["Columns 1, 2, 3 of 4 are the coordinates; the others are not read."]
    );
}

#[test]
fn wrong_choices_are_refused() {
    for (columns, detail) in [
        ("", "an entry of the columns is empty"),
        ("1,,2", "an entry of the columns is empty"),
        (
            "q=1,r=2",
            "unknown role \"q\" of a column; expected one of x, y, z and t",
        ),
        ("x=1,y=", "a column is missing"),
        ("1:", "a column is missing"),
        ("y=2", "there is a column for y and none for x"),
        ("x=1,z=2", "there is a column for z and none for y"),
        ("x=1,x=2,y=3", "two columns are given for x"),
        ("t,time,a", "two columns are given for the times"),
        ("x=1,y=1", "column 1 is chosen twice"),
        ("a,A", "column a is chosen twice"),
        ("2,1:3", "column 2 is chosen twice"),
        ("x=1,2", "some columns have a role"),
        ("t", "no column is one of coordinates"),
        ("t=1", "no column is one of coordinates"),
        (
            "1:17",
            "17 columns are coordinates, and points have at most 16",
        ),
        ("3:1", "columns 3:1 are not a range"),
        ("x=1:2", "\"1:2\" are several columns"),
        ("0,1", "column \"0\" does not exist"),
        (
            "1,99999999999999999999",
            "column \"99999999999999999999\" does not exist",
        ),
        ("x=1,y=2,w=3", "weights of points are not read"),
        ("x,y,weight", "weights of points are not read"),
    ] {
        let wrong = Columns::of_text(columns).unwrap_err();
        assert!(wrong.starts_with(detail), "{columns}: {wrong}");
    }
    let named = "by hand\n\nx,y,code\n1,2,a\n3,5,b\n";
    let bare = "1,2,a\n3,5,b\n";
    for (text, columns, line, detail) in [
        (
            named,
            "x,speed",
            3,
            "no column is called \"speed\": the file has 3 columns, \"x\", \"y\", \"code\"",
        ),
        (
            named,
            "1,4",
            3,
            "there is no column 4: the file has 3 columns, \"x\"",
        ),
        (named, "x,1", 3, "column 1 is chosen twice"),
        (named, "y:x", 3, "columns \"y:x\" are not a range"),
        (named, "y,code", 4, "column 3: \"a\" is no number"),
        (
            named,
            "x,y,t=code",
            3,
            "column 3 has no times: a number, or ISO",
        ),
        (
            bare,
            "x,y",
            1,
            "no column is called \"x\": the file has 3 columns without names",
        ),
        (
            bare,
            "1,4",
            1,
            "there is no column 4: the file has 3 columns without names",
        ),
        (
            "1 2\n3 4\n",
            "1,3",
            1,
            "there is no column 3: the file has 2 columns",
        ),
    ] {
        let wrong = errors(text, &hints(columns));
        assert_eq!(wrong[0].line, Some(line), "{columns}: {wrong:?}");
        assert!(wrong[0].detail.starts_with(detail), "{columns}: {wrong:?}");
    }
    let array = errors("[[0, 0], [1, 2]]", &hints("1,2"));
    assert!(
        array[0]
            .detail
            .starts_with("columns can be chosen only in a table")
    );
}

#[test]
fn a_first_column_that_counts_is_left_out() {
    let counted = imported(&rows(9, "# 1.# -# "));
    assert_eq!(first(&counted), [1.0, 0.0]);
    assert_eq!(
        counted.notices[0],
        "Columns 2 and 3 are the coordinates; column 1 counts the points and is not read."
    );
    assert_eq!(first(&imported("1 5 6 7\n2 5 7 9\n")), [5.0, 6.0, 7.0]);
    // Functions, few points, other numbers, and a counter that does not continue.
    assert_eq!(imported(&rows(9, "# 1.#")).points.dimension(), 2);
    for text in [
        "1 5 6\n2 5 7\n".to_owned(),
        rows(9, "0.# 1.# -#"),
        rows(9, "# 1.# -#") + "10 1 2\n",
        rows(9, "# 1.# -#") + "3 1 2\n",
    ] {
        let read = imported(&text);
        assert_eq!((read.points.dimension(), read.notices.len()), (3, 0));
    }
    let cut = imported(&(rows(9, "# 1 2 3") + "8 1 2 4\n"));
    assert_eq!(first(&cut), [0.0, 1.0, 2.0]);
    assert_eq!(
        cut.notices[0],
        "Columns 1, 2, 3 of 4 are the coordinates; the others are not read."
    );
    // Points of a surface have three coordinates.
    let surface = Hints {
        kind: Some(Kind::Surface),
        ..HINTS
    };
    let read = read(rows(9, "# 1.# -#").as_bytes(), &surface).unwrap();
    assert_eq!(read.points.dimension(), 3);
}

#[test]
fn gaps_are_left_out_of_curves() {
    for gap in ["nan", "NaN", "-nan", "", "NULL", "null", "NA", "n/a"] {
        let text = format!("x,y\n0,1\n{gap},2\n3,4\n5,{gap}\n6,{gap}\n7,8\n");
        let read = imported(&text);
        assert_eq!(read.points.to_flat(), [0.0, 1.0, 3.0, 4.0, 7.0, 8.0]);
        assert_eq!(read.lines, [2, 4, 7]);
        assert_eq!(
            read.notices,
            ["3 points have no coordinates and are left out, the first of them in line 3."]
        );
    }
    for text in [
        "x,y\nnan,nan\n0,1\n3,4\n",
        "nan,2\n0,1\n3,4\n",
        "x\ty\n\t2\n0\t1\n3\t4\n",
        "x;y\n;\n0;1\n3;4\n",
    ] {
        let read = imported(text);
        assert_eq!(read.points.to_flat(), [0.0, 1.0, 3.0, 4.0], "{text:?}");
        assert!(read.notices[0].ends_with("has no coordinates and is left out."));
    }
    // A part without other contents is left out.
    let parts = "x,y\n0,1\n3,4\n\nnan,nan\n\n1,1\n2,3\n";
    let parts = crate::import::read_parts(parts.as_bytes(), &HINTS).unwrap();
    assert_eq!(parts.len(), 2);
    for (text, line, detail) in [
        ("x,y\n0,1\n1,nan\n", None, "there is one point"),
        ("x,y\n1,2\n0,inf\n3,4\n", Some(3), "column 2: \"inf\" is no"),
        ("x,y\n1,2\n0,1e999\n", Some(3), "column 2: \"1e999\" is no"),
        ("x,y\n1,2\n0,-\n3,4\n", Some(3), "column 2: \"-\" is no"),
        (
            "x,y\n1,oops\n2,3\n4,5\n",
            Some(2),
            "column 2: \"oops\" is no",
        ),
    ] {
        let wrong = errors(text, &HINTS);
        assert_eq!(wrong[0].line, line, "{wrong:?}");
        assert!(wrong[0].detail.starts_with(detail), "{wrong:?}");
    }
}

#[test]
fn gaps_of_grids_are_missing() {
    let lattice = "x,y,z\n0,0,1\n1,0,nan\n2,0,3\n0,1,4\n1,1,5\n2,1,\n";
    let read_lattice = imported(lattice);
    let size = Grid {
        rows: 2,
        columns: 3,
    };
    assert_eq!(
        (read_lattice.grid, &read_lattice.missing[..]),
        (Some(size), &[1, 5][..])
    );
    assert_eq!(read_lattice.points.lane(0), [0.0, 1.0, 2.0, 0.0, 1.0, 2.0]);
    assert_eq!(read_lattice.points.lane(2), [1.0, 0.0, 3.0, 4.0, 5.0, 0.0]);
    assert_eq!(
        read_lattice.notices,
        [
            "The points are 2 rows of 3: x and y form a grid.",
            "2 points are missing in the grid, the first of them in line 3."
        ]
    );
    // In rows with blank lines a point may have nothing.
    let spaced = imported("0 0 1\n1 0 nan\n2 0 3\n\n0 1 4\nnan nan nan\n2.5 1 3\n");
    assert_eq!(
        (spaced.grid, &spaced.missing[..]),
        (Some(size), &[1, 4][..])
    );
    let said = Hints {
        size: Some(size),
        ..HINTS
    };
    let said = read(lattice.replace("2,1,", "2.5,1,").as_bytes(), &said).unwrap();
    assert_eq!(said.missing, [1, 5]);
    // The value of a header, and not without one.
    let heights = lattice
        .replace("nan", "-9999")
        .replace("2,1,", "2,1,-9999.0");
    assert!(imported(&heights).missing.is_empty());
    let headed = imported(&format!("# NODATA_value: -9999\n{heights}"));
    assert_eq!(headed.missing, [1, 5]);
    let curve = Hints {
        kind: Some(Kind::Curve),
        ..HINTS
    };
    let curve = read(lattice.as_bytes(), &curve).unwrap();
    assert_eq!((curve.grid, curve.points.len()), (None, 4));
}

#[test]
fn degrees_become_metres() {
    let track = "lat,lon,ele\n48,11.5,500\n48.001,11.5,510\n48,11.501,520\n";
    let read_track = imported(track);
    let notice = "Longitude and latitude are metres east and north of latitude 48, longitude 11.5.";
    assert_eq!(read_track.notices.last().unwrap(), notice);
    let points = &read_track.points;
    // A degree of latitude is 111,200 m long there, and one of longitude 74,600 m.
    for (lane, point, expected) in [(0, 0, 0.0), (1, 1, 111.2), (0, 2, 74.6), (1, 2, 0.0)] {
        assert!(
            (points.lane(lane)[point] - expected).abs() < 0.1,
            "{points:?}"
        );
    }
    assert_eq!(points.lane(2), [500.0, 510.0, 520.0]);
    let turned = chosen(track, "lat,lon");
    assert_eq!(turned.points.lane(0), points.lane(1));
    // A grid of degrees is one before it is in metres.
    let grid = "lng,lat,height\n10,60,1\n10.5,60,2\n11,60,nan\n10,61,4\n10.5,61,5\n11,61,7\n";
    let grid = imported(grid);
    assert_eq!(
        (grid.grid.map(|grid| grid.columns), grid.missing),
        (Some(3), vec![2])
    );
    let wrong = "longitude,latitude\n10,50\n10,91\n-361,0\n";
    let wrong = errors(wrong, &HINTS);
    assert_eq!(wrong.len(), 2);
    assert_eq!((wrong[0].line, wrong[1].line), (Some(3), Some(4)));
    assert!(wrong[0].detail.starts_with("latitude 91 is not between"));
}

/// Large tables are read by all threads, also with texts, times and gaps: a quote more makes no other difference.
#[test]
fn large_tables_are_the_same_in_pieces() {
    let hints = Hints {
        most: 10_000,
        ordered: true,
        ..HINTS
    };
    let file = |head: &str, row: &str, is_quoted: bool| {
        let row = |i: usize| {
            let gap = if i % 1000 == 7 {
                "nan".to_owned()
            } else {
                (i * i).to_string()
            };
            let quote = if is_quoted && i == 9_000 { "\"" } else { "" };
            let time = format!(
                "2026-01-01T{:02}:{:02}:{:02}Z",
                i / 3600,
                i / 60 % 60,
                i % 60
            );
            let row = row.replace("#t", &time).replace("#g", &gap);
            let row = row.replace('@', &format!("{quote}{i}{quote}"));
            row.replace('#', &i.to_string()) + "\n"
        };
        head.to_owned() + &(0..9_100).map(row).collect::<String>()
    };
    for (head, row) in [
        ("t,x,y,what\n", "#t,@,#g,\"kerb, low\""),
        ("what;x;y\n", "a b; @ ;#g;"),
        ("x\ty\tid\n", "@\t#g\t"),
        ("", "# @ #g"),
        ("t,q1,q2,q3,q4,q5\n", "#,1.#,@,1.#,1.#,#g"),
    ] {
        let [plain, quoted] = [false, true].map(|quoted| file(head, row, quoted));
        let [plain, quoted] = [plain, quoted].map(|text| read(text.as_bytes(), &hints));
        let (plain, quoted) = (plain.unwrap(), quoted.unwrap());
        assert!(plain == quoted, "{head}");
        assert!(
            plain
                .notices
                .iter()
                .any(|it| it.starts_with("10 points have no")),
            "{head}"
        );
    }
}

proptest! {
    /// Any table and any choice of columns give points with finite numbers, or an error.
    #[test]
    fn no_table_breaks_it(
        head in "((x|y|z|t|lat|lon|e|n|id|q1|q2|j1|w|x \\(m\\))[,;\\t]){0,5}\n",
        rows in "((-?[0-9]{1,2}|0\\.5|1e9|nan|NA|a b|\"k, l\"|2026-01-0[1-9]|)[,;\\t ]){0,5}(\n+((-?[0-9]{1,2}|0\\.5|nan||\"k, l\"|2026-01-0[1-9])[,;\\t]){0,5}){0,8}",
        columns in "([xyzt]=)?(t|x|q1|[1-4])(,([xyzt]=)?(y|z|lat|[1-4]|2:3|q1:q2)){0,3}",
        times: bool,
    ) {
        let text = format!("{head}{rows}");
        let chosen = Columns::of_text(&columns).ok();
        for columns in [None, chosen] {
            let hints = Hints { columns, times, ..HINTS };
            let Ok(parts) = crate::import::read_parts(text.as_bytes(), &hints) else {
                continue;
            };
            for part in parts {
                prop_assert_eq!(part.lines.len(), part.points.len());
                let mut numbers = part.points.lanes().iter().flat_map(|lane| lane.iter());
                prop_assert!(numbers.all(|it| it.is_finite()));
                prop_assert!(part.missing.iter().all(|it| *it < part.points.len()));
                if let Some(parameters) = part.parameters {
                    prop_assert_eq!(parameters.len(), part.points.len());
                    prop_assert!(parameters.iter().all(|it| it.is_finite()));
                }
            }
        }
    }
}
