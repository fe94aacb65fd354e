//! Files as users have them.

use proptest::prelude::*;

use super::error::MOST_ERRORS;
use super::*;
use piad_fit::data::Grid;

pub(super) const HINTS: Hints = Hints {
    kind: None,
    size: None,
    closed: None,
    ordered: false,
    columns: None,
    part: None,
    sections: None,
    piece: None,
    times: false,
    most: 100,
};

fn read(text: &str, hints: &Hints) -> Result<Imported, Vec<FileError>> {
    super::read(text.as_bytes(), hints).map_err(|errors| errors.0)
}

fn points(text: &str) -> Vec<Vec<f64>> {
    let imported = read(text, &HINTS).unwrap();
    let lanes = imported.points.lanes();
    let point = |index: usize| lanes.iter().map(|lane| lane[index]).collect();
    (0..imported.points.len()).map(point).collect()
}

fn errors(text: &str) -> Vec<(Option<usize>, String)> {
    let errors = read(text, &HINTS).unwrap_err().into_iter();
    errors.map(|it| (it.line, it.detail)).collect()
}

#[test]
fn tables_are_read_however_they_are_written() {
    let expected = [[1.5, 2.0], [-3.0, 0.25]];
    for text in [
        "1.5,2\n-3,.25\n",
        "1.5, 2\r\n-3, 0.25",
        "1.5;2\n-3;0.25\n",
        "1,5;2\n-3;0,25\n",
        "1,5;2\r-3;0,25\r",
        "1.5 2\n-3 0.25\n",
        "  1.5\t2  \n\n\n-3\t0.25\n\n",
        "1,5\t2,0\n-3,0\t0,25\n",
        "1,5 2,0\n-3,0 0,25\n",
        "1.5D+00 2.0d0\n-3 +25e-2\n",
        "\"1.5\",\"2\"\n\"-3\",\"0.25\"\n",
        "1.5,2,\n-3,0.25,\n",
        "x,y\n1.5,2\n-3,0.25\n",
        "X;Y\n1,5;2\n-3;0,25\n",
        "t value\n1.5 2\n-3 0.25\n",
        "t,value\n1.5,2\n-3,0.25\n",
        "Made by hand\nx,y\n1.5,2\n-3,0.25\n",
        "# made by hand\n% and more\n1.5 2 # the first\n// the next\n-3 0.25\n",
        "y,x\n2,1.5\n0.25,-3\n",
        "u,x,y\n0,1.5,2\n1,-3,0.25\n",
    ] {
        assert_eq!(points(text), expected, "{text:?}");
    }
}

#[test]
fn decimal_commas_need_not_be_in_the_first_line() {
    for text in ["0;0\n1,5;2\n", "0\t0\n1,5\t2\n", "0 0\n1,5 2\n"] {
        assert_eq!(points(text), [[0.0, 0.0], [1.5, 2.0]], "{text:?}");
    }
}

#[test]
fn outlines_that_come_back_are_closed_unless_there_is_a_corner() {
    let outline = "2 0\n3 1\n3 2\n2 3\n1 3\n0 2\n0 1\n1 0\n2 0\n";
    let read_as =
        |closed: Option<bool>, text: &str| read(text, &Hints { closed, ..HINTS }).unwrap();
    for (closed, text, expected, notice) in [
        (None, outline, true, "is closed"),
        (Some(true), outline, true, "is closed"),
        (Some(false), outline, false, "as requested"),
        // Three points of which one is on an edge, a corner, and a trailing edge.
        (None, "2 0\n0 .2\n4 .2\n2 0\n", false, "few points"),
        (None, "0 0\n2 0\n2 2\n0 2\n0 0\n", false, "a corner"),
        (None, "1 0\n.5 .06\n0 0\n.5 -.04\n1 0\n", false, "a corner"),
    ] {
        let imported = read_as(closed, text);
        let count = text.lines().count() - usize::from(expected);
        assert_eq!((imported.closed, imported.points.len()), (expected, count));
        assert_eq!(imported.lines.len(), count);
        assert!(
            imported.notices[0].contains(notice),
            "{:?}",
            imported.notices
        );
    }
    // There and back is no outline, and neither are points that end elsewhere.
    for text in ["0 0\n1 1\n0 0\n", "0 0\n2 0\n2 2\n0 2\n"] {
        let imported = read_as(None, text);
        assert!(!imported.closed && imported.notices.is_empty());
    }
}

