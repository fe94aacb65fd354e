//! Opening a store that no server uses.

use std::time::Duration;

use crate::config::Storage;
use crate::job::counters::Counters;
use crate::job::store::Store;
use crate::job::store::shared::Settings;

/// Work job by job needs few connections.
const SETTINGS: Settings = Settings {
    connections: 2,
    lease: Duration::from_secs(15),
};

/// Opens a store that no server uses.
pub(super) async fn open(storage: &Storage) -> Result<Store, String> {
    if *storage == Storage::Memory {
        return Err(":memory: is not a persistent store".to_owned());
    }
    let store = Store::open(storage.place(SETTINGS), Counters::default()).await;
    let store = store.map_err(|error| error.to_string())?;
    if let Some(shared) = store.shared()
        && shared
            .is_in_use()
            .await
            .map_err(|error| error.to_string())?
    {
        return Err("servers are running jobs of the database: stop them first".to_owned());
    }
    Ok(store)
}
