//! The authorization of each call.

use crate::access::scope::Scope::{JobsRead, JobsWrite};
use crate::api::needs::Needs;

/// The path before the name of a call.
const SERVICE: &str = "/piad.v1.FittingService/";

/// The scopes that a call needs, by its path. Health and reflection reveal no secrets.
pub(in crate::api) fn needs(path: &str) -> Needs {
    let Some(call) = path.strip_prefix(SERVICE) else {
        return Needs::Nothing;
    };
    Needs::A(match call {
        "GetJob" | "ListJobs" | "GetIteration" | "GetResult" | "GetDeviation" | "GetInput"
        | "CompareBases" | "WatchJob" => JobsRead,
        _ => JobsWrite,
    })
}

#[cfg(test)]
mod tests {
    use prost::Message;
    use prost_types::FileDescriptorSet;

    use super::*;
    use crate::proto::DESCRIPTORS;

    /// A new call must be classified here.
    #[test]
    fn every_call_has_its_scope() {
        let described = FileDescriptorSet::decode(DESCRIPTORS).unwrap();
        let services = described.file.iter().flat_map(|file| &file.service);
        let [service] = services.collect::<Vec<_>>().try_into().unwrap();
        assert_eq!(SERVICE, format!("/piad.v1.{}/", service.name()));
        let calls = service.method.iter().map(|call| call.name());
        let (reading, writing): (Vec<_>, Vec<_>) =
            calls.partition(|call| needs(&format!("{SERVICE}{call}")) == Needs::A(JobsRead));
        assert_eq!(
            writing,
            [
                "CreateJob",
                "Fit",
                "FitBatch",
                "CancelJob",
                "DeleteJob",
                "EditJob"
            ]
        );
        assert_eq!(reading.len(), 8);
    }
}
