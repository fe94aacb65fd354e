//! `piad token`: makes, lists and revokes the tokens of a server.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::ExitCode;

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::shells;
use crate::access::file::{Token, TokensFile};
use crate::access::scope::Scope;
use crate::access::secret::{self, Hash};
use crate::config::{Lifetime, TokenCommand};
use crate::job::tenant::Tenant;
use crate::terminal::say;

/// The number of characters of an id.
const ID: usize = 8;

/// Runs the command; the exit status says whether it has succeeded.
pub fn run(command: &TokenCommand) -> ExitCode {
    let done = match command {
        TokenCommand::Create {
            tokens,
            tenant,
            scope,
            expires,
            note,
        } => create(tokens, tenant, scope, *expires, note.clone()),
        TokenCommand::List { tokens } => list(tokens),
        TokenCommand::Revoke { tokens, id } => revoke(tokens, id),
    };
    match done {
        Ok(lines) => shells::show_lines(lines.iter().map(String::as_str)),
        Err(reason) => {
            say(format_args!("piad: {reason}"));
            ExitCode::FAILURE
        }
    }
}

/// Makes a token, which is shown once.
fn create(
    path: &Path,
    tenant: &str,
    scopes: &[Scope],
    lifetime: Lifetime,
    note: Option<String>,
) -> Result<Vec<String>, String> {
    let tenant: Tenant = tenant.parse()?;
    let text = secret::generate()?;
    let created = Timestamp::now();
    let expires = match lifetime {
        Lifetime::Never => None,
        Lifetime::For(time) => Some(end(created, time)?),
    };
    let token = TokensFile::change(path, |file| {
        let id = Uuid::new_v4().simple().to_string();
        let token = Token {
            id: id[..ID].to_owned(),
            tenant,
            scopes: scopes.iter().copied().collect(),
            created: second(created),
            expires: expires.map(second),
            note,
            hash: Hash::of(&text),
        };
        file.tokens.push(token.clone());
        Ok(token)
    })?;
    say(line(&token));
    Ok(vec![text])
}

/// The end of a lifetime.
fn end(begin: Timestamp, time: SignedDuration) -> Result<Timestamp, String> {
    let end = begin.checked_add(time);
    end.map_err(|_| "--expires: that is too long; never is possible, too".to_owned())
}

/// A time rounded to seconds.
fn second(at: Timestamp) -> Timestamp {
    Timestamp::from_second(at.as_second()).unwrap_or(at)
}

/// All tokens and quotas, a line each.
fn list(path: &Path) -> Result<Vec<String>, String> {
    let file = TokensFile::read(path)?;
    let quotas = file.quotas.iter().map(|(tenant, quota)| {
        let quota = toml::to_string(quota).unwrap_or_default();
        format!(
            "quota of {tenant}: {}",
            quota.trim_end().replace('\n', ", ")
        )
    });
    let lines: Vec<String> = file.tokens.iter().map(line).chain(quotas).collect();
    match lines.is_empty() {
        true => Ok(vec!["there are no tokens".to_owned()]),
        false => Ok(lines),
    }
}

fn line(token: &Token) -> String {
    let scopes: BTreeSet<&str> = token.scopes.iter().map(|scope| scope.name()).collect();
    let scopes = scopes.into_iter().collect::<Vec<_>>().join(",");
    let expires = match token.expires {
        None => "never expires".to_owned(),
        Some(at) if token.has_expired() => format!("has expired {at}"),
        Some(at) => format!("expires {at}"),
    };
    let (id, tenant, created) = (&token.id, token.tenant, token.created);
    let note = token.note.as_deref().map(|it| format!("  {it}"));
    let note = note.unwrap_or_default();
    format!("{id}  {tenant}  {scopes}  created {created}  {expires}{note}")
}

/// Removes a token. Servers notice within two seconds.
fn revoke(path: &Path, id: &str) -> Result<Vec<String>, String> {
    TokensFile::change(path, |file| {
        let place = file.tokens.iter().position(|token| token.id == id);
        let Some(place) = place else {
            return Err(format!("there is no token {id} in {}", path.display()));
        };
        let token = file.tokens.remove(place);
        Ok(vec![format!("revoked {}", line(&token))])
    })
}
