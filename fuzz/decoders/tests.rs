//! The seeds of the fuzz targets, and what they are given besides.

use std::fs;
use std::path::Path;

use jiff::Timestamp;
use prost::Message;
use uuid::Uuid;

use super::*;
use crate::job::store::IdempotencyEntry;
use crate::proto::messages as pb;

/// Each seed of a target, which says itself what it is.
fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let files = fs::read_dir(Path::new("fuzz/seeds").join(target)).unwrap();
    files
        .map(|file| {
            let path = file.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, fs::read(path).unwrap())
        })
        .collect()
}

/// Calls a target with a generated seed, and stores it for the fuzzer on request.
fn sow(target: &str, name: &str, bytes: &[u8]) {
    match target {
        "message" => message(bytes),
        "edit_message" => edit_message(bytes),
        "made" => made(bytes),
        _ => record(bytes),
    }
    if std::env::var_os("PIAD_WRITE_SEEDS").is_some() {
        let corpus = Path::new("fuzz/corpus").join(target);
        fs::create_dir_all(&corpus).unwrap();
        fs::write(corpus.join(name), bytes).unwrap();
    }
}

#[test]
fn seeds_are_jobs_and_pass_through_every_decoder() {
    for (name, seed) in seeds("job") {
        job(&seed);
        let job = job_of_json(&seed).unwrap();
        let outline = outline(&job);
        sow(
            "message",
            &name,
            &proto::view::input(&outline, &job.problem),
        );
        let iteration = compute(&job.problem).unwrap();
        let entry = IdempotencyEntry {
            id: Uuid::from_u128(1),
            digest: [7; 32],
            created: Timestamp::UNIX_EPOCH,
        };
        let records = [
            store::kept_record(&record_of(outline, Some(&iteration))),
            kept_level(&iteration),
            store::kept_entry(&entry),
            store::kept(&job.problem),
        ];
        for (kind, bytes) in (0..).zip(records) {
            let bytes = [&[kind], bytes.as_slice()].concat();
            sow("record", &format!("{name}-{kind}"), &bytes);
        }
    }
}

#[test]
fn seeds_are_edits_of_a_parent() {
    assert_eq!(parents().len(), PARENTS.len());
    for (name, seed) in seeds("edit") {
        edit(&seed);
        let fits = |parent| edit_of_json(parent, &seed).is_ok();
        assert!(parents().iter().any(fits), "{name}");
    }
    for (name, edit) in messages() {
        let bytes = edit.encode_to_vec();
        sow("edit_message", name, &bytes);
        let fits = |parent| edit_of_message(parent, &bytes).is_ok();
        assert!(parents().iter().any(fits), "{name}");
    }
}

/// Bytes by chance make jobs of which a good part can be computed, and so can edits of them.
#[test]
fn many_generated_requests_are_accepted() {
    let (mut jobs, mut edits) = (0, 0);
    for seed in 0..300_u64 {
        let bytes = by_chance(seed);
        sow("made", &seed.to_string(), &bytes);
        let mut choices = Choices::of(&bytes);
        let asked = choices.job();
        if let Ok(job) = job_of_json(&view::to_bytes(&asked)) {
            jobs += 1;
            let edit = view::to_bytes(&choices.edit(&asked));
            let edited = |parent| edit_of_json(&parent, &edit).is_ok();
            edits += usize::from(Parent::of(job).is_some_and(edited));
        }
    }
    assert!(jobs > 100 && edits > 50, "{jobs} jobs, {edits} edits");
}

/// Fits that choose their knots, whatever they obey and weigh, end, and with finite numbers.
#[test]
fn generated_automatic_fits_end() {
    let mut count = 0;
    for seed in 0..60_000_u64 {
        let asked = Choices::of(&by_chance(seed)).job();
        if asked["method"]["control_points"] != "auto" {
            continue;
        }
        let Ok(job) = job_of_json(&view::to_bytes(&asked)) else {
            continue;
        };
        count += 1;
        let mut iteration = Iteration::start(Arc::new(System::new(Arc::new(job.problem))));
        for _ in 0..500 {
            if iteration.outcome().is_none() {
                iteration.step();
            }
        }
        let lanes = iteration.control_points().lanes().iter();
        let finite = lanes.flat_map(|lane| lane.iter()).all(|x| x.is_finite());
        assert!(iteration.outcome().is_some() && finite, "{asked}");
    }
    assert!(count > 500, "{count} fits");
}

/// Bytes that look random.
fn by_chance(seed: u64) -> Vec<u8> {
    let bytes = (0..16_u64).flat_map(|k| {
        let mixed = (16 * seed + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ (mixed >> 29))
            .wrapping_mul(0xbf58_476d_1ce4_e5b9)
            .to_be_bytes()
    });
    bytes.collect()
}

/// Edits as messages.
fn messages() -> [(&'static str, pb::Edit); 3] {
    let moved = pb::Edit {
        name: Some("moved".to_owned()),
        moved: vec![1, 2],
        points: vec![0.9, 0.03, 0.8, 0.02],
        ..pb::Edit::default()
    };
    let weighted = pb::Edit {
        iteration: Some(2),
        weighted: vec![1],
        point_weights: vec![3.0],
        method: Some(pb::Method {
            kind: Some(pb::method::Kind::Global(pb::method::Global {})),
        }),
        ..pb::Edit::default()
    };
    let reweighted = pb::Edit {
        weights: Some(pb::Weights {
            values: vec![1.0, 2.0, 3.0, 4.0],
            ..pb::Weights::default()
        }),
        stop: Some(pb::StopRules {
            max_iterations: Some(7),
            ..pb::StopRules::default()
        }),
        ..pb::Edit::default()
    };
    [
        ("moved", moved),
        ("weighted", weighted),
        ("reweighted", reweighted),
    ]
}

/// Found by the target `made`: the neighbour of the first line of a closed surface is the last one.
#[test]
fn a_gap_between_the_last_line_and_the_first_is_named() {
    let job = serde_json::json!({
        "surface": {
            "points": [[null, [0, 1]], [[1, 0], [1, 1]], [[2, 0], [2, 2]], [[0, 3], null]],
            "degree": {"u": 2, "v": 1}, "closed": {"u": true, "v": false}, "parameters": "chord_length",
        },
        "method": {"kind": "least_squares", "control_points": {"u": 3, "v": 2}},
    });
    let refusal = job_of_json(&view::to_bytes(&job)).unwrap_err();
    let named = "no two neighbours of lines 3 and 0 are given";
    assert!(refusal.detail().contains(named), "{}", refusal.detail());
}
