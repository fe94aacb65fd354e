//! Files of all formats as people have them: large and small, broken, with claims that are not true.

use std::fs;

use crate::support::Folder;

/// The name of a file, its bytes, the status of the program, and its message.
type Case = (&'static str, Vec<u8>, i32, &'static str);

fn text(name: &'static str, text: &str, status: i32, finished: &'static str) -> Case {
    (name, text.into(), status, finished)
}

/// The same file with the line ends of Windows and of old Macintosh computers, and in UTF-16.
fn written_otherwise(name: &'static str, text: &str, finished: &'static str) -> Vec<Case> {
    let utf16 = |order: fn(u16) -> [u8; 2]| {
        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
        units.flat_map(order).collect::<Vec<u8>>()
    };
    vec![
        (name, text.into(), 0, finished),
        (name, text.replace('\n', "\r\n").into(), 0, finished),
        (name, text.replace('\n', "\r").into(), 0, finished),
        (name, utf16(u16::to_le_bytes), 0, finished),
        (name, utf16(u16::to_be_bytes), 0, finished),
    ]
}

fn tables() -> Vec<Case> {
    let counted: String = (1..=9)
        .map(|i| format!("{i},{},{}\n", i * i, 7 - i))
        .collect();
    let mut cases = written_otherwise(
        "named columns",
        "id,x (m),y (m)\n7,0,0\n8,1,2\n9,3,1\n",
        "(id) is not read",
    );
    cases.extend([
        text("a column that counts", &counted, 0, "column 1 counts"),
        text(
            "decimal commas",
            "t;x;y\n0;0,5;1\n1;1,5;2\n2;3;4\n",
            0,
            "Columns 2 (x) and 3 (y)",
        ),
        text(
            "texts with commas",
            "P,N,E,D\n1,10,20,\"a, b\"\n2,12,22,c\n3,13,25,d\n",
            0,
            "Columns 3 (E) and 2 (N)",
        ),
        text(
            "gaps",
            "x,y\n0,0\n1,nan\n2,1\n3,\n4,4\n5,5\n",
            0,
            "2 points",
        ),
        text(
            "seven angles",
            "time,j1,j2,j3,j4\n0,1,2,3,4\n1,2,3,4,5\n2,4,4,4,4\n3,5,5,5,6\n",
            0,
            "The parameters of the curve are its times",
        ),
        text(
            "times that go back",
            "time,j1,j2\n0,1,2\n2,2,3\n1,4,4\n3,5,5\n",
            2,
            ":4: the time of this point is not after",
        ),
        text(
            "degrees",
            "lon,lat\n11.5,48\n11.51,48.01\n11.53,48.01\n11.54,48.02\n",
            0,
            "metres east and north of latitude 48",
        ),
        text(
            "latitudes beyond the poles",
            "lon,lat\n11.5,48\n11.51,98.01\n11.53,48.01\n",
            2,
            ":3: latitude 98.01",
        ),
        text(
            "two curves",
            "x,y\n0,0\n1,1\n2,0\n\n5,5\n6,6\n7,5\n",
            0,
            "2 parts",
        ),
        text(
            "one point alone",
            "x,y\n0,0\n1,1\n\n5,5\n",
            2,
            ":5: this part has one point",
        ),
        text(
            "lines that are all words",
            &"these are words\n".repeat(20),
            2,
            ":4: ",
        ),
        text(
            "numbers beyond all bounds",
            "0,0\n1,1e999\n3,1\n",
            2,
            ":2: column 2",
        ),
    ]);
    cases
}

