//! Long values are stored in pieces, each in a row of its own, which bounds the size of a single message.

use sqlx::PgConnection;
use uuid::Uuid;

/// The bytes of a piece; the last one is shorter.
pub(super) const PIECE: usize = 4 << 20;

/// The table of a value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Table {
    Inputs,
    Results,
}

/// A value to be written: its first piece with the row of its job, the others behind it.
pub(super) struct Value<'a> {
    pub(super) table: Table,
    pub(super) id: Uuid,
    pub(super) bytes: &'a [u8],
}

impl Value<'_> {
    pub(super) fn first(&self) -> &[u8] {
        &self.bytes[..self.bytes.len().min(PIECE)]
    }

    /// Returns true if there is more than the first piece. A value that ends with a full piece has an empty one behind
    /// it.
    pub(super) fn is_long(&self) -> bool {
        self.bytes.len() >= PIECE
    }

    /// The pieces behind the first one, with their numbers.
    fn rest(&self) -> impl Iterator<Item = (i32, &[u8])> {
        let count = self.bytes.len() / PIECE;
        (1..=count).map(|piece| {
            let begin = piece * PIECE;
            let end = self.bytes.len().min(begin + PIECE);
            (piece as i32, &self.bytes[begin..end])
        })
    }

    /// Writes the pieces behind the first one.
    pub(super) async fn write_rest(
        &self,
        connection: &mut PgConnection,
    ) -> Result<(), sqlx::Error> {
        let insertion = match self.table {
            Table::Inputs => "INSERT INTO inputs VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
            Table::Results => "INSERT INTO results VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
        };
        for (piece, bytes) in self.rest() {
            let insertion = sqlx::query(insertion).bind(self.id).bind(piece).bind(bytes);
            insertion.execute(&mut *connection).await?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_piece_is_shorter() {
        for (length, count) in [
            (0, 1),
            (7, 1),
            (PIECE - 1, 1),
            (PIECE, 2),
            (2 * PIECE + 1, 3),
        ] {
            let bytes: Vec<u8> = (0..length).map(|i| i as u8).collect();
            let (table, id) = (Table::Inputs, Uuid::nil());
            let value = Value {
                table,
                id,
                bytes: &bytes,
            };
            let rest: Vec<(i32, &[u8])> = value.rest().collect();
            assert_eq!(rest.len() + 1, count, "{length}");
            assert_eq!(value.is_long(), count > 1);
            assert!(rest.iter().map(|it| it.0).eq(1..count as i32));
            assert!(rest.last().map_or(value.first(), |it| it.1).len() < PIECE);
            let whole = rest
                .iter()
                .fold(value.first().to_vec(), |all, it| [&all, it.1].concat());
            assert_eq!(whole, bytes);
        }
    }
}
