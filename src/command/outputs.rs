//! Outputs: files and formats, written completely or not at all.

use std::collections::HashSet;
use std::fmt;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use axum::body::Body;
use http_body_util::BodyExt;
use tempfile::NamedTempFile;

use super::failure::Failure;
use super::file_query::FileQuery;
use super::point_kind::PointKind;
use crate::config::fit_arguments::FitArguments;
use piad_files::export::shape::NoShape;
use piad_files::export::{Format, check_shape};

/// The format whose samples a shape has.
const SAMPLED: Format = Format::Csv;

/// The format of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OutputFormat {
    /// The JSON of a result.
    Json,
    /// A file.
    File(Format),
    /// The JSON of a shape.
    Shape,
}

impl OutputFormat {
    /// The format with this name or ending.
    fn named(text: &str) -> Option<Self> {
        match text.to_ascii_lowercase().as_str() {
            "json" => Some(Self::Json),
            text => text.parse().ok().map(Self::File),
        }
    }

    /// The ending of its names.
    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::Json | Self::Shape => "json",
            Self::File(format) => format.extension(),
        }
    }

    /// The path of a result or an iteration, relative to it.
    pub(super) fn suffix(self, query: &FileQuery) -> String {
        match self {
            Self::Json | Self::Shape => String::new(),
            Self::File(format) => format!("/{format}?{}", query.of(format)),
        }
    }

    /// The path relative to a job.
    pub(super) fn path(self, query: &FileQuery) -> String {
        match self {
            Self::Shape => format!("/shape?{}", query.of(SAMPLED)),
            Self::Json | Self::File(_) => format!("/result{}", self.suffix(query)),
        }
    }

    /// The format with the same options.
    fn choices(self) -> Option<Format> {
        match self {
            Self::Json => None,
            Self::File(format) => Some(format),
            Self::Shape => Some(SAMPLED),
        }
    }

    /// The error of results for these points in this format.
    fn check(self, points: &PointKind, query: &FileQuery) -> Result<(), String> {
        match self {
            Self::Shape if points.dimension < 2 => return Err(NoShape::OneCoordinate.to_string()),
            Self::File(format) => check_shape(format, points.surface, points.dimension)
                .map_err(|reason| reason.to_string())?,
            Self::Json | Self::Shape => {}
        }
        match self.choices() {
            None => Ok(()),
            Some(format) => query.options(format, points.surface).map(drop),
        }
    }
}

