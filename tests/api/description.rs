//! The description of the API, as tests use it.

use jsonschema::{Draft, Validator};
use serde_json::{Map, Value, json};

use crate::support::Server;

/// The description that a server gives of itself.
pub struct Description(pub Value);

impl Description {
    pub async fn of(server: &Server) -> Self {
        Self(server.json("/openapi.json").await)
    }

    /// The operations, with their paths and methods.
    pub fn operations(&self) -> Vec<(String, String, &Value)> {
        let paths = self.0["paths"].as_object().unwrap();
        let operations = paths.iter().flat_map(|(path, resource)| {
            let operations = resource.as_object().unwrap().iter();
            operations.map(move |(method, operation)| (path.clone(), method.clone(), operation))
        });
        operations.collect()
    }

    pub fn schemas(&self) -> &Map<String, Value> {
        self.0["components"]["schemas"].as_object().unwrap()
    }

    pub fn component(&self, section: &str, name: &str) -> &Value {
        let component = &self.0["components"][section][name];
        assert!(!component.is_null(), "there is no {name}");
        component
    }

    /// A validator for one of the schemas. Clients ignore fields that they do not know; here every
    /// field must be described.
    pub fn validator(&self, name: &str) -> Validator {
        self.component("schemas", name);
        let mut schema = json!({
            "$ref": format!("#/components/schemas/{name}"),
            "components": {"schemas": self.schemas()},
        });
        close(&mut schema);
        let options = jsonschema::options().with_draft(Draft::Draft202012);
        options
            .should_validate_formats(true)
            .build(&schema)
            .unwrap()
    }

    pub fn check(&self, name: &str, value: &Value) {
        let validator = self.validator(name);
        let errors = validator.iter_errors(value);
        let errors: Vec<_> = errors
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{name}: {errors:#?}\n{value:#}");
    }
}

/// Allows no fields besides those that are described.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            fields.values_mut().for_each(close);
            let open = fields
                .get("properties")
                .is_some_and(|it| !it["type"].is_string());
            if open && fields.get("type") == Some(&json!("object")) {
                fields.entry("additionalProperties").or_insert(json!(false));
            }
        }
        Value::Array(items) => items.iter_mut().for_each(close),
        _ => {}
    }
}
