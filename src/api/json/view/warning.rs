//! What is doubtful about a job.

use serde::Serialize;

use crate::api::json::request::places::Places;
use crate::fit::warning::Warning;
use crate::job::outline::Outline;
use crate::job::state::Levels;

/// A warning as clients see it.
#[derive(Serialize)]
pub struct WarningView {
    code: &'static str,
    pointer: String,
    detail: String,
}

/// What is doubtful about a job, as far as is known by now.
pub fn warnings(outline: &Outline, levels: Option<&Levels>) -> Vec<WarningView> {
    let view = |warning: Warning| WarningView {
        code: warning.code(),
        pointer: pointer(&warning, outline, outline.bases_differ),
        detail: warning.detail(),
    };
    outline.warnings(levels).map(view).collect()
}

/// Where in the job's input the part stands that a warning is about; `each` if directions of surfaces
/// have bases of their own there.
pub fn pointer(warning: &Warning, outline: &Outline, each: bool) -> String {
    let columns = outline.surface.then_some(outline.grid.columns);
    Places::of_input(columns, each).pointer_to(warning.place())
}
