//! A batch as one JSON object: its defaults, then its items. Only the object and the list are parsed here; their values
//! are parsed later.

use bytes::{Buf, BytesMut};

use super::pieces::Piece;
use crate::api::problem::{Kind, Problem};
use piad_files::text::quoted;

/// The byte-order mark of UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The state of the parser.
#[derive(Default)]
pub(super) struct Document {
    next: Next,
    /// The value that is being read.
    value: Value,
    /// The number of items found.
    items: usize,
    has_defaults: bool,
    has_items: bool,
}

/// The next expected token.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Next {
    /// The object.
    #[default]
    Start,
    /// The name of a field, or the end of the object if there is no comma before.
    Name {
        may_end: bool,
    },
    Colon(Field),
    /// The value of `defaults`, which may have begun.
    Defaults,
    /// The list of items.
    List,
    /// An item that has not begun, or the end of the list if there is no comma before.
    Item {
        may_end: bool,
    },
    /// The rest of an item.
    RestOfItem,
    /// A comma or the end of the list.
    AfterItem,
    /// A comma or the end of the object.
    AfterField,
    /// Nothing more.
    End,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Field {
    Defaults,
    Items,
}

impl Document {
    /// The next piece, if all of it is there.
    pub(super) fn next(&mut self, bytes: &mut BytesMut) -> Result<Option<Piece>, Problem> {
        loop {
            if self.next == Next::Start && bytes.starts_with(MARK) {
                bytes.advance(MARK.len());
            }
            if self.value.read == 0 {
                let blanks = bytes.iter().take_while(|byte| is_blank(**byte)).count();
                bytes.advance(blanks);
            }
            let Some(&byte) = bytes.first() else {
                return Ok(None);
            };
            match self.next {
                Next::Start if bytes.len() < MARK.len() && MARK.starts_with(bytes) => {
                    return Ok(None);
                }
                Next::Name { may_end } if byte != b'}' || !may_end => {
                    let Some(field) = self.name(bytes)? else {
                        return Ok(None);
                    };
                    self.next = Next::Colon(field);
                }
                Next::Defaults | Next::RestOfItem => {
                    let Some(length) = self.value.end(bytes) else {
                        return Ok(None);
                    };
                    self.value = Value::default();
                    return Ok(Some(self.piece(bytes, length)));
                }
                Next::Item { may_end } if byte != b']' || !may_end => {
                    if matches!(byte, b',' | b':' | b']' | b'}') {
                        return Err(self.wrong_item("expected an item"));
                    }
                    self.next = Next::RestOfItem;
                }
                _ => {
                    self.mark(byte)?;
                    bytes.advance(1);
                }
            }
        }
    }

    /// The error for a body that has ended too soon; these bytes of it are left.
    pub(super) fn finish(&self, bytes: &[u8]) -> Result<(), Problem> {
        let detail = match self.next {
            Next::End => return Ok(()),
            Next::Start if bytes.is_empty() => "the body is empty; a batch is expected",
            Next::Item { .. } | Next::RestOfItem | Next::AfterItem => {
                "the body ends within the list of items"
            }
            _ => "the body ends within the object",
        };
        Err(Problem::new(Kind::NotJson, detail))
    }

    /// The piece of this length, with which a value ends.
    fn piece(&mut self, bytes: &mut BytesMut, length: usize) -> Piece {
        let value = bytes.split_to(length).freeze();
        if self.next == Next::Defaults {
            self.next = Next::AfterField;
            return Piece::Defaults(value);
        }
        self.next = Next::AfterItem;
        self.items += 1;
        Piece::Item(value)
    }

