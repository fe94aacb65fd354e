//! Files that cannot be read, detected by their first bytes: the error names the type and an alternative.

use super::error::FileError;

/// How much of a file is searched for bytes that do not occur in text.
const LOOKED_AT: usize = 4096;

/// A file with more control characters than one in this number is not text.
const CONTROL_CHARACTERS: usize = 10;

/// Where the signature of a tar archive is.
const TAR: (usize, &[u8]) = (257, b"ustar");

/// How long the lines of IGES files are, and what their first one ends with.
const IGES: (usize, char) = (72, 'S');

/// Advice for archives.
const UNPACK: &str = "unpack it";

/// Advice for tables and arrays of other programs.
const SAVE_AS_CSV: &str = "save its points as CSV";

/// Advice for exact geometry of CAD systems.
const SAVE_AS_MESH: &str = "points are read, not its curves and surfaces: save points as CSV, or a mesh as STL, PLY or OBJ";

/// Advice for other meshes.
const CONVERT_MESH: &str = "save the mesh as PLY, STL or OBJ";

/// Advice for images of heights.
const CONVERT_GRID: &str = "for heights, convert it to an ASCII grid (gdal_translate -of AAIGrid)";

/// Advice for drawings.
const CONVERT_DRAWING: &str = "save it as DXF in text, or its points as CSV";

/// Advice for files without points.
const NO_POINTS: &str = "it has no points that can be read";

/// Signatures, types and advice.
const SIGNATURES: &[(&[u8], &str, &str)] = &[
    // Archives.
    (
        b"PK\x03\x04",
        "a ZIP archive (such as .zip, .3mf, .xlsx or .kmz)",
        UNPACK,
    ),
    (b"PK\x05\x06", "an empty ZIP archive", NO_POINTS),
    (b"\x1f\x8b", "a gzip archive", UNPACK),
    (b"BZh", "a bzip2 archive", UNPACK),
    (b"\xfd7zXZ\0", "an xz archive", UNPACK),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", UNPACK),
    (b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    // Documents and images.
    (b"%PDF-", "a PDF document", NO_POINTS),
    (b"%!PS", "a PostScript document", NO_POINTS),
    (b"{\\rtf", "an RTF document", "save it as plain text"),
    (b"\x89PNG\r\n\x1a\n", "a PNG image", NO_POINTS),
    (b"\xff\xd8\xff", "a JPEG image", NO_POINTS),
    (b"GIF87a", "a GIF image", NO_POINTS),
    (b"GIF89a", "a GIF image", NO_POINTS),
    (b"RIFF", "a RIFF file (such as WebP or WAV)", NO_POINTS),
    (b"II*\0", "a TIFF image", CONVERT_GRID),
    (b"MM\0*", "a TIFF image", CONVERT_GRID),
    (b"II+\0", "a BigTIFF image", CONVERT_GRID),
    (b"MM\0+", "a BigTIFF image", CONVERT_GRID),
    // Tables and arrays.
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "an Excel workbook (.xls) or another document of old Office programs",
        SAVE_AS_CSV,
    ),
    (b"PAR1", "a Parquet file", SAVE_AS_CSV),
    (b"ARROW1", "an Arrow file", SAVE_AS_CSV),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (such as .h5, .nc or .mat)",
        SAVE_AS_CSV,
    ),
    (b"CDF\x01", "a NetCDF file", SAVE_AS_CSV),
    (b"CDF\x02", "a NetCDF file", SAVE_AS_CSV),
    (b"CDF\x05", "a NetCDF file", SAVE_AS_CSV),
    (
        b"\x93NUMPY",
        "a NumPy array (.npy)",
        "save it as text (numpy.savetxt)",
    ),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file (.mat)", SAVE_AS_CSV),
    (
        b"SQLite format 3\0",
        "an SQLite database (such as a GeoPackage)",
        SAVE_AS_CSV,
    ),
    (
        b"\0\0\x27\x0a\0\0\0\0",
        "a shapefile (.shp)",
        "save it as GeoJSON or CSV",
    ),
    // Scans.
    (b"ASTM-E57", "an E57 scan", "convert it to LAS, PLY or PTS"),
    // Geometry of CAD systems.
    (b"ISO-10303-21;", "a STEP file", SAVE_AS_MESH),
    (
        b"3D Geometry File Format",
        "a Rhino file (.3dm)",
        SAVE_AS_MESH,
    ),
    (b"AutoCAD Binary DXF", "a binary DXF file", CONVERT_DRAWING),
    (b"AC10", "a DWG drawing", CONVERT_DRAWING),
    // Meshes.
    (b"Kaydara FBX Binary", "an FBX file", CONVERT_MESH),
    (b"; FBX ", "an FBX file", CONVERT_MESH),
    (b"glTF", "a binary glTF file (.glb)", CONVERT_MESH),
    (b"DRACO", "a Draco mesh", CONVERT_MESH),
    (b"PXR-USDC", "a USD file", CONVERT_MESH),
    (b"BLENDER", "a Blender file", CONVERT_MESH),
    (b"#VRML V", "a VRML file", CONVERT_MESH),
];

