//! The description of the API, as tests use it.

use serde_json::{Map, Value};

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

    /// An object, or what it refers to.
    pub fn resolved<'a>(&'a self, object: &'a Value) -> &'a Value {
        let Some(reference) = object["$ref"].as_str() else {
            return object;
        };
        let pointer = reference.strip_prefix('#').unwrap();
        self.0.pointer(pointer).expect(reference)
    }

    pub fn component(&self, section: &str, name: &str) -> &Value {
        let component = &self.0["components"][section][name];
        assert!(!component.is_null(), "there is no {name}");
        component
    }
}
