//! The file of the tokens of a server and the quotas of its tenants: TOML, without the tokens themselves. Its last line
//! marks the end: a truncated file could be valid, with fewer quotas.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use super::scope::Scope;
use super::secret::Hash;
use crate::files;
use crate::job::quota::Quota;
use crate::job::tenant::Tenant;
use crate::toml_text;

/// The last line of a file.
const LAST_LINE: &str = "# end of file";

/// The contents of a file.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TokensFile {
    /// The tokens, in the order in which they were made.
    #[serde(default, rename = "token")]
    pub(crate) tokens: Vec<Token>,
    /// The quotas of tenants.
    #[serde(default, rename = "tenant", skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) quotas: BTreeMap<Tenant, Quota>,
}

/// An entry of a token.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Token {
    /// Its id in lists and in the log.
    pub(crate) id: String,
    /// The tenant that owns the jobs made with it.
    pub(crate) tenant: Tenant,
    /// Its scopes.
    pub(crate) scopes: BTreeSet<Scope>,
    pub(crate) created: Timestamp,
    /// The time at which it expires.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) expires: Option<Timestamp>,
    /// A note by its creator on what it is for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) note: Option<String>,
    pub(crate) hash: Hash,
}

impl Token {
    /// Returns true if it has expired.
    pub(crate) fn has_expired(&self) -> bool {
        self.expires.is_some_and(|at| at <= Timestamp::now())
    }

    /// Returns true if it has this scope.
    pub(crate) fn may(&self, scope: Scope) -> bool {
        let has = |scope| self.scopes.contains(&scope);
        has(scope) || has(Scope::Admin) || (scope == Scope::Metrics && has(Scope::MetricsAll))
    }
}

impl TokensFile {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read, is truncated or has another format; the error names it.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let wrong = |reason: String| format!("{}: {reason}", path.display());
        let text = files::read_settings(path).map_err(|reason| wrong(reason.to_string()))?;
        let file: Self = toml_text::parse(&text).map_err(wrong)?;
        if text
            .lines()
            .rfind(|line| !line.trim().is_empty())
            .map(str::trim)
            != Some(LAST_LINE)
        {
            return Err(wrong(format!(
                "its last line is not `{LAST_LINE}`: the file is cut off, or something was added below that line"
            )));
        }
        let mut ids = BTreeSet::new();
        match file.tokens.iter().find(|token| !ids.insert(&token.id)) {
            Some(token) => Err(wrong(format!("there are two tokens {}", token.id))),
            None => Ok(file),
        }
    }

    /// Changes a file, which need not exist. It is replaced atomically. Links to it, its owner and its permissions stay
    /// as they are; a new file is readable for its owner alone.
    ///
    /// # Errors
    ///
    /// If it cannot be read or written, or the change is refused.
    pub(crate) fn change<T>(
        path: &Path,
        change: impl FnOnce(&mut Self) -> Result<T, String>,
    ) -> Result<T, String> {
        let wrong = |reason: io::Error| format!("{}: {reason}", path.display());
        let path = &behind_links(path).map_err(wrong)?;
        let parent = path.parent().filter(|it| !it.as_os_str().is_empty());
        let directory = parent.unwrap_or(Path::new("."));
        // Other writers wait meanwhile.
        let lock = File::open(directory).map_err(wrong)?;
        lock.lock().map_err(wrong)?;
        let mut file = match path.try_exists().map_err(wrong)? {
            true => Self::read(path)?,
            false => Self::default(),
        };
        let changed = change(&mut file)?;
        let text = toml::to_string(&file).map_err(|reason| reason.to_string())?;
        replace(path, directory, &format!("{text}\n{LAST_LINE}\n")).map_err(wrong)?;
        // On Unix a new name is durable once its directory is on the disk.
        #[cfg(unix)]
        lock.sync_all().map_err(wrong)?;
        Ok(changed)
    }
}

/// The file that a path leads to through links; the path itself if there is none.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    match fs::canonicalize(path) {
        Err(reason) if reason.kind() == ErrorKind::NotFound => match fs::symlink_metadata(path) {
            Err(_) => Ok(path.to_owned()),
            Ok(_) => Err(io::Error::new(
                reason.kind(),
                "a link to a file that is not there",
            )),
        },
        found => found,
    }
}

/// Replaces a file by one with this text, with its owner and permissions.
fn replace(path: &Path, directory: &Path, text: &str) -> io::Result<()> {
    let mut new = NamedTempFile::new_in(directory)?;
    new.write_all(text.as_bytes())?;
    if path.try_exists()? {
        let old = fs::metadata(path)?;
        #[cfg(unix)]
        keep_owner(&old, new.as_file())?;
        new.as_file().set_permissions(old.permissions())?;
    }
    new.as_file().sync_all()?;
    new.persist(path)?;
    Ok(())
}

/// Gives a file the owner and the group of the one that it replaces: otherwise a server that runs as its owner could not
/// read what root has changed.
#[cfg(unix)]
fn keep_owner(old: &fs::Metadata, new: &File) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    if old.nlink() > 1 {
        return Err(io::Error::other(
            "the file has several names (hard links), all but one of which would keep the old tokens: remove the others",
        ));
    }
    let made = new.metadata()?;
    if (made.uid(), made.gid()) == (old.uid(), old.gid()) {
        return Ok(());
    }
    fchown(new, Some(old.uid()), Some(old.gid())).map_err(|reason| {
        let (owner, group) = (old.uid(), old.gid());
        let text = format!("its owner {owner} and group {group} cannot be kept: {reason}");
        io::Error::new(reason.kind(), text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::secret;

    fn token(id: &str) -> Token {
        Token {
            id: id.to_owned(),
            tenant: Tenant::DEFAULT,
            scopes: [Scope::JobsRead].into(),
            created: Timestamp::UNIX_EPOCH,
            expires: None,
            note: None,
            hash: Hash::of(&secret::generate().unwrap()),
        }
    }

    #[test]
    fn a_file_that_is_cut_off_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.toml");
        let quota = Quota {
            jobs: Some(10),
            points: Some(1000),
            streams: Some(5),
            ..Quota::default()
        };
        TokensFile::change(&path, |file| {
            file.tokens.push(token("a1"));
            file.quotas.insert(Tenant::DEFAULT, quota);
            file.quotas.insert("cad".parse().unwrap(), quota);
            Ok(())
        })
        .unwrap();
        let whole = fs::read(&path).unwrap();
        assert_eq!(TokensFile::read(&path).unwrap().quotas.len(), 2);
        // All but the end of the last line.
        for length in 0..whole.len() - 1 {
            fs::write(&path, &whole[..length]).unwrap();
            let refused = TokensFile::read(&path).unwrap_err();
            assert!(refused.starts_with(path.to_str().unwrap()), "{refused}");
            assert!(TokensFile::change(&path, |_| Ok(())).is_err(), "{length}");
        }
        let added = [&whole, &b"[tenant.late]\njobs = 1\n"[..]].concat();
        fs::write(&path, added).unwrap();
        let refused = TokensFile::read(&path).unwrap_err();
        assert!(refused.contains("added below that line"), "{refused}");
    }
}