#[test]
fn clouds_have_more_than_coordinates() {
    let imported = read("1 2 3 255 0 0\n4 5 6 0 255 0\n", &HINTS).unwrap();
    assert_eq!(imported.points.dimension(), 3);
    assert!(imported.notices[0].contains("Columns 1, 2, 3 of 6"));
    assert_eq!(points("1\n2\n4\n"), [[1.0], [2.0], [4.0]]);
}

#[test]
fn errors_name_their_lines() {
    let wrong = errors("x,y\n1,2\n3,oops\n4\n5,6,7\n\n8,inf\n9,1e999\n");
    let lines: Vec<_> = wrong.iter().map(|it| it.0.unwrap()).collect();
    assert_eq!(lines, [3, 4, 5, 7, 8]);
    assert_eq!(wrong[0].1, "column 2: \"oops\" is no number");
    assert!(wrong[1].1.contains("1 column here, and 2"), "{wrong:?}");
    assert!(wrong[3].1.contains("inf") && wrong[4].1.contains("1e999"));
    assert_eq!(errors("")[0].0, None);
    assert_eq!(
        errors("# nothing\n\n")[0].1,
        "there are no points in the file"
    );
    let lonely = errors("2948");
    assert_eq!(lonely[0].0, None);
    assert!(lonely[0].1.contains("one point"), "{lonely:?}");
    assert!(errors("{\"curve\": 1}")[0].1.contains("JSON"));
    assert!(errors(&"1 ".repeat(2000))[0].1.contains("1000 columns"));
    // Only a limited number of errors, and no more points than the limit.
    assert_eq!(errors(&"1 2\n3\n".repeat(50)).len(), MOST_ERRORS);
    let many = errors(&"1 2\n".repeat(200));
    assert_eq!(many.len(), 1);
    assert_eq!(many[0].0, Some(101));
}

#[test]
fn airfoils_go_around() {
    let selig = "NACA 0012\n1.0 0.001\n0.5 0.05\n0 0\n0.5 -0.05\n1.0 -0.001\n";
    let lednicer = "NACA 0012\n 3. 3.\n\n0 0\n0.5 0.05\n1.0 0.001\n\n0 0\n0.5 -0.05\n1.0 -0.001\n";
    assert_eq!(points(selig), points(lednicer));
    let imported = read(lednicer, &HINTS).unwrap();
    assert_eq!(imported.name.as_deref(), Some("NACA 0012"));
    assert_eq!(imported.lines, [6, 5, 4, 9, 10]);
    assert!(imported.notices[0].contains("Lednicer"));
    assert_eq!(imported.grid, None);
}

#[test]
fn rows_are_a_surface() {
    let grid = |rows, columns| Some(Grid { rows, columns });
    let of = |text: &str| read(text, &HINTS).unwrap().grid;
    // Blank lines between rows.
    assert_eq!(
        of("0 0 1\n1 0 2\n2 0 3\n\n0 1 1\n1.1 1 2\n2 1 3\n"),
        grid(2, 3)
    );
    // A lattice, in each direction.
    assert_eq!(of("0 0 1\n0 1 2\n0 2 3\n1 0 1\n1 1 2\n1 2 3\n"), grid(2, 3));
    assert_eq!(of("0 5 1\n1 5 2\n0 4 3\n1 4 1\n0 2 2\n1 2 3\n"), grid(3, 2));
    // None of them.
    assert_eq!(of("0 0 1\n0 1 2\n0 2 3\n1 0 1\n1 1 2\n1 2.5 3\n"), None);
    assert_eq!(of("0 0 1\n0 0 2\n0 0 3\n0 0 1\n"), None);
    // A blank line after each line parts nothing.
    let spaced = read("0 0 1\n\n1 0 2\n\n2 0 3\n", &HINTS).unwrap();
    assert_eq!((spaced.grid, spaced.points.len()), (None, 3));
}

