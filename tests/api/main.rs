//! Drives a server over HTTP, as a client does; one file for each capability.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    missing_docs,
    unreachable_pub,
    reason = "tests fail by panicking, and have no users"
)]

mod access;
mod access_file;
mod access_tickets;
mod any_order;
mod attacks;
mod automatic;
mod bad_requests;
mod base_path;
mod batch;
mod between;
mod bodies;
mod changed;
mod clocks;
mod closed;
mod cluster;
mod collector;
mod compressed;
mod constrained_surfaces;
mod constraints;
mod constraints_messages;
mod constraints_refused;
mod convex;
mod copies;
mod corners;
mod cors;
mod crash_recovery;
mod crashes;
mod creases;
mod custom;
mod damage;
mod data;
mod database;
mod deleting;
mod deltas;
mod dense;
mod dense_curves;
mod description;
mod deviation;
mod digits;
mod durable;
mod edits;
mod encodings;
mod ends;
mod ephemeral;
mod examples;
mod exports;
mod extremes;
mod fault_proxy;
mod file_answers;
mod files;
mod fit_once;
mod floods;
mod foot_points;
mod forecasts;
mod gaps;
mod generated;
mod goldens;
mod headers;
mod heights;
mod http;
mod jobs;
mod kernel;
mod large;
mod least_squares;
mod least_squares_ends;
mod least_squares_knots;
mod load;
mod local;
mod many_coordinates;
mod many_errors;
mod many_readers;
mod meshes;
mod messages_over_rest;
mod methods;
mod metrics;
mod milestones;
mod minimum;
mod moved;
mod nets;
mod noise;
mod numbers;
mod omega;
mod one_answer;
mod openapi;
mod outliers;
mod page;
mod peers;
mod plain_words;
mod polylines;
mod process;
mod program;
mod proxies;
mod quotas;
mod random;
mod rates;
mod rational;
mod readme;
mod reference;
mod refusals;
mod repeated_points;
mod replicas;
mod resumed;
mod rpc;
mod rpc_operations;
mod salvage;
mod scales;
mod scattered;
mod sections;
mod secure;
mod settings;
mod shape;
mod short_forms;
mod sockets;
mod stream_object;
mod streams;
mod support;
mod sweeps;
mod telemetry;
mod termination;
mod texts;
mod theory;
mod thresholds;
mod timeouts;
mod tokens_file;
mod transformed;
mod trims;
mod unfolding;
mod views;
mod warnings;

/// The messages and the client that the contract gives to everybody.
#[allow(clippy::all, reason = "generated")]
mod messages {
    include!(concat!(env!("OUT_DIR"), "/client/piad.v1.rs"));
}
