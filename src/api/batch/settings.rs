//! What holds for all of a batch.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use bytes::Bytes;

use super::defaults::Defaults;
use super::pieces::BodyForm;
use crate::api::app::App;
use crate::api::language::{Framing, Language};
use crate::api::order;
use crate::api::problem::{Problem, ProblemBody};
use crate::model::job::Limits;
use crate::model::stream::StreamSpec;
use crate::model::stream::form::{Encoding, Form};
use crate::model::stream::options;
use crate::telemetry::request::RequestTrace;
use piad_fit::engine as fit;

/// How the curves and surfaces of a batch are shown; an item of which the choices make no sense fails.
#[derive(Clone, Debug)]
pub(in crate::api) struct Forms {
    pub curve: Result<(StreamSpec, Form), Problem>,
    pub surface: Result<(StreamSpec, Form), Problem>,
}

impl Forms {
    /// The form of a curve or of a surface, which must have room for the data of this problem.
    pub(super) fn of(&self, problem: &fit::Problem) -> Result<Form, Problem> {
        let form = match problem.v() {
            None => &self.curve,
            Some(_) => &self.surface,
        };
        let (spec, form) = form.as_ref().map_err(Clone::clone)?;
        if form.encoding == Encoding::Base64F32 {
            options::check_range(spec, None, problem)?;
        }
        Ok(form.clone())
    }
}

/// What is requested for all items of a batch.
pub(in crate::api) struct Settings {
    pub(super) app: App,
    /// How the body is cut into items.
    pub(super) body: BodyForm,
    /// What items are written in.
    pub(super) language: Language,
    /// How lines are framed.
    pub(super) framing: Framing,
    pub(super) limits: Limits,
    forms: Forms,
    defaults: OnceLock<Defaults>,
    /// The id of the request, which problems have.
    request_id: Option<String>,
    trace_id: Option<String>,
    /// Nobody waits for the batch any more.
    pub(super) cancelled: Arc<AtomicBool>,
}

impl Settings {
    /// A batch whose answer is framed like this.
    pub(in crate::api) fn new(
        app: &App,
        body: BodyForm,
        framing: Framing,
        forms: Forms,
        request_id: Option<String>,
    ) -> Self {
        Self {
            app: app.clone(),
            body,
            language: Language::Json,
            framing,
            limits: order::limits(app),
            forms,
            defaults: OnceLock::new(),
            request_id,
            trace_id: RequestTrace::current().map(|trace| trace.trace_id()),
            cancelled: Arc::default(),
        }
    }

    /// Reads what the items have in common.
    pub(super) fn set_defaults(&self, text: &Bytes) -> Result<(), Problem> {
        let defaults = Defaults::json(text, self.app.config.max_points)?;
        let _ = self.defaults.set(defaults);
        Ok(())
    }

    /// What the items have in common, if that was given.
    pub(super) fn defaults(&self) -> Option<&Defaults> {
        self.defaults.get()
    }

    /// How items are shown.
    pub(super) fn forms(&self) -> &Forms {
        &self.forms
    }

    /// A problem object of this request.
    pub(in crate::api) fn body_of(&self, problem: &Problem) -> ProblemBody {
        let mut body = problem.body(self.request_id.as_deref());
        body.trace_id.clone_from(&self.trace_id);
        body
    }

    /// Returns true if nobody waits for the batch any more.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Acquire)
    }
}
