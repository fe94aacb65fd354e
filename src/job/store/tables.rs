//! The tables of the database, and the version of their content.

use redb::TableDefinition;

/// The version of what is described here. Files of other versions are refused.
pub(super) const VERSION: u64 = 1;

/// Facts about the file itself.
pub(super) const FACTS: TableDefinition<&str, u64> = TableDefinition::new("facts");
pub(super) const VERSION_FACT: &str = "version";

/// Jobs without their points, by id: lists read only these.
pub(super) const HEADERS: TableDefinition<u128, &[u8]> = TableDefinition::new("headers");
/// Problems as they were asked for, by the id of the job.
pub(super) const INPUTS: TableDefinition<u128, &[u8]> = TableDefinition::new("inputs");
/// The free control points of the last level, by the id of the job.
pub(super) const RESULTS: TableDefinition<u128, &[u8]> = TableDefinition::new("results");
/// Which job was made for a key.
pub(super) const KEYS: TableDefinition<&str, &[u8]> = TableDefinition::new("keys");
/// Nothing: pages are taken and given back here, so that there are some.
pub(super) const SLACK: TableDefinition<u64, &[u8]> = TableDefinition::new("slack");