/// The destination of an output.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Place {
    /// The standard output.
    Standard,
    /// A file.
    File(PathBuf),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standard => f.write_str("<stdout>"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

/// An output.
#[derive(Clone, Debug)]
pub(super) struct Output {
    /// Its destination.
    pub place: Place,
    /// Its format.
    pub format: OutputFormat,
}

/// The requested outputs, if all of them can be written as far as known before the fit.
pub(super) fn outputs(arguments: &FitArguments) -> Result<Vec<Output>, Failure> {
    let given = given_format(arguments)?;
    let mut outputs = Vec::new();
    for path in &arguments.output {
        outputs.push(output(path, given)?);
    }
    if let Some(path) = &arguments.plot {
        outputs.push(Output {
            place: place(path),
            format: OutputFormat::File(Format::Svg),
        });
    }
    if let Some(path) = &arguments.shape {
        outputs.push(Output {
            place: place(path),
            format: OutputFormat::Shape,
        });
    }
    // A drawing or a shape alone is not a result.
    if arguments.output.is_empty() {
        let standard = Output {
            place: Place::Standard,
            format: given.unwrap_or(OutputFormat::Json),
        };
        outputs.insert(0, standard);
    }
    check(&outputs)?;
    check_choices(arguments, &outputs)?;
    Ok(outputs)
}

/// Returns true if files of a format have an option.
type Has = fn(Format) -> bool;

/// Refuses options of files that no output has.
pub(super) fn check_choices(arguments: &FitArguments, outputs: &[Output]) -> Result<(), Failure> {
    let choices: [(&str, &Option<String>, Has, &str); 6] = [
        (
            "--units",
            &arguments.units,
            Format::has_unit,
            "STEP or IGES, which alone have a unit that can be chosen",
        ),
        ("--svg", &arguments.svg, Format::has_style, "SVG"),
        ("--dxf", &arguments.dxf, Format::has_version, "DXF"),
        (
            "--samples",
            &arguments.samples,
            Format::has_samples,
            "of a format with samples",
        ),
        (
            "--spacing",
            &arguments.spacing,
            Format::has_spacing,
            "of a format with samples along a curve",
        ),
        (
            "--origin",
            &arguments.origin,
            Format::has_origin,
            "GeoJSON or GPX",
        ),
    ];
    for (flag, value, has, what) in choices {
        let is_about = |output: &Output| output.format.choices().is_some_and(has);
        if let Some(value) = value
            && !outputs.iter().any(is_about)
        {
            return Err(Failure::usage(format!(
                "{flag} {value}: no output is {what}"
            )));
        }
    }
    Ok(())
}

/// Returns true if the results go to a directory, each into a file named after its input.
pub(super) fn is_directory(arguments: &FitArguments) -> bool {
    let names_one = |path: &Path| path.is_dir() || path.to_string_lossy().ends_with(['/', '\\']);
    arguments.output.iter().any(|path| names_one(path))
}

/// The output for an input in a directory: a file of the same name with the ending of its format.
pub(super) fn in_directory(
    directory: &Path,
    input: &Path,
    arguments: &FitArguments,
) -> Result<Output, Failure> {
    let stem = input.file_stem().unwrap_or(input.as_os_str());
    let format = given_format(arguments)?.unwrap_or(OutputFormat::Json);
    let mut name = stem.to_owned();
    name.push(".");
    name.push(format.ending());
    Ok(Output {
        place: Place::File(directory.join(name)),
        format,
    })
}

/// The format of `--format`.
fn given_format(arguments: &FitArguments) -> Result<Option<OutputFormat>, Failure> {
    let given = arguments.format.as_deref().map(|name| {
        let no_format = || Failure::usage(format!("--format {name}: {}", formats("there are")));
        OutputFormat::named(name).ok_or_else(no_format)
    });
    given.transpose()
}

/// Checks that results for these points can be written in the formats of all outputs, with their options. The points
/// are read only if a format has restrictions.
pub(super) fn check_formats(
    outputs: &[Output],
    query: &mut FileQuery,
    points: impl FnOnce() -> Option<PointKind>,
) -> Result<(), Failure> {
    let as_usual = query.of(Format::Csv).is_empty();
    let files = outputs.iter().filter(|output| match output.format {
        OutputFormat::Json => false,
        // Tables have no restrictions.
        OutputFormat::File(Format::Csv) => !as_usual,
        OutputFormat::File(_) | OutputFormat::Shape => true,
    });
    let mut files = files.peekable();
    let Some(points) = files.peek().and_then(|_| points()) else {
        return Ok(());
    };
    query.set_origin(points.origin);
    let refusals = files.filter_map(|output| {
        let checked = output.format.check(&points, query);
        Some(format!("{}: {}", output.place, checked.err()?))
    });
    let refusals: Vec<String> = refusals.collect();
    match refusals.is_empty() {
        true => Ok(()),
        false => Err(Failure::Usage(refusals)),
    }
}

fn output(path: &Path, given: Option<OutputFormat>) -> Result<Output, Failure> {
    let place = place(path);
    let by_name = || match &place {
        Place::Standard => Some(OutputFormat::Json),
        Place::File(path) => OutputFormat::named(path.extension()?.to_str()?),
    };
    let format = given.or_else(by_name);
    let format = format.ok_or_else(|| {
        let formats = formats("its extension is none of");
        Failure::usage(format!("{place}: {formats}; --format says the format"))
    })?;
    Ok(Output { place, format })
}

fn place(path: &Path) -> Place {
    match path.to_str() {
        Some("-") => Place::Standard,
        _ => Place::File(path.to_owned()),
    }
}

fn formats(before: &str) -> String {
    let names = Format::ALL.map(Format::name).join(", ");
    format!("{before} json, {names}")
}

/// Checks that files can be written at the requested paths, and that no two share one.
pub(super) fn check(outputs: &[Output]) -> Result<(), Failure> {
    let mut places = HashSet::new();
    for Output { place, .. } in outputs {
        if !places.insert(place) {
            return Err(Failure::usage(format!("{place}: it is given twice")));
        }
        if let Place::File(path) = place {
            let wrong = |detail: &str| Err(Failure::usage(format!("{place}: {detail}")));
            if path.is_dir() {
                return wrong("it is a directory");
            }
            if !directory(path).is_dir() {
                let directory = directory(path).display().to_string();
                return wrong(&format!("there is no directory {directory}"));
            }
        }
    }
    Ok(())
}

/// The directory that a file is in.
fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => path,
    }
}

