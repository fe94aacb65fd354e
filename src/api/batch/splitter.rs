//! Cuts the body of a batch into pieces.

use bytes::BytesMut;

use super::document::Document;
use super::lines::Lines;
use super::messages::Messages;
use super::pieces::{BodyForm, Piece};
use crate::api::problem::{Kind, Problem};

/// Cuts a body into pieces while it arrives.
pub(super) struct Splitter {
    /// The bytes that belong to no piece yet.
    bytes: BytesMut,
    /// The most bytes of a piece.
    limit: usize,
    rule: Rule,
}

enum Rule {
    Document(Document),
    Lines(Lines),
    Messages(Messages),
}

impl Splitter {
    /// Nothing has arrived yet.
    pub(super) fn new(form: BodyForm, limit: usize) -> Self {
        Self {
            bytes: BytesMut::new(),
            limit,
            rule: match form {
                BodyForm::Document => Rule::Document(Document::default()),
                BodyForm::Lines => Rule::Lines(Lines::default()),
                BodyForm::Messages => Rule::Messages(Messages::default()),
            },
        }
    }

    /// The number of bytes that have arrived and belong to no piece yet.
    pub(super) fn waiting(&self) -> usize {
        self.bytes.len()
    }

    /// Adds bytes that have arrived.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// The next piece, if all of it has arrived.
    pub(super) fn next(&mut self) -> Result<Option<Piece>, Problem> {
        let piece = match &mut self.rule {
            Rule::Document(document) => document.next(&mut self.bytes)?,
            Rule::Lines(lines) => lines.next(&mut self.bytes),
            Rule::Messages(messages) => return messages.next(&mut self.bytes, self.limit),
        };
        let length = match &piece {
            None => self.bytes.len(),
            Some(Piece::Defaults(bytes) | Piece::Item(bytes)) => bytes.len(),
        };
        if length > self.limit {
            let detail = format!(
                "an item is larger than {} bytes, the limit of this server",
                self.limit
            );
            return Err(Problem::new(Kind::BodyTooLarge, detail));
        }
        Ok(piece)
    }

