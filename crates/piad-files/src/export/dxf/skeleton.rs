//! The parts of an AutoCAD R2000 drawing around its entities: tables, blocks and dictionaries, which refer to each
//! other by handles.
//!
//! Here each line is a group: its code and its value. Handles below [`FIRST_FREE`] are fixed, and are those that
//! AutoCAD gives the same objects in an empty drawing.

use super::groups::pair;
use crate::export::text::Text;

/// The first handle that is not fixed.
pub(super) const FIRST_FREE: usize = 0x100;

/// The handle of the model space, which owns all entities.
pub(super) const MODEL_SPACE: &str = "1F";

/// The handle of the table of layers.
pub(super) const LAYERS: &str = "2";

/// The handle of the plot style of all layers.
pub(super) const PLOT_STYLE: &str = "F";

/// The classes that objects at the end of the file have.
pub(super) const CLASSES: &str = "\
0 SECTION
2 CLASSES
0 CLASS
1 ACDBDICTIONARYWDFLT
2 AcDbDictionaryWithDefault
3 ObjectDBX Classes
90 0
280 0
281 0
0 CLASS
1 ACDBPLACEHOLDER
2 AcDbPlaceHolder
3 ObjectDBX Classes
90 0
280 0
281 0
0 CLASS
1 LAYOUT
2 AcDbLayout
3 ObjectDBX Classes
90 0
280 0
281 0
0 ENDSEC";

/// The three types of lines that every drawing has.
pub(super) const LINE_TYPES: &str = "\
0 TABLE
2 LTYPE
5 5
330 0
100 AcDbSymbolTable
70 3
0 LTYPE
5 14
330 5
100 AcDbSymbolTableRecord
100 AcDbLinetypeTableRecord
2 ByBlock
70 0
3 
72 65
73 0
40 0.0
0 LTYPE
5 15
330 5
100 AcDbSymbolTableRecord
100 AcDbLinetypeTableRecord
2 ByLayer
70 0
3 
72 65
73 0
40 0.0
0 LTYPE
5 16
330 5
100 AcDbSymbolTableRecord
100 AcDbLinetypeTableRecord
2 Continuous
70 0
3 Solid line
72 65
73 0
40 0.0
0 ENDTAB";

/// The tables behind that of layers.
pub(super) const OTHER_TABLES: &str = "\
0 TABLE
2 STYLE
5 3
330 0
100 AcDbSymbolTable
70 1
0 STYLE
5 11
330 3
100 AcDbSymbolTableRecord
100 AcDbTextStyleTableRecord
2 Standard
70 0
40 0.0
41 1.0
50 0.0
71 0
42 2.5
3 txt
4 
0 ENDTAB
0 TABLE
2 VIEW
5 6
330 0
100 AcDbSymbolTable
70 0
0 ENDTAB
0 TABLE
2 UCS
5 7
330 0
100 AcDbSymbolTable
70 0
0 ENDTAB
0 TABLE
2 APPID
5 9
330 0
100 AcDbSymbolTable
70 1
0 APPID
5 12
330 9
100 AcDbSymbolTableRecord
100 AcDbRegAppTableRecord
2 ACAD
70 0
0 ENDTAB
0 TABLE
2 DIMSTYLE
5 A
330 0
100 AcDbSymbolTable
70 1
100 AcDbDimStyleTable
0 DIMSTYLE
105 27
330 A
100 AcDbSymbolTableRecord
100 AcDbDimStyleTableRecord
2 Standard
70 0
340 11
0 ENDTAB
0 TABLE
2 BLOCK_RECORD
5 1
330 0
100 AcDbSymbolTable
70 2
0 BLOCK_RECORD
5 1F
330 1
100 AcDbSymbolTableRecord
100 AcDbBlockTableRecord
2 *Model_Space
340 22
0 BLOCK_RECORD
5 1B
330 1
100 AcDbSymbolTableRecord
100 AcDbBlockTableRecord
2 *Paper_Space
340 1E
0 ENDTAB
0 ENDSEC";

