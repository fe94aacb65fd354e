//! Jobs without their points, as protobuf messages.

use std::sync::Arc;

use prost::Message;

use super::super::{Record, StoreError};
use super::error::{damaged, mistaken};
use super::fields::{Time, grid, number, time, uuid};
use super::status::StatusMessage;
use super::warning::WarningMessage;
use crate::job::outline::{Label, Outline, Parent};
use crate::job::state::Status;
use crate::proto::messages as pb;
use crate::proto::{method, stream};

/// A job without its points.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Header {
    #[prost(bytes = "vec", tag = "1")]
    id: Vec<u8>,
    #[prost(string, optional, tag = "2")]
    name: Option<String>,
    #[prost(bytes = "vec", optional, tag = "3")]
    parent: Option<Vec<u8>>,
    #[prost(uint64, tag = "4")]
    parent_iteration: u64,
    #[prost(message, optional, tag = "6")]
    created: Option<Time>,
    #[prost(bool, tag = "7")]
    surface: bool,
    #[prost(uint64, tag = "8")]
    rows: u64,
    #[prost(uint64, tag = "9")]
    columns: u64,
    #[prost(uint64, optional, tag = "11")]
    adjusted: Option<u64>,
    #[prost(double, tag = "12")]
    tolerance: f64,
    #[prost(uint64, tag = "13")]
    max_iterations: u64,
    #[prost(uint64, tag = "14")]
    memory: u64,
    #[prost(uint64, tag = "15")]
    step_cost: u64,
    #[prost(message, optional, tag = "16")]
    status: Option<StatusMessage>,
    #[prost(uint32, tag = "17")]
    pub(super) crashes: u32,
    /// Bytes of the input and of the result.
    #[prost(uint64, tag = "18")]
    pub(super) bytes: u64,
    /// The key of the request that made the job.
    #[prost(string, optional, tag = "19")]
    pub(super) key: Option<String>,
    #[prost(bool, tag = "20")]
    pub(super) on_probation: bool,
    #[prost(message, repeated, tag = "21")]
    warnings: Vec<WarningMessage>,
    #[prost(bool, tag = "22")]
    bases_differ: bool,
    #[prost(message, optional, tag = "23")]
    method: Option<pb::Method>,
    #[prost(message, optional, tag = "24")]
    stream: Option<pb::StreamOptions>,
}

impl Header {
    /// The header in these bytes.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, StoreError> {
        Self::decode(bytes).map_err(damaged)
    }

    /// The header of a record.
    pub(super) fn new(record: &Record, bytes: u64, key: Option<String>) -> Self {
        let outline = &record.outline;
        let label = &outline.label;
        Self {
            id: outline.id.as_bytes().to_vec(),
            name: label.name.clone(),
            parent: label.parent.map(|parent| parent.id.as_bytes().to_vec()),
            parent_iteration: label.parent.map_or(0, |parent| parent.iteration as u64),
            created: Some(outline.created.into()),
            surface: outline.surface,
            rows: outline.grid.rows as u64,
            columns: outline.grid.columns as u64,
            adjusted: outline.adjusted.map(|count| count as u64),
            tolerance: outline.tolerance,
            max_iterations: outline.max_iterations as u64,
            memory: outline.memory as u64,
            step_cost: outline.step_cost as u64,
            status: Some((&record.status).into()),
            crashes: record.crashes,
            bytes,
            key,
            on_probation: record.on_probation,
            warnings: outline
                .warnings
                .iter()
                .filter_map(WarningMessage::new)
                .collect(),
            bases_differ: outline.bases_differ,
            method: Some(method::message(&outline.method, outline.surface, None)),
            stream: label.stream.as_deref().map(stream::options),
        }
    }

    /// The state of the job is another one now.
    pub(super) fn set_status(&mut self, status: &Status) {
        self.status = Some(status.into());
    }

    /// The job was running in a crash, after which this is its record.
    pub(super) fn recover(&mut self, record: &Record) {
        self.set_status(&record.status);
        (self.crashes, self.on_probation) = (record.crashes, record.on_probation);
    }

    /// The record of a header.
    pub(super) fn into_record(self) -> Result<Record, StoreError> {
        let iteration = number(self.parent_iteration)?;
        let parent = self.parent.map(|id| {
            Ok::<_, StoreError>(Parent {
                id: uuid(&id)?,
                iteration,
            })
        });
        let stream = self.stream.map(|it| stream::spec(it, "").map_err(mistaken));
        Ok(Record {
            outline: Outline {
                id: uuid(&self.id)?,
                label: Label {
                    name: self.name,
                    parent: parent.transpose()?,
                    stream: stream.transpose()?.map(Arc::new),
                },
                created: time(self.created)?,
                surface: self.surface,
                grid: grid(self.rows, self.columns)?,
                method: method::outline(self.method, self.surface).map_err(mistaken)?,
                adjusted: self.adjusted.map(number).transpose()?,
                tolerance: self.tolerance,
                max_iterations: number(self.max_iterations)?,
                memory: number(self.memory)?,
                step_cost: number(self.step_cost)?,
                warnings: self
                    .warnings
                    .iter()
                    .filter_map(WarningMessage::meaning)
                    .collect(),
                bases_differ: self.bases_differ,
            },
            status: self
                .status
                .ok_or_else(|| damaged("no status"))?
                .try_into()?,
            crashes: self.crashes,
            on_probation: self.on_probation,
        })
    }
}
