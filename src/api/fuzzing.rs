//! What the fuzz targets call (`fuzz/`): each decoder with any bytes, and what must hold of all that it
//! accepts. Tests give it the seeds.
//!
//! A job that is accepted is written again, in JSON, as a message and as it is kept in the store, and each
//! is read again: the problem is the same to the last bit. Then its first levels are computed.

use std::sync::{Arc, OnceLock};

use bytes::Bytes;

use crate::api::json::request::{edit as json_edit, job as json_job};
use crate::api::json::view;
use crate::api::problem::{Problem as Refusal, Words};
use crate::api::proto;
use crate::config::Config;
use crate::fit::iteration::Iteration;
use crate::fit::points::Points;
use crate::fit::problem::Problem;
use crate::fit::system::System;
use crate::job::outline::{Label, Outline};
use crate::job::state::{Levels, State, Status};
use crate::job::store::embedded::fuzzing as store;
use crate::job::store::{Record, StoreError};
use crate::model::edit::{EditSpec, ParentFit};
use crate::model::job::ValidJob;
use crate::model::mistakes::MOST_MISTAKES;

/// Jobs of more points are read and written, but not computed.
const MOST_POINTS: usize = 50;

/// Nor are those that take more multiplications before the first level.
const MOST_WORK: usize = 1_000_000;

/// The levels that are computed after the first.
const LEVELS: usize = 3;

/// The most bytes of an answer that says what is wrong with a request.
const LONGEST_ANSWER: usize = 64 * 1024;

/// The body of `POST /v1/jobs` in JSON.
pub fn job(bytes: &[u8]) {
    if let Some(job) = accepted(job_of_json(bytes)) {
        check(&job);
    }
}

/// The body of `POST /v1/jobs/{id}/edits` in JSON, for each of a few jobs.
pub fn edit(bytes: &[u8]) {
    parents()
        .iter()
        .for_each(|parent| check_edit(edit_of_json(parent, bytes)));
}

/// The body of `POST /v1/jobs` as a protobuf message.
pub fn message(bytes: &[u8]) {
    if let Some(job) = accepted(job_of_message(bytes)) {
        check(&job);
    }
}

/// The body of `POST /v1/jobs/{id}/edits` as a protobuf message, for each of the same jobs.
pub fn edit_message(bytes: &[u8]) {
    parents()
        .iter()
        .for_each(|parent| check_edit(edit_of_message(parent, bytes)));
}

/// A record of the store. The first byte says of which kind.
pub fn record(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    match kind % 4 {
        0 => check_kept(store::record(bytes), store::kept_record, store::record),
        1 => check_kept(store::points(bytes), store::kept_points, store::points),
        2 => check_kept(store::entry(bytes), store::kept_entry, store::entry),
        _ => {
            let problem = store::problem(bytes);
            if let Ok(problem) = &problem {
                compute(problem);
            }
            check_kept(problem, store::kept, store::problem);
        }
    }
}

fn config() -> &'static Config {
    static CONFIG: OnceLock<Config> = OnceLock::new();
    CONFIG.get_or_init(Config::standard)
}

fn job_of_json(bytes: &[u8]) -> Result<ValidJob, Refusal> {
    json_job::read(Bytes::copy_from_slice(bytes), config())
}

fn job_of_message(bytes: &[u8]) -> Result<ValidJob, Refusal> {
    proto::request::read(Bytes::copy_from_slice(bytes), config())
}

/// What was accepted. A refusal says what is wrong, and not at any length.
fn accepted<T>(outcome: Result<T, Refusal>) -> Option<T> {
    let refusal = match outcome {
        Ok(accepted) => return Some(accepted),
        Err(refusal) => refusal,
    };
    assert!(!refusal.detail().is_empty(), "{refusal:?}");
    assert!(refusal.errors().len() <= MOST_MISTAKES, "{refusal:?}");
    let answer = view::to_bytes(&refusal.body(None));
    assert!(answer.len() <= LONGEST_ANSWER, "{refusal:?}");
    None
}

/// The outline of a job. Nothing depends on its id.
fn outline(job: &ValidJob) -> Outline {
    let label = Label {
        name: job.name.clone(),
        parent: None,
        stream: job.stream.clone(),
    };
    Outline::new(label, &job.problem)
}

/// What must hold of every job that is accepted: what is written of it asks for the same job.
fn check(job: &ValidJob) {
    let outline = outline(job);
    let json = view::input::input(&outline, &job.problem);
    check_same(job, &job_of_json(&json));
    let message = proto::view::input(&outline, &job.problem);
    check_same(job, &job_of_message(&message));
    check_run(outline, &job.problem);
}

