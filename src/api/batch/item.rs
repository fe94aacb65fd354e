//! An item of a batch: a job, read and checked like any job, with errors located in the batch.

use bytes::Bytes;
use serde::Deserialize;

use super::pieces::BodyForm;
use super::settings::Settings;
use crate::api::json::request;
use crate::api::json::request::places::Places;
use crate::api::media_type::Language;
use crate::api::problem::{Kind, Location, Locator, Problem};
use crate::api::proto;
use crate::api::proto::fields::MessageLayout;
use crate::job::memory::Permit;
use crate::model::errors::SpecPart;
use crate::model::job::{JobRequest, LONGEST_NAME};

/// An item as it has arrived.
pub(super) struct Item {
    /// Its place among the items.
    pub(super) index: usize,
    pub(super) bytes: Bytes,
    /// The memory of a large one.
    pub(super) memory: Option<Permit>,
}

/// An item that was read.
pub(super) struct ReadItem {
    pub(super) request: JobRequest,
    /// The locations of its parts.
    pub(super) locator: ItemLocator,
}

/// The locations of the parts of an item.
pub(super) enum ItemLocator {
    Json(Places),
    Message(MessageLayout),
}

impl Locator for ItemLocator {
    fn of(&self, place: SpecPart) -> String {
        match self {
            Self::Json(places) => places.of(place),
            Self::Message(layout) => layout.of(place),
        }
    }

    fn place(&self, text: String) -> Location {
        match self {
            Self::Json(places) => places.place(text),
            Self::Message(layout) => layout.place(text),
        }
    }
}

impl Settings {
    /// Reads an item, with the defaults of the batch.
    pub(super) fn read(&self, item: &Bytes) -> Result<ReadItem, Problem> {
        let bytes = match self.defaults() {
            None => item.clone(),
            Some(defaults) => defaults.merge(item),
        };
        let config = &self.app.config;
        match self.language {
            Language::Json => {
                let (request, places) = request::job::read(bytes, config.max_points)?;
                let locator = ItemLocator::Json(places);
                Ok(ReadItem { request, locator })
            }
            Language::Protobuf => {
                let (request, layout) = proto::request::read(bytes, config)?;
                let locator = ItemLocator::Message(layout);
                Ok(ReadItem { request, locator })
            }
        }
    }

    /// Returns true if a batch cannot continue after this problem with an item: its body is no JSON.
    pub(super) fn is_fatal(&self, problem: &Problem) -> bool {
        self.body == BodyForm::Document && problem.kind() == Kind::NotJson
    }

    /// A problem with an item, located in the batch: in the item, or in the defaults.
    pub(super) fn located(&self, problem: Problem, item: &Item) -> Problem {
        let in_defaults = |pointer: &str| {
            let defaults = self.defaults();
            defaults.is_some_and(|defaults| defaults.has(pointer, &item.bytes))
        };
        problem.relocated(|place| match place {
            Location::Pointer(pointer) if in_defaults(&pointer) => {
                Location::Pointer(format!("/defaults{pointer}"))
            }
            Location::Pointer(pointer) => {
                Location::Pointer(format!("/items/{}{pointer}", item.index))
            }
            Location::Field(field) if field.is_empty() => Location::Field("item".to_owned()),
            Location::Field(field) => Location::Field(format!("item.{field}")),
            place => place,
        })
    }

    /// The name of an item that could not be read, if that can be read.
    pub(super) fn name_of(&self, item: &Item) -> Option<String> {
        #[derive(Deserialize)]
        struct Named {
            name: Option<String>,
        }
        let name = match self.language {
            Language::Json => serde_json::from_slice::<Named>(&item.bytes).ok()?.name,
            Language::Protobuf => None,
        };
        name.filter(|name| name.chars().count() <= LONGEST_NAME)
    }
}