    /// Reads a single character.
    fn mark(&mut self, byte: u8) -> Result<(), Problem> {
        let not_json = |detail: &str| Err(Problem::new(Kind::NotJson, detail));
        self.next = match (self.next, byte) {
            (Next::Start, b'{') => Next::Name { may_end: true },
            (Next::Start, _) => {
                let detail = "expected an object with items";
                return Err(Problem::new(Kind::InvalidFit, detail));
            }
            (Next::Colon(Field::Defaults), b':') => Next::Defaults,
            (Next::Colon(Field::Items), b':') => Next::List,
            (Next::Colon(_), _) => return not_json("expected : behind the name of a field"),
            (Next::List, b'[') => Next::Item { may_end: true },
            (Next::List, _) => return Err(at("/items", "expected a list")),
            (Next::AfterItem, b',') => Next::Item { may_end: false },
            (Next::Item { .. } | Next::AfterItem, b']') => Next::AfterField,
            (Next::AfterItem, _) => return Err(self.wrong_item("expected , or ]")),
            (Next::AfterField, b',') => Next::Name { may_end: false },
            (Next::Name { .. } | Next::AfterField, b'}') if !self.has_items => {
                return Err(at("", "the field \"items\" is missing"));
            }
            (Next::Name { .. } | Next::AfterField, b'}') => Next::End,
            (Next::End, _) => return not_json("something follows the end of the batch"),
            _ => return not_json("expected , or }"),
        };
        Ok(())
    }

    /// Reads the name of a field, if all of it is there.
    fn name(&mut self, bytes: &mut BytesMut) -> Result<Option<Field>, Problem> {
        let wrong = || Problem::new(Kind::NotJson, "expected the name of a field");
        if bytes.first() != Some(&b'"') {
            return Err(wrong());
        }
        let Some(length) = self.value.end(bytes) else {
            return Ok(None);
        };
        self.value = Value::default();
        let text = bytes.split_to(length);
        let name: String = serde_json::from_slice(&text).map_err(|_| wrong())?;
        let (field, given) = match name.as_str() {
            "defaults" if self.has_items => {
                let detail = "it must come before the items, which are read as they arrive";
                return Err(at("/defaults", detail));
            }
            "defaults" => (Field::Defaults, &mut self.has_defaults),
            "items" => (Field::Items, &mut self.has_items),
            other => {
                let detail = format!(
                    "unknown field {}; expected one of defaults, items",
                    quoted(other)
                );
                return Err(at(&format!("/{other}"), &detail));
            }
        };
        match std::mem::replace(given, true) {
            false => Ok(Some(field)),
            true => Err(at(&format!("/{name}"), "this field is given twice")),
        }
    }

    fn wrong_item(&self, detail: &str) -> Problem {
        let pointer = format!("/items/{}", self.items);
        Problem::at_pointer(Kind::NotJson, pointer, detail)
    }
}

fn at(pointer: &str, detail: &str) -> Problem {
    Problem::at_pointer(Kind::InvalidFit, pointer.to_owned(), detail)
}

/// The state of a search for the end of a value.
#[derive(Default)]
struct Value {
    /// The number of its bytes that were read.
    read: usize,
    /// The number of open lists and objects.
    depth: usize,
    in_string: bool,
    /// True if the next character of a string is escaped.
    is_escaped: bool,
}

impl Value {
    /// The length of the value with which these bytes begin, if all of it is there.
    fn end(&mut self, bytes: &[u8]) -> Option<usize> {
        while let Some(&byte) = bytes.get(self.read) {
            if self.in_string {
                self.read_string(bytes);
                if self.in_string {
                    return None;
                }
                if self.depth == 0 {
                    return Some(self.read);
                }
                continue;
            }
            match byte {
                b'"' => self.in_string = true,
                b'{' | b'[' => self.depth += 1,
                b'}' | b']' if self.depth == 1 => return Some(self.read + 1),
                b'}' | b']' if self.depth > 1 => self.depth -= 1,
                // Numbers and literals end before the character that follows.
                b'}' | b']' | b',' if self.depth == 0 => return Some(self.read),
                blank if is_blank(blank) && self.depth == 0 => return Some(self.read),
                _ => {}
            }
            self.read += 1;
        }
        None
    }

    /// Reads the rest of a string, as far as it is there.
    fn read_string(&mut self, bytes: &[u8]) {
        while let Some(&byte) = bytes.get(self.read) {
            self.read += 1;
            match byte {
                _ if self.is_escaped => self.is_escaped = false,
                b'\\' => self.is_escaped = true,
                b'"' => {
                    self.in_string = false;
                    return;
                }
                _ => {}
            }
        }
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r')
}
