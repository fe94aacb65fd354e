//! `piad store repair`: a new file with all that can be read of a damaged one.

use super::source::{open_file, read_file};
use crate::config::Storage;
use crate::job::store::copy::Batch;
use crate::job::store::embedded::salvage::{Salvage, Salvaged};

/// Replaces a damaged file by a new one; the old one stays beside it.
pub(super) async fn repair(storage: &Storage) -> Result<String, String> {
    let Storage::Directory(directory) = storage else {
        return Err("only files are repaired: databases have backups of their own".to_owned());
    };
    let file = open_file(directory)?;
    let reading = read_file(&file, async |_| Ok(())).await?;
    let summary = match reading.verdict(storage) {
        Ok(whole) => return Ok(whole),
        Err(summary) => summary,
    };
    if reading.good == 0 {
        let advice = "restore it from a backup, or move it away to start without its jobs";
        return Err(format!(
            "{storage:?} cannot be repaired: {summary}: {advice}"
        ));
    }
    let failed = |error| format!("{storage:?} could not be repaired: {error}");
    let fresh = Salvage::make(directory).map_err(|error| failed(error.to_string()))?;
    let mut batch = Batch::to(&fresh);
    let put = async |salvaged: Salvaged| {
        let kept = batch.put(salvaged.job).await;
        kept.map_err(|error| failed(error.to_string()))
    };
    read_file(&file, put).await?;
    let ended = batch.end().await;
    ended.map_err(|error| failed(error.to_string()))?;
    let kept = file.replace(directory, fresh);
    let kept = kept.map_err(|error| failed(error.to_string()))?;
    Ok(format!(
        "{storage:?} is repaired: {summary}; the damaged file is {kept:?}"
    ))
}
