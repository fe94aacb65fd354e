//! The one thread that writes. Changes that arrive while a commit is being written go into the next one
//! together: a hundred clients that create jobs at the same time wait for one commit.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;
use tracing::{error, warn};

use super::super::StoreError;
use super::super::ended::Ended;
use super::change::{Change, Outcome};
use super::database::JobDatabase;
use super::error::{catch_panic, closed};
use super::transaction::{EndedChange, Transaction};
use crate::job::counters::Counters;

/// The most points of jobs that go into one commit: they are in memory until it is done.
const POINTS_OF_COMMIT: usize = 2_000_000;

/// For this long after the disk was full, changes that need space are refused without trying. A failed
/// attempt takes long, as the database has to be opened again: clients that keep on posting would hold up
/// everything else (`durable::a_full_disk`).
const PAUSE: Duration = Duration::from_millis(500);

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
        counters: Counters,
    ) -> Result<Self, StoreError> {
        let mut writer = WriterThread {
            database,
            counters,
            ended: Ended::default(),
            full_until: None,
        };
        let ((), ended) = writer.transact(|transaction| transaction.recover())?;
        writer.count(ended);
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
    counters: Counters,
    ended: Ended,
    /// The end of the pause after the disk was full.
    full_until: Option<Instant>,
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
        self.refuse_while_full(requests);
        if requests.is_empty() {
            return Ok(());
        }
        self.counters.commits.inc();
        self.counters.writes.inc_by(requests.len() as u64);
        let adds = requests.iter().any(|it| it.change.adds());
        let leaves_slack = adds && self.database.is_on_disk();
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
                for (request, outcome) in requests.drain(..).zip(outcomes) {
                    request.answer(Ok(outcome));
                }
                Ok(())
            }
            Err(error) => self.commit_failed(requests, error),
        }
    }

    /// Opens the database again after a commit that has failed.
    fn commit_failed(
        &mut self,
        requests: &mut Vec<WriteRequest>,
        error: StoreError,
    ) -> Result<(), StoreError> {
        if let Err(error) = self.database.reopen() {
            error!(%error, "the store could not be opened again");
        }
        let [request] = requests.as_slice() else {
            return Err(error);
        };
        if let (StoreError::Full(_), true) = (&error, request.change.adds()) {
            self.full_until = Some(Instant::now() + PAUSE);
        }
        for request in requests.drain(..) {
            request.answer(Err(error.clone()));
        }
        Err(error)
    }

    /// Refuses changes that need space for a moment after the disk was full.
    fn refuse_while_full(&mut self, requests: &mut Vec<WriteRequest>) {
        if self.full_until.is_none_or(|until| Instant::now() >= until) {
            return;
        }
        for request in requests.extract_if(.., |request| request.change.adds()) {
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

    /// Takes note of jobs that have ended, or are gone.
    fn count(&mut self, changes: Vec<EndedChange>) {
        for change in changes {
            match change {
                EndedChange::Add { at, id, bytes } => self.ended.add(at, id, bytes),
                EndedChange::Remove { at, id } => {
                    self.ended.remove(at, id);
                    self.full_until = None;
                }
            }
        }
    }
}
