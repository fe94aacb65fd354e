//! Reading all jobs of a store that may be damaged, without changing it.

use std::panic;
use std::path::Path;

use super::counting::{counter, jobs};
use super::opening::open;
use crate::config::Storage;
use crate::job::store::copy::Records;
use crate::job::store::embedded::salvage::{Salvage, Salvaged};
use crate::job::store::{Store, StoreError};
use crate::terminal::say;

/// A store that may be damaged.
pub(super) enum Source {
    File(Box<Salvage>),
    Database(Store),
}

/// The readable contents.
#[derive(Debug, Default)]
pub(super) struct Reading {
    /// Jobs that could be read, and those of them that have lost their end.
    pub good: usize,
    pub endless: usize,
    /// Jobs that could not be read.
    pub lost: usize,
    /// The errors of each of these two kinds.
    pub reasons: Vec<String>,
    /// The errors of the file outside its jobs.
    pub complaint: Option<String>,
}

impl Source {
    pub(super) async fn open(storage: &Storage) -> Result<Self, String> {
        match storage {
            Storage::Directory(path) => Ok(Self::File(open_file(path)?)),
            storage => open(storage).await.map(Self::Database),
        }
    }

    /// Reads all jobs, and hands on each that can be read.
    pub(super) async fn read_all(
        &self,
        mut take: impl AsyncFnMut(Salvaged) -> Result<(), String>,
    ) -> Result<Reading, String> {
        let store = match self {
            Self::File(file) => return read_file(file, take).await,
            Self::Database(store) => store,
        };
        let mut reading = Reading::default();
        let bar = counter();
        let mut records = Records::of(store);
        while let Some(record) = records.next().await.map_err(|error| error.to_string())? {
            match store.whole(record).await {
                Ok(job) => reading.add(Salvaged { job, lost: None }, &mut take).await?,
                Err(error) => reading.miss(&error),
            }
            bar.set_message(jobs(reading.good));
        }
        bar.finish_and_clear();
        Ok(reading)
    }
}

/// Opens the file in a directory.
pub(super) fn open_file(directory: &Path) -> Result<Box<Salvage>, String> {
    be_silent_of_damage();
    let file = Salvage::open(directory).map_err(|error| error.to_string())?;
    Ok(Box::new(file))
}

/// Reads all jobs of a file, and hands on each that can be read.
pub(super) async fn read_file(
    file: &Salvage,
    mut take: impl AsyncFnMut(Salvaged) -> Result<(), String>,
) -> Result<Reading, String> {
    let mut reading = Reading::default();
    let bar = counter();
    reading.complaint = file.complaint().map(str::to_owned);
    for id in file.ids() {
        match file.job(id) {
            Ok(job) => reading.add(job, &mut take).await?,
            Err(error) => reading.miss(&error),
        }
        bar.set_message(jobs(reading.good));
    }
    bar.finish_and_clear();
    Ok(reading)
}

/// Damage makes the database panic at times, which is reported in other words.
fn be_silent_of_damage() {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |what| {
        if what
            .location()
            .is_none_or(|at| !at.file().contains("/redb-"))
        {
            usual(what);
        }
    }));
}

/// The errors of a store that works.
fn plain(error: &StoreError) -> String {
    match error {
        StoreError::Failed(reason) => reason.clone(),
        error => error.to_string(),
    }
}

impl Reading {
    async fn add(
        &mut self,
        job: Salvaged,
        take: &mut impl AsyncFnMut(Salvaged) -> Result<(), String>,
    ) -> Result<(), String> {
        self.good += 1;
        if let Some(error) = &job.lost {
            self.endless += 1;
            self.reasons
                .push(format!("{}; it can be computed again", plain(error)));
        }
        take(job).await
    }

    fn miss(&mut self, error: &StoreError) {
        self.lost += 1;
        self.reasons.push(plain(error));
    }

    /// Prints the damaged jobs and their errors.
    pub(super) fn tell_reasons(&self) {
        self.reasons.iter().for_each(say);
    }

    /// Reports whether a store is whole; if it is not, says why and lists what could be read.
    pub(super) fn verdict(&self, storage: &Storage) -> Result<String, String> {
        self.tell_reasons();
        let summary = self.summary();
        if self.is_whole() {
            return Ok(format!("{storage:?}: {summary}, nothing is damaged"));
        }
        Err(summary)
    }

    /// Returns true if everything could be read, and there is no other error.
    pub(super) fn is_whole(&self) -> bool {
        self.endless == 0 && self.lost == 0 && self.complaint.is_none()
    }

    /// The readable contents, in words.
    pub(super) fn summary(&self) -> String {
        let mut summary = match self.lost {
            0 => format!("{} can be read", jobs(self.good)),
            lost => format!("{} of {} can be read", self.good, jobs(self.good + lost)),
        };
        if self.endless > 0 {
            summary += &format!(", {} of them without the result", self.endless);
        }
        if let Some(complaint) = &self.complaint {
            summary += &format!("; {complaint}");
        }
        summary
    }
}
