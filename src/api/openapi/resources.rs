//! The resources of the API, each of which is described in `api.json`.

use axum::Router;
use axum::handler::Handler;
use axum::routing::{MethodRouter, delete, get, post};

use crate::api::app::App;
use crate::api::needs::{Methods, Needs};

/// The resources of the API.
#[derive(Default)]
pub(crate) struct Resources {
    router: Router<App>,
    /// The methods of each path, and their authorization.
    methods: Methods,
}

impl Resources {
    /// Serves GET.
    pub(crate) fn get<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        needs: Needs,
        handler: H,
    ) -> Self {
        self.add(path, "get", needs, get(handler))
    }

    /// Serves POST.
    pub(crate) fn post<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        needs: Needs,
        handler: H,
    ) -> Self {
        self.add(path, "post", needs, post(handler))
    }

    /// Serves DELETE.
    pub(crate) fn delete<H: Handler<T, App>, T: 'static>(
        self,
        path: &'static str,
        needs: Needs,
        handler: H,
    ) -> Self {
        self.add(path, "delete", needs, delete(handler))
    }

    fn add(
        mut self,
        path: &'static str,
        verb: &'static str,
        needs: Needs,
        handler: MethodRouter<App>,
    ) -> Self {
        self.router = self.router.route(path, handler);
        self.methods.entry(path).or_default().push((verb, needs));
        self
    }

    /// The routes, and the methods of each path.
    pub(crate) fn parts(self) -> (Router<App>, Methods) {
        (self.router, self.methods)
    }
}
