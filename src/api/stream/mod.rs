//! Event streams: their contents, order and form.
//!
//! - [`feed`]: a job as a sequence of events; [`milestones`]: the iterations that a stream of the progress alone
//!   reports;
//! - [`encode`]: their data, made once for all readers and off the network threads; `chain`: differences from the
//!   reader's state; [`encoded`]: events as messages;
//! - [`sending`]: the bytes sent on a connection.

mod chain;
pub(crate) mod encode;
pub(crate) mod encoded;
pub(crate) mod feed;
pub(crate) mod milestones;
pub(crate) mod sending;
