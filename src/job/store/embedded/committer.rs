//! Commits, and the treatment of failed ones.
//!
//! A disk that fails in the middle of a commit does not report whether the commit is on it. So each commit writes its
//! number, and when the database is open again, that number shows if the commit was done: its changes succeed or fail
//! together with it. Where the database cannot be opened again, the changes fail; as soon as it can, new jobs among
//! them that are there after all are removed before anything else is done.

use std::sync::Arc;

use tracing::{error, warn};
use uuid::Uuid;

use super::database::JobDatabase;
use super::ended::Ended;
use super::error::{catch_panic, not_open};
use super::transaction::{EndedChange, Transaction};
use super::usage::Usage;
use crate::job::store::StoreError;

/// Runs transactions, one after the other.
pub(super) struct Committer {
    database: Arc<JobDatabase>,
    ended: Ended,
    usage: Usage,
    /// The number of the last attempt.
    number: u64,
    /// A failed attempt whose commit may have been done.
    doubt: Option<Attempt>,
    /// Jobs that were refused and are there, to be removed by the next transaction.
    refused: Vec<Uuid>,
}

/// A transaction whose commit was begun, with changes of the bookkeeping for after it.
struct Attempt {
    number: u64,
    changes: Vec<EndedChange>,
    usage: Usage,
    inserted: Vec<Uuid>,
}

/// A transaction that was committed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Committed {
    /// True if it has removed jobs: there may be space again.
    pub(super) has_removed: bool,
}

impl Committer {
    /// A database in which nothing was counted yet.
    pub(super) fn new(database: Arc<JobDatabase>) -> Result<Self, StoreError> {
        Ok(Self {
            number: database.last_commit()?,
            database,
            ended: Ended::default(),
            usage: Usage::default(),
            doubt: None,
            refused: Vec::new(),
        })
    }

    /// Does everything or nothing, perhaps more than once; `inserted` are the new jobs among it. If it fails,
    /// the database is opened again.
    pub(super) fn transact(
        &mut self,
        inserted: &[Uuid],
        mut work: impl FnMut(&mut Transaction<'_>) -> Result<(), StoreError>,
    ) -> Result<Committed, StoreError> {
        self.ensure_open()?;
        match self.attempt_and_settle(inserted, &mut work) {
            // An earlier error of a reader.
            Err(StoreError::Unusable(_)) if self.doubt.is_none() && self.database.is_open() => {
                self.attempt_and_settle(inserted, &mut work)
            }
            done => done,
        }
    }

    /// Opens the database if it is closed after an error.
    pub(super) fn ensure_open(&mut self) -> Result<(), StoreError> {
        if self.doubt.is_none() && self.database.is_open() {
            return Ok(());
        }
        let answered = self.doubt.as_ref().map(|it| it.inserted.clone());
        if self.reopen()?.is_some() {
            warn!("a commit that had failed is stored, and its new jobs are removed");
            self.refused.extend(answered.into_iter().flatten());
        }
        Ok(())
    }

    fn attempt_and_settle(
        &mut self,
        inserted: &[Uuid],
        work: &mut impl FnMut(&mut Transaction<'_>) -> Result<(), StoreError>,
    ) -> Result<Committed, StoreError> {
        let error = match self.attempt(inserted, work) {
            Ok(committed) => return Ok(committed),
            Err(error) => error,
        };
        match self.reopen() {
            Ok(Some(committed)) => {
                warn!(%error, "a commit that reported a failure is stored");
                Ok(committed)
            }
            Ok(None) => Err(error),
            Err(reason) => {
                error!(error = %reason, "the store could not be opened again");
                Err(error)
            }
        }
    }

    fn attempt(
        &mut self,
        inserted: &[Uuid],
        work: &mut impl FnMut(&mut Transaction<'_>) -> Result<(), StoreError>,
    ) -> Result<Committed, StoreError> {
        self.number += 1;
        let database = Arc::clone(&self.database);
        let committed = catch_panic(|| {
            let redb = database.redb();
            let write = redb.as_ref().ok_or_else(not_open)?.begin_write()?;
            let (usage, now) = (self.usage.clone(), database.clock.measured());
            let mut transaction = Transaction::open(&write, &self.ended, usage, now)?;
            for id in &self.refused {
                transaction.remove(*id)?;
            }
            work(&mut transaction)?;
            transaction.number(self.number)?;
            self.doubt = Some(Attempt {
                number: self.number,
                changes: std::mem::take(&mut transaction.changes),
                usage: std::mem::take(&mut transaction.usage),
                inserted: inserted.to_vec(),
            });
            drop(transaction);
            Ok(write.commit()?)
        });
        committed.and_then(|done| done)?;
        Ok(self.note())
    }

    /// Opens the database again. `Some` if the unknown attempt was done.
    fn reopen(&mut self) -> Result<Option<Committed>, StoreError> {
        self.database.reopen()?;
        let last = self.database.last_commit()?;
        if self.doubt.as_ref().is_some_and(|it| it.number == last) {
            return Ok(Some(self.note()));
        }
        self.doubt = None;
        Ok(None)
    }

    /// The attempt was done.
    fn note(&mut self) -> Committed {
        let mut has_removed = false;
        if let Some(attempt) = self.doubt.take() {
            self.refused.clear();
            self.usage = attempt.usage;
            for change in attempt.changes {
                match change {
                    EndedChange::Add { at, id, bytes } => {
                        self.database.clock.see(at);
                        self.ended.add(at, id, bytes);
                    }
                    EndedChange::Remove { at, id } => {
                        self.ended.remove(at, id);
                        has_removed = true;
                    }
                }
            }
        }
        Committed { has_removed }
    }
}
