//! The one thread that writes. Changes that arrive while a commit is being written go into the next one
//! together: a hundred clients that create jobs at the same time wait for one commit.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use tokio::sync::oneshot;
use tracing::{error, warn};

use super::super::StoreError;
use super::super::ended::Ended;
use super::change::{Change, Outcome};
use super::database::JobDatabase;
use super::disk_space::DiskSpace;
use super::error::{catch_panic, closed};
use super::transaction::{EndedChange, Transaction};
use crate::job::counters::Counters;

/// The most points of jobs that go into one commit: they are in memory until it is done.
const POINTS_OF_COMMIT: usize = 2_000_000;

/// A change that is asked for, and where its outcome goes.
pub(super) struct WriteRequest {
    pub(super) change: Change,
    pub(super) reply: oneshot::Sender<Result<Outcome, StoreError>>,
}

impl WriteRequest {
    fn answer(self, outcome: Result<Outcome, StoreError>) {
        // Nobody may wait for it any more.
        let _ = self.reply.send(outcome);
    }
}

/// Sends changes to the thread, which ends when this is dropped.
pub(super) struct Writer {
    sender: Option<Sender<WriteRequest>>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    /// Recovers the jobs that were running in a crash, and starts the thread.
    pub(super) fn start(
        database: Arc<JobDatabase>,
        disk_space: Option<DiskSpace>,
        counters: Counters,
    ) -> Result<Self, StoreError> {
        let mut writer = WriterThread {
            database,
            disk_space,
            counters,
            ended: Ended::default(),
        };
        writer.recover()?;
        let (sender, receiver) = channel();
        let thread = thread::Builder::new()
            .name("piad-store".to_owned())
            .spawn(move || writer.serve(&receiver))
            .map_err(|reason| StoreError::Failed(reason.to_string()))?;
        Ok(Self {
            sender: Some(sender),
            thread: Some(thread),
        })
    }

    pub(super) fn send(&self, request: WriteRequest) -> Result<(), StoreError> {
        let sender = self.sender.as_ref().ok_or_else(ended)?;
        sender.send(request).map_err(|_| ended())
    }
}

impl Drop for Writer {
    /// All changes that were sent are done before the store is gone.
    fn drop(&mut self) {
        drop(self.sender.take());
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            error!("the thread of the store panicked");
        }
    }
}

/// The thread has ended.
pub(super) fn ended() -> StoreError {
    StoreError::Failed("the store is closed".to_owned())
}

/// What the thread works with.
struct WriterThread {
    database: Arc<JobDatabase>,
    /// `None` for a store in memory.
    disk_space: Option<DiskSpace>,
    counters: Counters,
    ended: Ended,
}

impl WriterThread {
    fn serve(&mut self, receiver: &Receiver<WriteRequest>) {
        while let Ok(first) = receiver.recv() {
            let mut points = first.change.points();
            let mut requests = vec![first];
            while points < POINTS_OF_COMMIT
                && let Ok(request) = receiver.try_recv()
            {
                points += request.change.points();
                requests.push(request);
            }
            let count = requests.len();
            if let Err(error) = self.commit(&mut requests) {
                warn!(%error, writes = count, "a commit failed");
                // One change that cannot be done must not take the others with it.
                for request in requests.drain(..) {
                    let failed = self.commit(&mut vec![request]);
                    // Whoever asked for it has been told.
                    drop(failed);
                }
            }
        }
    }

