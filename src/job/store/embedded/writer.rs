//! The one thread that writes. What has gathered while a commit went to the disk goes into the
//! next one together: a hundred clients that create jobs at the same time wait for one commit.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use jiff::Timestamp;
use prost::Message;
use redb::{ReadableTable, Table, WriteTransaction};
use tokio::sync::oneshot;
use tracing::{error, warn};
use uuid::Uuid;

use super::super::blame::Crash;
use super::super::{Ended, Key, Made, Record, Retention, StoreError};
use super::database::JobDatabase;
use super::error::{closed, damaged, unwritable};
use super::header::{Header, KeyMessage};
use super::input::{Input, PointsMessage};
use super::quiet;
use super::room::Room;
use super::tables::{HEADERS, INPUTS, KEYS, RESULTS, SLACK};
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::job::counters::Counters;
use crate::job::state::{State, Status};

/// The most points of jobs that go into one commit: they are in memory until it is done.
const POINTS_OF_COMMIT: usize = 2_000_000;

/// So many pages of the file stay free for changes that must be possible: deleting a job takes a few
/// dozen, which are free again two commits later.
const SLACK_PAGES: u64 = 128;

/// A change of the file, and where its outcome goes.
pub(super) struct Write {
    pub(super) change: Change,
    pub(super) reply: oneshot::Sender<Result<Outcome, StoreError>>,
}

/// A change of the file.
pub(super) enum Change {
    Insert {
        record: Box<Record>,
        problem: Arc<Problem>,
        key: Option<Key>,
    },
    Start {
        id: Uuid,
        status: Status,
        watched: bool,
    },
    Clear {
        id: Uuid,
    },
    Requeue {
        id: Uuid,
    },
    Finish {
        id: Uuid,
        status: Status,
        result: Option<Arc<Points>>,
    },
    Remove {
        id: Uuid,
    },
    Retain(Retention),
    /// To wait for the writes before.
    Nothing,
}

/// What came of a change.
pub(super) enum Outcome {
    Done,
    /// There is a job for the key.
    Made(Made),
    /// Whether there was a job to be removed.
    Removed(bool),
    Forgotten(Vec<Uuid>),
}

/// Sends writes to the thread, which ends with this.
pub(super) struct Writer {
    sender: Option<Sender<Write>>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    /// Puts what was running in a crash back into the queue, and starts the thread.
    pub(super) fn start(
        database: Arc<JobDatabase>,
        room: Option<Room>,
        counters: Counters,
    ) -> Result<Self, StoreError> {
        let mut pen = Pen {
            database,
            room,
            counters,
            ended: Ended::default(),
        };
        let mut recovered = pen.recover();
        if matches!(recovered, Err(StoreError::Full(_))) && pen.release_room() {
            pen.database.reopen()?;
            recovered = pen.recover();
        }
        recovered?;
        let (sender, receiver) = channel();
        let thread = thread::Builder::new()
            .name("piad-store".to_owned())
            .spawn(move || pen.serve(&receiver))
            .map_err(|reason| StoreError::Failed(reason.to_string()))?;
        Ok(Self {
            sender: Some(sender),
            thread: Some(thread),
        })
    }

    pub(super) fn send(&self, write: Write) -> Result<(), StoreError> {
        let sender = self.sender.as_ref().ok_or_else(gone)?;
        sender.send(write).map_err(|_| gone())
    }
}

impl Drop for Writer {
    /// All writes that were sent are done before the store is gone.
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
pub(super) fn gone() -> StoreError {
    StoreError::Failed("the store is closed".to_owned())
}

/// What the thread works with.
struct Pen {
    database: Arc<JobDatabase>,
    /// `None` for a store in memory.
    room: Option<Room>,
    counters: Counters,
    ended: Ended,
}

/// A change of [`Ended`], which counts when the commit is done.
enum Count {
    Add(Timestamp, Uuid, u64),
    Remove(Timestamp, Uuid),
}

impl Pen {
    fn serve(&mut self, receiver: &Receiver<Write>) {
        while let Ok(first) = receiver.recv() {
            let mut points = first.change.points();
            let mut writes = vec![first];
            while points < POINTS_OF_COMMIT
                && let Ok(write) = receiver.try_recv()
            {
                points += write.change.points();
                writes.push(write);
            }
            let count = writes.len();
            if let Err(error) = self.commit(&mut writes) {
                warn!(%error, writes = count, "a commit failed");
                // One that cannot be done must not take the others with it.
                for write in writes.drain(..) {
                    let outcome = self.commit(&mut vec![write]);
                    drop(outcome);
                }
            }
        }
    }