fn check_same(job: &ValidJob, again: &Result<ValidJob, Refusal>) {
    assert!(again.is_ok(), "{again:?} for what was written of {job:?}");
    if let Ok(again) = again {
        assert_eq!((&again.name, &again.stream), (&job.name, &job.stream));
        let kept = (store::kept(&again.problem), store::kept(&job.problem));
        assert!(kept.0 == kept.1, "{again:?} for {job:?}");
    }
}

/// What was read from the store is there again after it was written: to the last bit, as not all
/// numbers are equal to themselves.
fn check_kept<T>(
    read: Result<T, StoreError>,
    write: impl Fn(&T) -> Vec<u8>,
    read_again: impl Fn(&[u8]) -> Result<T, StoreError>,
) {
    let Ok(read) = read else { return };
    let kept = write(&read);
    match read_again(&kept) {
        Ok(again) => assert_eq!(write(&again), kept),
        Err(error) => assert_eq!(error.to_string(), "it can be read", "{kept:?}"),
    }
}

/// A job is kept as it is, before it runs and after.
fn check_run(outline: Outline, problem: &Problem) {
    let kept = store::kept(problem);
    check_kept(store::problem(&kept), store::kept, store::problem);
    let iteration = compute(problem);
    if let Some(iteration) = &iteration {
        let kept = store::kept_points(iteration.control_points());
        check_kept(store::points(&kept), store::kept_points, store::points);
    }
    let record = record_of(outline, iteration.as_ref());
    let kept = store::kept_record(&record);
    check_kept(store::record(&kept), store::kept_record, store::record);
}

/// The record of a job, which was cancelled if it has begun.
fn record_of(outline: Outline, iteration: Option<&Iteration>) -> Record {
    let levels = iteration.map(|iteration| Levels {
        first: iteration.level(),
        last: iteration.level(),
        forecast: iteration.system().forecast(),
    });
    let (created, begun) = (outline.created, iteration.is_some());
    Record {
        outline,
        status: Status {
            state: if begun {
                State::Cancelled
            } else {
                State::Queued
            },
            levels,
            started: begun.then_some(created),
            finished: begun.then_some(created),
            ..Status::QUEUED
        },
        crashes: 0,
        watched: false,
    }
}

/// The first levels of a small problem.
fn compute(problem: &Problem) -> Option<Iteration> {
    if problem.grid().count() > MOST_POINTS || problem.start_cost() > MOST_WORK {
        return None;
    }
    let system = Arc::new(System::new(Arc::new(problem.clone())));
    let mut iteration = Iteration::start_plain(system);
    for _ in 0..LEVELS {
        if iteration.outcome().is_some() {
            break;
        }
        iteration.step();
    }
    Some(iteration)
}

/// A job that is edited.
struct Parent {
    outline: Outline,
    problem: Problem,
    control_points: Arc<Points>,
}

/// A curve, one with weights, one with fixed weights, a surface, and one with missing points.
const PARENTS: [&str; 5] = [
    include_str!("../../fuzz/seeds/job/curve.json"),
    include_str!("../../fuzz/seeds/job/homogeneous.json"),
    include_str!("../../fuzz/seeds/job/fixed.json"),
    include_str!("../../fuzz/seeds/job/surface.json"),
    include_str!("../../fuzz/seeds/job/missing.json"),
];

fn parents() -> &'static [Parent] {
    static JOBS: OnceLock<Vec<Parent>> = OnceLock::new();
    JOBS.get_or_init(|| {
        let parent = |text: &&str| {
            let job = job_of_json(text.as_bytes()).ok()?;
            Some(Parent {
                outline: outline(&job),
                control_points: compute(&job.problem)?.shared_control_points(),
                problem: job.problem,
            })
        };
        PARENTS.iter().filter_map(parent).collect()
    })
}

fn edit_of_json(parent: &Parent, bytes: &[u8]) -> Result<ValidJob, Refusal> {
    let (spec, places) = json_edit::read(Bytes::copy_from_slice(bytes), &parent.outline)?;
    parent.edited(spec, &places)
}

fn edit_of_message(parent: &Parent, bytes: &[u8]) -> Result<ValidJob, Refusal> {
    let most = parent.outline.grid.count();
    let message = proto::request::decode(Bytes::copy_from_slice(bytes), most)?;
    let (spec, layout) = proto::edit::edit(message, &parent.outline)?;
    parent.edited(spec, &layout)
}

