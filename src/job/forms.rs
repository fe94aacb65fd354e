//! Things on the wire: each is made once in each form, and shared by all who want it.

use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::OnceCell;

use super::content::Content;

/// What was made of something, by the name of the form.
#[derive(Debug, Default)]
pub struct Forms(Mutex<Vec<(Arc<str>, Place)>>);

/// The place for the content of a form, which its first reader fills.
pub type Place = Arc<OnceCell<Content>>;

impl Forms {
    /// The place for this form.
    pub fn of(&self, form: &Arc<str>) -> Place {
        let mut forms = self.0.lock();
        if let Some((_, known)) = forms.iter().find(|(name, _)| name == form) {
            return Arc::clone(known);
        }
        let place = Place::default();
        forms.push((Arc::clone(form), Arc::clone(&place)));
        place
    }
}
