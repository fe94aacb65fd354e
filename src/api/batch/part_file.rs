//! The answer to a batch as one file: the curves and surfaces of all its items.

use jiff::Timestamp;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use super::geometry::Geometry;
use piad_files::export::{Format, Header, Options, Part, write_parts};

/// A line of the answer to a batch: an item, or the end.
#[derive(Debug, Deserialize)]
pub(crate) struct BatchLine<'a> {
    /// The index of an item; `None` at the end.
    pub index: Option<usize>,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The final state of its fit.
    #[serde(default)]
    pub state: String,
    /// Notices about its points.
    #[serde(default)]
    pub notices: Vec<String>,
    /// The distances from the data.
    pub error: Option<Distances>,
    #[serde(borrow)]
    curve: Option<&'a RawValue>,
    #[serde(borrow)]
    surface: Option<&'a RawValue>,
    /// Why it has not converged, or why the batch ended early.
    pub problem: Option<Why>,
    /// At the end: the number of items.
    pub totals: Option<IgnoredAny>,
}

/// Distances from the data; `None` where they are infinite.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Distances {
    /// The largest one.
    pub max: Option<f64>,
    /// Their root mean square.
    pub rms: Option<f64>,
}

/// Why a fit failed.
#[derive(Debug, Deserialize)]
pub(crate) struct Why {
    /// In a sentence.
    pub detail: String,
}

impl BatchLine<'_> {
    /// The name of an item, or its number from 1.
    pub(crate) fn title(&self) -> String {
        let number = self.index.map_or(0, |index| index + 1);
        self.name
            .clone()
            .unwrap_or_else(|| format!("part {number}"))
    }

    /// The fitted geometry, if there is a result.
    pub(crate) fn geometry(&self) -> serde_json::Result<Option<Geometry>> {
        let raw = self.curve.or(self.surface);
        raw.map(|raw| serde_json::from_str(raw.get())).transpose()
    }
}

/// The curves and surfaces of a file, with their names.
#[derive(Debug, Default)]
pub(crate) struct PartFile(Vec<(String, Geometry)>);

impl PartFile {
    /// Adds a curve or a surface.
    pub(crate) fn add(&mut self, name: String, geometry: Geometry) {
        self.0.push((name, geometry));
    }

    /// Returns true if there is a surface among them.
    pub(crate) fn has_surface(&self) -> bool {
        self.0.iter().any(|(_, geometry)| geometry.is_surface())
    }

    /// All of them as one file.
    ///
    /// # Errors
    ///
    /// Why one of them cannot be written, with its name.
    pub(crate) fn write(&self, format: Format, options: Options) -> Result<Vec<u8>, String> {
        let mut parts = Vec::with_capacity(self.0.len());
        for (name, geometry) in &self.0 {
            let wrong = |reason| format!("{name}: {reason}");
            parts.push(Part {
                name: Some(name.as_str()),
                nurbs: geometry.nurbs().map_err(wrong)?,
                outline: geometry.outline().map_err(wrong)?,
            });
        }
        let header = Header::new(Timestamp::now(), options);
        write_parts(format, &parts, &header).map_err(|reason| reason.to_string())
    }
}
