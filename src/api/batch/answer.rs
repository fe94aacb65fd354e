//! The lines of a batch with their framing.

use std::sync::Arc;

use bytes::{BufMut, Bytes, BytesMut};

use super::settings::Settings;
use crate::api::json::view::batch::{self as view, BatchEnd, BatchProblem, BatchTotals, ItemEnd};
use crate::api::json::view::to_bytes;
use crate::api::media_type::Framing;
use crate::api::problem::Problem;
use crate::api::proto;
use crate::job::content::Content;
use crate::job::direct::EndedFit;
use crate::job::memory::{Cache, Charge};
use crate::job::state::State;
use crate::model::stream::form::Form;

/// Contents up to this size are copied together.
const SMALL: usize = 16 * 1024;

/// A part of the answer to a batch.
pub(super) enum Output {
    /// Lines of items.
    Lines(Content),
    /// The end: the totals of all items, or why it ended early.
    End(Result<BatchTotals, Problem>),
}

/// Lines of items that follow each other.
pub(super) struct Lines {
    framing: Framing,
    /// Large contents with the lines around them.
    contents: Vec<Content>,
    /// The lines after the last of these.
    text: BytesMut,
    /// The number of items that have converged, and of those that have not.
    pub(super) converged: usize,
    pub(super) failed: usize,
    /// Its bytes in the cache.
    charge: Option<Charge>,
    /// Why it ended early.
    pub(super) fatal: Option<Problem>,
}

impl Lines {
    /// No lines.
    pub(super) fn new(framing: Framing) -> Self {
        Self {
            framing,
            contents: Vec::new(),
            text: BytesMut::new(),
            converged: 0,
            failed: 0,
            charge: None,
            fatal: None,
        }
    }

    /// The same lines, counted in the cache until they are sent.
    pub(super) fn counted(mut self, cache: &Arc<Cache>) -> Self {
        self.charge = Some(cache.charge(self.text.len()));
        self
    }

    /// The number of bytes, without those of large contents.
    pub(super) fn len(&self) -> usize {
        self.text.len()
    }

    /// Returns true if there is a content that takes a while to send.
    pub(super) fn has_large(&self) -> bool {
        !self.contents.is_empty()
    }

    /// Adds the line of an item.
    pub(super) fn push(&mut self, index: usize, data: Content) {
        match self.framing {
            Framing::Sse => {
                let head = format!("event: item\nid: {index}\ndata: ");
                self.text.put_slice(head.as_bytes());
                self.put(data);
                self.text.put_slice(b"\n\n");
            }
            Framing::Ndjson => {
                self.put(data);
                self.text.put_slice(b"\n");
            }
            // It is framed already.
            Framing::Protobuf => self.put(data),
        }
    }

    fn put(&mut self, content: Content) {
        if content.rest.is_none() && content.head.len() <= SMALL {
            return self.text.extend_from_slice(&content.head);
        }
        self.cut();
        self.contents.push(content);
    }

    fn cut(&mut self) {
        if !self.text.is_empty() {
            self.contents.push(self.text.split().freeze().into());
        }
    }

    /// The contents to send.
    pub(super) fn into_contents(mut self) -> Vec<Content> {
        self.cut();
        self.contents
    }
}

/// The first bytes of a stream.
pub(super) fn beginning(framing: Framing) -> Bytes {
    match framing {
        // Some proxies pass on the head only with the first bytes of the body.
        Framing::Sse => Bytes::from_static(b": piad\n\n"),
        Framing::Ndjson | Framing::Protobuf => Bytes::new(),
    }
}

/// The bytes sent while there is nothing to say.
pub(super) fn quiet(framing: Framing) -> Bytes {
    match framing {
        Framing::Sse => Bytes::from_static(b": still here\n\n"),
        Framing::Ndjson | Framing::Protobuf => Bytes::new(),
    }
}

/// The last line; the status of a call reports why a batch ended early.
pub(super) fn last(settings: &Settings, end: &Result<BatchTotals, Problem>) -> Bytes {
    let (name, data) = match (end, settings.framing) {
        (Ok(totals), Framing::Protobuf) => {
            return proto::batch::totals(totals.items, totals.converged, totals.seconds);
        }
        (Err(_), Framing::Protobuf) => return Bytes::new(),
        (&Ok(totals), _) => ("totals", to_bytes(&BatchEnd { totals })),
        (Err(problem), _) => {
            let problem = settings.body_of(problem);
            ("problem", to_bytes(&BatchProblem { problem }))
        }
    };
    let mut text = BytesMut::with_capacity(data.len() + 32);
    if settings.framing == Framing::Sse {
        text.put_slice(format!("event: {name}\ndata: ").as_bytes());
    }
    text.put_slice(&data);
    text.put_slice(b"\n");
    if settings.framing == Framing::Sse {
        text.put_slice(b"\n");
    }
    text.freeze()
}

/// The item of a line.
pub(super) struct LineHead<'a> {
    /// Its place among the items.
    pub(super) index: usize,
    pub(super) name: Option<&'a str>,
    /// Notices about its points.
    pub(super) notices: &'a [String],
}

/// The line of a fit that has ended.
pub(super) fn fitted(
    settings: &Settings,
    head: &LineHead<'_>,
    ended: &EndedFit,
    form: &Form,
    problem: Option<&Problem>,
) -> Content {
    let frame = ended.frame.as_ref();
    if settings.framing == Framing::Protobuf {
        let end = proto::batch::ItemEnd {
            index: head.index,
            name: head.name,
            notices: head.notices,
            state: ended.status.state,
            problem,
        };
        return proto::batch::item(&end, frame.map(|frame| (frame, form)));
    }
    let end = ItemEnd {
        index: head.index,
        name: head.name,
        notices: head.notices,
        status: &ended.status,
        frame,
        problem: problem.map(|problem| settings.body_of(problem)),
    };
    view::fitted(end, form)
}

/// The line of an item that is invalid.
pub(super) fn failed(settings: &Settings, head: &LineHead<'_>, problem: &Problem) -> Content {
    if settings.framing == Framing::Protobuf {
        let end = proto::batch::ItemEnd {
            index: head.index,
            name: head.name,
            notices: head.notices,
            state: State::Failed,
            problem: Some(problem),
        };
        return proto::batch::item(&end, None);
    }
    let problem = settings.body_of(problem);
    view::failed(head.index, head.name, head.notices, problem).into()
}
