//! Enumerations whose values have names, which are the same in JSON, in queries and in stores.

/// A value with a name.
pub trait Named: Copy + PartialEq + 'static {
    /// All values with their names; the first is the one that is meant if none is chosen.
    const ALL: &'static [(Self, &'static str)];

    /// The names.
    fn names() -> Vec<&'static str> {
        Self::ALL.iter().map(|(_, name)| *name).collect()
    }

    /// What it is called.
    fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(value, _)| *value == self);
        entry.map_or("", |(_, name)| name)
    }

    /// The value of a name.
    fn of_name(name: &str) -> Option<Self> {
        let entry = Self::ALL.iter().find(|(_, known)| *known == name);
        entry.map(|(value, _)| *value)
    }
}

/// Declares an enumeration with the names of its values.
macro_rules! named {
    ($(#[$about:meta])* $type:ident { $($(#[$meaning:meta])* $value:ident = $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
        pub enum $type {
            $($(#[$meaning])* #[serde(rename = $name)] $value,)+
        }

        impl $crate::model::named::Named for $type {
            const ALL: &'static [(Self, &'static str)] = &[$((Self::$value, $name),)+];
        }
    };
}
pub(crate) use named;
