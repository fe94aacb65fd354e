//! A pull parser of XML, with lines. It keeps only the names of the enclosing elements, and does not expand entities of
//! the file, so neither nesting nor entities can take more memory than the file.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::error::FileError;

/// The next node of a file.
pub(super) enum Node<'a> {
    /// An element begins.
    Start(Element<'a>),
    /// The last element that began ends.
    End,
    /// Text, or a piece of it.
    Text(Cow<'a, str>),
}

/// An element, with its attributes.
pub(super) struct Element<'a> {
    start: BytesStart<'a>,
    /// The line that it begins in, from 1.
    pub(super) line: u32,
    /// The byte that it begins at.
    at: usize,
}

/// Where an element begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    at: usize,
    line: u32,
}

/// The nodes of a text.
pub(super) struct Nodes<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    /// Where they begin in the file.
    start: usize,
    /// The number of enclosing elements.
    depth: usize,
    /// The number of bytes whose lines were counted.
    counted: usize,
    line: u32,
}

impl<'a> Nodes<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self::from_place(text, Place { at: 0, line: 1 })
    }

    /// The nodes from an element on.
    pub(super) fn from_place(text: &'a str, place: Place) -> Self {
        let text = text.get(place.at..).unwrap_or_default();
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Self {
            text,
            reader,
            start: place.at,
            depth: 0,
            counted: 0,
            line: place.line,
        }
    }

    /// The number of bytes read.
    pub(super) fn position(&self) -> u64 {
        self.reader.buffer_position()
    }

    /// The next node; none at the end.
    ///
    /// # Errors
    ///
    /// If the text is not XML, or ends within an element.
    pub(super) fn next(&mut self) -> Result<Option<Node<'a>>, FileError> {
        loop {
            let place = self.reader.buffer_position();
            let event = self.reader.read_event();
            let event = event.map_err(|error| {
                let line = self.line_of(self.reader.error_position());
                FileError::at(line as usize, format!("this is no XML: {error}"))
            })?;
            return Ok(Some(match event {
                Event::Start(start) => {
                    self.depth += 1;
                    let line = self.line_of(place);
                    let at = self.start + usize::try_from(place).unwrap_or(usize::MAX);
                    Node::Start(Element { start, line, at })
                }
                Event::End(_) => {
                    self.depth = self.depth.saturating_sub(1);
                    Node::End
                }
                Event::Text(text) => Node::Text(text.into_inner()),
                Event::CData(text) => Node::Text(text.into_inner()),
                Event::GeneralRef(entity) => match entity.resolve_char_ref() {
                    Ok(Some(character)) => Node::Text(Cow::Owned(character.to_string())),
                    _ => Node::Text(Cow::Borrowed(
                        resolve_predefined_entity(&entity).unwrap_or(""),
                    )),
                },
                Event::Eof if self.depth > 0 => return Err(self.cut_off()),
                Event::Eof => return Ok(None),
                _ => continue,
            }));
        }
    }

    fn cut_off(&mut self) -> FileError {
        let line = self.line_of(self.text.len() as u64);
        FileError::at(
            line as usize,
            "the file ends within an element of XML: it is cut off",
        )
    }

    /// The line of a place in the text. Places come one after the other, but for those of errors.
    fn line_of(&mut self, place: u64) -> u32 {
        let place = usize::try_from(place).unwrap_or(usize::MAX);
        let passed = self.text.as_bytes().get(self.counted..place);
        let count = passed.map_or(0, |passed| memchr::memchr_iter(b'\n', passed).count());
        self.counted = self.counted.max(place.min(self.text.len()));
        self.line = self
            .line
            .saturating_add(u32::try_from(count).unwrap_or(u32::MAX));
        self.line
    }
}

impl Element<'_> {
    /// Where it begins.
    pub(super) fn place(&self) -> Place {
        Place {
            at: self.at,
            line: self.line,
        }
    }

    /// The name without its prefix.
    pub(super) fn name(&self) -> &str {
        let name = self.full_name();
        name.split_once(':').map_or(name, |(_, local)| local)
    }

    /// The prefix of the name, of a namespace.
    pub(super) fn prefix(&self) -> Option<&str> {
        self.full_name().split_once(':').map(|(prefix, _)| prefix)
    }

    fn full_name(&self) -> &str {
        self.start.name().0
    }

    /// The value of an attribute.
    ///
    /// # Errors
    ///
    /// If the attributes up to it are not XML.
    pub(super) fn attribute(&self, name: &str) -> Result<Option<String>, FileError> {
        let wrong = |error: &dyn std::fmt::Display| {
            FileError::at(self.line as usize, format!("this is no XML: {error}"))
        };
        // The check for repeated names takes time quadratic in the number of attributes.
        for attribute in self.start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| wrong(&error))?;
            if attribute.key.0 == name {
                let value = attribute.normalized_value(XmlVersion::Implicit1_0);
                let value = value.map_err(|error| wrong(&error))?;
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }
}

/// The name of the first element of a text without its prefix, if it is XML.
pub(super) fn root(text: &str) -> Option<String> {
    if !text.trim_start().starts_with('<') {
        return None;
    }
    let mut nodes = Nodes::new(text);
    loop {
        match nodes.next().ok()?? {
            Node::Start(element) => return Some(element.name().to_owned()),
            Node::Text(text) if text.trim().is_empty() => {}
            Node::End | Node::Text(_) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_found_behind_what_is_before_it() {
        for (text, expected) in [
            ("<gpx>", Some("gpx")),
            (
                " \n<?xml version='1.0'?>\n<!-- <a> -->\n<x:svg a='b'/>",
                Some("svg"),
            ),
            (
                "<!DOCTYPE svg PUBLIC 'a' 'b' [<!ENTITY a '<b>'> <!-- ]> -->]><svg/>",
                Some("svg"),
            ),
            ("1 2\n<gpx>", None),
            ("<", None),
            ("", None),
        ] {
            assert_eq!(root(text).as_deref(), expected, "{text}");
        }
    }

    #[test]
    fn elements_have_lines_and_attributes() {
        let text =
            "<a>\n<b:c x:d='no'\n d='1 &lt;&#10;2'/>A &amp; &#66;<![CDATA[<]]>&c;\n\n<d/></a>";
        let mut nodes = Nodes::new(text);
        let mut found = Vec::new();
        let mut words = String::new();
        while let Some(node) = nodes.next().unwrap() {
            match node {
                Node::Start(element) => {
                    let d = element.attribute("d").unwrap();
                    found.push((element.name().to_owned(), element.line, d));
                }
                Node::Text(text) => words += &text,
                Node::End => {}
            }
        }
        let plain = |name: &str, line| (name.to_owned(), line, None);
        let with = ("c".to_owned(), 2, Some("1 <\n2".to_owned()));
        assert_eq!(found, [plain("a", 1), with, plain("d", 5)]);
        assert_eq!(words.trim(), "A & B<");
    }

    #[test]
    fn syntax_errors_name_their_lines() {
        for (text, line) in [
            ("<a>\n<b>\n</a>", 3),
            ("<a>\n\n", 3),
            ("<a>\n<b", 2),
            ("<a>\n<!-- ", 2),
        ] {
            let mut nodes = Nodes::new(text);
            let error = loop {
                match nodes.next() {
                    Ok(Some(_)) => {}
                    Ok(None) => panic!("{text}"),
                    Err(error) => break error,
                }
            };
            assert_eq!(error.line, Some(line), "{error}");
        }
    }
}