    /// Does the writes in one transaction and tells their clients. If that fails, a single write is
    /// answered with the error, and several are left to be tried one by one.
    fn commit(&mut self, writes: &mut Vec<Write>) -> Result<(), StoreError> {
        self.refuse_without_room(writes);
        if writes.is_empty() {
            return Ok(());
        }
        self.counters.commits.inc();
        self.counters.writes.inc_by(writes.len() as u64);
        let mut counts = Vec::new();
        let done = self.transact(|tables| {
            let changes = writes.iter().map(|write| &write.change);
            let outcomes = changes
                .map(|change| self.apply(change, tables, &mut counts))
                .collect::<Result<Vec<Outcome>, StoreError>>()?;
            let grows = writes.iter().any(|write| write.change.needs().is_some());
            if grows && self.room.is_some() {
                tables.leave_slack()?;
            }
            Ok(outcomes)
        });
        match done {
            Ok(outcomes) => {
                counts.into_iter().for_each(|count| self.count(count));
                if outcomes
                    .iter()
                    .any(|it| matches!(it, Outcome::Removed(true)))
                {
                    self.was_left(0);
                }
                for (write, outcome) in writes.drain(..).zip(outcomes) {
                    // The client may have gone away.
                    let _ = write.reply.send(Ok(outcome));
                }
                Ok(())
            }
            Err(error) => {
                // After an I/O error redb takes no more writes until it is opened again.
                if let Err(error) = self.database.reopen() {
                    error!(%error, "the store could not be opened again");
                }
                if let ([write], StoreError::Full(_)) = (writes.as_slice(), &error) {
                    if write.change.needs().is_some() {
                        self.room.iter_mut().for_each(Room::was_missing);
                    } else if self.release_room() {
                        return self.commit(writes);
                    }
                }
                if let [_] = writes.as_slice() {
                    for write in writes.drain(..) {
                        let _ = write.reply.send(Err(error.clone()));
                    }
                }
                Err(error)
            }
        }
    }

    /// Answers what needs more room than there is, without trying.
    fn refuse_without_room(&mut self, writes: &mut Vec<Write>) {
        let Some(room) = &mut self.room else {
            return;
        };
        let (tried, refused) = std::mem::take(writes).into_iter().partition(|write| {
            let needs = write.change.needs();
            needs.is_none_or(|bytes| room.admits(bytes))
        });
        *writes = tried;
        let refused: Vec<Write> = refused;
        for write in refused {
            let full = StoreError::Full("there is no room on the disk".to_owned());
            // The client may have gone away.
            let _ = write.reply.send(Err(full));
        }
    }

    /// Everything or nothing. A defect here must not take the store away from everybody.
    fn transact<T>(
        &self,
        work: impl FnOnce(&mut Tables<'_>) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let transaction = || {
            let redb = self.database.redb();
            let redb = redb.as_ref().ok_or_else(closed)?;
            let transaction = redb.begin_write()?;
            let value = work(&mut Tables::open(&transaction)?)?;
            transaction.commit()?;
            Ok(value)
        };
        quiet::catch(transaction).unwrap_or_else(|panic| {
            error!(panic, "the database panicked while it was written");
            Err(unwritable())
        })
    }

    fn count(&mut self, count: Count) {
        match count {
            Count::Add(at, id, bytes) => self.ended.add(at, id, bytes),
            Count::Remove(at, id) => {
                let bytes = self.ended.remove(at, id);
                self.was_left(bytes);
            }
        }
    }

    /// So many bytes of jobs were deleted.
    fn was_left(&mut self, bytes: u64) {
        if let Some(room) = &mut self.room {
            room.was_left(bytes);
        }
    }

    /// Makes room for what must be possible; says whether that has helped.
    fn release_room(&mut self) -> bool {
        self.room.as_mut().is_some_and(Room::release)
    }

