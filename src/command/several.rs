//! Many files, each fitted by itself into a file of a directory.

use std::fs;
use std::path::{Path, PathBuf};

use super::client::Current;
use super::failure::Failure;
use super::outputs::{self, Output};
use super::progress::Progress;
use super::single;
use super::table::{self, Row};
use crate::config::fit_arguments::FitArguments;

/// Fits and writes files one after the other. A failure does not stop the others.
pub(super) async fn fit(
    arguments: &FitArguments,
    inputs: &[PathBuf],
    current: &Current,
) -> Result<Vec<Row>, Failure> {
    let directory = directory(arguments)?;
    let output = |input: &PathBuf| outputs::in_directory(directory, input, arguments);
    let outputs: Vec<Output> = inputs.iter().map(output).collect::<Result<_, _>>()?;
    outputs::check(&outputs)?;
    outputs::check_choices(arguments, &outputs)?;
    let mut progress = Progress::of_many(arguments.quiet, inputs.len());
    let mut rows = Vec::new();
    for (index, (input, output)) in inputs.iter().zip(&outputs).enumerate() {
        let name = input.display().to_string();
        progress.item(index, &name);
        let outputs = std::slice::from_ref(output);
        match single::fit(arguments, input, outputs, current, true).await {
            Ok(fitted) => rows.extend(fitted.into_iter().map(|row| row.within(&name))),
            Err(failure) => rows.push(Row::failed(name, &failure)),
        }
    }
    progress.end();
    table::report(&format!("{} files", inputs.len()), &rows, arguments.quiet);
    Ok(rows)
}

/// The directory of the outputs, which is made if it is missing.
fn directory(arguments: &FitArguments) -> Result<&Path, Failure> {
    let [directory] = &arguments.output[..] else {
        let detail = "several files are fitted into one directory: name it with -o DIR/";
        return Err(Failure::usage(detail));
    };
    for (flag, is_given) in [
        ("--plot", arguments.plot.is_some()),
        ("--shape", arguments.shape.is_some()),
        ("--iterations", arguments.iterations.is_some()),
    ] {
        if is_given {
            return Err(Failure::usage(format!("{flag}: it is for one file")));
        }
    }
    let wrong = |reason: &dyn std::fmt::Display| {
        Failure::usage(format!("-o {}: {reason}", directory.display()))
    };
    if directory.is_file() {
        return Err(wrong(
            &"several files are fitted into a directory, and this is a file",
        ));
    }
    fs::create_dir_all(directory).map_err(|reason| wrong(&reason))?;
    Ok(directory)
}