#[test]
fn blank_lines_part_curves() {
    let text = "x,y\n0,0\n1,2\n\n\n5,5\n6,7\n7,9\n";
    let parts = read_parts(text.as_bytes(), &HINTS).unwrap();
    let lines: Vec<&[u32]> = parts.iter().map(|part| &part.lines[..]).collect();
    assert_eq!(lines, [&[2, 3][..], &[6, 7, 8]]);
    assert!(
        parts[1].notices[0].contains("2 parts"),
        "{:?}",
        parts[1].notices
    );
    let part = |part: &str| Hints {
        part: Some(PartChoice::of_text(part)),
        ..HINTS
    };
    assert_eq!(read(text, &part("2")).unwrap(), parts[1]);
    for (hints, detail) in [
        (HINTS, "the file has 2 parts, and a fit is of one"),
        (part("3"), "the file has parts 1 to 2"),
        (part("0"), "the file has parts 1 to 2"),
        (part("top"), "no part of the file is called \"top\""),
    ] {
        let wrong = read(text, &hints).unwrap_err();
        assert!(wrong[0].detail.starts_with(detail), "{wrong:?}");
    }
    let alone = read("0 0\n1 1\n\n2 2\n\n3 3\n4 4\n", &part("1")).unwrap_err();
    assert_eq!(alone[0].line, Some(4));
}

#[test]
fn rows_can_be_said() {
    let text = "0 0 1\n1 0 2\n2 0 3\n0 1 1\n1.1 1 2\n2 1 3\n";
    let size = |rows, columns| Hints {
        size: Some(Grid { rows, columns }),
        ..HINTS
    };
    let grid = read(text, &size(2, 3)).unwrap().grid.unwrap();
    assert_eq!((grid.rows, grid.columns), (2, 3));
    let wrong = read(text, &size(2, 4)).unwrap_err();
    assert_eq!(
        wrong[0].detail,
        "the file has 6 points, which are not 2 rows of 4"
    );
    let curve = Hints {
        kind: Some(Kind::Curve),
        ..HINTS
    };
    assert_eq!(
        read("0 0 1\n0 1 2\n1 0 1\n1 1 2\n", &curve).unwrap().grid,
        None
    );
}

proptest! {
    /// Any file gives points with their lines, or an error.
    #[test]
    fn no_file_breaks_it(text in "([-+0-9.,;eD xyz#\\t\"]{0,12}\n|[0-9] [0-9] [0-9]\n|\\PC{0,9}\n){0,12}") {
        match read(&text, &HINTS) {
            Ok(file) => {
                prop_assert_eq!(file.lines.len(), file.points.len());
                prop_assert!(file.grid.is_none_or(|grid| grid.count() == file.points.len()));
                prop_assert!(file.points.lanes().iter().flat_map(|lane| lane.iter()).all(|it| it.is_finite()));
            }
            Err(errors) => prop_assert!(!errors.is_empty()),
        }
    }
}

#[test]
fn marks_and_other_encodings_do_no_harm() {
    let marked = super::read(b"\xef\xbb\xbf1,2\n3,4\n", &HINTS).unwrap();
    assert_eq!((marked.points.len(), marked.name), (2, None));
    let latin = super::read(b"Fl\xfcgel\n1 2\n3 4\n", &HINTS).unwrap();
    assert_eq!(latin.points.len(), 2);
    assert_eq!(latin.name.as_deref(), Some("Fl\u{fffd}gel"));
}