    /// After a start: what was running goes back to the queue, and what has ended is counted. This reads
    /// every header.
    fn recover(&mut self) -> Result<(), StoreError> {
        let ended = self.transact(|tables| {
            let mut ended = Vec::new();
            let mut running = Vec::new();
            let mut crash = Crash::default();
            for entry in tables.headers.iter()? {
                let header = Header::decode(entry?.1.value()).map_err(damaged)?;
                let record = header.clone().into_record()?;
                crash.note(&record);
                if record.status.state == State::Running {
                    running.push((record, header));
                } else if let Some(at) = record.status.finished {
                    ended.push((at, record.outline.id, header.bytes));
                }
            }
            for (record, mut header) in running {
                let id = record.outline.id;
                let Some(record) = crash.recovered(&record) else {
                    continue;
                };
                warn!(job = %id, crashes = record.crashes, "a job was running when the process ended");
                header.recover(&record);
                tables.put(id, &header)?;
                ended.extend(record.status.finished.map(|at| (at, id, header.bytes)));
            }
            Ok(ended)
        })?;
        for (at, id, bytes) in ended {
            self.ended.add(at, id, bytes);
        }
        Ok(())
    }

    fn apply(
        &self,
        change: &Change,
        tables: &mut Tables<'_>,
        counts: &mut Vec<Count>,
    ) -> Result<Outcome, StoreError> {
        Ok(match change {
            Change::Insert {
                record,
                problem,
                key,
            } => {
                let made = tables.insert(record, problem, key.as_ref())?;
                made.map_or(Outcome::Done, Outcome::Made)
            }
            Change::Start {
                id,
                status,
                watched,
            } => {
                tables.update(*id, |header| {
                    header.set_status(status);
                    header.watched = *watched;
                })?;
                Outcome::Done
            }
            Change::Clear { id } => {
                tables.update(*id, |header| header.watched = false)?;
                Outcome::Done
            }
            Change::Requeue { id } => {
                tables.update(*id, |header| {
                    header.set_status(&Status::QUEUED);
                    (header.crashes, header.watched) = (0, false);
                })?;
                Outcome::Done
            }
            Change::Finish { id, status, result } => {
                counts.extend(tables.finish(*id, status, result.as_deref())?);
                Outcome::Done
            }
            Change::Remove { id } => {
                let removed = tables.remove(*id)?;
                let existed = removed.is_some();
                counts.extend(removed.flatten());
                Outcome::Removed(existed)
            }
            Change::Retain(retention) => {
                tables.forget_keys()?;
                let forgotten = self.ended.surplus(*retention);
                for &id in &forgotten {
                    counts.extend(tables.remove(id)?.flatten());
                }
                Outcome::Forgotten(forgotten)
            }
            Change::Nothing => Outcome::Done,
        })
    }
}

impl Change {
    /// About how many bytes it needs that did not have a place before; `None` if it must be possible
    /// without any.
    fn needs(&self) -> Option<u64> {
        let numbers = match self {
            Self::Insert { problem, .. } => {
                let directions = problem.directions().map(|each| 2 * each.parameters.len());
                problem.grid().count() * problem.data().dimension() + directions.sum::<usize>()
            }
            Self::Finish {
                result: Some(result),
                ..
            } => result.len() * result.dimension(),
            _ => return None,
        };
        Some((numbers * size_of::<f64>()) as u64)
    }

    /// How many points it writes.
    fn points(&self) -> usize {
        match self {
            Self::Insert { problem, .. } => problem.grid().count(),
            Self::Finish { result, .. } => result.as_ref().map_or(0, |points| points.len()),
            _ => 0,
        }
    }
}

/// The tables of a transaction.
struct Tables<'a> {
    headers: Table<'a, u128, &'static [u8]>,
    inputs: Table<'a, u128, &'static [u8]>,
    results: Table<'a, u128, &'static [u8]>,
    keys: Table<'a, &'static str, &'static [u8]>,
    slack: Table<'a, u64, &'static [u8]>,
}

impl<'a> Tables<'a> {
    fn open(transaction: &'a WriteTransaction) -> Result<Self, StoreError> {
        Ok(Self {
            headers: transaction.open_table(HEADERS)?,
            inputs: transaction.open_table(INPUTS)?,
            results: transaction.open_table(RESULTS)?,
            keys: transaction.open_table(KEYS)?,
            slack: transaction.open_table(SLACK)?,
        })
    }

