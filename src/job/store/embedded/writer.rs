//! The one thread that writes. Changes that arrive while a commit is being written go into the next one
//! together: a hundred clients that create jobs at the same time wait for one commit.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;
use tracing::{error, warn};
use uuid::Uuid;

use super::change::{Barrier, Change, Pending};
use super::committer::Committer;
use super::database::JobDatabase;
use super::error::closed;
use super::transaction::Transaction;
use crate::job::counters::Counters;
use crate::job::store::{Acknowledgement, StoreError};

/// The most points of jobs that go into one commit: they are in memory until it is done.
const POINTS_OF_COMMIT: usize = 2_000_000;

/// For this long after the disk was full, changes that need space are refused without trying. A failed attempt takes
/// long, as the database has to be opened again: clients that keep posting would delay everything else
/// (`durable::a_full_disk`).
const PAUSE: Duration = Duration::from_millis(500);

/// The interval of checks that the file is where it was opened.
const LOOK: Duration = Duration::from_secs(1);

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
        let mut committer = Committer::new(Arc::clone(&database))?;
        committer.transact(&[], |transaction| transaction.recover())?;
        let mut writer = WriterThread {
            leaves_slack: database.is_on_disk(),
            database,
            committer,
            counters,
            full_until: None,
            looked: Instant::now(),
        };
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

    /// Adds a change to the end of the order.
    pub(super) fn write<T: Send + 'static>(
        &self,
        points: usize,
        function: impl Fn(&mut Transaction<'_>) -> Result<T, StoreError> + Send + 'static,
    ) -> Acknowledgement<T> {
        self.write_with(points, None, function)
    }

    /// A change that writes this new job.
    pub(super) fn insert<T: Send + 'static>(
        &self,
        id: Uuid,
        points: usize,
        function: impl Fn(&mut Transaction<'_>) -> Result<T, StoreError> + Send + 'static,
    ) -> Acknowledgement<T> {
        self.write_with(points, Some(id), function)
    }

    fn write_with<T: Send + 'static>(
        &self,
        points: usize,
        inserts: Option<Uuid>,
        function: impl Fn(&mut Transaction<'_>) -> Result<T, StoreError> + Send + 'static,
    ) -> Acknowledgement<T> {
        let (reply, receiver) = oneshot::channel();
        self.send(Box::new(Pending {
            points,
            inserts,
            function,
            outcome: None,
            reply,
        }));
        answered(receiver)
    }

    /// Completes after the changes that were sent before it, with a store that is open.
    pub(super) fn barrier(&self) -> Acknowledgement<()> {
        let (reply, receiver) = oneshot::channel();
        self.send(Box::new(Barrier(reply)));
        answered(receiver)
    }

    fn send(&self, change: Box<dyn Change>) {
        if let Some(sender) = &self.sender {
            // If the thread has ended, the change is dropped with its reply.
            let _ = sender.send(change);
        }
    }
}

fn answered<T: Send + 'static>(
    receiver: oneshot::Receiver<Result<T, StoreError>>,
) -> Acknowledgement<T> {
    Box::pin(async move { receiver.await.unwrap_or_else(|_| Err(closed())) })
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

/// The state of the thread.
struct WriterThread {
    database: Arc<JobDatabase>,
    committer: Committer,
    counters: Counters,
    leaves_slack: bool,
    /// The end of the pause after the disk was full.
    full_until: Option<Instant>,
    /// When it was last checked that the file is where it was opened.
    looked: Instant,
}

impl WriterThread {
    fn serve(&mut self, receiver: &Receiver<Box<dyn Change>>) {
        loop {
            match receiver.recv_timeout(LOOK) {
                Ok(first) => self.commit_all(gather(first, receiver)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if self.looked.elapsed() >= LOOK {
                self.look();
            }
        }
    }

    fn look(&mut self) {
        self.database.look_for_file();
        self.looked = Instant::now();
    }

    /// Commits changes together, and one by one if that fails, so that a failing one does not take the others with it.
    fn commit_all(&mut self, mut changes: Vec<Box<dyn Change>>) {
        self.refuse(&mut changes);
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

    /// Answers changes that are not to be tried.
    fn refuse(&mut self, changes: &mut Vec<Box<dyn Change>>) {
        if self.full_until.is_some_and(|until| Instant::now() < until) {
            for change in changes.extract_if(.., |change| change.points() > 0) {
                let full = StoreError::Full("there is no room on the disk".to_owned());
                change.answer(Err(full));
            }
        }
        if changes.iter().any(|change| change.inserts().is_some()) {
            self.look();
            if let Err(error) = self.database.check_place() {
                for change in changes.extract_if(.., |change| change.inserts().is_some()) {
                    change.answer(Err(error.clone()));
                }
            }
        }
    }

    /// Applies changes in one transaction.
    fn commit(&mut self, changes: &mut [Box<dyn Change>]) -> Result<(), StoreError> {
        if !changes.iter().any(|change| change.writes()) {
            return self.committer.ensure_open();
        }
        self.counters.commits.inc();
        self.counters.writes.inc_by(changes.len() as u64);
        let inserted: Vec<Uuid> = changes.iter().filter_map(|it| it.inserts()).collect();
        let adds = changes.iter().any(|change| change.points() > 0);
        let leaves_slack = adds && self.leaves_slack;
        let is_single = changes.len() == 1;
        let committed = self.committer.transact(&inserted, |transaction| {
            for change in changes.iter_mut() {
                change.apply(transaction)?;
            }
            match leaves_slack {
                true => transaction.leave_slack(),
                false => Ok(()),
            }
        });
        match committed {
            Ok(committed) if committed.has_removed => self.full_until = None,
            Err(StoreError::Full(_)) if is_single && adds => {
                self.full_until = Some(Instant::now() + PAUSE);
            }
            _ => {}
        }
        committed.map(|_| ())
    }
}

/// A change, and those behind it that go into one commit with it.
fn gather(first: Box<dyn Change>, receiver: &Receiver<Box<dyn Change>>) -> Vec<Box<dyn Change>> {
    let mut points = first.points();
    let mut changes = vec![first];
    while points < POINTS_OF_COMMIT
        && let Ok(change) = receiver.try_recv()
    {
        points += change.points();
        changes.push(change);
    }
    changes
}
