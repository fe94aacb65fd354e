//! Names of choices about files.

use piad_files::export::{Dots, Style, Unit, Version};

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

impl Named for Style {
    const ALL: &'static [(Self, &'static str)] =
        &[(Self::Drawing, "drawing"), (Self::Path, "path")];
}

impl Named for Version {
    const ALL: &'static [(Self, &'static str)] = &[(Self::R12, "r12"), (Self::R2000, "r2000")];
}
