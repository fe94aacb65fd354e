//! Fields of a job that are given one by one, by their paths: `curve.degree` is `{"curve": {"degree": …}}`.

use serde_json::{Map, Value};

/// The most names in a path.
const DEEPEST: usize = 6;

/// Sets a value at its path: parsed if it is JSON, else as a text.
pub(crate) fn insert(
    fields: &mut Map<String, Value>,
    path: &str,
    text: &str,
) -> Result<(), String> {
    // A name of digits is a name.
    let json = serde_json::from_str(text).ok().filter(|_| path != "name");
    insert_value(fields, path, json.unwrap_or_else(|| Value::from(text)))
}

/// Sets a value at its path.
pub(crate) fn insert_value(
    fields: &mut Map<String, Value>,
    path: &str,
    value: Value,
) -> Result<(), String> {
    let mut names: Vec<&str> = path.split('.').collect();
    let last = names.pop().unwrap_or("");
    if last.is_empty() || names.contains(&"") || names.len() >= DEEPEST {
        return Err("not the path of a field; expected one such as curve.degree".to_owned());
    }
    if last == "points" && names.len() == 1 {
        return Err("the points are those of the body".to_owned());
    }
    let mut object = fields;
    for name in names {
        let inner = object.entry(name).or_insert_with(|| Map::new().into());
        object = inner
            .as_object_mut()
            .ok_or("what it is a field of is given as a value")?;
    }
    match object.insert(last.to_owned(), value) {
        None => Ok(()),
        Some(_) => Err("it is given twice".to_owned()),
    }
}
