//! The options of a stream, from the choices of its request and those of its job.

use super::choices::{ChoiceError, Choices};
use super::form::{self, Encoding, Form, View};
use super::{
    self as chosen, Choice, Describe, Digits, MOST_MILESTONES, OnDisconnect, Pace, StreamSpec,
};
use crate::model::errors::ValidationError;
use piad_files::text::quoted;
use piad_fit::engine::Problem;

/// The options of a stream.
#[derive(Clone, Debug)]
pub(crate) struct StreamOptions {
    /// The view of each event.
    pub form: Form,
    /// The view once the client has complete control points.
    pub changes: Option<Form>,
    /// True if events are differences from the client's numbers.
    pub deltas: bool,
    /// The `job` event has knots, parameters and fixed weights.
    pub describes: bool,
    /// Only iterations that are multiples of this, and the last.
    pub every: usize,
    /// Only the first iteration whose largest distance is within each of these, which decrease.
    pub milestones: Vec<f64>,
    /// A slow client skips to the newest iteration.
    pub latest: bool,
    /// The job ends with this stream.
    pub cancels: bool,
}

impl StreamOptions {
    /// The options of a stream of a curve or a surface of JSON events or of `protobuf` messages. `job` has the defaults
    /// of `request`.
    pub(crate) fn new(
        request: &StreamSpec,
        job: Option<&StreamSpec>,
        protobuf: bool,
        surface: bool,
    ) -> Result<Self, ChoiceError> {
        if !protobuf {
            return Self::of(Choices::new(request, job), surface);
        }
        refuse_numbers(request)?;
        // The encoding of numbers in JSON does not apply to protobuf.
        let encoding = Choices::new(request, job).get(|spec| spec.encoding);
        let request = StreamSpec {
            encoding: match encoding {
                Some(chosen::Encoding::Delta) => encoding,
                _ => Some(chosen::Encoding::Json),
            },
            digits: Some(Digits::Full),
            ..request.clone()
        };
        let options = Self::of(Choices::new(&request, job), surface)?;
        Ok(Self {
            form: options.form.in_protobuf(),
            changes: options.changes.map(|form| form.in_protobuf()),
            ..options
        })
    }

    /// The options of a stream of a job that another request has created: it shows the job, and does not end it,
    /// whatever the job's own options.
    pub(crate) fn of_reader(
        request: &StreamSpec,
        job: Option<&StreamSpec>,
        protobuf: bool,
        surface: bool,
    ) -> Result<Self, ChoiceError> {
        let options = Self::new(request, job, protobuf, surface)?;
        if options.cancels && request.on_disconnect.is_some() {
            let detail = "only the stream that is the answer to the request for the job can end it";
            return Err(ChoiceError::of_request(Choice::OnDisconnect, detail));
        }
        Ok(Self {
            cancels: false,
            ..options
        })
    }

    fn of(choices: Choices<'_>, surface: bool) -> Result<Self, ChoiceError> {
        let form = Form::of(choices, surface)?;
        let changed = choices.get(|spec| spec.changed).unwrap_or(false);
        let options = Self {
            deltas: choices.get(|spec| spec.encoding) == Some(chosen::Encoding::Delta),
            changes: changed.then(|| Form::new(View::Changed, form.encoding, form.digits)),
            form,
            describes: choices.get(|spec| spec.describe) != Some(Describe::None),
            every: every(choices)?,
            milestones: milestones(choices)?,
            latest: choices.get(|spec| spec.pace) == Some(Pace::Latest),
            cancels: choices.get(|spec| spec.on_disconnect) == Some(OnDisconnect::Cancel),
        };
        options.check(choices)?;
        Ok(options)
    }

    /// Refuses options that exclude each other.
    fn check(&self, choices: Choices<'_>) -> Result<(), ChoiceError> {
        const COMPLETE: &str =
            "changes are reported from each iteration to the next, so none can be skipped";
        let changed = self.changes.is_some();
        let some = self.every > 1;
        let selects = !self.milestones.is_empty();
        let Form {
            view,
            encoding,
            digits,
            ..
        } = self.form;
        choices.refuse(&[
            (
                changed && view != View::ControlPoints,
                Choice::Changed,
                Choice::View,
                "it is about control points",
            ),
            (
                changed && encoding != Encoding::Json,
                Choice::Changed,
                Choice::Encoding,
                "indices with their points are no array of numbers",
            ),
            (
                changed && digits != Digits::Full,
                Choice::Changed,
                Choice::Digits,
                "a point that stays would keep the coarser rounding of an earlier iteration",
            ),
            (changed && some, Choice::Changed, Choice::Every, COMPLETE),
            (
                changed && selects,
                Choice::Changed,
                Choice::Milestones,
                COMPLETE,
            ),
            (
                changed && self.latest,
                Choice::Changed,
                Choice::Pace,
                COMPLETE,
            ),
            (
                selects && some,
                Choice::Milestones,
                Choice::Every,
                "milestones choose the iterations themselves",
            ),
            (
                selects && self.latest,
                Choice::Milestones,
                Choice::Pace,
                "the first iteration to reach a milestone may not be skipped",
            ),
        ])
    }
}

