//! Layers named after the parts.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::export::document::Document;

/// The layer that is always there.
pub(super) const ALWAYS: &str = "0";

/// Rules for layer names.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerRules {
    /// The most characters of a name.
    pub(super) longest: usize,
    /// Returns true for characters that a name can have.
    pub(super) allows: fn(char) -> bool,
}

/// The names of R12: letters, digits and three signs.
pub(super) const R12: LayerRules = LayerRules {
    longest: 31,
    allows: |c| c.is_ascii_alphanumeric() || matches!(c, '$' | '-' | '_'),
};

/// The names of R2000: all but the signs that AutoCAD refuses, as the first 65,536 characters, which it has escapes for.
pub(super) const R2000: LayerRules = LayerRules {
    longest: 255,
    allows: |c| {
        let refused = "<>/\\\":;?*|=,`";
        !c.is_control() && u32::from(c) <= 0xffff && !refused.contains(c)
    },
};

/// The layer of each shape: the name of the part made a valid one, which no other shape has. Without a name it is
/// layer 0, and so it is for fits, whose name is not that of a part.
pub(super) fn of_shapes(document: &Document<'_>, rules: LayerRules) -> Vec<String> {
    let mut given = Given::default();
    let layer = |name: Option<&str>| {
        let name = name.filter(|_| document.has_parts).map(str::trim);
        match name.filter(|name| !name.is_empty()) {
            None => ALWAYS.to_owned(),
            Some(name) => given.unique(name, rules),
        }
    };
    let names = document.shapes.iter().map(|shape| shape.name);
    names.map(layer).collect()
}

/// The names that were given, and how often each was wanted. Layers do not differ by the case of letters.
#[derive(Default)]
struct Given(HashMap<String, usize>);

impl Given {
    fn unique(&mut self, name: &str, rules: LayerRules) -> String {
        let clean = |c| if (rules.allows)(c) { c } else { '_' };
        let stem: String = name.chars().map(clean).take(rules.longest).collect();
        let key = stem.to_lowercase();
        if key != ALWAYS && !self.0.contains_key(&key) {
            self.0.insert(key, 1);
            return stem;
        }
        loop {
            let count = self.0.entry(key.clone()).or_insert(1);
            *count += 1;
            let suffix = format!("_{count}");
            let kept = rules.longest - suffix.len();
            let name: String = stem.chars().take(kept).chain(suffix.chars()).collect();
            if let Entry::Vacant(free) = self.0.entry(name.to_lowercase()) {
                free.insert(1);
                return name;
            }
        }
    }
}

/// The distinct layers besides layer 0.
pub(super) fn declared(layers: &[String]) -> impl Iterator<Item = &str> + Clone {
    let names = layers.iter().map(String::as_str);
    names.filter(|name| *name != ALWAYS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_unique() {
        let mut given = Given::default();
        let mut r12 = |name: &str| given.unique(name, R12);
        assert_eq!(r12("contour 5.0 m"), "contour_5_0_m");
        assert_eq!(r12("Contour 5:0 M"), "Contour_5_0_M_2");
        assert_eq!(r12("contour_5_0_m_2"), "contour_5_0_m_2_2");
        assert_eq!(r12("0"), "0_2");
        assert_eq!(r12("Höhe"), "H_he");
        let long = "x".repeat(40);
        assert_eq!(r12(&long), "x".repeat(31));
        assert_eq!(r12(&long), format!("{}_2", "x".repeat(29)));
        let mut given = Given::default();
        assert_eq!(given.unique("Höhe 5/7 🛩", R2000), "Höhe 5_7 _");
    }
}
