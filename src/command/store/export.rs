//! `piad store export`: the jobs of a store as files of JSON.

use std::fs;
use std::path::Path;

use super::counting::jobs;
use super::source::Source;
use crate::api::json::view;
use crate::config::Storage;
use crate::job::store::embedded::salvage::Salvaged;
use crate::model::stream::form::{Digits, Encoding, Form, View};

/// Writes `ID.json`, which requests the same job again, and `ID.result.json` of each that has a result.
pub(super) async fn export(storage: &Storage, directory: &Path) -> Result<String, String> {
    let source = Source::open(storage).await?;
    let of_file = |reason| format!("{directory:?} cannot be written: {reason}");
    fs::create_dir_all(directory).map_err(of_file)?;
    let write = async |salvaged: Salvaged| write(&salvaged, directory).map_err(of_file);
    let reading = source.read_all(write).await?;
    reading.tell_reasons();
    if reading.is_whole() {
        return Ok(format!("{} written to {directory:?}", jobs(reading.good)));
    }
    let summary = reading.summary();
    Err(format!(
        "{storage:?} is damaged: {summary}, and stand in {directory:?}"
    ))
}

fn write(salvaged: &Salvaged, directory: &Path) -> std::io::Result<()> {
    let (outline, problem) = (&salvaged.job.record.outline, &salvaged.job.problem);
    let id = outline.id;
    let input = view::input::input(outline, problem);
    fs::write(directory.join(format!("{id}.json")), input)?;
    let status = &salvaged.job.record.status;
    if let (Some(result), Some(levels)) = (&salvaged.job.result, status.levels) {
        let frame = result.clone().frame(levels.last, problem.clone());
        let form = Form::new(View::ControlPoints, Encoding::Json, Digits::Full);
        let result = view::result::result(outline, status, &frame, &form).whole();
        fs::write(directory.join(format!("{id}.result.json")), result)?;
    }
    Ok(())
}