impl StreamSpec {
    /// Checks that the stream options of a job suit a curve or a surface.
    pub fn check(&self, surface: bool) -> Result<(), ValidationError> {
        let request = Self::default();
        StreamOptions::of(Choices::new(&request, Some(self)), surface)?;
        Ok(())
    }

    /// Checks that the data of a job fit in numbers of 32 bits, if requested.
    pub fn check_range(&self, problem: &Problem) -> Result<(), ValidationError> {
        Ok(check_range(&Self::default(), Some(self), problem)?)
    }
}

/// The form of a single iteration of a curve or a surface in JSON.
pub(crate) fn json_form(request: &StreamSpec, surface: bool) -> Result<Form, ChoiceError> {
    if request.encoding == Some(chosen::Encoding::Delta) {
        let detail = "delta is for streams: there is no event before this one to differ from";
        return Err(ChoiceError::of_request(Choice::Encoding, detail));
    }
    Form::of(Choices::new(request, None), surface)
}

/// The form of a single iteration of a curve or a surface as a protobuf message.
pub(crate) fn message_form(request: &StreamSpec, surface: bool) -> Result<Form, ChoiceError> {
    refuse_numbers(request)?;
    Ok(json_form(request, surface)?.in_protobuf())
}

/// Checks that the data fit in numbers of 32 bits, if requested.
pub(crate) fn check_range(
    request: &StreamSpec,
    job: Option<&StreamSpec>,
    problem: &Problem,
) -> Result<(), ChoiceError> {
    form::check_range(Choices::new(request, job), problem)
}

/// Messages have no choice of number encoding.
fn refuse_numbers(request: &StreamSpec) -> Result<(), ChoiceError> {
    let written = |encoding: &chosen::Encoding| *encoding != chosen::Encoding::Delta;
    let given = [
        (
            Choice::Encoding,
            request.encoding.as_ref().is_some_and(written),
        ),
        (Choice::Digits, request.digits.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((choice, _)) => {
            let detail = "it is about numbers in JSON; protobuf messages have all 64 bits, or in streams encoding=delta";
            Err(ChoiceError::of_request(choice, detail))
        }
    }
}

fn every(choices: Choices<'_>) -> Result<usize, ChoiceError> {
    match choices.get(|spec| spec.every) {
        Some(0) => Err(choices.error(Choice::Every, not_positive("0"))),
        every => Ok(every.unwrap_or(1)),
    }
}

/// The error for an invalid `every`.
pub(crate) fn not_positive(text: &str) -> String {
    format!("{} is no positive whole number", quoted(text))
}

/// Milestones are positive and decrease.
fn milestones(choices: Choices<'_>) -> Result<Vec<f64>, ChoiceError> {
    let Some(milestones) = choices.get(|spec| spec.milestones.as_ref()) else {
        return Ok(Vec::new());
    };
    let wrong = |index, detail| Err(choices.error_at(Choice::Milestones, index, detail));
    if milestones.len() > MOST_MILESTONES {
        return wrong(None, format!("there are more than {MOST_MILESTONES}"));
    }
    for (index, milestone) in milestones.iter().enumerate() {
        if !(*milestone > 0.0 && milestone.is_finite()) {
            return wrong(Some(index), no_milestone(&format!("{milestone:?}")));
        }
        if let Some(before) = milestones[..index].last().filter(|it| *it <= milestone) {
            let detail =
                format!("milestones decrease, and {milestone} does not lie below {before}");
            return wrong(Some(index), detail);
        }
    }
    Ok(milestones.clone())
}

/// The error for an invalid milestone.
pub(crate) fn no_milestone(text: &str) -> String {
    format!("{} is no positive finite number", quoted(text))
}
