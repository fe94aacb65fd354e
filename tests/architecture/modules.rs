//! The modules of a crate, and which of them use which.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, Item, Visibility};

use super::paths::{self, Import};

/// The path of a module in its crate; that of the crate itself is empty.
pub type Name = Vec<String>;

/// What is read of a module.
#[derive(Default)]
pub struct Module {
    /// The names of what it defines.
    pub defined: HashSet<String>,
    /// What it imports or passes on.
    pub imports: Vec<Import>,
    /// The other paths in it, as they are written.
    pub paths: Vec<Name>,
}

/// The modules of a crate by their names, without those of tests.
pub struct Modules(HashMap<Name, Module>);

impl Modules {
    /// Reads the modules of a crate, from `lib.rs` or `main.rs` on.
    pub fn of(folder: &Path) -> Self {
        let mut modules = Self(HashMap::new());
        let root = folder.join("lib.rs");
        modules.read(Vec::new(), &root, folder);
        modules
    }

    /// Reads a module and those below it, whose files are in `folder`.
    fn read(&mut self, name: Name, file: &Path, folder: &Path) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{file:?}: {error}"));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{file:?}: {error}"));
        let items: Vec<Item> = parsed.items.into_iter().filter(|it| !is_test(it)).collect();
        let mut module = Module::default();
        for item in &items {
            module.defined.extend(defined(item));
            match item {
                Item::Use(item) => {
                    let is_passed_on = !matches!(item.vis, Visibility::Inherited);
                    module
                        .imports
                        .extend(paths::imports(&item.tree, is_passed_on));
                }
                item => module.paths.extend(paths::of(item)),
            }
            if let Item::Mod(item) = item
                && item.content.is_none()
            {
                let child = item.ident.to_string();
                let (file, folder) = place(folder, &child);
                self.read([&name[..], &[child]].concat(), &file, &folder);
            }
        }
        self.0.insert(name, module);
    }

    /// Which modules use which.
    pub fn uses(&self) -> Vec<(Name, Name)> {
        let mut uses = Vec::new();
        for (name, module) in &self.0 {
            let imports = module.imports.iter().filter(|it| !it.is_passed_on);
            let imports = imports.map(|it| it.path.clone());
            for path in imports.chain(module.paths.iter().map(|path| module.imported(path))) {
                let path = self.absolute(name, &path);
                if let Some(used) = path.and_then(|path| self.home(&path))
                    && used != *name
                {
                    uses.push((name.clone(), used));
                }
            }
        }
        uses.sort();
        uses.dedup();
        uses
    }

    /// A path of a module as one of the crate, if it is one.
    fn absolute(&self, module: &Name, path: &Name) -> Option<Name> {
        let mut from = module.clone();
        let mut rest = &path[..];
        match rest.first()?.as_str() {
            "crate" => (from, rest) = (Vec::new(), &rest[1..]),
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|it| it == "super") {
                    from.pop();
                    rest = &rest[1..];
                }
            }
            child => {
                let child = [&from[..], &[child.to_owned()]].concat();
                self.0.get(&child)?;
            }
        }
        Some([&from[..], rest].concat())
    }

    /// The module that defines what a path of the crate leads to.
    fn home(&self, path: &Name) -> Option<Name> {
        let mut home: Name = Vec::new();
        for (place, part) in path.iter().enumerate() {
            let child = [&home[..], std::slice::from_ref(part)].concat();
            if self.0.contains_key(&child) {
                home = child;
                continue;
            }
            let module = &self.0[&home];
            if module.defined.contains(part) {
                return Some(home);
            }
            // Children also see what their parents have imported for themselves.
            let Some(import) = module.imports.iter().find(|it| it.name == *part) else {
                return Some(home);
            };
            let origin = self.absolute(&home, &import.path)?;
            return self.home(&[&origin[..], &path[place + 1..]].concat());
        }
        Some(home)
    }
}

impl Module {
    /// A path whose first name was imported, with what it was imported from.
    fn imported(&self, path: &Name) -> Name {
        let import = self.imports.iter().find(|it| it.name == path[0]);
        match import {
            Some(import) => [&import.path[..], &path[1..]].concat(),
            None => path.clone(),
        }
    }
}

/// The file of a module in a folder, and the folder of those below it.
fn place(folder: &Path, child: &str) -> (PathBuf, PathBuf) {
    let below = folder.join(child);
    let file = folder.join(format!("{child}.rs"));
    match file.exists() {
        true => (file, below),
        false => (below.join("mod.rs"), below),
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Mod(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        _ => &[],
    }
}

/// Returns true if an item is only there in tests or for fuzzing.
fn is_test(item: &Item) -> bool {
    attributes(item).iter().any(|attribute| {
        let condition = attribute.meta.require_list();
        attribute.path().is_ident("cfg")
            && condition.is_ok_and(|it| {
                let condition = it.tokens.to_string();
                condition.contains("test") || condition.contains("fuzzing")
            })
    })
}

/// The name that an item defines.
fn defined(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        _ => return None,
    };
    Some(name.to_string())
}
