//! A task that computes a group of items: its waits, and its memory.
//!
//! A group that holds memory computes, and waits neither for another item nor for a client: it gives its memory back
//! before it waits for its lines to be sent. So items that wait for memory get it, in any order.

use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::TrySendError;
use tokio::task::JoinHandle;

use super::answer::Lines;
use super::group::{Group, Reading, SMALL_FIT, Want};
use super::item::Item;
use super::settings::Settings;
use crate::api::app::App;
use crate::api::http::body_limits::{READING, SMALL};
use crate::api::start::Base;
use crate::job::memory::Permit;
use crate::job::peer::{self, Peer};

/// A group that is being computed.
pub(super) struct Running {
    lines: mpsc::Receiver<Lines>,
    task: JoinHandle<Duration>,
    /// The number of its items.
    items: usize,
}

impl Running {
    /// Begins to compute some items for the current peer.
    pub(super) fn begin(settings: &Arc<Settings>, items: Vec<Item>) -> Self {
        let count = items.len();
        let group = Group::new(Arc::clone(settings), items);
        let unread = group.unread();
        let (sender, lines) = mpsc::channel(1);
        let task = Task {
            settings: Arc::clone(settings),
            group: Arc::new(Mutex::new(group)),
            sender,
        };
        Self {
            lines,
            task: peer::spawn(task.run(unread)),
            items: count,
        }
    }

    /// The next of its lines; `None` at its end. A future that is dropped loses nothing.
    pub(super) async fn next(&mut self) -> Option<Lines> {
        self.lines.recv().await
    }

    /// After its end: how long an item has taken on average; `None` if the batch was cut short.
    pub(super) async fn pace(mut self) -> Option<Duration> {
        let busy = (&mut self.task).await.ok()?;
        Some(busy / u32::try_from(self.items).unwrap_or(u32::MAX).max(1))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.task.abort();
    }
}

struct Task {
    settings: Arc<Settings>,
    group: Arc<Mutex<Group>>,
    sender: mpsc::Sender<Lines>,
}

impl Task {
    /// Computes the items after reading these bytes; returns how long that took.
    async fn run(self, unread: (usize, usize)) -> Duration {
        let Settings { app, .. } = &*self.settings;
        let reading = take_for_reading(app, unread).await;
        self.group.lock().reading = Some(reading);
        let memory = take_for_fits(app, 0, SMALL_FIT).await;
        self.group.lock().set_memory(memory);
        loop {
            let lane = self.group.lock().lane();
            let scheduler = &app.jobs.resources().scheduler;
            let is_broken = scheduler.run_errand(lane, &self.group).await.is_err();
            if self.settings.is_cancelled() {
                break;
            }
            if is_broken {
                self.group.lock().break_off();
                continue;
            }
            let want = self.group.lock().take_want();
            match want {
                None => break,
                Some(Want::Base(base)) => {
                    let found = Base::of(app, Some(&base)).await;
                    self.group.lock().set_base(found);
                }
                Some(Want::Memory { step_cost, bytes }) => {
                    self.group.lock().set_memory(None);
                    let memory = take_for_fits(app, step_cost, bytes).await;
                    self.group.lock().set_memory(memory);
                }
                Some(Want::Send) => self.send().await,
            }
        }
        self.group.lock().set_memory(None);
        let (lines, busy) = {
            let mut group = self.group.lock();
            (group.take_lines(), group.busy())
        };
        let _ = self.sender.send(lines).await;
        busy
    }

    /// Sends the lines so far. All memory is released if that takes a while.
    async fn send(&self) {
        let lines = self.group.lock().take_lines();
        let Err(TrySendError::Full(lines)) = self.sender.try_send(lines) else {
            return;
        };
        let unread = {
            let mut group = self.group.lock();
            group.set_memory(None);
            group.reading = None;
            group.unread()
        };
        let _ = self.sender.send(lines).await;
        let reading = take_for_reading(&self.settings.app, unread).await;
        self.group.lock().reading = Some(reading);
    }
}

/// Waits for the memory to read this many bytes of items, with `more` memory beside them.
async fn take_for_reading(app: &App, (bytes, more): (usize, usize)) -> Reading {
    let memory = &app.jobs.resources().memory;
    let is_large = bytes > 2 * SMALL;
    let share = match is_large {
        false => &memory.requests,
        true => &memory.reading,
    };
    let needed = READING.saturating_mul(bytes).saturating_add(more);
    let taken = share.take(Peer::current(), needed).await;
    let large_body = match is_large {
        true => Some(app.jobs.read_large_body().await),
        false => None,
    };
    Reading {
        _memory: taken,
        _large_body: large_body,
    }
}

/// Waits for memory for fits with steps of this cost.
async fn take_for_fits(app: &App, step_cost: usize, bytes: usize) -> Option<(Permit, usize)> {
    let taken = app.jobs.fit_memory(step_cost, bytes).await;
    taken.map(|permit| (permit, bytes))
}
