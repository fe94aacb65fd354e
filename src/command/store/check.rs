//! `piad store check`: whether everything in a store can be read.

use super::source::Source;
use crate::config::Storage;

/// Reads everything, and reports errors.
pub(super) async fn check(storage: &Storage) -> Result<String, String> {
    let source = Source::open(storage).await?;
    let reading = source.read_all(async |_| Ok(())).await?;
    let advice = match (reading.good, storage) {
        (0, _) => "restore it from a backup",
        (_, Storage::Directory(_)) => "`piad store repair` keeps what can be read",
        _ => "restore the database from a backup, or delete these jobs",
    };
    let damaged = |summary| format!("{storage:?} is damaged: {summary}: {advice}");
    reading.verdict(storage).map_err(damaged)
}
