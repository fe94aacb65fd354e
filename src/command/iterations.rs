//! Files of all iterations.

use std::fs;
use std::path::Path;

use super::client::Client;
use super::failure::Failure;
use super::file_query::FileQuery;
use super::outputs::{OutputFormat, Place, write};
use crate::config::fit_arguments::FitArguments;

/// The default limit of the number of files.
const MAX_FILES: usize = 1000;

/// Makes the directory before the fit begins, so that errors are found early.
pub(super) fn prepare(directory: &Path) -> Result<(), Failure> {
    match fs::create_dir(directory) {
        Err(_) if directory.is_dir() => Ok(()),
        Err(reason) => Err(Failure::usage(format!(
            "--iterations {}: {reason}",
            directory.display()
        ))),
        Ok(()) => Ok(()),
    }
}

/// Writes iterations of a job up to the last one; returns their number and bytes.
pub(super) async fn write_all(
    client: &Client,
    arguments: &FitArguments,
    query: &FileQuery,
    (directory, format): (&Path, OutputFormat),
    last: usize,
) -> Result<(usize, u64), Failure> {
    let every = arguments.every.map(|every| every as usize);
    let every = every.unwrap_or_else(|| (last + 1).div_ceil(MAX_FILES).max(1));
    let mut numbers: Vec<usize> = (0..=last).step_by(every).collect();
    if numbers.last() != Some(&last) {
        numbers.push(last);
    }
    let digits = last.to_string().len();
    let job = client.job.get().map_or("", String::as_str);
    let mut bytes = 0;
    for k in &numbers {
        let name = format!("iteration-{k:0digits$}.{}", format.ending());
        let place = Place::File(directory.join(name));
        let suffix = format.suffix(query);
        let path = format!("{job}/iterations/{k}{suffix}");
        bytes += match client.get(&path, "*/*").await? {
            Ok(body) => write(&place, body).await?,
            Err(refusal) => return Err(Failure::Failed(format!("{place}: {}", refusal.detail))),
        };
    }
    Ok((numbers.len(), bytes))
}
