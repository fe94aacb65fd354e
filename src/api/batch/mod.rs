//! Batches: many fits in one request, and what has come of each of them in one answer. Nothing is kept.
//!
//! A body is read while it arrives, its items are fitted on the compute pool, and their lines are sent in the order of
//! the items, all at the same time. None of them gets far ahead of the others: a client that reads slowly is read
//! slowly.
//!
//! - [`driver`]: takes a batch from its body to its answer;
//! - [`arrival`]: the bytes of the body; [`pieces`]: what [`splitter`] cuts them into, by [`document`], [`lines`]
//!   or [`messages`];
//! - [`defaults`]: what items have in common;
//! - [`item`]: a job of a batch, read and checked; [`group`]: some of them, one after another on a thread of the pool;
//!   [`task`]: the memory that a group takes, and what it waits for;
//! - [`answer`]: lines, as they are framed; [`sending`]: the bytes of an answer; [`part_file`]: all of it as one file, of each [`geometry`]; [`settings`]: what holds for all of a batch.

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
