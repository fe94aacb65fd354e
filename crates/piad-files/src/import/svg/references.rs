//! The elements of SVG that `use` draws again, by their ids.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::scan::{Scanner, Transform};
use crate::import::error::FileError;
use crate::import::xml::{Element, Node, Nodes, Place};
use crate::text::quoted;

/// The deepest nesting of references.
const MOST_NESTED: usize = 16;

/// The most bytes that are read again for all references: a few of them can draw very much.
const MOST_BYTES: u64 = 16 << 20;

/// The attributes of a reference.
pub(super) struct Referred {
    /// The width and the height; 0 if missing, `None` if unknown.
    pub(super) size: Option<[f64; 2]>,
}

/// The positions of the elements with an id, and the number of bytes read again.
pub(super) struct References<'a> {
    text: &'a str,
    /// Found when the first reference is read.
    places: Option<HashMap<String, Place>>,
    depth: usize,
    bytes: u64,
}

impl<'a> References<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            text,
            places: None,
            depth: 0,
            bytes: 0,
        }
    }

    /// The nodes from the element on that a `use` names; `None` if that is not in the file. Inside of it are others, up to
    /// [`Self::leave`].
    ///
    /// # Errors
    ///
    /// If references are nested too deep, as one to itself.
    pub(super) fn enter(&mut self, element: &Element<'_>) -> Result<Option<Nodes<'a>>, FileError> {
        let Some(id) = target(element)? else {
            return Ok(None);
        };
        if self.places.is_none() {
            self.places = Some(places(self.text)?);
        }
        let places = self.places.as_ref();
        let Some(place) = places.and_then(|places| places.get(&id)) else {
            return Ok(None);
        };
        if self.depth == MOST_NESTED {
            let detail = format!(
                "references to {} are nested more than {MOST_NESTED} deep here, or it has itself inside",
                quoted(&id)
            );
            return Err(FileError::at(element.line as usize, detail));
        }
        self.depth += 1;
        Ok(Some(Nodes::from_place(self.text, *place)))
    }

    /// Ends the reference that was entered last, for which this many bytes were read.
    ///
    /// # Errors
    ///
    /// If all references take too many.
    pub(super) fn leave(&mut self, element: &Element<'_>, bytes: u64) -> Result<(), FileError> {
        self.depth -= 1;
        self.bytes += bytes;
        if self.bytes <= MOST_BYTES {
            return Ok(());
        }
        let detail = format!(
            "what is drawn by references up to this one is more than {} MiB, the limit",
            MOST_BYTES >> 20
        );
        Err(FileError::at(element.line as usize, detail))
    }
}

/// The id that a `use` names.
fn target(element: &Element<'_>) -> Result<Option<String>, FileError> {
    let named = match element.attribute("href")? {
        None => element.attribute("xlink:href")?,
        named => named,
    };
    Ok(named.and_then(|named| Some(named.trim().strip_prefix('#')?.to_owned())))
}

/// Where each element with an id begins; the first one of those with the same id.
fn places(text: &str) -> Result<HashMap<String, Place>, FileError> {
    let mut places = HashMap::new();
    let mut nodes = Nodes::new(text);
    while let Some(node) = nodes.next()? {
        let Node::Start(element) = node else {
            continue;
        };
        if let Some(id) = element.attribute("id")?
            && let Entry::Vacant(entry) = places.entry(id)
        {
            entry.insert(element.place());
        }
    }
    Ok(places)
}

/// The transform that fits a symbol into a window of this size, centred; `None` if it is unknown.
pub(super) fn in_window(
    symbol: &Element<'_>,
    size: Option<[f64; 2]>,
) -> Result<Option<Transform>, FileError> {
    let Some(window) = symbol.attribute("viewBox")? else {
        return Ok(Some(Transform::IDENTITY));
    };
    let (Some([x, y, width, height]), Some(size)) = (Scanner::new(&window).numbers(), size) else {
        return Ok(None);
    };
    let scale = (size[0] / width).min(size[1] / height);
    let other = symbol.attribute("preserveAspectRatio")?.is_some();
    if other || !scale.is_finite() || scale <= 0.0 {
        return Ok(None);
    }
    let centre = [size[0] / 2.0, size[1] / 2.0];
    let [x, y] = [
        centre[0] - scale * (x + width / 2.0),
        centre[1] - scale * (y + height / 2.0),
    ];
    Ok(Some(Transform::scaled(scale, x, y)))
}
