//! Settings of a batch.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use prost::Message;

use super::defaults::Defaults;
use super::pieces::BodyForm;
use crate::api::app::App;
use crate::api::create_job;
use crate::api::media_type::{Framing, Language};
use crate::api::problem::{Problem, ProblemBody};
use crate::api::proto::{self, fields};
use crate::model::job::Limits;
use crate::model::stream::StreamSpec;
use crate::model::stream::form::{Encoding, Form};
use crate::model::stream::options;
use crate::proto::messages as pb;
use crate::proto::stream;
use crate::telemetry::request::RequestTrace;
use piad_fit::engine as fit;

/// The form of the curves and surfaces of a batch; an item with invalid choices fails.
#[derive(Clone, Debug)]
pub(in crate::api) struct Forms {
    curve: Chosen,
    surface: Chosen,
}

/// The choices, and the form that follows from them.
type Chosen = Result<(StreamSpec, Form), Problem>;

impl Forms {
    /// The form of messages. Choices that suit neither curves nor surfaces are an error.
    pub(in crate::api) fn of_message(options: &pb::BatchOptions) -> Result<Self, Problem> {
        let (view, samples_u, samples_v) = (options.view, options.samples_u, options.samples_v);
        let stream_options = pb::StreamOptions {
            view,
            samples_u,
            samples_v,
            ..pb::StreamOptions::default()
        };
        let spec = stream::spec(stream_options, "").map_err(fields::wrong)?;
        let of = |surface| {
            let form = options::message_form(&spec, surface);
            let form = form.map_err(|error| fields::wrong_choice(error, ""))?;
            Ok((spec.clone(), form))
        };
        Self::any(of(false), of(true))
    }

    /// These, if they suit curves or surfaces.
    pub(in crate::api) fn any(curve: Chosen, surface: Chosen) -> Result<Self, Problem> {
        match (curve, surface) {
            (Err(problem), Err(_)) => Err(problem),
            (curve, surface) => Ok(Self { curve, surface }),
        }
    }

    /// The form of a curve or of a surface, checked for the range of the data of this problem.
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

/// Settings in the body of a batch.
struct Common {
    defaults: Option<Defaults>,
    /// The form of results, if it is set.
    forms: Option<Forms>,
}

impl Common {
    /// Settings from `BatchOptions`.
    fn of_message(bytes: Bytes, most_points: usize) -> Result<Self, Problem> {
        let options: pb::BatchOptions = proto::request::decode(bytes, most_points)?;
        let defaults = options.defaults.as_ref();
        let defaults = defaults.map(|it| Defaults::Message(it.encode_to_vec().into()));
        let forms = Forms::of_message(&options)?;
        Ok(Self {
            defaults,
            forms: Some(forms),
        })
    }
}

/// The settings of all items of a batch.
pub(in crate::api) struct Settings {
    pub(super) app: App,
    /// The format of the body.
    pub(super) body: BodyForm,
    /// The encoding of items.
    pub(super) language: Language,
    /// The framing of lines.
    pub(super) framing: Framing,
    pub(super) limits: Limits,
    forms: Forms,
    common: OnceLock<Common>,
    /// Notices about each part, if the items are the parts of a file.
    notices: OnceLock<Vec<Arc<[String]>>>,
    /// The id of the request, which problems have.
    request_id: Option<String>,
    trace_id: Option<String>,
    /// The batch was abandoned.
    pub(super) cancelled: Arc<AtomicBool>,
}

impl Settings {
    /// A batch whose answer has this framing.
    pub(in crate::api) fn new(
        app: &App,
        body: BodyForm,
        framing: Framing,
        forms: Forms,
        request_id: Option<String>,
    ) -> Arc<Self> {
        Arc::new(Self {
            app: app.clone(),
            body,
            language: match body {
                BodyForm::Document | BodyForm::Lines => Language::Json,
                BodyForm::Messages => Language::Protobuf,
            },
            framing,
            limits: create_job::limits(app),
            forms,
            common: OnceLock::new(),
            notices: OnceLock::new(),
            request_id,
            trace_id: RequestTrace::current().map(|trace| trace.trace_id()),
            cancelled: Arc::default(),
        })
    }

    /// Reads the defaults of the items.
    pub(super) fn set_common(&self, bytes: &Bytes) -> Result<(), Problem> {
        let most_points = self.app.config.max_points;
        let common = match self.language {
            Language::Json => Common {
                defaults: Some(Defaults::json(bytes, most_points)?),
                forms: None,
            },
            Language::Protobuf => Common::of_message(bytes.clone(), most_points)
                .map_err(|problem| problem.within("options"))?,
        };
        let _ = self.common.set(common);
        Ok(())
    }

    /// Takes the notices about each part of the file whose parts are the items.
    pub(in crate::api) fn set_notices(&self, notices: Vec<Arc<[String]>>) {
        let _ = self.notices.set(notices);
    }

    /// Notices about the part that this item is.
    pub(super) fn notices_of(&self, index: usize) -> &[String] {
        let notices = self.notices.get();
        notices
            .and_then(|notices| notices.get(index))
            .map_or(&[], |notices| notices)
    }

    /// The defaults of the items, if given.
    pub(super) fn defaults(&self) -> Option<&Defaults> {
        self.common.get()?.defaults.as_ref()
    }

    /// The form of results.
    pub(super) fn forms(&self) -> &Forms {
        let common = self.common.get();
        let forms = common.and_then(|common| common.forms.as_ref());
        forms.unwrap_or(&self.forms)
    }

    /// A problem object of this request.
    pub(in crate::api) fn body_of(&self, problem: &Problem) -> ProblemBody {
        let mut body = problem.body(self.request_id.as_deref());
        body.trace_id.clone_from(&self.trace_id);
        body
    }

    /// Returns true if the batch was abandoned.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Acquire)
    }
}
