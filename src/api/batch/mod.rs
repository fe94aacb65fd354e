//! Batches: many fits in one request, with the results of each in one answer. Nothing is stored.
//!
//! The body is read as it arrives, its items are fitted on the compute pool, and their lines are sent in the order of
//! the items, all at the same time. No stage gets far ahead of the others: reading slows down with a client that reads
//! slowly.
//!
//! - [`driver`]: runs a batch from its body to its answer;
//! - [`arrival`]: the bytes of the body; [`pieces`]: its parts, cut by [`splitter`] with [`document`], [`lines`] or
//!   [`messages`];
//! - [`defaults`]: default fields of items;
//! - [`item`]: a job of a batch, read and validated; [`group`]: some of them, one after another on a thread of the
//!   pool;
//!   [`task`]: the memory that a group takes, and what it waits for;
//! - [`answer`]: lines with their framing; [`sending`]: the bytes of an answer; [`part_file`]: all results as one file,
//!   of each [`geometry`]; [`settings`]: settings of a batch.

pub(in crate::api) mod answer;
mod arrival;
mod defaults;
mod document;
pub(in crate::api) mod driver;
pub(crate) mod geometry;
mod group;
mod item;
mod lines;
mod messages;
pub(crate) mod part_file;
pub(in crate::api) mod pieces;
pub(in crate::api) mod sending;
pub(in crate::api) mod settings;
mod splitter;
mod task;
