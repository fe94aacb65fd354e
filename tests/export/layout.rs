//! What every file of a format must be like, by its standard.

use piad_files::export::Format;
use serde_json::Value;

pub fn check(format: Format, file: &[u8]) {
    match format {
        Format::Step => step(std::str::from_utf8(file).unwrap()),
        Format::Iges => iges(std::str::from_utf8(file).unwrap()),
        Format::Obj => obj(std::str::from_utf8(file).unwrap()),
        Format::Gltf => glb(file),
        Format::Stl => stl(file),
        Format::Dxf => dxf(std::str::from_utf8(file).unwrap()),
        Format::Svg => svg(std::str::from_utf8(file).unwrap()),
        Format::Ply => ply(file),
        Format::GeoJson => geojson(file),
        Format::Gpx => assert!(file.ends_with(b"</gpx>\n")),
        Format::Csv => csv(std::str::from_utf8(file).unwrap()),
    }
}

/// Instances are numbered without gaps, and refer to existing ones.
fn step(text: &str) {
    assert!(text.is_ascii());
    let mut numbers: Vec<usize> = Vec::new();
    let mut references: Vec<usize> = Vec::new();
    let data = text.split_once("DATA;\n").unwrap().1;
    for statement in data.split(";\n").filter(|it| it.starts_with('#')) {
        let (number, content) = statement[1..].split_once('=').unwrap();
        numbers.push(number.parse().unwrap());
        let found = content.split('#').skip(1).filter_map(|tail| {
            let digits = tail.split(|c: char| !c.is_ascii_digit()).next()?;
            digits.parse::<usize>().ok()
        });
        references.extend(found);
    }
    let mut sorted = numbers.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (1..=numbers.len()).collect::<Vec<_>>());
    assert!(references.iter().all(|it| (1..=numbers.len()).contains(it)));
}

/// Lines of 80 columns, in sections whose lines are numbered and counted.
fn iges(text: &str) {
    assert!(text.is_ascii());
    let mut counts = [0; 5];
    for line in text.lines() {
        assert_eq!(line.len(), 80, "{line:?}");
        let section = "SGDPT".find(&line[72..73]).unwrap();
        assert!(counts[section + 1..].iter().all(|count| *count == 0));
        counts[section] += 1;
        assert_eq!(line[73..].trim().parse(), Ok(counts[section]));
    }
    let last = text.lines().last().unwrap();
    for (i, section) in "SGDP".chars().enumerate() {
        let field = &last[8 * i..8 * i + 8];
        assert_eq!(field, format!("{section}{:7}", counts[i]));
    }
    let parameters = text.lines().filter(|line| &line[72..73] == "P");
    let joined: String = parameters.map(|line| line[..64].trim_end()).collect();
    let numbers = joined.trim_end_matches(';').split(',');
    for number in numbers {
        assert!(number.replace('D', "e").parse::<f64>().is_ok(), "{number}");
    }
}

/// Statements are known; indices lie within the vertices.
fn obj(text: &str) {
    let joined = text.replace("\\\n", "");
    let vertices = joined.lines().filter(|line| line.starts_with("v ")).count();
    for line in joined.lines() {
        let mut words = line.split_whitespace();
        let numbers = match words.next().unwrap() {
            "#" | "cstype" | "end" => continue,
            "v" | "deg" => 0,
            "curv" => 2,
            "surf" => 4,
            "parm" => {
                words.next();
                0
            }
            other => panic!("{other}"),
        };
        let values: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        if numbers > 0 {
            assert_eq!(values.len(), numbers + vertices);
        }
    }
}

/// Chunks are aligned and fill the file.
fn glb(file: &[u8]) {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&file[..4], b"glTF");
    assert_eq!((number(4), number(8)), (2, file.len()));
    let json = number(12);
    assert_eq!(&file[16..20], b"JSON");
    let document: Value = serde_json::from_slice(&file[20..20 + json]).unwrap();
    let binary = number(20 + json);
    assert_eq!(&file[24 + json..28 + json], b"BIN\0");
    assert_eq!(28 + json + binary, file.len());
    assert!(json.is_multiple_of(4) && binary.is_multiple_of(4));
    assert!(document["buffers"][0]["byteLength"].as_u64().unwrap() as usize <= binary);
}

/// A count, and as many triangles.
fn stl(file: &[u8]) {
    assert!(!file.starts_with(b"solid"));
    let count = u32::from_le_bytes(file[80..84].try_into().unwrap()) as usize;
    assert!(count > 0);
    assert_eq!(file.len(), 84 + 50 * count);
}

/// A header, vertices of three doubles and three floats, and triangles.
fn ply(file: &[u8]) {
    let end = b"end_header\n";
    let header = file.windows(end.len()).position(|it| it == end).unwrap() + end.len();
    let text = std::str::from_utf8(&file[..header]).unwrap();
    let count = |element: &str| -> usize {
        let line = text.lines().find_map(|line| line.strip_prefix(element));
        line.unwrap().trim().parse().unwrap()
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    assert_eq!(file.len(), header + 36 * vertices + 13 * faces);
}

/// One line with finite positions.
fn geojson(file: &[u8]) {
    let document: Value = serde_json::from_slice(file).unwrap();
    let geometry = &document["features"][0]["geometry"];
    assert_eq!(geometry["type"], "LineString");
    assert!(geometry["coordinates"].as_array().unwrap().len() > 1);
}

/// Groups: a code and a value, up to the end of the file.
fn dxf(text: &str) {
    assert!(text.is_ascii() && text.ends_with("  0\nEOF\n"));
    let lines: Vec<&str> = text.lines().collect();
    for group in lines.chunks(2) {
        let code: u32 = group[0].trim().parse().unwrap();
        match code {
            10..=59 => assert!(group[1].parse::<f64>().unwrap().is_finite()),
            60..=79 => assert!(group[1].parse::<u32>().is_ok()),
            _ => {}
        }
    }
}

/// Every number is one.
fn svg(text: &str) {
    assert!(text.ends_with("</svg>\n"));
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

/// Lines have as many numbers as the header has names.
fn csv(text: &str) {
    let mut lines = text.lines();
    let columns = lines.next().unwrap().split(',').count();
    for line in lines {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(numbers.len(), columns);
    }
}
