//! Readers that come, skip and go at random while a run computes.

use std::time::Duration;

use proptest::prelude::*;
use tokio::time::timeout;

use super::*;
use crate::job::outline::{Label, Outline};
use crate::job::resources::Resources;
use crate::job::run::SharedSystem;
use crate::job::samples::sine;
use crate::job::scheduler::Scheduler;
use crate::job::store::Record;
use piad_fit::engine::{Iteration, Problem, System};

const POINTS: u32 = 2000;
const LAST: usize = 1500;

/// The next action of a reader. Readers are chosen modulo their number.
#[derive(Clone, Copy, Debug)]
enum Action {
    /// A new reader from the level after the one that another reader has read last.
    Resume(usize),
    /// A new reader, this many levels after the one that the run has reached.
    AttachAhead(usize),
    Read(usize),
    /// A reader skips levels.
    Seek(usize, usize),
    Detach(usize),
    /// Lets the run compute.
    Wait(u64),
}

fn action() -> impl Strategy<Value = Action> {
    let reader = 0..8_usize;
    prop_oneof![
        3 => reader.clone().prop_map(Action::Resume),
        2 => (0..12_usize).prop_map(Action::AttachAhead),
        6 => reader.clone().prop_map(Action::Read),
        1 => (reader.clone(), 0..40_usize).prop_map(|(reader, skipped)| Action::Seek(reader, skipped)),
        3 => reader.prop_map(Action::Detach),
        1 => (0..300_u64).prop_map(Action::Wait),
    ]
}

/// The error and a coordinate of each level, by single steps of the plain loop.
fn levels_by_single_steps(problem: &Arc<Problem>) -> Vec<(f64, f64)> {
    let system = Arc::new(System::new(Arc::clone(problem)));
    let mut iteration = Iteration::start_plain(system);
    let mut levels = Vec::new();
    for _ in 0..=LAST {
        let middle = iteration.control_points().lanes()[1][POINTS as usize / 2];
        levels.push((iteration.level().error.max, middle));
        iteration.step();
    }
    levels
}

/// A running job whose run keeps only a few frames.
fn running_job(problem: &Arc<Problem>, frames: usize) -> (Arc<Job>, Arc<SharedSystem>) {
    let frame_bytes = Frame::weight(2, problem.most_control_points());
    let scheduler = Scheduler::new(2).unwrap();
    let resources = Arc::new(Resources::new(scheduler, 1 << 30, frames * frame_bytes));
    let outline = Outline::new(Label::default(), problem, None);
    let record = Record::new(outline, Status::running());
    let job = Arc::new(Job::new(record, None, None, (resources, Arc::default())));
    let system = Arc::new(SharedSystem::new(Arc::clone(problem), None));
    (job, system)
}

/// A cursor, and the level that it must give next.
struct Reader {
    cursor: Cursor,
    next: usize,
}

impl Reader {
    fn at(job: &Arc<Job>, next: usize) -> Self {
        let mut cursor = Cursor::new(Arc::clone(job), 0);
        cursor.seek(next);
        Self { cursor, next }
    }

    async fn read(&mut self, expected: &[(f64, f64)]) {
        let next = timeout(Duration::from_secs(60), self.cursor.next()).await;
        let Next::Frame(frame) = next.expect("a frame in time").unwrap() else {
            panic!("the end instead of iteration {}", self.next);
        };
        assert_eq!(frame.level.iteration, self.next);
        let middle = frame.control_points.lanes()[1][POINTS as usize / 2];
        assert_eq!((frame.level.error.max, middle), expected[self.next]);
        self.next += 1;
    }
}

async fn follow(frames: usize, actions: &[Action]) {
    let problem = Arc::new(sine(POINTS, LAST));
    let expected = levels_by_single_steps(&problem);
    let (job, system) = running_job(&problem, frames);
    let run = job.begin(Arc::clone(&system), None);
    let computed = tokio::spawn(async move { run.complete().await });
    let mut readers = vec![Reader::at(&job, 0)];
    for &action in actions {
        let count = readers.len();
        match action {
            Action::Resume(reader) if count > 0 => {
                let next = readers[reader % count].next;
                readers.push(Reader::at(&job, next));
            }
            Action::AttachAhead(ahead) | Action::Resume(ahead) => {
                let reached = job.status().levels;
                let reached = reached.map_or(0, |levels| levels.last.iteration);
                readers.push(Reader::at(&job, (reached + ahead).min(LAST)));
            }
            Action::Wait(microseconds) => {
                tokio::time::sleep(Duration::from_micros(microseconds)).await;
            }
            _ if count == 0 => {}
            Action::Detach(reader) => drop(readers.swap_remove(reader % count)),
            Action::Seek(reader, skipped) => {
                let reader = &mut readers[reader % count];
                reader.next = (reader.next + skipped).min(LAST);
                reader.cursor.seek(reader.next);
            }
            Action::Read(reader) => {
                let reader = &mut readers[reader % count];
                if reader.next <= LAST {
                    reader.read(&expected).await;
                }
            }
        }
    }
    drop(readers);
    drop(system);
    job.request_cancel();
    computed.await.unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]

    // Readers that do not read hold others up for a second each, which bounds how many there can be.
    /// Every reader gets the level that it counts by hand, with the numbers of that level, however few frames
    /// are kept and however many steps the run takes at once.
    #[test]
    fn readers_get_the_levels_that_they_ask_for(
        frames in 1..5_usize,
        actions in prop::collection::vec(action(), 10..40),
    ) {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        runtime.unwrap().block_on(follow(frames, &actions));
    }
}
