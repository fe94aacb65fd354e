//! Flags about output files as the query of a request.

use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};

use crate::api::http::query::file_options;
use crate::config::fit_arguments::FitArguments;
use piad_files::export::{Format, Options, Origin};

/// The choices about files of a fit.
#[derive(Clone, Debug, Default)]
pub(super) struct FileQuery {
    units: Option<String>,
    svg: Option<String>,
    dxf: Option<String>,
    samples: Option<String>,
    spacing: Option<String>,
    /// The origin of the coordinates.
    origin: Option<String>,
}

impl FileQuery {
    /// The choices of the flags.
    pub(super) fn new(arguments: &FitArguments) -> Self {
        Self {
            units: arguments.units.clone(),
            svg: arguments.svg.clone(),
            dxf: arguments.dxf.clone(),
            samples: arguments.samples.clone(),
            spacing: arguments.spacing.clone(),
            origin: arguments.origin.clone(),
        }
    }

    /// Takes the origin of the longitudes and latitudes of the input, unless another one is given.
    pub(super) fn set_origin(&mut self, origin: Option<Origin>) {
        let text = origin.map(|it| format!("{},{}", it.latitude, it.longitude));
        self.origin = self.origin.take().or(text);
    }

    /// The query for a file of this format, with the options it has.
    pub(super) fn of(&self, format: Format) -> String {
        let has_samples = format.has_samples();
        let exact = format == Format::Dxf && self.dxf.as_deref() == Some("r2000");
        let parameters = [
            ("units", &self.units, format.has_unit()),
            ("style", &self.svg, format.has_style()),
            ("version", &self.dxf, format.has_version()),
            ("samples", &self.samples, has_samples && !exact),
            ("spacing", &self.spacing, format.has_spacing() && !exact),
            ("origin", &self.origin, format.has_origin()),
        ];
        let given = parameters.iter().filter(|(_, _, is_about)| *is_about);
        let given = given.filter_map(|(name, value, _)| {
            let value = value.as_ref()?;
            Some(format!(
                "{name}={}",
                utf8_percent_encode(value, NON_ALPHANUMERIC)
            ))
        });
        given.collect::<Vec<_>>().join("&")
    }

    /// The options of a file of this format for a curve or a surface, or the error in them.
    pub(super) fn options(&self, format: Format, surface: bool) -> Result<Options, String> {
        let options = file_options(&self.of(format), format, surface);
        options.map_err(|problem| problem.detail().to_owned())
    }
}
