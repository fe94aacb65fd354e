//! Routes with their descriptions: what is served is described, and what is described is served.

use std::collections::HashMap;

use axum::Router;
use axum::handler::Handler;
use axum::routing::{MethodRouter, delete, get, post};
use serde_json::{Map, Value, json};

use super::operation::Operation;
use crate::api::app::App;

/// The resources of the API.
#[derive(Default)]
pub struct DescribedRoutes {
    router: Router<App>,
    paths: Map<String, Value>,
}

impl DescribedRoutes {
    /// Serves GET.
    pub fn get<H, T>(self, path: &str, handler: H, operation: Operation) -> Self
    where
        H: Handler<T, App>,
        T: 'static,
    {
        self.add(path, "get", get(handler), operation)
    }

    /// Serves POST.
    pub fn post<H, T>(self, path: &str, handler: H, operation: Operation) -> Self
    where
        H: Handler<T, App>,
        T: 'static,
    {
        self.add(path, "post", post(handler), operation)
    }

    /// Serves DELETE.
    pub fn delete<H, T>(self, path: &str, handler: H, operation: Operation) -> Self
    where
        H: Handler<T, App>,
        T: 'static,
    {
        self.add(path, "delete", delete(handler), operation)
    }

    fn add(
        mut self,
        path: &str,
        verb: &str,
        handler: MethodRouter<App>,
        operation: Operation,
    ) -> Self {
        self.router = self.router.route(path, handler);
        let resource = self.paths.entry(path).or_insert_with(|| json!({}));
        resource[verb] = operation.object();
        self
    }

    /// The methods of each path, as text for error messages.
    pub fn methods(&self) -> HashMap<String, String> {
        let of = |resource: &Value| {
            let verbs = resource.as_object().into_iter().flat_map(Map::keys);
            let names = verbs.map(|verb| match verb.as_str() {
                "get" => "GET, HEAD".to_owned(),
                verb => verb.to_uppercase(),
            });
            names.collect::<Vec<_>>().join(", ")
        };
        let paths = self.paths.iter();
        paths.map(|(path, it)| (path.clone(), of(it))).collect()
    }

    /// The routes, and the paths of the document.
    pub fn parts(self) -> (Router<App>, Map<String, Value>) {
        (self.router, self.paths)
    }
}
