//! The one thread that writes. Changes that arrive while a commit is being written go into the next one
//! together: a hundred clients that create jobs at the same time wait for one commit.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;
use tracing::{error, warn};

use super::change::{Change, Pending};
use super::database::JobDatabase;
use super::ended::Ended;
use super::error::{catch_panic, not_open};
use super::transaction::{EndedChange, Transaction};
use super::usage::Usage;
use crate::job::counters::Counters;
use crate::job::store::{Acknowledgement, StoreError};

/// The most points of jobs that go into one commit: they are in memory until it is done.
const POINTS_OF_COMMIT: usize = 2_000_000;

/// For this long after the disk was full, changes that need space are refused without trying. A failed
/// attempt takes long, as the database has to be opened again: clients that keep on posting would hold up
/// everything else (`durable::a_full_disk`).
const PAUSE: Duration = Duration::from_millis(500);

/// Sends changes to the thread, which ends when this is dropped.
pub(super) struct Writer {
    sender: Option<Sender<Box<dyn Change>>>,
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
            usage: Usage::default(),
            full_until: None,
        };
        writer.transact(|transaction| transaction.recover())?;
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

    /// A change, which takes its place in the order of changes now.
    pub(super) fn write<T: Send + 'static>(
        &self,
        points: usize,
        function: impl Fn(&mut Transaction<'_>) -> Result<T, StoreError> + Send + 'static,
    ) -> Acknowledgement<T> {
        let (reply, receiver) = oneshot::channel();
        let change = Box::new(Pending {
            points,
            function,
            outcome: None,
            reply,
        });
        if let Some(sender) = &self.sender {
            // If the thread has ended, the change is dropped with its reply.
            let _ = sender.send(change);
        }
        Box::pin(async move { receiver.await.unwrap_or_else(|_| Err(closed())) })
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
pub(super) fn closed() -> StoreError {
    StoreError::Failed("the store is closed".to_owned())
}

/// What the thread works with.
struct WriterThread {
    database: Arc<JobDatabase>,
    counters: Counters,
    ended: Ended,
    usage: Usage,
    /// The end of the pause after the disk was full.
    full_until: Option<Instant>,
}

impl WriterThread {
    fn serve(&mut self, receiver: &Receiver<Box<dyn Change>>) {
        while let Ok(first) = receiver.recv() {
            let mut points = first.points();
            let mut changes = vec![first];
            while points < POINTS_OF_COMMIT
                && let Ok(change) = receiver.try_recv()
            {
                points += change.points();
                changes.push(change);
            }
            self.commit_all(changes);
        }
    }

    /// Commits changes together, and one by one if that fails: one that cannot be done must not take the
    /// others with it.
    fn commit_all(&mut self, mut changes: Vec<Box<dyn Change>>) {
        if self.full_until.is_some_and(|until| Instant::now() < until) {
            for change in changes.extract_if(.., |change| change.points() > 0) {
                let full = StoreError::Full("there is no room on the disk".to_owned());
                change.answer(Err(full));
            }
        }
        if changes.is_empty() {
            return;
        }
        let committed = self.commit(&mut changes);
        if let Err(error) = &committed {
            warn!(%error, writes = changes.len(), "a commit failed");
        }
        if committed.is_err() && changes.len() > 1 {
            for change in changes {
                self.commit_all(vec![change]);
            }
        } else {
            for change in changes {
                change.answer(committed.clone());
            }
        }
    }

    /// Does changes in one transaction. If that fails, the database is opened again.
    fn commit(&mut self, changes: &mut [Box<dyn Change>]) -> Result<(), StoreError> {
        self.counters.commits.inc();
        self.counters.writes.inc_by(changes.len() as u64);
        let adds = changes.iter().any(|change| change.points() > 0);
        let leaves_slack = adds && self.database.is_on_disk();
        let is_single = changes.len() == 1;
        let committed = self.transact(|transaction| {
            for change in changes {
                change.apply(transaction)?;
            }
            match leaves_slack {
                true => transaction.leave_slack(),
                false => Ok(()),
            }
        });
        if let Err(error) = &committed {
            if let Err(error) = self.database.reopen() {
                error!(%error, "the store could not be opened again");
            }
            if is_single && adds && matches!(error, StoreError::Full(_)) {
                self.full_until = Some(Instant::now() + PAUSE);
            }
        }
        committed
    }

    /// Does everything or nothing. A panic of the database must not take the store away from everybody.
    fn transact(
        &mut self,
        work: impl FnOnce(&mut Transaction<'_>) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let transact = || {
            let redb = self.database.redb();
            let redb = redb.as_ref().ok_or_else(not_open)?;
            let write = redb.begin_write()?;
            let mut transaction = Transaction::open(&write, &self.ended, self.usage.clone())?;
            work(&mut transaction)?;
            let changes = std::mem::take(&mut transaction.changes);
            let usage = std::mem::take(&mut transaction.usage);
            drop(transaction);
            write.commit()?;
            Ok((changes, usage))
        };
        let (changes, usage) = catch_panic(transact).and_then(|done| done)?;
        self.usage = usage;
        for change in changes {
            match change {
                EndedChange::Add { at, id, bytes } => self.ended.add(at, id, bytes),
                EndedChange::Remove { at, id } => {
                    self.ended.remove(at, id);
                    self.full_until = None;
                }
            }
        }
        Ok(())
    }
}
