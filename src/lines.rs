//! The lines of a body, as they arrive.

use axum::body::Body;
use http_body_util::BodyExt;

/// A body of lines.
pub(crate) struct Lines {
    body: Body,
    /// The bytes received of the next lines, and the number of them known to hold no line end.
    bytes: Vec<u8>,
    searched: usize,
}

impl Lines {
    /// The lines of this body.
    pub(crate) fn new(body: Body) -> Self {
        Self {
            body,
            bytes: Vec::new(),
            searched: 0,
        }
    }

    /// The next line; `None` after the last one. Text without a line end is not a line.
    pub(crate) async fn next(&mut self) -> Result<Option<Vec<u8>>, String> {
        loop {
            if let Some(line) = self.take() {
                return Ok(Some(line));
            }
            match self.body.frame().await {
                None => return Ok(None),
                Some(Err(reason)) => return Err(reason.to_string()),
                Some(Ok(frame)) => {
                    if let Ok(data) = frame.into_data() {
                        self.bytes.extend_from_slice(&data);
                    }
                }
            }
        }
    }

    fn take(&mut self) -> Option<Vec<u8>> {
        let rest = self.bytes.get(self.searched..).unwrap_or_default();
        let Some(length) = rest.iter().position(|byte| *byte == b'\n') else {
            self.searched = self.bytes.len();
            return None;
        };
        let line = self.bytes.drain(..=self.searched + length).collect();
        self.searched = 0;
        Some(line)
    }
}