    /// Does the changes in one transaction and answers the requests. If that fails, a single request is
    /// answered with the error, and several are left to be tried one by one.
    fn commit(&mut self, requests: &mut Vec<WriteRequest>) -> Result<(), StoreError> {
        self.refuse_without_space(requests);
        if requests.is_empty() {
            return Ok(());
        }
        self.counters.commits.inc();
        self.counters.writes.inc_by(requests.len() as u64);
        let adds = requests.iter().any(|it| it.change.added_bytes().is_some());
        let leaves_slack = adds && self.disk_space.is_some();
        let committed = self.transact(|transaction| {
            let changes = requests.iter().map(|request| &request.change);
            let outcomes = changes.map(|change| transaction.apply(change, &self.ended));
            let outcomes = outcomes.collect::<Result<Vec<Outcome>, StoreError>>()?;
            if leaves_slack {
                transaction.leave_slack()?;
            }
            Ok(outcomes)
        });
        match committed {
            Ok((outcomes, ended)) => {
                self.count(ended);
                let removed = |outcome: &Outcome| matches!(outcome, Outcome::Removed(true));
                if outcomes.iter().any(removed) {
                    self.add_freed(0);
                }
                for (request, outcome) in requests.drain(..).zip(outcomes) {
                    request.answer(Ok(outcome));
                }
                Ok(())
            }
            Err(error) => self.commit_failed(requests, error),
        }
    }

    /// Opens the database again after a commit that has failed, and tries a change again if there is space
    /// for it now.
    fn commit_failed(
        &mut self,
        requests: &mut Vec<WriteRequest>,
        error: StoreError,
    ) -> Result<(), StoreError> {
        // After an I/O error redb takes no more changes until it is opened again.
        if let Err(error) = self.database.reopen() {
            error!(%error, "the store could not be opened again");
        }
        let [request] = requests.as_slice() else {
            return Err(error);
        };
        if let (StoreError::Full(_), Some(space)) = (&error, &mut self.disk_space) {
            if request.change.added_bytes().is_some() {
                space.ran_out();
            } else if space.release_reserve() {
                return self.commit(requests);
            }
        }
        for request in requests.drain(..) {
            request.answer(Err(error.clone()));
        }
        Err(error)
    }

    /// Refuses changes that need more disk space than there is, without trying them.
    fn refuse_without_space(&mut self, requests: &mut Vec<WriteRequest>) {
        let Some(space) = &mut self.disk_space else {
            return;
        };
        let (admitted, refused): (_, Vec<WriteRequest>) =
            std::mem::take(requests).into_iter().partition(|request| {
                let added = request.change.added_bytes();
                added.is_none_or(|bytes| space.admits(bytes))
            });
        *requests = admitted;
        for request in refused {
            let full = StoreError::Full("there is no room on the disk".to_owned());
            request.answer(Err(full));
        }
    }

    /// Does everything or nothing, and gives what is to be done to [`Ended`] if it is done. A panic of the
    /// database must not take the store away from everybody.
    fn transact<T>(
        &self,
        work: impl FnOnce(&mut Transaction<'_>) -> Result<T, StoreError>,
    ) -> Result<(T, Vec<EndedChange>), StoreError> {
        let transact = || {
            let redb = self.database.redb();
            let redb = redb.as_ref().ok_or_else(closed)?;
            let write = redb.begin_write()?;
            let mut transaction = Transaction::open(&write)?;
            let value = work(&mut transaction)?;
            let ended = std::mem::take(&mut transaction.ended);
            drop(transaction);
            write.commit()?;
            Ok((value, ended))
        };
        catch_panic(transact).and_then(|done| done)
    }

    fn count(&mut self, changes: Vec<EndedChange>) {
        for change in changes {
            match change {
                EndedChange::Add { at, id, bytes } => self.ended.add(at, id, bytes),
                EndedChange::Remove { at, id } => {
                    let bytes = self.ended.remove(at, id);
                    self.add_freed(bytes);
                }
            }
        }
    }

    /// Jobs of so many bytes were deleted.
    fn add_freed(&mut self, bytes: u64) {
        if let Some(space) = &mut self.disk_space {
            space.add_freed(bytes);
        }
    }

    /// The first transaction after a start.
    fn recover(&mut self) -> Result<(), StoreError> {
        let mut recovered = self.transact(|transaction| transaction.recover());
        if let (Err(StoreError::Full(_)), Some(space)) = (&recovered, &mut self.disk_space)
            && space.release_reserve()
        {
            self.database.reopen()?;
            recovered = self.transact(|transaction| transaction.recover());
        }
        let ((), ended) = recovered?;
        self.count(ended);
        Ok(())
    }
}
