//! Some items of a batch, computed one after another on a thread of the compute pool: handing over each of them alone
//! would take longer than a small fit.

use std::sync::Arc;
use std::time::{Duration, Instant};
use std::vec;

use super::answer::{self, LineHead, Lines};
use super::defaults::Defaults;
use super::item::{Item, ItemLocator, ReadItem};
use super::settings::Settings;
use crate::api::create_job::PARSED_AT_ONCE;
use crate::api::media_type::Language;
use crate::api::problem::Problem;
use crate::api::proto::bounds;
use crate::api::start::Base;
use crate::api::stream::encode::Cost;
use crate::job::direct::{DirectFit, EndedFit};
use crate::job::errand::{Errand, Progress};
use crate::job::memory::Permit;
use crate::job::outline::{Label, Outline};
use crate::job::probation::LargeBody;
use crate::job::scheduler::WorkLane;
use crate::job::state::{Failure, State};
use crate::model::job::JobRequest;
use crate::model::scattered::{self, FootPoints};
use crate::model::stream::form::Form;
use crate::proto::messages as pb;

/// Fits that take up to this many bytes need no memory of their own: a group has that much from the start.
pub(super) const SMALL_FIT: usize = 1024 * 1024;

/// The lines of a group are sent when they have this many bytes.
const GROUP_BYTES: usize = 128 * 1024;

/// Some items, and their results.
pub(super) struct Group {
    settings: Arc<Settings>,
    items: vec::IntoIter<Item>,
    /// The item that is being computed.
    current: Option<Item>,
    stage: Stage,
    /// The queue that it works on.
    lane: WorkLane,
    lines: Lines,
    /// What it waits for, if it pauses before its end.
    want: Option<Want>,
    /// Held until the last item was read.
    pub(super) reading: Option<Reading>,
    /// The memory for fits, and its size.
    memory: Option<(Permit, usize)>,
    /// The time it has computed.
    busy: Duration,
}

/// The stage of the current item.
enum Stage {
    /// To be read.
    Unread,
    /// To be validated.
    Read(Box<JobRequest>, ItemLocator, Base),
    /// To be fitted, and returned in this form.
    Fitting(Fitting),
    /// Its line is to be written.
    Ended(Fitting, Box<EndedFit>),
}

struct Fitting {
    name: Option<String>,
    /// Notices about the file of its points, and choices of the fit.
    notices: Vec<String>,
    form: Form,
    fit: DirectFit,
}

/// A resource that a group waits for.
pub(super) enum Want {
    /// The surface to which an item refers.
    Base(FootPoints),
    /// This much memory for a fit with steps of this cost.
    Memory { step_cost: usize, bytes: usize },
    /// Sending of its lines.
    Send,
}

/// Memory to read items.
pub(super) struct Reading {
    pub(super) _memory: Option<Permit>,
    /// A large item is read; jobs on probation do not run meanwhile.
    pub(super) _large_body: Option<LargeBody>,
}

impl Group {
    /// Nothing is computed yet.
    pub(super) fn new(settings: Arc<Settings>, items: Vec<Item>) -> Self {
        let lines = Lines::new(settings.framing);
        Self {
            settings,
            items: items.into_iter(),
            current: None,
            stage: Stage::Unread,
            lane: WorkLane::Quick,
            lines,
            want: None,
            reading: None,
            memory: None,
            busy: Duration::ZERO,
        }
    }

    /// The queue that its next slice belongs to.
    pub(super) fn lane(&mut self) -> WorkLane {
        self.lane = self.next_lane();
        self.lane
    }

    /// What it waits for; `None` at its end.
    pub(super) fn take_want(&mut self) -> Option<Want> {
        self.want.take()
    }

    /// The lines so far, which are taken out.
    pub(super) fn take_lines(&mut self) -> Lines {
        let lines = Lines::new(self.settings.framing);
        let lines = std::mem::replace(&mut self.lines, lines);
        lines.counted(&self.settings.app.jobs.resources().memory.cache)
    }

    /// The number of bytes to be read, and the additional memory for them.
    pub(super) fn unread(&self) -> (usize, usize) {
        let of_defaults = self.settings.defaults().map_or(0, Defaults::size);
        let items = self.items.as_slice().iter();
        let sizes = items.map(|item| {
            let more = match self.settings.language {
                Language::Json => 0,
                Language::Protobuf => bounds::memory::<pb::JobInput>(&item.bytes),
            };
            (item.bytes.len() + of_defaults, more)
        });
        let add = |(bytes, more), (b, m)| (bytes + b, more + m);
        sizes.fold((0, 0), add)
    }

    /// The time it has computed.
    pub(super) fn busy(&self) -> Duration {
        self.busy
    }

    /// Gives it memory for fits; `None` while it waits for something else.
    pub(super) fn set_memory(&mut self, memory: Option<(Permit, usize)>) {
        self.memory = memory;
    }

    /// Gives it the surface to which the current item refers, or why there is none.
    pub(super) fn set_base(&mut self, found: Result<Base, Problem>) {
        match (&mut self.stage, found) {
            (Stage::Read(_, _, base), Ok(found)) => *base = found,
            (_, Ok(_)) => {}
            (_, Err(problem)) => self.fail(problem),
        }
    }

    /// Continues with the next item after a panic, which is a bug.
    pub(super) fn break_off(&mut self) {
        self.fail(Problem::from(Failure::Defect));
    }