impl Parent {
    fn edited(&self, spec: EditSpec, words: &impl Words) -> Result<ValidJob, Refusal> {
        let origin = ParentFit {
            problem: &self.problem,
            control_points: &self.control_points,
            lambda_min: None,
            stream: None,
        };
        let edited = spec.apply(&origin, config().limits());
        edited.map_err(|mistakes| Refusal::of_mistakes(mistakes, words))
    }
}

/// What must hold of every edit that is accepted. What is written of it asks for its problem from the
/// start.
fn check_edit(edited: Result<ValidJob, Refusal>) {
    let Some(job) = accepted(edited) else {
        return;
    };
    let outline = outline(&job);
    let json = view::input::input(&outline, &job.problem);
    let again = job_of_json(&json);
    assert!(again.is_ok(), "{again:?} for what was written of {job:?}");
    if let Ok(again) = again {
        let again = view::input::input(&outline, &again.problem);
        assert_eq!(again, json);
    }
    check_run(outline, &job.problem);
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use jiff::Timestamp;
    use prost::Message;
    use uuid::Uuid;

    use super::*;
    use crate::job::store::IdempotencyEntry;
    use crate::proto::messages as pb;

    /// Each seed of a target, which says itself what it is.
    fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
        let files = fs::read_dir(Path::new("fuzz/seeds").join(target)).unwrap();
        files
            .map(|file| {
                let path = file.unwrap().path();
                let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
                (name, fs::read(path).unwrap())
            })
            .collect()
    }

    /// Calls a target with a seed that was made of one of the jobs, and keeps it for the fuzzer where
    /// that is asked for.
    fn sow(target: &str, name: &str, bytes: &[u8]) {
        match target {
            "message" => message(bytes),
            "edit_message" => edit_message(bytes),
            _ => record(bytes),
        }
        if std::env::var_os("PIAD_WRITE_SEEDS").is_some() {
            let corpus = Path::new("fuzz/corpus").join(target);
            fs::create_dir_all(&corpus).unwrap();
            fs::write(corpus.join(name), bytes).unwrap();
        }
    }

    #[test]
    fn seeds_are_jobs_and_pass_through_every_decoder() {
        for (name, seed) in seeds("job") {
            job(&seed);
            let job = job_of_json(&seed).unwrap();
            let outline = outline(&job);
            sow(
                "message",
                &name,
                &proto::view::input(&outline, &job.problem),
            );
            let iteration = compute(&job.problem).unwrap();
            let entry = IdempotencyEntry {
                id: Uuid::from_u128(1),
                digest: [7; 32],
                created: Timestamp::UNIX_EPOCH,
            };
            let records = [
                store::kept_record(&record_of(outline, Some(&iteration))),
                store::kept_points(iteration.control_points()),
                store::kept_entry(&entry),
                store::kept(&job.problem),
            ];
            for (kind, bytes) in (0..).zip(records) {
                let bytes = [&[kind], bytes.as_slice()].concat();
                sow("record", &format!("{name}-{kind}"), &bytes);
            }
        }
    }

    #[test]
    fn seeds_are_edits_of_a_parent() {
        assert_eq!(parents().len(), PARENTS.len());
        for (name, seed) in seeds("edit") {
            edit(&seed);
            let fits = |parent| edit_of_json(parent, &seed).is_ok();
            assert!(parents().iter().any(fits), "{name}");
        }
        for (name, edit) in messages() {
            let bytes = edit.encode_to_vec();
            sow("edit_message", name, &bytes);
            let fits = |parent| edit_of_message(parent, &bytes).is_ok();
            assert!(parents().iter().any(fits), "{name}");
        }
    }

    /// Edits as messages.
    fn messages() -> [(&'static str, pb::Edit); 3] {
        let moved = pb::Edit {
            name: Some("moved".to_owned()),
            moved: vec![1, 2],
            points: vec![0.9, 0.03, 0.8, 0.02],
            ..pb::Edit::default()
        };
        let weighted = pb::Edit {
            iteration: Some(2),
            weighted: vec![1],
            point_weights: vec![3.0],
            method: Some(pb::Method {
                kind: Some(pb::method::Kind::Global(pb::method::Global {})),
            }),
            ..pb::Edit::default()
        };
        let reweighted = pb::Edit {
            weights: Some(pb::Weights {
                values: vec![1.0, 2.0, 3.0, 4.0],
                ..pb::Weights::default()
            }),
            stop: Some(pb::StopRules {
                max_iterations: Some(7),
                ..pb::StopRules::default()
            }),
            ..pb::Edit::default()
        };
        [
            ("moved", moved),
            ("weighted", weighted),
            ("reweighted", reweighted),
        ]
    }
}