#[test]
fn remarks_below_points_are_no_points() {
    let wing = "NACA 2412\n1 0.0013\n0.95 0.0114\n0.9 0.0208\n";
    let bare = "1 0.0013\n0.95 0.0114\n0.9 0.0208\n";
    let remark = "Source: https://airfoils.example\n28 nov 1999\n";
    for (text, line) in [
        (format!("{wing}{remark}"), 5),
        (format!("{wing}\n{remark}"), 6),
        (format!("{bare}\n\n{remark}"), 6),
        (format!("{wing}\n28/12/2005 https://airfoils.example\n"), 6),
        (format!("{wing}\n28 nov 1999\n{remark}"), 6),
        (format!("{wing}\n9%_1.4%  1.000733 --> 1.0\n"), 6),
        (
            format!("{wing}\n*modification\n\n-----\nof 12 % by hand\n"),
            6,
        ),
    ] {
        let read = read(&text, &HINTS).unwrap();
        assert_eq!(read.points.len(), 3, "{text}");
        let expected = format!("from line {line} on, ");
        assert!(read.notices[0].contains(&expected), "{:?}", read.notices);
    }
    // Points below them, damaged points, tables with names of columns, and no blank line or title.
    for (text, line) in [
        (format!("{wing}words here\n0.8 0.03\n"), 5),
        (format!("{wing}\nwords here\n0.8 0.03\n"), 6),
        (format!("{wing}0.8 oops\n"), 5),
        (format!("{wing}\n0.8 oops\n"), 6),
        (format!("{wing}\n***** 0.03\n"), 6),
        (format!("{wing}\n0.8\n"), 6),
        (format!("{wing}\n0,8 0,03\n"), 6),
        (format!("{wing}\n0.8 0.03 oops\n"), 6),
        (format!("{wing}20 nov 2005\n"), 5),
        ("1 2\n3 4\nwords here\n".to_owned(), 3),
        ("x y\n1 2\n3 4\nwords here\n".to_owned(), 4),
        ("x,y\n1,2\n3,4\n\nwords here\n".to_owned(), 5),
    ] {
        assert_eq!(errors(&text)[0].0, Some(line), "{text}");
    }
}

#[test]
fn lines_of_words_stand_above_the_points() {
    let points = "1 0.5\n0.5 0.25\n0 0\n";
    let of = |titles: &str| read(&format!("{titles}{points}"), &HINTS).unwrap();
    let wing = of("SC(2)-0714\nmeasured coordinates\n\nfrom TP-2890, of 1990\n");
    assert_eq!(wing.name.as_deref(), Some("SC(2)-0714"));
    assert_eq!((wing.points.len(), wing.lines[0]), (3, 5));
    assert!(wing.notices[0].contains("3 lines of words"));
    let table = of("by hand\ny x\n");
    assert_eq!(table.name.as_deref(), Some("by hand"));
    assert_eq!((table.points.lane(0)[0], table.notices), (0.5, vec![]));
    // Commas and tabs of a title are no columns of numbers between blanks.
    for title in ["HM 55, by somebody", "HM 55\tby somebody"] {
        let wing = read(&format!("{title}\n{points}by hand\n"), &HINTS).unwrap();
        assert_eq!(wing.name.unwrap(), title.replace('\t', " "));
    }
    // A point with an invalid coordinate is not a title, and many words are another format.
    assert_eq!(
        errors("NACA 23021\n1.0 .....\n1.0 (0.2)\n0.9 0.1\n"),
        [
            (Some(2), "column 2: \".....\" is no number".to_owned()),
            (Some(3), "column 2: \"(0.2)\" is no number".to_owned())
        ]
    );
    assert_eq!(errors("1.0 oops\n0.9 0.1\n0.8 0.2\n")[0].0, Some(1));
    let head = "mesh\nversion 1.0\npoints below\nall of them\n0 0 0\n1 1 1\n";
    assert_eq!(errors(head)[0].0, Some(4));
}