/// The blocks of both spaces; entities of the model space are in a section of their own.
pub(super) const BLOCKS: &str = "\
0 SECTION
2 BLOCKS
0 BLOCK
5 20
330 1F
100 AcDbEntity
8 0
100 AcDbBlockBegin
2 *Model_Space
70 0
10 0.0
20 0.0
30 0.0
3 *Model_Space
1 
0 ENDBLK
5 21
330 1F
100 AcDbEntity
8 0
100 AcDbBlockEnd
0 BLOCK
5 1C
330 1B
100 AcDbEntity
67 1
8 0
100 AcDbBlockBegin
2 *Paper_Space
70 0
10 0.0
20 0.0
30 0.0
3 *Paper_Space
1 
0 ENDBLK
5 1D
330 1B
100 AcDbEntity
67 1
8 0
100 AcDbBlockEnd
0 ENDSEC";

/// The dictionaries, the plot style and the layouts of both spaces.
pub(super) const OBJECTS: &str = "\
0 SECTION
2 OBJECTS
0 DICTIONARY
5 C
330 0
100 AcDbDictionary
281 1
3 ACAD_GROUP
350 D
3 ACAD_LAYOUT
350 1A
3 ACAD_PLOTSTYLENAME
350 E
0 DICTIONARY
5 D
330 C
100 AcDbDictionary
281 1
0 DICTIONARY
5 1A
330 C
100 AcDbDictionary
281 1
3 Model
350 22
3 Layout1
350 1E
0 ACDBDICTIONARYWDFLT
5 E
330 C
100 AcDbDictionary
281 1
3 Normal
350 F
100 AcDbDictionaryWithDefault
340 F
0 ACDBPLACEHOLDER
5 F
330 E";

/// A layout, from the end of its plot settings on: the settings of both spaces differ in their flags.
const PLOT_SETTINGS: &str = "\
100 AcDbPlotSettings
1 
2 none_device
4 
6 
40 0.0
41 0.0
42 0.0
43 0.0
44 0.0
45 0.0
46 0.0
47 0.0
48 0.0
49 0.0
140 0.0
141 0.0
142 1.0
143 1.0";

const PLOT_SCALE: &str = "\
72 0
73 0
74 5
7 
75 16
147 1.0
148 0.0
149 0.0";

const LIMITS: &str = "\
10 0.0
20 0.0
11 12.0
21 9.0
12 0.0
22 0.0
32 0.0
14 1.0E20
24 1.0E20
34 1.0E20
15 -1.0E20
25 -1.0E20
35 -1.0E20
146 0.0
13 0.0
23 0.0
33 0.0
16 1.0
26 0.0
36 0.0
17 0.0
27 1.0
37 0.0
76 0";

/// The layouts at the end of the objects.
pub(super) fn layouts(text: &mut Text) {
    for (handle, name, plot_flags, tab, record) in [
        ("22", "Model", 1024, 0, MODEL_SPACE),
        ("1E", "Layout1", 0, 1, "1B"),
    ] {
        pair(text, 0, format_args!("LAYOUT"));
        pair(text, 5, format_args!("{handle}"));
        pair(text, 330, format_args!("1A"));
        groups(text, PLOT_SETTINGS);
        pair(text, 70, format_args!("{plot_flags}"));
        groups(text, PLOT_SCALE);
        pair(text, 100, format_args!("AcDbLayout"));
        pair(text, 1, format_args!("{name}"));
        pair(text, 70, format_args!("1"));
        pair(text, 71, format_args!("{tab}"));
        groups(text, LIMITS);
        pair(text, 330, format_args!("{record}"));
    }
}

/// Appends groups, each in a line: its code, a blank, its value.
pub(super) fn groups(text: &mut Text, lines: &str) {
    for line in lines.lines() {
        let (code, value) = line.split_once(' ').unwrap_or((line, ""));
        text.put(format_args!("{code:>3}\n{value}\n"));
    }
}