fn drawings() -> Vec<Case> {
    let gpx = |inner: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<gpx>\n<trk><name>way</name><trkseg>\n{inner}</trkseg></trk>\n</gpx>\n"
        )
    };
    let point = |i: u32| format!("<trkpt lat=\"48.0{i}\" lon=\"11.{i}\"><ele>{i}</ele></trkpt>\n");
    let track: String = (1..6).map(point).collect();
    let line = "{\"type\": \"LineString\", \"coordinates\": [[0, 0], [1, 2], [3, 1], [4, 4]]}";
    let dxf = |entities: &str| format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
    let polyline = "0\nLWPOLYLINE\n8\nA\n90\n4\n70\n0\n10\n0\n20\n0\n10\n1\n20\n2\n10\n3\n20\n1\n10\n4\n20\n4\n";
    let svg = |inner: &str| {
        format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\">{inner}</svg>")
    };
    let bomb = "<!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<gpx><trk><name>&b;</name></trk></gpx>";
    let mut cases = written_otherwise("track", &gpx(&track), "metres east and north");
    cases.extend(
        written_otherwise("line on a map", line, "LineString")
            .into_iter()
            .map(|(name, bytes, status, _)| (name, bytes, status, "4 points")),
    );
    cases.extend(written_otherwise("drawing", &dxf(polyline), "4 points"));
    cases.extend(written_otherwise(
        "outline",
        &svg("<polyline points=\"0,0 1,2 3,1 4,4\"/>"),
        "4 points",
    ));
    cases.extend(written_otherwise(
        "path of a tool",
        "%\nG21 G90\nG0 X0 Y0\nG1 X1 Y2\nG1 X3 Y1\nG1 X4 Y4\nM30\n",
        "4 points",
    ));
    cases.extend([
        text("track that is cut off", &gpx(&track)[..200], 2, ""),
        text("track without points", &gpx(""), 2, "there are no points"),
        text("entities in entities", bomb, 2, ""),
        text(
            "latitude that is none",
            &gpx("<trkpt lat=\"north\" lon=\"1\"/>"),
            2,
            ":4: ",
        ),
        text("map that is cut off", &line[..50], 2, ""),
        text(
            "position that is none",
            "{\"type\": \"LineString\", \"coordinates\": [[0, 0], [1, \"b\"]]}",
            2,
            "position 1",
        ),
        text("drawing that is cut off", &dxf(polyline)[..90], 2, ""),
        text(
            "drawing of words",
            &dxf("0\nTEXT\n8\nA\n1\nhello\n"),
            2,
            "no points",
        ),
        text(
            "drawing in binary",
            "AutoCAD Binary DXF\r\n\u{1a}\0",
            2,
            "DXF",
        ),
        text("outline without points", &svg(""), 2, "no points"),
        text(
            "outline in outlines",
            &svg(&("<g>".repeat(50_000) + "<path d='M0 0 L1 1'/>")),
            2,
            "",
        ),
        text(
            "two outlines",
            &svg("<path d='M0 0 L1 1 2 0'/><path d='M5 5 l1 1 2 3'/>"),
            0,
            "2 parts",
        ),
    ]);
    cases
}

fn clouds() -> Vec<Case> {
    let ply = |count: &str, format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        )
    };
    let four = "0 0 0\n1 0 1\n0 1 2\n1 1 4\n";
    let mut stl = vec![0; 80];
    stl.extend(1000_u32.to_le_bytes());
    let floats = |order: fn(f32) -> [u8; 4]| {
        (0..12_u8)
            .flat_map(move |i| order(f32::from(i)))
            .collect::<Vec<u8>>()
    };
    let with = |head: String, body: &[u8]| [head.as_bytes(), body].concat();
    let little = with(ply("4", "binary_little_endian"), &floats(f32::to_le_bytes));
    let big = with(ply("4", "binary_big_endian"), &floats(f32::to_be_bytes));
    let claims = with(
        ply("999999999999999999", "binary_little_endian"),
        &floats(f32::to_le_bytes),
    );
    let grid = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n1 2 3\n4 5 7\n";
    // A mesh is a surface, which these have too few vertices for.
    let few = "for 3 different parameters";
    let order = "no order along a curve";
    let mut cases = vec![
        ("PLY, little end first", little, 2, order),
        ("PLY, big end first", big, 2, order),
        ("PLY with a claim", claims, 2, "999999999999999999"),
        text("PLY in text", &(ply("4", "ascii") + four), 2, order),
        text("PLY that is cut off", &(ply("9", "ascii") + four), 2, "9"),
        ("STL with a claim", stl, 2, ""),
        text("OBJ", "v 0 0 0\nv 1 0 1\nv 0 1 2\nf 1 2 3\n", 2, few),
        text(
            "OBJ with a line",
            "v 0 0 0\nv 1 0 1\nv 0 1 2\nl 1 2 3\n",
            0,
            "3 points",
        ),
        text(
            "OBJ with an index that is none",
            "v 0 0 0\nv 1 0 1\nl 1 9\n",
            2,
            ":3: ",
        ),
        text(
            "OFF",
            &("OFF\n4 1 0\n".to_owned() + four + "3 0 1 2\n"),
            2,
            few,
        ),
        text("PTS", &("4\n".to_owned() + four), 2, order),
        text(
            "PCD that is cut off",
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 9\nHEIGHT 1\nPOINTS 9\nDATA binary\nab",
            2,
            "9",
        ),
        text("LAS that is cut off", "LASF\0\0\0\0", 2, ""),
        text("grid", grid, 0, "2 rows of 3"),
        text("grid with too few heights", &grid[..grid.len() - 4], 2, ""),
        text("ZIP", "PK\u{3}\u{4}\0\0\0\0", 2, "ZIP"),
        text("PDF", "%PDF-1.7\n", 2, "PDF"),
        ("gzip", vec![0x1f, 0x8b, 8, 0, 0, 0], 2, "gzip"),
        (
            "unknown bytes",
            vec![1, 0, 2, 0, 3, 0, 255, 4, 0, 0, 0, 9],
            2,
            "binary file",
        ),
        text("STEP", "ISO-10303-21;\nHEADER;\n", 2, "STEP"),
    ];
    cases.retain(|(_, bytes, ..)| !bytes.is_empty());
    cases
}