#[test]
fn texts_beside_one_column_of_numbers_are_refused_once() {
    let rows = |text: &str| (1..9).map(|i| text.replace('#', &i.to_string())).collect();
    for (head, row, line, detail) in [
        (
            "id;height\n",
            "p#;431200,#\n",
            2,
            "column 1 (\"id\") is text, \"p1\" here",
        ),
        ("", "p# #\n", 1, "column 1 is text, \"p1\" here"),
        (
            "P,D\n",
            "10#.5,\"kerb\"\n",
            2,
            "column 2 (\"D\") is text, \"kerb\" here",
        ),
        ("a survey\n\nP\tD\n", "10#\tEP\n", 4, "column 2"),
    ] {
        let rows: String = rows(row);
        let wrong = errors(&format!("{head}{rows}"));
        assert_eq!((wrong.len(), wrong[0].0), (1, Some(line)), "{wrong:?}");
        assert!(wrong[0].1.starts_with(detail), "{wrong:?}");
    }
    // Lines that have no column of text.
    let words = errors(&"these are words\n".repeat(20));
    assert_eq!((words.len(), words[0].0), (1, Some(4)), "{words:?}");
}

/// Points of a spiral in an order of their own.
fn mixed(count: usize) -> String {
    let point = |i: usize| {
        let t = (i * 37 % count) as f64 * 0.1;
        format!("{} {}\n", t * t.cos(), t * t.sin())
    };
    (0..count).map(point).collect()
}

#[test]
fn curves_have_an_order() {
    let text = mixed(200);
    let wrong = errors_of(&text, HINTS);
    assert!(wrong[0].detail.contains("--order given"), "{wrong:?}");
    let curve = Hints {
        kind: Some(Kind::Curve),
        ..HINTS
    };
    assert_eq!(errors_of(&text, curve.clone()), wrong);
    let ordered = Hints {
        ordered: true,
        ..HINTS
    };
    assert!(!read_many(&text, ordered).unwrap().unordered);
    let surface = Hints {
        kind: Some(Kind::Surface),
        ..HINTS
    };
    assert!(read_many(&text, surface).unwrap().unordered);
    // The vertices of a mesh have none, however they lie.
    let mesh = "OFF\n3 1 3\n0 0 0\n1 0 0\n2 0 0.1\n3 0 1 2\n";
    assert_eq!(errors_of(mesh, curve), wrong);
}

fn read_many(text: &str, hints: Hints) -> Result<Imported, Vec<FileError>> {
    read(
        text,
        &Hints {
            most: 1000,
            ..hints
        },
    )
}

fn errors_of(text: &str, hints: Hints) -> Vec<FileError> {
    read_many(text, hints).unwrap_err()
}

#[test]
fn files_of_mses_have_a_domain_and_one_element() {
    let wing = "N+3 T100\n -2.0 3.0 -2.5 3.5\n1 0.5\n0.5 0.25\n0 0\n";
    let imported = read(wing, &HINTS).unwrap();
    assert_eq!((imported.points.len(), imported.lines[0]), (3, 3));
    let notice = "\"-2.0 3.0 -2.5 3.5\", is the domain";
    assert!(imported.notices[0].contains(notice));
    let flap = format!("{wing}999. 999.\n1.1 0\n1.2 0.1\n");
    let wrong = errors(&flap);
    assert_eq!((wrong.len(), wrong[0].0), (1, Some(6)));
    assert!(wrong[0].1.contains("another element"), "{wrong:?}");
    // Points with four columns, and numbers that are no domain.
    let cloud = read("a scan\n1 2 3 4\n5 6 7 8\n", &HINTS).unwrap();
    assert_eq!(cloud.points.len(), 2);
    assert_eq!(errors("N+3\n3 -2 -2.5 3.5\n1 0.5\n0 0\n")[0].0, Some(3));
    assert_eq!(errors("-2.0 3.0 -2.5 3.5\n1 0.5\n0 0\n")[0].0, Some(2));
}

