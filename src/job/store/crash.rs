//! Which jobs are to blame for a crash of the process, and what becomes of those that were running.
//!
//! The jobs that were running in a crash are suspects. After the next start they run again a few at a time,
//! each under watch at first. If the process crashes meanwhile, those under watch are to blame, and jobs
//! that have not been in a crash before; the other suspects are not. So there are fewer suspects after each
//! crash, until one is left.

use jiff::Timestamp;

use super::Record;
use crate::job::state::{Failure, State, Status};

/// A job that alone is to blame for its last crash is not run again after so many.
pub const MOST_CRASHES: u32 = 3;

/// A job is not run again after so many crashes, however many others are to blame for them.
pub const MOST_SHARED_CRASHES: u32 = 6;

/// A crash of the process.
#[derive(Clone, Copy, Debug, Default)]
pub struct Crash {
    /// Jobs that were running under watch, or for the first time.
    likely: usize,
    /// Jobs that were running under watch.
    watched: usize,
    /// All jobs that were running.
    running: usize,
}

impl Crash {
    /// Takes note of a job that was there when the process ended.
    pub fn note(&mut self, record: &Record) {
        if record.status.state == State::Running {
            self.running += 1;
            self.watched += usize::from(record.watched);
            self.likely += usize::from(record.is_likely_culprit());
        }
    }

    /// The record after the crash: what was running goes back to the queue, unless it is known to
    /// bring the process down. `None` if nothing changes.
    pub fn recovered(&self, record: &Record) -> Option<Record> {
        if record.status.state != State::Running {
            return None;
        }
        let (blamed, share) = match self.watched {
            0 => (true, self.running),
            _ => (record.is_likely_culprit(), self.likely),
        };
        let crashes = record.crashes + u32::from(blamed);
        let most = match share {
            1 => MOST_CRASHES,
            _ => MOST_SHARED_CRASHES,
        };
        let status = match blamed && crashes >= most {
            true => Status {
                state: State::Failed,
                finished: Some(Timestamp::now()),
                failure: Some(Failure::Crashes),
                ..record.status.clone()
            },
            false => Status::QUEUED,
        };
        Some(Record {
            status,
            crashes,
            watched: false,
            ..record.clone()
        })
    }
}

impl Record {
    /// Whether a crash is blamed on the job though others were running.
    fn is_likely_culprit(&self) -> bool {
        self.watched || self.crashes == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::crash_recovery::PARTS;
    use crate::job::samples;

    fn running() -> Record {
        let status = Status::running();
        Record {
            status,
            ..samples::queued()
        }
    }

    fn crash(jobs: &mut [Record]) {
        let mut crash = Crash::default();
        jobs.iter().for_each(|job| crash.note(job));
        for job in jobs {
            *job = crash.recovered(job).unwrap_or_else(|| job.clone());
        }
    }

    /// A life of the process, in which suspects run under watch part by part. It ends with the
    /// culprit; says whether it has ended.
    fn live(jobs: &mut [Record], culprit: usize) -> bool {
        for crashes in (1..=MOST_SHARED_CRASHES).rev() {
            let suspect = |job: &Record| job.crashes == crashes && job.status == Status::QUEUED;
            let group: Vec<usize> = (0..jobs.len()).filter(|&i| suspect(&jobs[i])).collect();
            let part = group.len().div_ceil(PARTS as usize).max(1);
            for part in group.chunks(part) {
                for &i in part {
                    (jobs[i].status, jobs[i].watched) = (Status::running(), true);
                }
                if part.contains(&culprit) {
                    crash(jobs);
                    return true;
                }
                part.iter().for_each(|&i| jobs[i].watched = false);
            }
        }
        false
    }

    #[test]
    fn one_of_many_suspects_is_found_after_a_few_crashes() {
        for (count, most) in [(1, 3), (2, 3), (40, 3), (1000, 3), (10_000, 4)] {
            for culprit in [0, count / 3, count - 1] {
                let mut jobs: Vec<_> = (0..count).map(|_| running()).collect();
                crash(&mut jobs);
                let mut crashes = 1;
                while live(&mut jobs, culprit) {
                    crashes += 1;
                }
                assert_eq!(crashes, most, "{count} jobs");
                for (i, job) in jobs.iter().enumerate() {
                    let failed = job.status.failure == Some(Failure::Crashes);
                    assert_eq!(failed, i == culprit, "{i} of {count}");
                }
            }
        }
    }

    #[test]
    fn a_job_that_is_new_is_suspect_and_one_that_was_cleared_is_not() {
        let (mut cleared, mut watched) = (running(), running());
        (cleared.crashes, watched.crashes, watched.watched) = (1, 2, true);
        let mut jobs = [running(), cleared, watched];
        crash(&mut jobs);
        assert_eq!(jobs.each_ref().map(|job| job.crashes), [1, 1, 3]);
        // Two of them may be to blame, so none is given up.
        assert!(jobs.iter().all(|job| job.status == Status::QUEUED));
    }

    #[test]
    fn jobs_that_crash_late_and_in_company_are_given_up_in_the_end() {
        let mut jobs = [running(), running()];
        for crashes in 1..=MOST_SHARED_CRASHES {
            assert!(jobs.iter().all(|job| job.crashes + 1 == crashes));
            jobs.iter_mut()
                .for_each(|job| job.status = Status::running());
            crash(&mut jobs);
        }
        let failed = |job: &Record| job.status.failure == Some(Failure::Crashes);
        assert!(jobs.iter().all(failed));
    }
}
