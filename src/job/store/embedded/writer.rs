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
use super::error::{closed, unwritable};
use super::panics;
use super::transaction::{EndedChange, Transaction};
use crate::job::counters::Counters;

/// For this long after the disk was full, changes that need space are refused without trying: a failed
/// attempt takes long, as the database has to be opened again after it.
const PAUSE: Duration = Duration::from_millis(500);

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
        on_disk: bool,
        counters: Counters,
    ) -> Result<Self, StoreError> {
        let mut writer = WriterThread {
            database,
            on_disk,
            full_until: None,
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
    /// Not in memory.
    on_disk: bool,
    /// The end of the pause, if no job was deleted since the disk was full.
    full_until: Option<Instant>,
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
        let adds = requests.iter().any(|it| it.change.adds());
        let leaves_slack = adds && self.on_disk;
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
        // After an I/O error redb takes no more changes until it is opened again.
        if let Err(error) = self.database.reopen() {
            error!(%error, "the store could not be opened again");
        }
        let [request] = requests.as_slice() else {
            return Err(error);
        };
        if matches!(error, StoreError::Full(_)) && request.change.adds() {
            self.full_until = Some(Instant::now() + PAUSE);
        }
        for request in requests.drain(..) {
            request.answer(Err(error.clone()));
        }
        Err(error)
    }

    /// Refuses changes that need disk space shortly after there was none.
    fn refuse_without_space(&self, requests: &mut Vec<WriteRequest>) {
        if self.full_until.is_none_or(|until| Instant::now() >= until) {
            return;
        }
        let (admitted, refused) = std::mem::take(requests)
            .into_iter()
            .partition(|request| !request.change.adds());
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
        panics::catch(transact).unwrap_or_else(|panic| {
            error!(panic, "the database panicked while it was written");
            Err(unwritable())
        })
    }

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

    /// The first transaction after a start.
    fn recover(&mut self) -> Result<(), StoreError> {
        let ((), ended) = self.transact(|transaction| transaction.recover())?;
        self.count(ended);
        Ok(())
    }
}