    /// The last piece of a body that has ended, if there is one left; a truncated body is an error.
    pub(super) fn finish(&mut self) -> Result<Option<Piece>, Problem> {
        match &mut self.rule {
            Rule::Document(document) => document.finish(&self.bytes).map(|()| None),
            Rule::Lines(lines) => Ok(lines.finish(&mut self.bytes)),
            Rule::Messages(_) => Messages::finish(&self.bytes).map(|()| None),
        }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use proptest::prelude::*;

    use super::*;

    /// The most bytes of a piece.
    const LIMIT: usize = 1000;

    /// The pieces of a body that arrives in parts of this size.
    fn pieces(form: BodyForm, body: &[u8], part: usize) -> Result<Vec<Piece>, String> {
        let mut splitter = Splitter::new(form, LIMIT);
        let mut pieces = Vec::new();
        let detail_of = |problem: Problem| problem.detail().to_owned();
        for part in body.chunks(part) {
            splitter.push(part);
            while let Some(piece) = splitter.next().map_err(detail_of)? {
                pieces.push(piece);
            }
        }
        pieces.extend(splitter.finish().map_err(detail_of)?);
        Ok(pieces)
    }

    fn item(text: &'static str) -> Piece {
        Piece::Item(Bytes::from_static(text.as_bytes()))
    }

    fn defaults(text: &'static str) -> Piece {
        Piece::Defaults(Bytes::from_static(text.as_bytes()))
    }

    #[test]
    fn bodies_are_cut_wherever_they_are_interrupted() {
        for (form, body, expected) in [
            (
                BodyForm::Document,
                "\u{feff} {\"defaults\": {\"a\": \"}]\\\"\"} , \"items\" : [ {\"b\": [1, {}]},\n7 , \"x,y\" , [], null ] } \n",
                vec![
                    defaults(r#"{"a": "}]\""}"#),
                    item(r#"{"b": [1, {}]}"#),
                    item("7"),
                    item(r#""x,y""#),
                    item("[]"),
                    item("null"),
                ],
            ),
            (BodyForm::Document, r#"{"items":[]}"#, vec![]),
            (BodyForm::Document, r#"{"items":[{}]}"#, vec![item("{}")]),
            (
                BodyForm::Lines,
                "\u{feff}{\"defaults\": {\"a\": 1}}\r\n\n  {\"b\": 2}\n{\"defaults\": 3}",
                vec![
                    defaults(r#"{"a": 1}"#),
                    item(r#"{"b": 2}"#),
                    item(r#"{"defaults": 3}"#),
                ],
            ),
            (BodyForm::Lines, "\n\r\n  ", vec![]),
            (BodyForm::Lines, "nonsense\n", vec![item("nonsense")]),
        ] {
            for part in 1..=body.len() {
                let found = pieces(form, body.as_bytes(), part);
                assert_eq!(found.as_ref(), Ok(&expected), "{body} by {part}");
            }
        }
    }

    #[test]
    fn invalid_batches_are_rejected_at_the_error() {
        for (body, reason) in [
            ("", "the body is empty"),
            ("[{}]", "expected an object with items"),
            ("{", "the body ends within the object"),
            ("{}", "the field \"items\" is missing"),
            (r#"{"items": {}}"#, "/items: expected a list"),
            (r#"{"items": [{}"#, "the body ends within the list of items"),
            (r#"{"items": [{} {}]}"#, "/items/1: expected , or ]"),
            (r#"{"items": [{},]}"#, "/items/1: expected an item"),
            (r#"{"items": [,]}"#, "/items/0: expected an item"),
            (r#"{"items": []"#, "the body ends within the object"),
            (r#"{"items": []]"#, "expected , or }"),
            (r#"{"items": []} {}"#, "something follows the end"),
            (
                r#"{"items": [], "items": []}"#,
                "/items: this field is given twice",
            ),
            (
                r#"{"items": [], "defaults": {}}"#,
                "/defaults: it must come before the items",
            ),
            (
                r#"{"curve": {}}"#,
                "/curve: unknown field \"curve\"; expected one of defaults, items",
            ),
            (r#"{"items" []}"#, "expected :"),
            (r#"{"items": [}"#, "/items/0: expected an item"),
            ("{7: 1}", "expected the name of a field"),
        ] {
            for part in 1..=body.len().max(1) {
                let detail = pieces(BodyForm::Document, body.as_bytes(), part).unwrap_err();
                assert!(detail.contains(reason), "{body} by {part}: {detail}");
            }
        }
    }

    #[test]
    fn pieces_have_a_limit() {
        let long = format!(r#"{{"items": [{{"a": "{}"}}]}}"#, "x".repeat(LIMIT));
        for part in [10, 10_000] {
            let detail = pieces(BodyForm::Document, long.as_bytes(), part).unwrap_err();
            assert!(
                detail.contains("an item is larger than 1000 bytes"),
                "{detail}"
            );
        }
        let many = format!(r#"{{"items": [{}1]}}"#, "1, ".repeat(500));
        let found = pieces(BodyForm::Document, many.as_bytes(), 10).unwrap();
        assert_eq!(found.len(), 501);
    }

    proptest! {
        /// Any items come out unchanged.
        #[test]
        fn items_stay_as_they_are(
            texts in prop::collection::vec("\\PC{0,12}", 0..5),
            part in 1..40_usize,
        ) {
            let items: Vec<_> = texts.iter().map(|text| serde_json::json!({"n": text, text: [[1], {}]})).collect();
            let body = serde_json::json!({"items": items});
            let expected: Vec<_> = items.iter().map(|item| Piece::Item(item.to_string().into())).collect();
            let document = serde_json::to_string_pretty(&body).unwrap();
            let found = pieces(BodyForm::Document, document.as_bytes(), part).unwrap();
            let plain = |piece: &Piece| match piece {
                Piece::Item(bytes) | Piece::Defaults(bytes) => {
                    let value: serde_json::Value = serde_json::from_slice(bytes).unwrap();
                    Piece::Item(value.to_string().into())
                }
            };
            let found: Vec<_> = found.iter().map(plain).collect();
            prop_assert_eq!(&found, &expected);
            let lines: String = items.iter().map(|item| format!("{item}\n")).collect();
            prop_assert_eq!(pieces(BodyForm::Lines, lines.as_bytes(), part).unwrap(), expected);
        }
    }
}
