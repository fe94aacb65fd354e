//! The statements of OBJ files.

use std::borrow::Cow;

use super::super::line::line_end;

/// The kind of a statement, by its first word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Polyline,
    Face,
    /// The name of an object or a group.
    Name,
    /// Curves and surfaces, and their points in the plane of parameters.
    FreeForm,
    /// Normals, materials and the like, which are skipped.
    Other,
    Unknown,
}

impl Kind {
    pub(super) fn of(word: &str) -> Self {
        match word {
            "v" => Self::Vertex,
            "l" => Self::Polyline,
            "f" | "fo" => Self::Face,
            "o" | "g" => Self::Name,
            "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm"
            | "trim" | "hole" | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" => Self::FreeForm,
            "vt" | "vn" | "p" | "s" | "mg" | "mtllib" | "usemtl" | "maplib" | "usemap"
            | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj" => Self::Other,
            _ => Self::Unknown,
        }
    }
}

/// The statements of a text, each with its first line, without comments. A backslash at the end of a line continues it.
pub(super) struct Statements<'a> {
    rest: Option<&'a str>,
    end: char,
    number: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            rest: Some(text),
            end: line_end(text),
            number: 0,
        }
    }

    fn line(&mut self) -> Option<&'a str> {
        let text = self.rest?;
        let (line, below) = match text.split_once(self.end) {
            Some((line, below)) => (line, Some(below)),
            None => (text, None),
        };
        self.rest = below;
        self.number += 1;
        Some(line.split('#').next().unwrap_or(line).trim())
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (usize, Cow<'a, str>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let line = self.line()?;
            let number = self.number;
            let mut statement = Cow::Borrowed(line);
            while let Some(continued) = statement.strip_suffix('\\') {
                let length = continued.len();
                let statement = statement.to_mut();
                statement.truncate(length);
                statement.push(' ');
                statement.push_str(self.line().unwrap_or_default());
            }
            if !statement.trim().is_empty() {
                return Some((number, statement));
            }
        }
    }
}
