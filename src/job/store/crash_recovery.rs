//! Crash recovery: the treatment of the jobs that were running when the process crashed.
//!
//! They go back to the queue and run again one at a time: each is on probation for a moment before the
//! next one starts. If the process crashes meanwhile, the crash is counted for the job on probation and
//! for jobs that were running for the first time, not for jobs that have passed. So a job that crashes the
//! process as soon as it runs fails after [`MOST_CRASHES`], and the others do not.
//!
//! Crashes while nothing is on probation are counted for every running job, but none fails with them: a request, or
//! something outside the process, may be the cause. With each crash that is counted for a job its next probation is
//! twice as long, up to [`LONGEST_PROBATION`], so that it is on probation when it crashes the process again. An orderly
//! stop clears the counts.

use std::time::Duration;

use jiff::Timestamp;

use super::Record;
use crate::job::state::{Failure, State, Status};

/// A job that was running in this many crashes, and on probation in the last one, is not run again.
pub(crate) const MOST_CRASHES: u32 = 3;

/// How long a job that was running in a crash runs before the next one starts.
const PROBATION: Duration = Duration::from_millis(250);

/// The longest probation of a job that was running in many crashes.
const LONGEST_PROBATION: Duration = Duration::from_secs(32);

/// How long a job that was running in this many crashes runs before the next one starts.
pub(crate) fn probation(crashes: u32) -> Duration {
    let factor = 2_u32.saturating_pow(crashes.saturating_sub(1));
    PROBATION.saturating_mul(factor).min(LONGEST_PROBATION)
}

impl Record {
    /// Returns true if it was on probation in the crash.
    pub(crate) fn was_on_probation(&self) -> bool {
        self.status.state == State::Running && self.on_probation
    }

    /// Puts a job that was running in a crash back into the queue, or fails it.
    pub(crate) fn recover(&mut self, any_on_probation: bool) {
        let counts = !any_on_probation || self.on_probation || self.crashes == 0;
        self.crashes += u32::from(counts);
        let fails = self.on_probation && self.crashes >= MOST_CRASHES;
        self.on_probation = false;
        self.status = match fails {
            true => Status {
                state: State::Failed,
                finished: Some(Timestamp::now()),
                failure: Some(Failure::Crashes),
                // They are not computed again.
                levels: None,
                ..self.status.clone()
            },
            false => Status::QUEUED,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::samples;

    fn run(job: &mut Record, on_probation: bool) {
        (job.status, job.on_probation) = (Status::running(), on_probation);
    }

    fn crash(jobs: &mut [Record]) {
        let any_on_probation = jobs.iter().any(Record::was_on_probation);
        let running = |job: &&mut Record| job.status.state == State::Running;
        let running = jobs.iter_mut().filter(running);
        running.for_each(|job| job.recover(any_on_probation));
    }

    fn has_failed(job: &Record) -> bool {
        job.status.failure == Some(Failure::Crashes)
    }

    #[test]
    fn a_job_that_crashes_the_process_at_once_fails_alone() {
        let mut jobs: Vec<_> = (0..10).map(|_| samples::queued()).collect();
        let culprit = 4;
        jobs.iter_mut().for_each(|job| run(job, false));
        crash(&mut jobs);
        for _ in 1..MOST_CRASHES {
            assert!(!has_failed(&jobs[culprit]));
            for job in &mut jobs[..culprit] {
                run(job, false);
            }
            run(&mut jobs[culprit], true);
            crash(&mut jobs);
        }
        for (i, job) in jobs.iter().enumerate() {
            assert_eq!(has_failed(job), i == culprit, "{i}");
        }
    }

    #[test]
    fn a_new_job_is_counted_beside_one_on_probation() {
        let mut jobs = [samples::queued(), samples::queued()];
        run(&mut jobs[0], false);
        (jobs[1].crashes, jobs[1].status) = (1, Status::running());
        jobs[1].on_probation = true;
        crash(&mut jobs);
        assert_eq!(jobs.each_ref().map(|job| job.crashes), [1, 2]);
    }

    #[test]
    fn a_job_that_crashes_the_process_late_fails_in_the_end_and_alone() {
        let mut jobs = [samples::queued(), samples::queued()];
        let late = Duration::from_secs(10);
        for crashes in 1.. {
            let before = jobs[0].crashes;
            let is_on_probation = before > 0 && probation(before) > late;
            run(&mut jobs[0], is_on_probation);
            // It has passed, or waits for its turn.
            run(&mut jobs[1], false);
            crash(&mut jobs);
            assert_eq!(jobs[0].crashes, crashes);
            if has_failed(&jobs[0]) {
                assert_eq!(crashes, 8);
                break;
            }
        }
        assert!(!has_failed(&jobs[1]));
    }

    #[test]
    fn crashes_after_a_probation_fail_no_job() {
        let mut jobs = [samples::queued(), samples::queued()];
        for crashes in 1..100 {
            jobs.iter_mut().for_each(|job| run(job, false));
            crash(&mut jobs);
            assert!(jobs.iter().all(|job| job.crashes == crashes));
        }
        assert!(!jobs.iter().any(has_failed));
        assert_eq!(probation(jobs[0].crashes), LONGEST_PROBATION);
    }
}
