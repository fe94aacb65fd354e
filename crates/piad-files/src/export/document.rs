//! The input of all writers: the curves and surfaces of a file with their names, and its metadata.

use std::borrow::Cow;

use jiff::Timestamp;

use super::error::ExportError;
use super::fitted::Fitted;
use super::nurbs::Nurbs;
use super::options::Options;
use super::part::{Header, Part};
use piad_fit::geometry::Outline;

/// The content of a file.
#[derive(Debug)]
pub(super) struct Document<'a> {
    /// The name of the file, or of its only curve or surface.
    pub(super) title: Cow<'a, str>,
    /// A description in one line of ASCII.
    pub(super) description: String,
    /// The time of creation.
    pub(super) created: Timestamp,
    /// The options of the file.
    pub(super) options: Options,
    /// The curves and surfaces, at least one.
    pub(super) shapes: Vec<Shape<'a>>,
    /// True if shapes are parts with their own names, in formats that have such names. The title of the only shape of a
    /// fit names the whole file.
    pub(super) has_parts: bool,
}

/// A curve or surface of a file.
#[derive(Debug)]
pub(super) struct Shape<'a> {
    /// The name that was given, if it is not empty.
    pub(super) name: Option<&'a str>,
    /// Its geometry.
    pub(super) nurbs: &'a Nurbs,
    /// The part of a surface that is left, if it is not all of it.
    pub(super) outline: Option<&'a Outline>,
}

impl<'a> Document<'a> {
    /// The only curve or surface of a fit.
    pub(super) fn of_fit(fitted: &Fitted<'a>, nurbs: &'a Nurbs) -> Self {
        Self {
            title: Cow::Borrowed(fitted.title()),
            description: fitted.description(),
            created: fitted.created,
            options: fitted.options,
            shapes: vec![Shape {
                name: fitted.name.filter(|name| !name.is_empty()),
                nurbs,
                outline: fitted.problem.outline().and_then(|it| trimmed(it)),
            }],
            has_parts: false,
        }
    }

    /// Several curves and surfaces.
    pub(super) fn of_parts(parts: &'a [Part<'a>], header: &Header<'a>) -> Self {
        let shapes: Vec<Shape<'a>> = parts.iter().map(Shape::of).collect();
        let own = match shapes.as_slice() {
            [only] => (Cow::Borrowed(only.title()), describe(only.nurbs)),
            several => {
                let count = count(several);
                (Cow::Owned(count.clone()), count)
            }
        };
        let given = header.name.filter(|name| !name.is_empty());
        Self {
            title: given.map_or(own.0, Cow::Borrowed),
            description: own.1,
            created: header.created,
            options: header.options,
            shapes,
            has_parts: true,
        }
    }

    /// Visits each shape; errors name the part if there are several.
    pub(super) fn try_each(
        &self,
        mut visit: impl FnMut(&Shape<'a>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        for (index, shape) in self.shapes.iter().enumerate() {
            visit(shape).map_err(|error| match self.shapes.len() {
                1 => error,
                _ => error.in_part(index + 1, shape.name),
            })?;
        }
        Ok(())
    }

    /// A description of one shape in one line of ASCII.
    pub(super) fn description_of(&self, shape: &Shape<'_>) -> String {
        match self.shapes.len() {
            1 => self.description.clone(),
            _ => describe(shape.nurbs),
        }
    }
}

impl<'a> Shape<'a> {
    fn of(part: &'a Part<'a>) -> Self {
        Self {
            name: part.name.filter(|name| !name.is_empty()),
            nurbs: &part.nurbs,
            outline: part.outline.as_ref().and_then(trimmed),
        }
    }

    /// The name, or `curve` or `surface` without one.
    pub(super) fn title(&self) -> &'a str {
        self.name.unwrap_or(kind(self.nurbs))
    }
}

/// An outline that leaves something out.
fn trimmed(outline: &Outline) -> Option<&Outline> {
    Some(outline).filter(|it| !it.is_whole())
}

fn kind(nurbs: &Nurbs) -> &'static str {
    match nurbs.v {
        None => "curve",
        Some(_) => "surface",
    }
}

/// The number of curves and surfaces.
fn count(shapes: &[Shape<'_>]) -> String {
    let surfaces = shapes.iter().filter(|it| it.nurbs.v.is_some()).count();
    let counted = |count: usize, kind: &str| match count {
        1 => format!("1 {kind}"),
        _ => format!("{count} {kind}s"),
    };
    let curves = counted(shapes.len() - surfaces, "curve");
    match surfaces {
        0 => curves,
        _ if surfaces == shapes.len() => counted(surfaces, "surface"),
        _ => format!("{curves} and {}", counted(surfaces, "surface")),
    }
}

fn describe(nurbs: &Nurbs) -> String {
    let rational = match nurbs.weights {
        None => "",
        Some(_) => "rational ",
    };
    match &nurbs.v {
        None => format!(
            "{rational}B-spline curve of degree {}, {} control points",
            nurbs.u.degree,
            nurbs.rows()
        ),
        Some(v) => format!(
            "{rational}B-spline surface of degree {} x {}, {} x {} control points",
            nurbs.u.degree,
            v.degree,
            nurbs.rows(),
            nurbs.columns()
        ),
    }
}
