//! The tokens of a server, and the checks of requests against them. The quotas of tenants come from the same file.

use std::env::{self, VarError};
use std::path::PathBuf;
use std::sync::Arc;

use jiff::Timestamp;
use parking_lot::Mutex;
use uuid::Uuid;

use super::denial::Denial;
use super::file::{Token, TokensFile};
use super::scope::Scope;
use super::secret::Hash;
use super::ticket::{Ticket, TicketKey};
use crate::job::quota::Quotas;
use crate::job::tenant::Tenant;
use crate::reload::{Reload, Seen};

/// The variable with a token of all scopes, for use before there is a file.
pub(crate) const BOOTSTRAP: &str = "PIAD_TOKEN";

/// The shortest token in the variable: shorter ones could be guessed.
const SHORTEST: usize = 32;

/// The tokens of a server.
#[derive(Debug)]
pub(crate) struct Tokens {
    path: Option<PathBuf>,
    /// The token of the variable.
    bootstrap: Option<Token>,
    loaded: Mutex<Loaded>,
    /// The quotas that the file sets.
    quotas: Arc<Quotas>,
}

#[derive(Debug)]
struct Loaded {
    tokens: Arc<Vec<Token>>,
    seen: Seen,
    /// True if the file could not be loaded since.
    is_stale: bool,
}

impl Tokens {
    /// The tokens of a file and of the variable, if there are any.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, or the token of the variable can be guessed.
    pub(crate) fn find(path: Option<PathBuf>, quotas: Arc<Quotas>) -> Result<Option<Self>, String> {
        let bootstrap = match env::var(BOOTSTRAP) {
            Ok(token) if !token.is_empty() => Some(bootstrap(&token)?),
            Ok(_) | Err(VarError::NotPresent) => None,
            Err(VarError::NotUnicode(_)) => return Err(format!("{BOOTSTRAP}: not UTF-8")),
        };
        if path.is_none() && bootstrap.is_none() {
            return Ok(None);
        }
        let loaded = Mutex::new(Loaded::from(path.as_ref(), &quotas)?);
        Ok(Some(Self {
            path,
            bootstrap,
            loaded,
            quotas,
        }))
    }

    /// The token with this text, if it has the scope.
    pub(crate) fn admit(&self, text: &str, scope: Scope) -> Result<Token, Denial> {
        let hash = Hash::of(text);
        // All are compared, so that the time reveals no match.
        let found = self.all(|token, found: &mut Option<Token>| {
            if token.hash.is(&hash) {
                *found = Some(token.clone());
            }
        });
        checked(found.ok_or(Denial::Unknown)?, scope)
    }

    /// The token that a ticket for a job was made with.
    pub(crate) fn admit_by_ticket(
        &self,
        text: &str,
        job: Uuid,
        key: &TicketKey,
    ) -> Result<Token, Denial> {
        let ticket = Ticket::read(text).ok_or(Denial::Ticket)?;
        let found = self.all(|token, found: &mut Option<Token>| {
            if ticket.opens(key, token, job) {
                *found = Some(token.clone());
            }
        });
        checked(found.ok_or(Denial::Ticket)?, Scope::JobsRead)
    }

    /// Returns true if the file could not be loaded the last time: tokens revoked in it since are still accepted.
    pub(crate) fn are_stale(&self) -> bool {
        self.loaded.lock().is_stale
    }

    /// Calls back with each token.
    fn all<T: Default>(&self, mut look: impl FnMut(&Token, &mut T)) -> T {
        let mut result = T::default();
        let tokens = Arc::clone(&self.loaded.lock().tokens);
        for token in tokens.iter().chain(&self.bootstrap) {
            look(token, &mut result);
        }
        result
    }
}

/// Checks that a token has not expired, and has the scope.
fn checked(token: Token, needed: Scope) -> Result<Token, Denial> {
    if token.has_expired() {
        return Err(Denial::Expired { token: token.id });
    }
    match token.may(needed) {
        true => Ok(token),
        false => Err(Denial::Scope {
            token: token.id,
            needed,
        }),
    }
}

/// The token of the variable, which has all scopes.
fn bootstrap(text: &str) -> Result<Token, String> {
    if text.len() < SHORTEST {
        return Err(format!(
            "{BOOTSTRAP}: a token has at least {SHORTEST} characters; `piad token create` makes one"
        ));
    }
    Ok(Token {
        id: BOOTSTRAP.to_owned(),
        tenant: Tenant::DEFAULT,
        scopes: [Scope::Admin].into(),
        created: Timestamp::now(),
        expires: None,
        note: None,
        hash: Hash::of(text),
    })
}

impl Loaded {
    fn from(path: Option<&PathBuf>, quotas: &Quotas) -> Result<Self, String> {
        let seen = Seen::of(path);
        let file = path.map(|path| TokensFile::read(path)).transpose();
        let file = file.map_err(|reason| format!("--tokens {reason}"))?;
        let file = file.unwrap_or_default();
        quotas.set(file.quotas);
        let tokens = Arc::new(file.tokens);
        Ok(Self {
            tokens,
            seen,
            is_stale: false,
        })
    }
}

impl Reload for Tokens {
    const WHAT: &'static str = "tokens";

    fn load_again(&self, anyway: bool) -> Result<bool, String> {
        let seen = Seen::of(self.path.as_ref());
        if !anyway && self.loaded.lock().seen == seen {
            return Ok(false);
        }
        let loaded = Loaded::from(self.path.as_ref(), &self.quotas);
        let mut current = self.loaded.lock();
        match loaded {
            Ok(loaded) => {
                *current = loaded;
                Ok(true)
            }
            Err(reason) => {
                // An error is logged once.
                current.seen = seen;
                current.is_stale = true;
                Err(reason)
            }
        }
    }
}
