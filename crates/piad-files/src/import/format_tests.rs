//! All readers of clouds, meshes and grids: no input makes them panic.

use proptest::prelude::*;

use super::tests::HINTS;
use super::{Hints, Kind, read, read_parts};

/// What files of each format begin with. Numbers and bytes follow.
fn starts() -> Vec<Vec<u8>> {
    let mut las = b"LASF".to_vec();
    las.resize(24, 0);
    las.extend([1, 4]);
    las.resize(96, 0);
    las.extend([0x90, 1, 0, 0, 0, 0, 0, 0, 6, 30, 0, 3, 0, 0, 0]);
    let mut stl = b"solid by a program".to_vec();
    stl.resize(80, b' ');
    let ply = "element face 2\nproperty list uchar int vertex_indices\nelement vertex 3\nproperty uchar red\nproperty float x\nproperty list char double near\nproperty short y\nend_header\n";
    let pcd = "VERSION 0.7\nFIELDS rgb x y\nSIZE 4 4 8\nTYPE F F F\nCOUNT 2 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ";
    let texts = [
        format!("ply\nformat ascii 1.0\n{ply}"),
        format!("ply\nformat binary_little_endian 1.0\n{ply}"),
        format!(
            "ply\r\nformat binary_big_endian 1.0\r\n{}",
            ply.replace('\n', "\r\n")
        ),
        "ply\nformat ascii 1.0\nelement vertex ".to_owned(),
        format!("{pcd}ascii\n"),
        format!("{pcd}binary\n"),
        format!("{pcd}binary_compressed\n"),
        "VERSION 0.7\nFIELDS ".to_owned(),
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex ".to_owned(),
        "v 0 0 0\nv 1 1 0\nv 2 0 0\nl 1 2 ".to_owned(),
        "o a\nv ".to_owned(),
        "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n".to_owned(),
        "ncols ".to_owned(),
        "2\n1 2 3\n".to_owned(),
        "\u{feff}".to_owned(),
        String::new(),
    ];
    let texts = texts.into_iter().map(String::into_bytes);
    let others = [
        las,
        stl,
        b"\xff\xfe".to_vec(),
        b"\xfe\xff".to_vec(),
        b"PK\x03\x04".to_vec(),
    ];
    texts.chain(others).collect()
}

/// Bytes, and what numbers and lines consist of.
fn below() -> impl Strategy<Value = Vec<u8>> {
    let bytes = prop::collection::vec(any::<u8>(), 0..400);
    let text = "([-+0-9., ]{0,12}\n|[0-9] [0-9] [0-9]\n|(vertex|endloop|endfacet|l|f|nan|end_header) ?[0-9 \\\\]{0,6}\n){0,20}";
    prop_oneof![bytes, text.prop_map(String::into_bytes)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Any bytes after a valid beginning give points or an error.
    #[test]
    fn no_bytes_break_a_reader(start in prop::sample::select(starts()), below in below(), cut in 0..500_usize, changed in any::<(prop::sample::Index, u8)>()) {
        let mut file = [start, below].concat();
        if let Some(byte) = file.get_mut(changed.0.index(1 << 12)) {
            *byte = changed.1;
        }
        file.truncate(file.len().saturating_sub(cut / 4));
        for kind in [None, Some(Kind::Surface)] {
            match read(&file, &Hints { kind, ..HINTS }) {
                Ok(file) => {
                    prop_assert!(file.points.len() >= 2 && file.points.len() <= HINTS.most);
                    prop_assert!(file.lines.is_empty() || file.lines.len() == file.points.len());
                    prop_assert!(file.grid.is_none_or(|grid| grid.count() == file.points.len()));
                    prop_assert!(file.points.lanes().iter().flat_map(|lane| lane.iter()).all(|it| it.is_finite()));
                }
                Err(errors) => prop_assert!(!errors.0.is_empty()),
            }
        }
        let _ = read_parts(&file, &HINTS);
    }
}
