//! Which columns of a table are what, as somebody says it.

/// The columns of coordinates, and those of times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    entries: Vec<String>,
}

impl Columns {
    /// Columns by numbers from 1 or by names: `x=2,y=3,t=1`, or `t,q1:q7`.
    ///
    /// # Errors
    ///
    /// What is wrong with the text.
    pub fn of_text(text: &str) -> Result<Self, String> {
        Ok(Self {
            entries: text.split(',').map(str::to_owned).collect(),
        })
    }
}
