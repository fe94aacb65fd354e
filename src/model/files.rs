//! The names of what can be chosen about files.

use piad_files::export::{Dots, Unit};

use super::named::Named;

impl Named for Dots {
    const ALL: &'static [(Self, &'static str)] =
        &[(Self::Auto, "auto"), (Self::On, "on"), (Self::Off, "off")];
}

impl Named for Unit {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Millimetre, "mm"),
        (Self::Metre, "m"),
        (Self::Inch, "in"),
    ];
}
