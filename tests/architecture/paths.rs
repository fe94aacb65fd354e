//! The paths in a file.

use syn::visit::{Visit, visit_path};
use syn::{Item, ItemMod, Path, UseTree, Visibility};

use super::modules::Name;

/// A name that a module has from elsewhere.
pub struct Import {
    /// What it is called there.
    pub name: String,
    /// Where it comes from, as it is written.
    pub path: Name,
    /// True if others can import it from there.
    pub is_passed_on: bool,
}

/// The names of a `use` declaration.
pub fn imports(tree: &UseTree, is_passed_on: bool) -> Vec<Import> {
    let mut all = Vec::new();
    collect(tree, &mut Vec::new(), &mut |name, path| {
        all.push(Import {
            name,
            path,
            is_passed_on,
        });
    });
    all
}

fn collect(tree: &UseTree, before: &mut Name, take: &mut impl FnMut(String, Name)) {
    let path = |before: &Name, last: &str| match last {
        "self" => before.clone(),
        last => [&before[..], &[last.to_owned()]].concat(),
    };
    match tree {
        UseTree::Path(tree) => {
            before.push(tree.ident.to_string());
            collect(&tree.tree, before, take);
            before.pop();
        }
        UseTree::Group(group) => {
            for tree in &group.items {
                collect(tree, before, take);
            }
        }
        UseTree::Name(name) => {
            let path = path(before, &name.ident.to_string());
            take(path.last().cloned().unwrap_or_default(), path);
        }
        UseTree::Rename(rename) => {
            let path = path(before, &rename.ident.to_string());
            take(rename.rename.to_string(), path);
        }
        UseTree::Glob(_) => take("*".to_owned(), before.clone()),
    }
}

/// The paths of an item with more than one name in them.
pub fn of(item: &Item) -> Vec<Name> {
    let mut paths = Paths(Vec::new());
    paths.visit_item(item);
    paths.0
}

struct Paths(Vec<Name>);

impl<'ast> Visit<'ast> for Paths {
    fn visit_path(&mut self, path: &'ast Path) {
        if path.segments.len() > 1 {
            let names = path.segments.iter().map(|it| it.ident.to_string());
            self.0.push(names.collect());
        }
        visit_path(self, path);
    }

    /// Who sees an item is not what it uses.
    fn visit_visibility(&mut self, _visibility: &'ast Visibility) {}

    /// Modules within a file are those of tests.
    fn visit_item_mod(&mut self, _module: &'ast ItemMod) {}
}
