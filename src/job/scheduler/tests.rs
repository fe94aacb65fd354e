//! The order of turns, and the treatment of work that panics.

use std::sync::mpsc::TryRecvError;

use futures_util::future::join_all;

use super::*;

/// Notes the order in which its turns come.
struct Counting {
    id: usize,
    left: Mutex<usize>,
    log: Arc<Mutex<Vec<usize>>>,
}

impl Work for Counting {
    fn slice(&self, _deadline: Instant) -> Turn {
        self.log.lock().push(self.id);
        let mut left = self.left.lock();
        *left -= 1;
        if *left == 0 {
            Turn::Done
        } else {
            Turn::Again(WorkLane::Heavy)
        }
    }

    fn broken(&self) {}
}

#[tokio::test]
async fn turns_go_round_the_peers_and_then_their_work() {
    let scheduler = Scheduler::new(1).unwrap();
    let log = Arc::new(Mutex::new(Vec::new()));
    let (release, blocked) = std::sync::mpsc::channel::<()>();
    let first = scheduler.compute(WorkLane::Heavy, move || blocked.recv().is_ok());
    let works = async {
        for (id, last) in [(0, 1), (1, 1), (2, 1), (9, 2)] {
            let left = Mutex::new(4);
            let log = Arc::clone(&log);
            let peer = Some(Peer::at([192, 0, 2, last].into()));
            let work = Arc::new(Counting { id, left, log });
            scheduler.submit(WorkLane::Heavy, peer, work);
        }
        release.send(()).unwrap();
    };
    let (first, ()) = tokio::join!(first, works);
    assert_eq!(first, Ok(true));
    // Queued behind the rest: once it has run, the others have had their turns.
    while log.lock().len() < 16 {
        scheduler.compute(WorkLane::Heavy, || ()).await.unwrap();
    }
    assert_eq!(
        *log.lock(),
        [0, 9, 1, 9, 2, 9, 0, 9, 1, 2, 0, 1, 2, 0, 1, 2]
    );
}

#[tokio::test]
async fn the_long_lane_takes_the_least_and_the_first_in_turn() {
    let scheduler = Scheduler::new(1).unwrap();
    let log = Arc::new(Mutex::new(Vec::new()));
    let (release, blocked) = std::sync::mpsc::channel::<()>();
    let (start, started) = oneshot::channel();
    let first = scheduler.compute(WorkLane::Long(9), move || {
        let _ = start.send(());
        blocked.recv().is_ok()
    });
    let sizes = [7, 5, 6, 1, 3].map(|size| {
        let log = Arc::clone(&log);
        scheduler.compute(WorkLane::Long(size), move || log.lock().push(size))
    });
    // All of them wait when the first one ends.
    let others = async {
        started.await.unwrap();
        let release = async { release.send(()).unwrap() };
        tokio::join!(join_all(sizes), release);
    };
    tokio::join!(first, others).0.unwrap();
    assert_eq!(*log.lock(), [1, 7, 3, 5, 6]);
}

/// The long lane has one thread, and a computation on it ends only once that of another peer has run.
#[tokio::test]
async fn long_samples_let_shorter_work_of_others_run_in_between() {
    let scheduler = Arc::new(Scheduler::new(1).unwrap());
    let peer = |last| Some(Peer::at([192, 0, 2, last].into()));
    let (short, longer) = (
        WorkLane::Long(LONG_STEP_MULTIPLICATIONS),
        WorkLane::Long(3 * LONG_STEP_MULTIPLICATIONS),
    );
    let (start, started) = oneshot::channel();
    let (send, is_sent) = std::sync::mpsc::channel();
    let pool = Arc::clone(&scheduler);
    let long = Peer::scope(peer(1), async move {
        let compute = move || {
            let _ = start.send(());
            while is_sent.try_recv() == Err(TryRecvError::Empty) {
                interrupt::check();
                thread::yield_now();
            }
        };
        pool.compute_in_turns(WorkLane::Long(2 * LONG_STEP_MULTIPLICATIONS), compute)
            .await
    });
    let pool = Arc::clone(&scheduler);
    let others = async move {
        started.await.unwrap();
        // Neither longer work nor work of the same peer runs in between.
        let longer = Peer::scope(peer(2), pool.compute_in_turns(longer, || ()));
        let own = Peer::scope(peer(1), pool.compute_in_turns(short, || ()));
        let other = async {
            Peer::scope(peer(2), pool.compute_in_turns(short, || ())).await?;
            send.send(()).map_err(|_| Broken)
        };
        tokio::join!(longer, own, other)
    };
    let (long, others) = tokio::join!(long, others);
    assert_eq!((long, others), (Ok(()), (Ok(()), Ok(()), Ok(()))));
}

#[tokio::test]
async fn abandoned_tasks_are_cancelled() {
    let scheduler = Scheduler::new(1).unwrap();
    let (start, started) = oneshot::channel();
    let endless = scheduler.compute(WorkLane::Quick, move || {
        let _ = start.send(());
        loop {
            interrupt::check();
            thread::yield_now();
        }
    });
    tokio::select! {
        _ = endless => unreachable!(),
        started = started => started.unwrap(),
    }
    assert_eq!(scheduler.compute(WorkLane::Quick, || 7).await, Ok(7));
}

#[tokio::test]
async fn a_panic_breaks_only_its_own_work() {
    let scheduler = Scheduler::new(1).unwrap();
    let broken: Result<(), Broken> = scheduler
        .compute(WorkLane::Quick, || panic!("meant to happen"))
        .await;
    assert_eq!(broken, Err(Broken));
    assert_eq!(scheduler.compute(WorkLane::Quick, || 7).await, Ok(7));
}
