//! Records of the store.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| piad::api::fuzzing::record(bytes));
