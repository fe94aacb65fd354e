//! The arguments of `piad fit`.

use std::path::PathBuf;

use bytesize::ByteSize;
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueHint};

use crate::model::named::Named;
use crate::model::stream::Samples;
use piad_files::export::{Style, Unit, Version};

/// The help below the flags.
const MORE: &str = "\
Input is recognised by what is in it: CSV and tables with blanks (with or without a header and comments), point clouds (XYZ, PTS, PCD, LAS), airfoils (.dat, Selig, Lednicer and MSES), GPX, KML, GeoJSON, DXF, SVG, G-code, meshes (PLY, STL, OBJ, OFF), ESRI grids, a JSON array of points, of rows of points or of rows of heights, or a whole job or batch as POST /v1/jobs and /v1/batch take them. Points are a surface where blank lines part their rows, where their x and y form a grid, or where --surface says so; points without an order are scattered points of a surface then. Meshes with faces are surfaces to the vertices of their largest piece.

Output is written as the ending of its name says: .json, .step (.stp), .iges (.igs), .obj, .gltf (.glb), .stl, .ply, .dxf, .svg, .geojson, .gpx, .csv. Without -o the result goes to the standard output. Files appear when they are complete; those that are there are overwritten.

Exit status: 0 converged; 1 not converged (files are written all the same), or failed; 2 wrong usage or data, reported with file and line; 130 interrupted.

Examples:
  piad fit wing.dat --tolerance 1e-4 -o wing.step
  piad fit grid.xyz --surface 40x60 --degree 3,3 -o grid.iges --plot error.svg
  piad fit scan.xyz --surface --control-points auto --tolerance 0.2 -o scan.iges
  cat points.csv | piad fit - --method chebyshev --format json > curve.json
  piad fit job.json --server https://fits.example.org --token-file token";

/// The input, the fit, and the outputs.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = MORE)]
pub struct FitArguments {
    /// File of points or of a job; - is the standard input. Several files are fitted separately, with outputs in the
    /// directory of -o.
    #[arg(value_name = "INPUT", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) input: Vec<PathBuf>,

    /// File to write, of the format of its ending; - is the standard output. May be given several times. A directory
    /// gets a file for each input, named after it.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Vec<PathBuf>,

    /// Format of the output, whatever the extension: json, step, iges, obj, gltf, stl, ply, dxf, svg, geojson, gpx or
    /// csv [default: that of the extension; json on the standard output].
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<String>,

