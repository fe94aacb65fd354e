//! `piad store copy`: the jobs of a server in another store.

use super::counting::{counter, jobs};
use super::opening::open;
use crate::config::Storage;
use crate::job::store::copy::copy as copy_jobs;

/// Copies all jobs.
pub(super) async fn copy(from: &Storage, to: &Storage) -> Result<String, String> {
    if from == to {
        return Err("both stores are the same".to_owned());
    }
    if let Storage::Directory(path) = from
        && !path.exists()
    {
        return Err(format!("there is no store in {path:?}"));
    }
    let (from, to) = (open(from).await?, open(to).await?);
    let bar = counter();
    let tell = |count: usize| bar.set_message(jobs(count));
    let copied = copy_jobs(&from, &to, tell).await;
    bar.finish_and_clear();
    copied
        .map(|count| format!("{} copied", jobs(count)))
        .map_err(|error| error.to_string())
}
