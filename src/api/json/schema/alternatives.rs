//! Objects whose fields depend on one of them: `omega` is a setting of the method `weighted` alone.
//!
//! Their readers know all fields, so that an error can say to which kind a field belongs. Their
//! schemas are derived from the readers and then split: one alternative for each kind.

use schemars::Schema;
use serde_json::{Map, Value, json};

/// One of the ways to write an object.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alternative {
    /// What it is called.
    pub title: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Fields that tell this alternative from others, with their only value.
    pub is: &'static [(&'static str, Constant)],
    /// Fields that must be there.
    pub needs: &'static [&'static str],
    /// Other fields that not all alternatives have.
    pub takes: &'static [&'static str],
}

/// The only value of a field.
#[derive(Clone, Copy, Debug)]
pub enum Constant {
    /// A name.
    Name(&'static str),
    /// True or false.
    Bool(bool),
}

impl Constant {
    fn schema(self, description: &Value) -> Value {
        match self {
            Self::Name(name) => {
                json!({"description": description, "type": "string", "const": name})
            }
            Self::Bool(value) => {
                json!({"description": description, "type": "boolean", "const": value})
            }
        }
    }
}

/// Splits the schema of an object into alternatives; `shared` are the fields that all of them have.
pub fn split(schema: &mut Schema, shared: &[&str], alternatives: &[Alternative]) {
    let Some(Value::Object(fields)) = schema.remove("properties") else {
        return;
    };
    for keyword in ["type", "required", "additionalProperties"] {
        schema.remove(keyword);
    }
    let objects = alternatives.iter().map(|it| it.object(&fields, shared));
    schema.insert("oneOf".to_owned(), objects.collect());
}

/// Allows the name of a kind alone where no more than that is to be said.
pub fn or_name(schema: &mut Schema, names: Vec<&str>) {
    let name = json!({
        "title": "Name",
        "description": "Short for an object with this kind and nothing else.",
        "type": "string",
        "enum": names,
    });
    if let Some(Value::Array(alternatives)) = schema.get_mut("oneOf") {
        alternatives.push(name);
    }
}

impl Alternative {
    /// The kind that it is.
    pub fn kind(&self) -> Option<&'static str> {
        self.is.iter().find_map(|(field, value)| match value {
            Constant::Name(name) if *field == "kind" => Some(*name),
            _ => None,
        })
    }

    /// The schema of this alternative, from the schemas of all fields.
    fn object(&self, fields: &Map<String, Value>, shared: &[&str]) -> Value {
        let mut properties = Map::new();
        for (name, schema) in fields {
            let name = name.as_str();
            let constant = self.is.iter().find(|(field, _)| *field == name);
            let schema = match constant {
                Some((_, constant)) => constant.schema(&schema["description"]),
                None if self.needs.contains(&name) => given(schema),
                None if self.takes.contains(&name) || shared.contains(&name) => schema.clone(),
                None => continue,
            };
            properties.insert(name.to_owned(), schema);
        }
        let fixed = self.is.iter().map(|(name, _)| name);
        let required: Vec<&str> = fixed.chain(self.needs).copied().collect();
        json!({
            "title": self.title,
            "description": self.description,
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }
}

/// A field that must be there cannot be null.
fn given(schema: &Value) -> Value {
    let mut schema = schema.clone();
    if let Some(types) = schema["type"].as_array() {
        schema["type"] = types
            .iter()
            .find(|it| *it != "null")
            .cloned()
            .unwrap_or_default();
    }
    if let Some(choices) = schema.get_mut("anyOf").and_then(Value::as_array_mut) {
        choices.retain(|choice| choice["type"] != "null");
    }
    schema
}