    /// Largest allowed distance from the data, in their units [default: a millionth of their diagonal].
    #[arg(
        long,
        value_name = "DISTANCE",
        allow_negative_numbers = true,
        help_heading = "Fit"
    )]
    pub(crate) tolerance: Option<String>,

    /// Method: global, weighted, local, adaptive, extended, transpose, convex, chebyshev, direct or
    /// least_squares [default: global, or least_squares with --control-points and --trim].
    #[arg(long, value_name = "METHOD", help_heading = "Fit")]
    pub(crate) method: Option<String>,

    /// Degree; of a surface also in each direction, such as 3,2 [default: 3].
    #[arg(long, value_name = "DEGREE", help_heading = "Fit")]
    pub(crate) degree: Option<String>,

    /// The points are of a surface, with this many rows and columns, such as 40x60; without a value the file shows
    /// them, or the points are scattered.
    #[arg(long, value_name = "ROWSxCOLUMNS", num_args = 0..=1, value_parser = size, help_heading = "Fit")]
    pub(crate) surface: Option<Option<String>>,

    /// The parts of the file are sections of one surface: curves across it, with any numbers of points. Closed ones of a table
    /// that lie one behind the other are taken as that by themselves.
    #[arg(long, conflicts_with_all = ["surface", "part"], help_heading = "Fit")]
    pub(crate) sections: bool,

    /// The order of the points of a curve: given is that of the file, even if the points seem unordered; nearest puts
    /// them in the order in which they are near each other.
    #[arg(long, value_name = "ORDER", value_parser = PossibleValuesParser::new(["given", "nearest"]), help_heading = "Fit")]
    pub(crate) order: Option<String>,

    /// The columns of a table, by numbers from 1 or names: x=2,y=3, or t,q1:q7 with the times of the points as
    /// parameters.
    #[arg(long, value_name = "COLUMNS", help_heading = "Input")]
    pub(crate) columns: Option<String>,

    /// The part to fit of a file with several: its number from 1, or its name.
    #[arg(long, value_name = "PART", help_heading = "Input")]
    pub(crate) part: Option<String>,

    /// The piece of a mesh to fit, from 1 for the largest.
    #[arg(long, value_name = "NUMBER", help_heading = "Input")]
    pub(crate) piece: Option<String>,

    /// Basis: bspline, bernstein, said_ball or wang_ball [default: bspline].
    #[arg(long, value_name = "BASIS", help_heading = "Fit")]
    pub(crate) basis: Option<String>,

    /// Number of control points of a least-squares fit, such as 20, or 20x30 on surfaces; auto takes the
    /// fewest that the tolerance allows.
    #[arg(long, value_name = "NUMBER", help_heading = "Fit")]
    pub(crate) control_points: Option<String>,

    /// Smoothness of a least-squares fit of noisy points: a number such as 1e-9, or auto to estimate it from the
    /// noise.
    #[arg(long, value_name = "FAIRNESS", help_heading = "Fit")]
    pub(crate) fairness: Option<String>,

    /// A least-squares fit without outliers: points far from the predictions of their neighbours.
    #[arg(long, help_heading = "Fit")]
    pub(crate) robust: bool,

    /// Points at which a curve may have corners: their indices, such as 12,40, or auto, or an angle in degrees such as 30deg.
    #[arg(long, value_name = "CORNERS", help_heading = "Fit")]
    pub(crate) corners: Option<String>,

    /// The edges between the points are data, too: a curve within the tolerance of all edges, with as few control
    /// points as possible.
    #[arg(long, help_heading = "Fit")]
    pub(crate) polyline: bool,

    /// A surface trimmed to the outline of its points in STEP, IGES, meshes and drawings. The points are at
    /// most this distance from it [default: about their distance from each other].
    #[arg(long, value_name = "DISTANCE", num_args = 0..=1, allow_negative_numbers = true, value_parser = distance, help_heading = "Fit")]
    pub(crate) trim: Option<Option<String>>,

    /// End conditions: estimated, repeated or natural, or JSON [default: estimated].
    #[arg(long, value_name = "ENDS", help_heading = "Fit")]
    pub(crate) ends: Option<String>,

    /// Last iteration [default: 1000].
    #[arg(long, value_name = "NUMBER", help_heading = "Fit")]
    pub(crate) max_iterations: Option<String>,

    /// A periodic fit; the first point is not repeated at the end.
    #[arg(long, help_heading = "Fit")]
    pub(crate) closed: bool,

    /// Any other field of a job, by its path, such as curve.parameters=centripetal or method.omega=1.2.
    /// May be given several times.
    #[arg(long, value_name = "PATH=VALUE", help_heading = "Fit")]
    pub(crate) set: Vec<String>,

    /// File with fields of a job in JSON, which flags and --set override.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Fit")]
    pub(crate) json: Option<PathBuf>,

    /// Largest input, and largest file of --json.
    #[arg(long, value_name = "SIZE", default_value = "1GiB")]
    pub(crate) max_input: ByteSize,

    /// Unit of length that STEP and IGES files declare [default: mm].
    #[arg(long, value_name = "UNIT", value_parser = PossibleValuesParser::new(Unit::names()))]
    pub(crate) units: Option<String>,

    /// Contents of SVG files: drawing, of the fit with its data, or path, of the curve alone for editors and plotters
    /// [default: drawing; path of several parts].
    #[arg(long, value_name = "STYLE", conflicts_with = "plot", value_parser = PossibleValuesParser::new(Style::names()))]
    pub(crate) svg: Option<String>,

    /// Version of DXF files: r12 with polylines, which all programs read, or r2000 with exact splines [default: r12].
    #[arg(long, value_name = "VERSION", value_parser = PossibleValuesParser::new(Version::names()))]
    pub(crate) dxf: Option<String>,

    /// Number of samples in files with samples, such as 200, or 40x60 of surfaces.
    #[arg(long, value_name = "NUMBER")]
    pub(crate) samples: Option<String>,

    /// Largest distance between the samples of a curve, in units of the data; the samples are then equidistant.
    #[arg(long, value_name = "DISTANCE", conflicts_with = "samples")]
    pub(crate) spacing: Option<String>,

    /// Latitude and longitude of the origin of the first two coordinates, such as 48.1,11.5, for GeoJSON and GPX files
    /// [default: that of an input with longitudes and latitudes].
    #[arg(long, value_name = "PLACE", allow_negative_numbers = true)]
    pub(crate) origin: Option<String>,

    /// Directory for a file of each iteration, in the format of the first output: iteration-00.step and so
    /// on, all numbers with the same number of digits. It is created if it is missing.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) iterations: Option<PathBuf>,

    /// With --iterations: every n-th iteration, and the last [default: the least n for at most 1000 files].
    #[arg(long, value_name = "NUMBER", requires = "iterations", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) every: Option<u32>,

    /// Drawing (SVG) of the fit, coloured by its distance from the data.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) plot: Option<PathBuf>,

    /// The shape of the fit (JSON): curvature at samples (--samples, --spacing) and its extremes, length or area,
    /// continuity at knots.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) shape: Option<PathBuf>,

    /// Print only errors.
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Fit on this server instead of in this process.
    #[arg(long, value_name = "URL", value_hint = ValueHint::Url)]
    pub(crate) server: Option<String>,

    /// File with the bearer token for the server [default: the token in the variable PIAD_TOKEN, if any].
    #[arg(long, value_name = "FILE", requires = "server", value_hint = ValueHint::FilePath)]
    pub(crate) token_file: Option<PathBuf>,
}

/// A number.
fn distance(text: &str) -> Result<String, String> {
    match text.parse::<f64>() {
        Ok(_) => Ok(text.to_owned()),
        Err(_) => {
            Err("not a distance such as 0.5; a file comes before --trim without a value".to_owned())
        }
    }
}

/// Rows and columns, such as 40x60.
fn size(text: &str) -> Result<String, String> {
    match Samples::of_text(text) {
        Some(Samples::Grid(..)) => Ok(text.to_owned()),
        _ => Err(
            "not rows and columns such as 40x60; a file comes before --surface without a value"
                .to_owned(),
        ),
    }
}
