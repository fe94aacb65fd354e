//! Files of tokens, as people make them.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use tempfile::TempDir;

use crate::program::{PROGRAM, Program};

/// A file of tokens.
pub struct TokensFile {
    pub folder: TempDir,
}

impl TokensFile {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder }
    }

    pub fn path(&self) -> PathBuf {
        self.folder.path().join("tokens.toml")
    }

    /// Adds lines above the last one.
    pub fn add(&self, text: &str) {
        let content = fs::read_to_string(self.path()).unwrap();
        let (content, last) = content.trim_end().rsplit_once('\n').unwrap();
        self.put(format!("{content}\n{text}\n{last}\n").as_bytes());
    }

    /// Puts another file in its place, in one step: one that is being written is cut off.
    pub fn put(&self, content: &[u8]) {
        let new = self.folder.path().join("new");
        fs::write(&new, content).unwrap();
        fs::rename(&new, self.path()).unwrap();
    }

    pub fn run(&self, verb: &str, arguments: &[&str]) -> Output {
        let mut command = Command::new(PROGRAM);
        command.args(["token", verb, "--tokens"]).arg(self.path());
        command.args(arguments).output().unwrap()
    }

    /// Makes a token.
    pub fn token(&self, tenant: &str, scopes: &str) -> String {
        let output = self.run("create", &["--tenant", tenant, "--scope", scopes]);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    /// The id of the token that was made last.
    pub fn last_id(&self) -> String {
        let output = self.run("list", &[]);
        let list = String::from_utf8(output.stdout).unwrap();
        let last = list.lines().last().unwrap();
        last.split_whitespace().next().unwrap().to_owned()
    }

    pub fn revoke(&self, id: &str) {
        let output = self.run("revoke", &[id]);
        assert!(output.status.success(), "{output:?}");
    }

    /// A server that asks for these tokens.
    pub fn server(&self, arguments: &[&str]) -> Program {
        let file = self.path();
        let tokens = ["--tokens", file.to_str().unwrap()];
        let arguments = [&tokens, arguments].concat();
        Program::with(self.folder.path(), &arguments)
    }
}
