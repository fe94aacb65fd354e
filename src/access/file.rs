//! The tokens of a server, and the quotas of its tenants, as a file has them: TOML, without the tokens
//! themselves.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use super::scope::Scope;
use super::secret::Hash;
use crate::job::quota::Quota;
use crate::job::tenant::Tenant;

/// What a file holds.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TokensFile {
    /// The tokens, in the order in which they were made.
    #[serde(default, rename = "token")]
    pub(crate) tokens: Vec<Token>,
    /// What tenants may have.
    #[serde(default, rename = "tenant", skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) quotas: BTreeMap<Tenant, Quota>,
}

/// What is known of a token.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Token {
    /// What it is called in lists and in the log.
    pub(crate) id: String,
    /// To whom the jobs belong that are made with it.
    pub(crate) tenant: Tenant,
    /// What it is good for.
    pub(crate) scopes: BTreeSet<Scope>,
    pub(crate) created: Timestamp,
    /// From when on it is good for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) expires: Option<Timestamp>,
    /// What it is for, in the words of whoever has made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) note: Option<String>,
    pub(crate) hash: Hash,
}

impl Token {
    /// Whether its time is over.
    pub(crate) fn has_expired(&self) -> bool {
        self.expires.is_some_and(|at| at <= Timestamp::now())
    }

    /// Whether it is good for this.
    pub(crate) fn may(&self, scope: Scope) -> bool {
        self.scopes.contains(&scope) || self.scopes.contains(&Scope::Admin)
    }
}

impl TokensFile {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read or is not such a file; the error names it.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let wrong = |reason: String| format!("{}: {reason}", path.display());
        let text = fs::read_to_string(path).map_err(|reason| wrong(reason.to_string()))?;
        let file: Self = toml::from_str(&text).map_err(|reason| wrong(reason.to_string()))?;
        let mut ids = BTreeSet::new();
        match file.tokens.iter().find(|token| !ids.insert(&token.id)) {
            Some(token) => Err(wrong(format!("there are two tokens {}", token.id))),
            None => Ok(file),
        }
    }

    /// Changes a file, which need not be there. It is there as a whole at each moment, and readable for its owner
    /// alone if it is new.
    ///
    /// # Errors
    ///
    /// If it cannot be read or written, or the change is refused.
    pub(crate) fn change<T>(
        path: &Path,
        change: impl FnOnce(&mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        let wrong = |reason: io::Error| format!("{}: {reason}", path.display());
        let parent = path.parent().filter(|it| !it.as_os_str().is_empty());
        let directory = parent.unwrap_or(Path::new("."));
        // Whoever changes it meanwhile waits.
        let lock = File::open(directory).map_err(wrong)?;
        lock.lock().map_err(wrong)?;
        let mut file = match path.exists() {
            true => Self::read(path)?,
            false => Self::default(),
        };
        let changed = change(&mut file)?;
        let text = toml::to_string(&file).map_err(|reason| reason.to_string())?;
        let write = || -> io::Result<()> {
            let mut new = NamedTempFile::new_in(directory)?;
            new.write_all(text.as_bytes())?;
            if let Ok(old) = fs::metadata(path) {
                new.as_file().set_permissions(old.permissions())?;
            }
            new.as_file().sync_all()?;
            new.persist(path)?;
            Ok(())
        };
        write().map_err(wrong)?;
        Ok(changed)
    }
}