/// The beginnings of web pages, in any case: a server without the file may answer with one.
const WEB_PAGES: [&[u8]; 2] = [b"<!doctype html", b"<html"];

/// Refuses a file that is not a point file.
///
/// # Errors
///
/// Its type.
pub(super) fn check(file: &[u8]) -> Result<(), FileError> {
    let error = match known(file) {
        Some((name, instead)) => format!("this is {name}, which is not read: {instead}"),
        None if is_binary(file) => "this is a binary file of an unknown format".to_owned(),
        None => return Ok(()),
    };
    Err(FileError::of_file(error))
}

/// The type of a file, and advice.
fn known(file: &[u8]) -> Option<(&'static str, &'static str)> {
    let text = file.trim_ascii_start();
    let is_page = |page: &&[u8]| {
        let start = text.get(..page.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(page))
    };
    let (place, tar) = TAR;
    let begins = |(signature, _, _): &&(&[u8], &str, &str)| file.starts_with(signature);
    match SIGNATURES.iter().find(begins) {
        // The text of a table may begin with the same letters.
        Some((b"AC10" | b"BZh" | b"glTF" | b"PAR1" | b"RIFF" | b"DRACO" | b"BLENDER", _, _))
            if !is_binary(file) =>
        {
            None
        }
        Some((_, name, instead)) => Some((name, instead)),
        None if file.get(place..).is_some_and(|it| it.starts_with(tar)) => {
            Some(("a tar archive", UNPACK))
        }
        None if is_iges(file) => Some(("an IGES file", SAVE_AS_MESH)),
        None if WEB_PAGES.iter().any(is_page) => Some(("a web page (HTML)", NO_POINTS)),
        None => None,
    }
}

/// Returns true if the first line of a file has the letter of its section and its number where IGES has them.
fn is_iges(file: &[u8]) -> bool {
    let (column, letter) = IGES;
    let Some(end) = file.get(column..column + 8) else {
        return false;
    };
    let line = file.get(..column).unwrap_or_default();
    let number = str::from_utf8(end).unwrap_or("").strip_prefix(letter);
    let number = number.and_then(|number| number.trim_start().parse().ok());
    number == Some(1) && !line.contains(&b'\n')
}

/// A text without the zeros and the old ends of files (Ctrl-Z) that some programs write below it.
pub(super) fn without_padding(text: &[u8]) -> &[u8] {
    let end = text.iter().rposition(|byte| !matches!(byte, 0 | 0x1a));
    text.get(..end.map_or(0, |end| end + 1)).unwrap_or_default()
}

/// Returns true if a file begins with what no text has.
fn is_binary(file: &[u8]) -> bool {
    let start = file.get(..LOOKED_AT).unwrap_or(file);
    let start = without_padding(start);
    let is_control = |byte: &&u8| byte.is_ascii_control() && !byte.is_ascii_whitespace();
    start.contains(&0) || start.iter().filter(is_control).count() * CONTROL_CHARACTERS > start.len()
}

#[cfg(test)]
mod tests {
    use super::SIGNATURES;
    use crate::import::read as read_file;
    use crate::import::tests::HINTS;

    fn error(bytes: &[u8]) -> String {
        read_file(bytes, &HINTS).unwrap_err().to_string()
    }

    #[test]
    fn files_that_are_not_read_are_named() {
        for (signature, name, instead) in SIGNATURES {
            let file = [signature, &b"\x01\0\xfe\x80\x03\x02\0\0"[..]].concat();
            let expected = format!("this is {name}, which is not read: {instead}");
            assert_eq!(error(&file), expected);
        }
        let mut tar = vec![b'a'; 257];
        tar.extend(b"ustar\0");
        assert!(error(&tar).starts_with("this is a tar archive"));
        let iges = format!("{:72}S{:>7}\n", "a part", 1);
        assert!(error(iges.as_bytes()).starts_with("this is an IGES file"));
        let page = b"\n<!DOCTYPE HTML>\n<title>404</title>";
        assert!(error(page).starts_with("this is a web page"));
        let step = b"ISO-10303-21;\nHEADER;\n";
        assert!(error(step).starts_with("this is a STEP file, which is not read"));
    }

    #[test]
    fn unknown_binary_files_are_no_text() {
        let unknown = "this is a binary file of an unknown format";
        assert_eq!(error(b"1 2\n\x003 4\n"), unknown);
        assert_eq!(error(b"\x01\x02\x03 1 2\n"), unknown);
        let random: Vec<u8> = (0..999_u32).map(|i| (i * i / 3) as u8).collect();
        assert_eq!(error(&random), unknown);
        for text in [
            &b"1 2\n3 4\n\0\0\0"[..],
            b"1 2\r\n3 4\r\n\x1a",
            b"1 2\n\x0c3 4\n",
            b"BZh, a wing\n1 2\n3 4\n",
        ] {
            assert_eq!(read_file(text, &HINTS).unwrap().points.len(), 2, "{text:?}");
        }
    }
}
