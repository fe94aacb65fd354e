//! Changes of one job take effect one after the other, in the order in which they were called.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::watch;
use uuid::Uuid;

/// The last change of each job that is not done yet.
#[derive(Default)]
pub(super) struct Order(Mutex<Last>);

#[derive(Default)]
struct Last {
    changes: HashMap<Uuid, (u64, watch::Receiver<()>)>,
    count: u64,
}

/// The place of a change among those of its job, until it is dropped.
pub(super) struct Place {
    order: Arc<Order>,
    id: Uuid,
    number: u64,
    before: Option<watch::Receiver<()>>,
    /// Those behind wait until this is dropped.
    _done: watch::Sender<()>,
}

impl Order {
    /// The place of a new change, behind those that are not done.
    pub(super) fn place(self: &Arc<Self>, id: Uuid) -> Place {
        let (done, behind) = watch::channel(());
        let mut last = self.0.lock();
        last.count += 1;
        let number = last.count;
        let before = last.changes.insert(id, (number, behind));
        Place {
            order: Arc::clone(self),
            id,
            number,
            before: before.map(|(_, before)| before),
            _done: done,
        }
    }

    /// Waits until the changes are done that have a place now.
    pub(super) async fn all_done(&self) {
        let pending: Vec<_> = self.0.lock().changes.values().cloned().collect();
        for (_, mut change) in pending {
            // Nothing is ever sent: this ends with the sender.
            let _ = change.changed().await;
        }
    }
}

impl Place {
    /// Waits for the changes before.
    pub(super) async fn come(&mut self) {
        if let Some(before) = &mut self.before {
            // Nothing is ever sent: this ends with the sender.
            let _ = before.changed().await;
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut last = self.order.0.lock();
        if last
            .changes
            .get(&self.id)
            .is_some_and(|it| it.0 == self.number)
        {
            last.changes.remove(&self.id);
        }
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    #[test]
    fn changes_of_a_job_wait_for_those_before() {
        let order = Arc::new(Order::default());
        let (id, other) = (Uuid::new_v4(), Uuid::new_v4());
        let [mut first, mut second, mut elsewhere] = [id, id, other].map(|id| order.place(id));
        let has_come = |place: &mut Place| place.come().now_or_never().is_some();
        assert!(has_come(&mut first) && !has_come(&mut second) && has_come(&mut elsewhere));
        drop(first);
        assert!(has_come(&mut second) && has_come(&mut second));
        assert!(order.all_done().now_or_never().is_none());
        drop((second, elsewhere));
        assert!(order.all_done().now_or_never().is_some());
        assert!(order.0.lock().changes.is_empty());
    }
}
