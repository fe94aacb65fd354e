//! `piad store repair`: a new file with all that can be read of a damaged one.

use super::source::Source;
use crate::config::Storage;
use crate::job::store::embedded::salvage::{Salvage, Salvaged};

/// Puts a new file in the place of a damaged one, which stays beside it.
pub(super) async fn repair(storage: &Storage) -> Result<String, String> {
    let Storage::Directory(directory) = storage else {
        return Err("only files are repaired: databases have backups of their own".to_owned());
    };
    let source = Source::open(storage).await?;
    let reading = source.read_all(async |_| Ok(())).await?;
    reading.tell_reasons();
    let summary = reading.summary();
    if reading.is_whole() {
        return Ok(format!("{storage:?}: {summary}, nothing is damaged"));
    }
    if reading.good == 0 {
        let advice = "restore it from a backup, or move it away to start without its jobs";
        return Err(format!(
            "{storage:?} cannot be repaired: {summary}: {advice}"
        ));
    }
    let told = |error| format!("{storage:?} could not be repaired: {error}");
    let fresh = Salvage::make(directory).map_err(|error| told(error.to_string()))?;
    let put = async |salvaged: Salvaged| {
        let kept = fresh.put(salvaged.job).await;
        kept.map_err(|error| told(error.to_string()))
    };
    source.read_all(put).await?;
    let kept = match source {
        Source::File(file) => file.replace(directory, fresh),
        Source::Database(_) => return Err("this is no file".to_owned()),
    };
    let kept = kept.map_err(|error| told(error.to_string()))?;
    Ok(format!(
        "{storage:?} is repaired: {summary}; the damaged file is {kept:?}"
    ))
}