/// Large files are read by all threads, unless a line is more than a plain point: a pair of quotes on the
/// last one makes no other difference.
#[test]
fn large_files_are_the_same_in_pieces() {
    let hints = Hints {
        most: 40_000,
        ..HINTS
    };
    let file = |head: &str, separator: &str, end: &str, rows: usize, quoted: bool| {
        let mut text = head.to_owned();
        for i in 0..40_000 {
            let t = f64::from(i) * 0.37;
            let last = if quoted && i == 39_999 { "\"" } else { "" };
            let (x, y, z) = (t.sin(), -t / 7.0, t.cos() * 1e-5);
            text += &format!("{x}{separator}{y}{separator}{last}{z}{last}{end}");
            if rows > 0 && i as usize % rows == rows - 1 {
                text += end;
            }
        }
        text
    };
    for (head, separator, end, rows) in [
        ("", ",", "\n", 0),
        ("z,y,x\r\n", ", ", "\r\n", 0),
        ("a scan\n\n", "\t", "\n", 200),
        ("", " ; ", "\r", 0),
        ("", "  ", "\n", 333),
        ("u,x,y\n", " , ", "\n", 0),
        ("x y u\n", " ", "\n", 0),
    ] {
        let [plain, quoted] = [false, true].map(|quoted| file(head, separator, end, rows, quoted));
        let [found, quoted] =
            [plain, quoted].map(|text| read_parts(text.as_bytes(), &hints).unwrap());
        assert_eq!(found, quoted, "{separator:?}");
        let counts = |part: &Imported| [part.points.len(), part.lines.len()];
        let total = found
            .iter()
            .map(counts)
            .reduce(|a, b| [a[0] + b[0], a[1] + b[1]]);
        assert_eq!(total, Some([40_000; 2]));
        assert_eq!(found[0].grid.is_some(), rows == 200);
        assert_eq!(found.len(), if rows == 333 { 121 } else { 1 });
    }
    let text = file("", ",", "\n", 0, false);
    let fewer = Hints {
        most: 39_999,
        ..hints.clone()
    };
    assert_eq!(read(&text, &fewer).unwrap_err()[0].line, Some(40_000));
    let line = text.lines().nth(30_000).unwrap();
    for wrong in ["1,oops,2", "1,2", "1,2,3,4", "1,1e999,2"] {
        let errors = read(&text.replace(line, wrong), &hints).unwrap_err();
        assert_eq!(errors[0].line, Some(30_001), "{wrong}");
    }
}

#[test]
fn points_of_curves_that_come_again_are_kept_once() {
    let imported = read("x,y\n0,0\n1,2\n1,2\n1,2\n3,1\n1,2\n", &HINTS).unwrap();
    assert_eq!(
        imported.points.to_flat(),
        [0.0, 0.0, 1.0, 2.0, 3.0, 1.0, 1.0, 2.0]
    );
    assert_eq!(imported.lines, [2, 3, 6, 7]);
    let notice = "2 points equal the one before, the first of them in line 4: each is kept once.";
    assert_eq!(imported.notices, [notice]);
    let array = read("[[0, 0],\n[1, 2],\n[1, 2],\n[3, 1]]", &HINTS).unwrap();
    assert_eq!((array.points.len(), &array.lines[..]), (3, &[1, 2, 4][..]));
    // Rows of a surface may meet in a point, and values of functions be equal.
    let rows = read("0 0 1\n0 0 1\n\n0 1 0\n1 1 2\n", &HINTS).unwrap();
    assert_eq!((rows.points.len(), rows.grid.is_some()), (4, true));
    assert_eq!(read("0\n1\n1\n0\n", &HINTS).unwrap().points.len(), 4);
}
