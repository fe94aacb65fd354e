//! Readers that share a run.

use futures_util::FutureExt;

use super::attached::Attached;
use super::*;
use crate::job::samples::problem;
use crate::job::scheduler::Scheduler;

/// Waits for a frame that is on its way.
async fn arrives(reader: &Attached, index: usize) {
    for _ in 0..1000 {
        if let FrameLookup::Frame(frame) = reader.read(index) {
            return assert_eq!(frame.level.iteration, index);
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("frame {index} has not come");
}

/// With a ring of one frame readers wait for each other, until the budget of one is used up.
#[tokio::test]
async fn readers_of_large_frames_wait_for_each_other() {
    let scheduler = Scheduler::new(1).unwrap();
    let resources = Arc::new(Resources::new(scheduler, 1 << 30, 0));
    let system = Arc::new(SharedSystem::new(Arc::new(problem()), None));
    let run = Run::new(system, Arc::clone(&resources), None, None, Arc::default());
    let quick = Attached::to_new(Arc::clone(&run), 0, None);
    let slow = run.attach(0, None, false).unwrap();
    quick.want(0, &mut None);
    arrives(&quick, 0).await;
    arrives(&slow, 0).await;
    // The other one has not taken frame 0 yet.
    assert!(matches!(quick.read(1), FrameLookup::Later));
    quick.want(1, &mut None);
    tokio::time::sleep(Duration::from_millis(50)).await;
    assert!(matches!(quick.read(1), FrameLookup::Later));
    assert!(matches!(slow.read(1), FrameLookup::Later));
    slow.want(1, &mut None);
    arrives(&quick, 1).await;
    arrives(&slow, 1).await;
    assert!(matches!(quick.read(2), FrameLookup::Later));
    let mut waiting = None;
    while let Some(until) = quick.want(2, &mut waiting) {
        tokio::time::sleep_until(until.into()).await;
    }
    arrives(&quick, 2).await;
    assert!(matches!(slow.read(1), FrameLookup::Gone));
    drop(slow);
    assert!(matches!(quick.read(3), FrameLookup::Later));
    quick.want(3, &mut None);
    arrives(&quick, 3).await;
    assert_eq!(resources.counters.iterations.get(), 4);
}

/// A run that was stopped delivers what it has. Readers that want more leave it when the job
/// continues elsewhere.
#[tokio::test]
async fn a_stopped_run_is_left_by_readers_that_want_more() {
    let scheduler = Scheduler::new(1).unwrap();
    let resources = Arc::new(Resources::new(scheduler, 1 << 30, 0));
    let system = Arc::new(SharedSystem::new(Arc::new(problem()), None));
    let run = Run::new(system, resources, None, None, Arc::default());
    let reader = Attached::to_new(Arc::clone(&run), 0, None);
    reader.want(0, &mut None);
    arrives(&reader, 0).await;
    run.stop();
    let reached = run.levels().unwrap().last.iteration;
    assert!(matches!(reader.read(reached + 1), FrameLookup::Stopped));
    assert!(run.attach(reached, None, true).is_some());
    assert!(run.attach(reached + 1, None, false).is_some());
    assert!(run.attach(reached + 1, None, true).is_none());
}

/// A reader that waits for a level far ahead is not woken by those before it.
#[tokio::test]
async fn readers_of_far_levels_sleep() {
    let scheduler = Scheduler::new(1).unwrap();
    let resources = Arc::new(Resources::new(scheduler, 1 << 30, 1 << 20));
    let system = Arc::new(SharedSystem::new(Arc::new(problem()), None));
    let run = Run::new(system, resources, None, None, Arc::default());
    let quick = Attached::to_new(Arc::clone(&run), 0, None);
    let patient = run.attach(5, None, false).unwrap();
    for index in 0..5 {
        assert!(patient.news().now_or_never().is_none(), "{index}");
        let _ = quick.read(index);
        run.want(index);
        quick.news().await;
        arrives(&quick, index).await;
    }
    run.want(5);
    patient.news().await;
    arrives(&patient, 5).await;
    // The end concerns all readers.
    assert!(matches!(patient.read(1_000_000), FrameLookup::Later));
    run.stop();
    patient.news().await;
}

/// With a full cache the frame that a reader waits for stays until it comes for it.
#[tokio::test]
async fn a_full_cache_leaves_readers_their_next_frame() {
    let scheduler = Scheduler::new(1).unwrap();
    let resources = Arc::new(Resources::new(scheduler, 1 << 20, 1 << 20));
    let _full = resources.memory.cache.charge(1 << 20);
    let system = Arc::new(SharedSystem::new(Arc::new(problem()), None));
    let run = Run::new(system, resources, None, None, Arc::default());
    let reader = Attached::to_new(run, 5, None);
    for index in 5..10 {
        assert!(matches!(reader.read(index), FrameLookup::Later));
        reader.want(index, &mut None);
        reader.news().await;
        // It would have come far meanwhile.
        tokio::time::sleep(Duration::from_millis(20)).await;
        arrives(&reader, index).await;
    }
}
