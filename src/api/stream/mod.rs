//! Event streams: what they show, and in which order and form.
//!
//! - [`feed`]: a job as a sequence of events; [`milestones`]: the iterations that a stream of the progress alone
//!   reports;
//! - [`encode`]: their data, made once for all readers and off the network threads; `chain`: as changes of what a
//!   reader has; [`encoded`]: events as
//!   messages;
//! - [`sending`]: what goes out on a connection.

mod chain;
pub(crate) mod encode;
pub(crate) mod encoded;
pub(crate) mod feed;
pub(crate) mod milestones;
pub(crate) mod sending;