    fn next_lane(&self) -> WorkLane {
        let of_reading = |item: Option<&Item>| match item {
            Some(item) if item.bytes.len() > PARSED_AT_ONCE => WorkLane::Wire,
            _ => WorkLane::Quick,
        };
        match &self.stage {
            Stage::Unread => of_reading(self.items.as_slice().first()),
            Stage::Read(_, _, base) if base.is_given() => WorkLane::Wire,
            Stage::Read(..) => of_reading(self.current.as_ref()),
            Stage::Fitting(fitting) => fitting.fit.lane(),
            Stage::Ended(fitting, ended) => {
                let cost = ended.frame.as_ref();
                let cost = cost.map(|frame| Cost::of(frame, fitting.form.view));
                cost.map_or(WorkLane::Quick, Cost::lane)
            }
        }
    }

    /// Advances the current item by one stage; returns false if that has to wait.
    fn step(&mut self, deadline: Instant) -> bool {
        match std::mem::replace(&mut self.stage, Stage::Unread) {
            Stage::Unread => self.read(),
            Stage::Read(request, locator, base) => self.check(*request, &locator, base),
            Stage::Fitting(fitting) => self.fit(fitting, deadline),
            Stage::Ended(fitting, ended) => self.write(fitting, &ended),
        }
        self.want.is_none() && self.lines.fatal.is_none()
    }

    fn read(&mut self) {
        let Some(item) = self.items.next() else {
            return;
        };
        let read = self.settings.read(&item.bytes);
        self.current = Some(item);
        match read {
            Err(problem) => self.fail(problem),
            Ok(ReadItem { request, locator }) => {
                self.want = request.base().cloned().map(Want::Base);
                self.stage = Stage::Read(Box::new(request), locator, Base::none());
            }
        }
    }

    fn check(&mut self, request: JobRequest, locator: &ItemLocator, base: Base) {
        let valid = base.validate(request, self.settings.limits, locator);
        if self.items.as_slice().is_empty() {
            self.reading = None;
        }
        let valid = match valid {
            Ok(valid) => valid,
            Err(problem) => return self.fail(problem),
        };
        let form = match self.settings.forms().of(&valid.problem) {
            Ok(form) => form,
            Err(problem) => return self.fail(problem),
        };
        if let Some(item) = &mut self.current {
            item.bytes.clear();
            item.memory = None;
        }
        let mut notices = match &self.current {
            Some(item) => self.settings.notices_of(item.index).to_vec(),
            None => Vec::new(),
        };
        notices.extend(scattered::notices(&valid.problem));
        let bytes = valid.problem.memory().max(SMALL_FIT);
        let step_cost = valid.problem.step_cost();
        let has = self.memory.as_ref().map_or(0, |(_, bytes)| *bytes);
        self.want = (bytes > has).then_some(Want::Memory { step_cost, bytes });
        self.stage = Stage::Fitting(Fitting {
            name: valid.name,
            notices,
            form,
            fit: DirectFit::new(valid.problem),
        });
    }

    fn fit(&mut self, mut fitting: Fitting, deadline: Instant) {
        let (settings, fit) = (&self.settings, &mut fitting.fit);
        let ended = fit.work(deadline, &settings.cancelled, settings.app.jobs.resources());
        self.stage = match ended {
            None => Stage::Fitting(fitting),
            Some(ended) => {
                // Small ones share the rest.
                self.memory.take_if(|(_, bytes)| *bytes > SMALL_FIT);
                Stage::Ended(fitting, Box::new(ended))
            }
        };
    }

    fn write(&mut self, fitting: Fitting, ended: &EndedFit) {
        let Some(item) = self.current.take() else {
            return;
        };
        let converged = ended.status.state == State::Converged;
        let problem = (!converged).then(|| {
            let outline = Outline::new(Label::default(), fitting.fit.problem(), None);
            Problem::not_converged(&outline, &ended.status)
        });
        let head = LineHead {
            index: item.index,
            name: fitting.name.as_deref(),
            notices: &fitting.notices,
        };
        let content = answer::fitted(
            &self.settings,
            &head,
            ended,
            &fitting.form,
            problem.as_ref(),
        );
        match converged {
            true => self.lines.converged += 1,
            false => self.lines.failed += 1,
        }
        self.lines.push(item.index, content);
        self.item_has_ended();
    }

    /// Ends the current item with a problem.
    fn fail(&mut self, problem: Problem) {
        self.stage = Stage::Unread;
        let Some(item) = self.current.take() else {
            return;
        };
        let is_fatal = self.settings.is_fatal(&problem);
        let name = self.settings.name_of(&item);
        let problem = self.settings.located(problem, &item);
        if is_fatal {
            self.lines.fatal = Some(problem);
            return;
        }
        let head = LineHead {
            index: item.index,
            name: name.as_deref(),
            notices: self.settings.notices_of(item.index),
        };
        let content = answer::failed(&self.settings, &head, &problem);
        self.lines.failed += 1;
        self.lines.push(item.index, content);
        self.item_has_ended();
    }

    fn item_has_ended(&mut self) {
        self.settings
            .app
            .jobs
            .resources()
            .counters
            .batch_items
            .inc();
        let is_last = self.items.as_slice().is_empty();
        if !is_last && (self.lines.len() >= GROUP_BYTES || self.lines.has_large()) {
            self.want = Some(Want::Send);
        }
    }

    /// Returns true if all items have ended.
    fn is_done(&self) -> bool {
        self.current.is_none() && self.items.as_slice().is_empty()
    }
}

impl Errand for Group {
    fn work(&mut self, deadline: Instant) -> Progress {
        let begun = Instant::now();
        let progress = loop {
            if self.is_done() || self.settings.is_cancelled() {
                break Progress::Paused;
            }
            let lane = self.next_lane();
            if lane != self.lane || Instant::now() >= deadline {
                break Progress::Again(self.lane());
            }
            if !self.step(deadline) {
                break Progress::Paused;
            }
        };
        self.busy += begun.elapsed();
        progress
    }
}
