//! What holds for all of a batch.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use prost::Message;

use super::defaults::Defaults;
use super::pieces::BodyForm;
use crate::api::app::App;
use crate::api::language::{Framing, Language};
use crate::api::order;
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

/// How the curves and surfaces of a batch are shown; an item of which the choices make no sense fails.
#[derive(Clone, Debug)]
pub(in crate::api) struct Forms {
    curve: Chosen,
    surface: Chosen,
}

/// What was chosen, and the form that follows.
type Chosen = Result<(StreamSpec, Form), Problem>;

impl Forms {
    /// Those of messages. What makes sense for neither curves nor surfaces is an error.
    pub(in crate::api) fn of_message(options: &pb::BatchOptions) -> Result<Self, Problem> {
        let (view, samples_u, samples_v) = (options.view, options.samples_u, options.samples_v);
        let asked = pb::StreamOptions {
            view,
            samples_u,
            samples_v,
            ..pb::StreamOptions::default()
        };
        let spec = stream::spec(asked, "").map_err(fields::wrong)?;
        let of = |surface| {
            let form = options::message_form(&spec, surface);
            let form = form.map_err(|mistake| fields::wrong_choice(mistake, ""))?;
            Ok((spec.clone(), form))
        };
        Self::any(of(false), of(true))
    }

    /// These, if one of them makes sense.
    pub(in crate::api) fn any(curve: Chosen, surface: Chosen) -> Result<Self, Problem> {
        match (curve, surface) {
            (Err(problem), Err(_)) => Err(problem),
            (curve, surface) => Ok(Self { curve, surface }),
        }
    }

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

/// What a body says of all items.
struct Common {
    defaults: Option<Defaults>,
    /// How they are shown, if it says that.
    forms: Option<Forms>,
}

impl Common {
    /// What `BatchOptions` say.
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
    common: OnceLock<Common>,
    /// What was understood of each part, if the items are the parts of a file.
    notices: OnceLock<Vec<Arc<[String]>>>,
    /// The id of the request, which problems have.
    request_id: Option<String>,
    trace_id: Option<String>,
    /// The batch was abandoned.
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
    ) -> Arc<Self> {
        Arc::new(Self {
            app: app.clone(),
            body,
            language: match body {
                BodyForm::Document | BodyForm::Lines => Language::Json,
                BodyForm::Messages => Language::Protobuf,
            },
            framing,
            limits: order::limits(app),
            forms,
            common: OnceLock::new(),
            notices: OnceLock::new(),
            request_id,
            trace_id: RequestTrace::current().map(|trace| trace.trace_id()),
            cancelled: Arc::default(),
        })
    }

    /// Reads what the items have in common.
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

    /// Takes what was understood of each part of the file whose parts are the items.
    pub(in crate::api) fn set_notices(&self, notices: Vec<Arc<[String]>>) {
        let _ = self.notices.set(notices);
    }

    /// What was understood of the part that this item is.
    pub(super) fn notices_of(&self, index: usize) -> &[String] {
        let notices = self.notices.get();
        notices
            .and_then(|notices| notices.get(index))
            .map_or(&[], |notices| notices)
    }

    /// What the items have in common, if that was given.
    pub(super) fn defaults(&self) -> Option<&Defaults> {
        self.common.get()?.defaults.as_ref()
    }

    /// How items are shown.
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