/// Other formats with all line ends and in UTF-16, and claims of sizes that no file has.
fn more() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, text, finished) in [
        (
            "grid",
            "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2 3\n4 5 7\n",
            "2 rows of 3",
        ),
        (
            "OBJ with a line",
            "v 0 0 0\nv 1 0 1\nv 0 1 2\nl 1 2 3\n",
            "3 points",
        ),
        (
            "JSON array",
            "[[0, 0],\n[1, 2],\n[3, 1],\n[4, 4]]",
            "4 points",
        ),
        (
            "airfoil",
            "A wing\n1 0\n0.5 0.1\n0 0\n0.5 -0.1\n0.9 -0.02\n",
            "5 points",
        ),
        (
            "KML",
            "<kml><Document><Placemark><LineString><coordinates>\n11,48\n11.1,48\n11.1,48.1\n11.2,48.3\n</coordinates></LineString></Placemark></Document></kml>",
            "metres east and north",
        ),
        (
            "drawing with a block",
            "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nA\n0\nLWPOLYLINE\n10\n0\n20\n0\n10\n1\n20\n2\n10\n3\n20\n1\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nA\n10\n5\n20\n5\n0\nENDSEC\n0\nEOF\n",
            "1 INSERTs are read",
        ),
    ] {
        cases.extend(written_otherwise(name, text, finished));
    }
    let rows: String = (0..20_000_u64)
        .map(|i| format!("{i},{}\r\n", i * i % 1009))
        .collect();
    cases.push(text("large table", &rows, 0, "20000 points"));
    let huge = "999999999";
    for (name, claim) in [
        ("grid with a claim", format!("ncols {huge}\nnrows {huge}\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n")),
        ("OFF with a claim", format!("OFF\n{huge} {huge} 0\n0 0 0\n1 0 0\n")),
        ("PTS with a claim", format!("{huge}\n0 0 0\n1 0 0\n")),
        ("PCD with a claim", format!("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {huge}\nHEIGHT {huge}\nPOINTS {huge}{huge}\nDATA binary\nab")),
        ("PLY with faces of a claim", "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n\u{7f}\u{7f}\u{7f}\u{7f}".to_owned()),
        ("drawing with rows of a claim", format!("0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nA\n0\nPOINT\n10\n0\n20\n0\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nA\n10\n5\n20\n5\n70\n{huge}\n71\n{huge}\n0\nENDSEC\n0\nEOF\n")),
        ("outline of itself", "<svg><g id='a'><use href='#a'/></g></svg>".to_owned()),
        ("array in arrays", "[".repeat(100_000)),
        ("map in maps", "{\"type\": \"GeometryCollection\", \"geometries\": [".repeat(10_000)),
    ] {
        cases.push(text(name, &claim, 2, ""));
    }
    let mut las = vec![0; 375];
    las[..4].copy_from_slice(b"LASF");
    (las[24], las[25], las[94]) = (1, 4, 0x77);
    las[96..100].copy_from_slice(&375_u32.to_le_bytes());
    las[105..107].copy_from_slice(&20_u16.to_le_bytes());
    las[247..255].fill(0xff);
    cases.push(("LAS with a claim", las, 2, ""));
    cases
}

#[test]
fn odd_files_of_all_formats_are_read_or_refused() {
    let folder = Folder::new();
    let cases = [tables(), drawings(), clouds(), more()].concat();
    assert!(cases.len() >= 100, "{}", cases.len());
    let wrong = cases
        .into_iter()
        .filter_map(|(name, bytes, status, finished)| {
            fs::write(folder.path("odd"), &bytes).unwrap();
            let answer = folder.fit(&["odd", "-o", "odd.json"]);
            let is_right = answer.status == status
                && answer.err.contains(finished)
                && !answer.err.contains("panicked");
            (!is_right).then(|| format!("{name}: {}: {}", answer.status, answer.err))
        });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
