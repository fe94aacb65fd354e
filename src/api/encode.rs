//! Making the JSON of frames and descriptions: once for all readers, and off the network threads.

use std::sync::Arc;

use bytes::Bytes;

use super::options::View;
use super::view;
use crate::fit::points::Grid;
use crate::job::Job;
use crate::job::frame::Frame;
use crate::job::scheduler::Lane;
use crate::job::store::StoreError;

/// So many numbers are written where they are needed, more of them on the compute pool.
const SMALL: usize = 2000;

/// Writing a number takes about as long as so many multiplications.
const OPERATIONS_PER_NUMBER: usize = 50;

/// The JSON of the `job` event, made once for each job.
pub async fn description(job: &Arc<Job>) -> Result<Bytes, StoreError> {
    job.description(|| async {
        let problem = job.problem().await?;
        let numbers = problem.grid().count();
        let described = Arc::clone(job);
        let levels = job.status().levels;
        let describe = move || view::description(&described, &problem, levels);
        Ok(off_network(job, numbers, describe).await)
    })
    .await
}

/// The JSON of an iteration, made once for each frame and view.
pub async fn frame(job: &Arc<Job>, frame: &Arc<Frame>, what: View) -> Result<Bytes, StoreError> {
    let key = match what {
        View::ControlPoints => String::new(),
        View::Errors => "errors".to_owned(),
        View::Samples(Grid { rows, columns }) => format!("{rows}x{columns}"),
    };
    let encoded = frame.encoded(&key.into());
    let problem = job.problem().await?;
    let encode = || {
        job.resources().counters.encodings.inc();
        let numbers = match what {
            View::Errors => 0,
            View::ControlPoints => frame.control_points.len() * frame.control_points.dimension(),
            View::Samples(grid) => {
                let functions =
                    |direction: &crate::fit::direction::Direction| direction.basis.support_width();
                let each: usize = problem.directions().map(functions).product();
                grid.count().saturating_mul(each)
            }
        };
        let frame = Arc::clone(frame);
        off_network(job, numbers, move || match what {
            View::ControlPoints => view::iteration(&problem, &frame.level, &frame.control_points),
            View::Errors => view::errors(&problem, &frame.level),
            View::Samples(grid) => {
                view::samples(&problem, &frame.level, &frame.control_points, grid)
            }
        })
    };
    Ok(encoded.get_or_init(encode).await.clone())
}

/// Encodes on the compute pool, unless it is little.
pub async fn off_network(
    job: &Job,
    numbers: usize,
    encode: impl FnOnce() -> Bytes + Send + 'static,
) -> Bytes {
    if numbers <= SMALL {
        return encode();
    }
    let lane = Lane::of(numbers.saturating_mul(OPERATIONS_PER_NUMBER));
    let encoded = job.resources().scheduler.compute(lane, encode).await;
    encoded.unwrap_or_else(|_| Bytes::from_static(b"null"))
}