    /// Has the file grow now if it is nearly full: writes and removes a few pages, in which later
    /// changes find the room to delete.
    fn leave_slack(&mut self) -> Result<(), StoreError> {
        const PAGE: [u8; 3800] = [0; 3800];
        for page in 0..SLACK_PAGES {
            self.slack.insert(page, PAGE.as_slice())?;
        }
        for page in 0..SLACK_PAGES {
            self.slack.remove(page)?;
        }
        Ok(())
    }

    fn insert(
        &mut self,
        record: &Record,
        problem: &Problem,
        key: Option<&Key>,
    ) -> Result<Option<Made>, StoreError> {
        let id = record.outline.id;
        if let Some(key) = key {
            if let Some(made) = self.made(&key.name)?
                && !made.is_forgotten()
            {
                return Ok(Some(made));
            }
            let entry = KeyMessage::new(key, id, record.outline.created).encode_to_vec();
            self.keys.insert(key.name.as_str(), entry.as_slice())?;
        }
        let input = Input::new(problem).encode_to_vec();
        let header = Header::new(record, input.len() as u64, key.map(|key| key.name.clone()));
        self.inputs.insert(id.as_u128(), input.as_slice())?;
        self.put(id, &header)?;
        Ok(None)
    }

    fn made(&self, key: &str) -> Result<Option<Made>, StoreError> {
        let entry = self.keys.get(key)?;
        let made = entry.map(|entry| {
            KeyMessage::decode(entry.value())
                .map_err(damaged)?
                .into_made()
        });
        made.transpose()
    }

    fn put(&mut self, id: Uuid, header: &Header) -> Result<(), StoreError> {
        let bytes = header.encode_to_vec();
        self.headers.insert(id.as_u128(), bytes.as_slice())?;
        Ok(())
    }

    fn header(&self, id: Uuid) -> Result<Option<Header>, StoreError> {
        let entry = self.headers.get(id.as_u128())?;
        let header = entry.map(|entry| Header::decode(entry.value()).map_err(damaged));
        header.transpose()
    }

    /// Changes a header; a job that is gone stays gone.
    fn update(
        &mut self,
        id: Uuid,
        change: impl FnOnce(&mut Header),
    ) -> Result<Option<Header>, StoreError> {
        let Some(mut header) = self.header(id)? else {
            return Ok(None);
        };
        change(&mut header);
        self.put(id, &header)?;
        Ok(Some(header))
    }

    fn finish(
        &mut self,
        id: Uuid,
        status: &Status,
        result: Option<&Points>,
    ) -> Result<Option<Count>, StoreError> {
        let result = result.map(|points| PointsMessage::new(points).encode_to_vec());
        let more = result.as_ref().map_or(0, |bytes| bytes.len() as u64);
        let header = self.update(id, |header| {
            header.set_status(status);
            header.bytes += more;
        })?;
        let Some(header) = header else {
            return Ok(None);
        };
        if let Some(bytes) = result {
            self.results.insert(id.as_u128(), bytes.as_slice())?;
        }
        Ok(status.finished.map(|at| Count::Add(at, id, header.bytes)))
    }

    /// Forgets a job: `None` if there is none, else what that means for the count of ended ones.
    fn remove(&mut self, id: Uuid) -> Result<Option<Option<Count>>, StoreError> {
        let Some(header) = self.header(id)? else {
            return Ok(None);
        };
        self.headers.remove(id.as_u128())?;
        self.inputs.remove(id.as_u128())?;
        self.results.remove(id.as_u128())?;
        // A forgotten key may have been used again.
        if let Some(key) = &header.key
            && self.made(key)?.is_some_and(|made| made.id == id)
        {
            self.keys.remove(key.as_str())?;
        }
        let finished = header.into_record()?.status.finished;
        Ok(Some(finished.map(|at| Count::Remove(at, id))))
    }

    fn forget_keys(&mut self) -> Result<(), StoreError> {
        let mut old = Vec::new();
        for entry in self.keys.iter()? {
            let (key, entry) = entry?;
            let made = KeyMessage::decode(entry.value())
                .map_err(damaged)?
                .into_made()?;
            if made.is_forgotten() {
                old.push(key.value().to_owned());
            }
        }
        for key in old {
            self.keys.remove(key.as_str())?;
        }
        Ok(())
    }
}
