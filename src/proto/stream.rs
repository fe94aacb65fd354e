//! Stream options in messages.

use super::messages as pb;
use super::values::{check_count, chosen, value};
use crate::model::errors::ValidationError;
use crate::model::named::Named;
use crate::model::stream::{
    Choice, Describe, Digits, Encoding, MOST_MILESTONES, OnDisconnect, Pace, Samples, StreamSpec,
    View,
};

const VIEWS: [(View, pb::View); 3] = [
    (View::ControlPoints, pb::View::ControlPoints),
    (View::Samples, pb::View::Samples),
    (View::Errors, pb::View::Errors),
];

const PACES: [(Pace, pb::Pace); 2] = [(Pace::All, pb::Pace::All), (Pace::Latest, pb::Pace::Latest)];

const DESCRIPTIONS: [(Describe, pb::Describe); 2] = [
    (Describe::Full, pb::Describe::Full),
    (Describe::None, pb::Describe::None),
];

const DISCONNECTS: [(OnDisconnect, pb::OnDisconnect); 2] = [
    (OnDisconnect::Continue, pb::OnDisconnect::Continue),
    (OnDisconnect::Cancel, pb::OnDisconnect::Cancel),
];

const ENCODINGS: [(Encoding, pb::JsonEncoding); 4] = [
    (Encoding::Json, pb::JsonEncoding::Json),
    (Encoding::Base64, pb::JsonEncoding::Base64),
    (Encoding::Base64F32, pb::JsonEncoding::Base64F32),
    (Encoding::Delta, pb::JsonEncoding::Delta),
];

const DIGITS: [(Digits, pb::JsonDigits); 2] = [
    (Digits::Full, pb::JsonDigits::Full),
    (Digits::Auto, pb::JsonDigits::Auto),
];

/// The field of a choice.
pub(crate) fn field(choice: Choice) -> &'static str {
    match choice {
        Choice::Samples => "samples_u",
        Choice::Milestones => "milestones.distances",
        Choice::Encoding => "json_encoding",
        Choice::Digits => "json_digits",
        choice => choice.name(),
    }
}

/// The choices of a message, which is a field with this name and a dot.
pub(crate) fn spec(
    options: pb::StreamOptions,
    within: &str,
) -> Result<StreamSpec, ValidationError> {
    let every = options.every.map(|every| {
        let detail = "it is larger than any number of iterations";
        usize::try_from(every)
            .map_err(|_| ValidationError::at_text(format!("{within}every"), detail))
    });
    let milestones = options.milestones.map(|milestones| milestones.distances);
    let count = milestones.as_ref().map_or(0, Vec::len);
    let field = |choice| format!("{within}{}", field(choice));
    let distances = field(Choice::Milestones);
    check_count(count, MOST_MILESTONES, "milestones", &distances)?;
    Ok(StreamSpec {
        view: chosen(&VIEWS, options.view, &field(Choice::View))?,
        samples: samples(
            options.samples_u,
            options.samples_v,
            &field(Choice::Samples),
        )?,
        every: every.transpose()?,
        milestones,
        pace: chosen(&PACES, options.pace, &field(Choice::Pace))?,
        changed: options.changed,
        describe: chosen(&DESCRIPTIONS, options.describe, &field(Choice::Describe))?,
        encoding: chosen(&ENCODINGS, options.json_encoding, &field(Choice::Encoding))?,
        digits: chosen(&DIGITS, options.json_digits, &field(Choice::Digits))?,
        on_disconnect: chosen(
            &DISCONNECTS,
            options.on_disconnect,
            &field(Choice::OnDisconnect),
        )?,
    })
}

/// The choices of the message of a call. JSON options are ignored.
pub(crate) fn of_call(options: Option<pb::StreamOptions>) -> Result<StreamSpec, ValidationError> {
    let options = options.unwrap_or_default();
    let is_delta = options.json_encoding == i32::from(pb::JsonEncoding::Delta);
    let options = pb::StreamOptions {
        json_encoding: if is_delta { options.json_encoding } else { 0 },
        json_digits: 0,
        ..options
    };
    spec(options, "stream.")
}

/// The message with the same choices.
pub(crate) fn options(spec: &StreamSpec) -> pb::StreamOptions {
    // Accepted values fit in 32 bits.
    let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let (samples_u, samples_v) = match spec.samples {
        None => (0, 0),
        Some(Samples::Count(count)) => (narrow(count), 0),
        Some(Samples::Grid(rows, columns)) => (narrow(rows), narrow(columns)),
    };
    let distances = spec.milestones.clone();
    pb::StreamOptions {
        view: value(&VIEWS, spec.view).into(),
        samples_u,
        samples_v,
        every: spec.every.map(|every| every as u64),
        milestones: distances.map(|distances| pb::Milestones { distances }),
        pace: value(&PACES, spec.pace).into(),
        changed: spec.changed,
        describe: value(&DESCRIPTIONS, spec.describe).into(),
        on_disconnect: value(&DISCONNECTS, spec.on_disconnect).into(),
        json_encoding: value(&ENCODINGS, spec.encoding).into(),
        json_digits: value(&DIGITS, spec.digits).into(),
    }
}

fn samples(u: u32, v: u32, field: &str) -> Result<Option<Samples>, ValidationError> {
    match (u as usize, v as usize) {
        (0, 0) => Ok(None),
        (u, 0) => Ok(Some(Samples::Count(u))),
        (0, _) => {
            let detail = "samples_v is given, so samples_u is needed as well";
            Err(ValidationError::at_text(field, detail))
        }
        (u, v) => Ok(Some(Samples::Grid(u, v))),
    }
}
