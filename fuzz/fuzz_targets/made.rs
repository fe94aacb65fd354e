//! Jobs that are made up of the bytes, and edits of them.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| piad::api::fuzzing::made(bytes));
