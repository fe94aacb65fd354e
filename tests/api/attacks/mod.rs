//! Clients that want more than their share: what they get, and that the server and its other clients
//! do not notice. Servers are processes of their own, whose memory is looked at from outside.

mod memory;
mod time;

use serde_json::{Value, json};
use tokio::sync::{Mutex, MutexGuard};

use crate::program::Program;

/// One attack after the other: each of them is meant to take all of the machine that it can get.
static ALONE: Mutex<()> = Mutex::const_new(());

async fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().await
}

/// A mebibyte.
const MIB: usize = 1 << 20;

/// `count` points of a spiral.
fn spiral(count: usize) -> Value {
    let point = |i: usize| {
        let t = i as f64 / 40.0;
        json!([t * t.cos(), t * t.sin()])
    };
    (0..count).map(point).collect()
}

/// Posts a job or an edit, and does not wait for its end.
async fn post(program: &Program, path: &str, body: &Value) -> Value {
    let answer = program.post(path).json(body).send().await.unwrap();
    assert_eq!(answer.status(), 201, "{:?}", answer.text().await);
    answer.json().await.unwrap()
}

/// The number of computed iterations of all clients.
async fn iterations(program: &Program) -> f64 {
    program.metrics().await["piad_iterations_total"]
}