/// Writes a body; returns its number of bytes.
pub(super) async fn write(place: &Place, mut body: Body) -> Result<u64, Failure> {
    let failed = |reason: &io::Error| match (place, reason.kind()) {
        (Place::Standard, io::ErrorKind::BrokenPipe) => Failure::Closed,
        _ => Failure::of_file(place, reason),
    };
    let mut sink = Sink::new(place).map_err(|reason| failed(&reason))?;
    let mut count = 0;
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|reason| Failure::Failed(format!("{place}: {reason}")))?;
        let data = frame.into_data().unwrap_or_default();
        count += data.len() as u64;
        sink.write(&data).map_err(|reason| failed(&reason))?;
    }
    sink.finish().map_err(|reason| failed(&reason))?;
    Ok(count)
}

/// A file while it is written.
enum Sink {
    Standard,
    /// A device or a pipe, which cannot be replaced.
    Special(File),
    /// A temporary file beside the destination, to which it is renamed when it is complete. It is removed if it is
    /// dropped before.
    Beside(NamedTempFile, PathBuf),
}

impl Sink {
    fn new(place: &Place) -> io::Result<Self> {
        let Place::File(path) = place else {
            return Ok(Self::Standard);
        };
        // The target of a link is replaced, rather than the link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.clone());
        let before = fs::metadata(&path).ok();
        if before.as_ref().is_some_and(|it| !it.is_file()) {
            return Ok(Self::Special(File::options().write(true).open(path)?));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".piad-").suffix(".part");
        if let Some(permissions) = permissions(before.map(|it| it.permissions())) {
            builder.permissions(permissions);
        }
        let file = builder.tempfile_in(directory(&path))?;
        Ok(Self::Beside(file, path))
    }

    fn write(&mut self, data: &[u8]) -> io::Result<()> {
        match self {
            Self::Standard => io::stdout().lock().write_all(data),
            Self::Special(file) => file.write_all(data),
            Self::Beside(file, _) => file.write_all(data),
        }
    }

    fn finish(self) -> io::Result<()> {
        match self {
            Self::Standard => io::stdout().lock().flush(),
            Self::Special(mut file) => file.flush(),
            Self::Beside(file, path) => match file.persist(path) {
                Ok(_) => Ok(()),
                Err(error) => Err(error.error),
            },
        }
    }
}

/// The permissions of the replaced file, or of a new one.
#[cfg(unix)]
fn permissions(before: Option<Permissions>) -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt;
    Some(before.unwrap_or_else(|| Permissions::from_mode(0o666)))
}

#[cfg(not(unix))]
fn permissions(_: Option<Permissions>) -> Option<Permissions> {
    None
}
