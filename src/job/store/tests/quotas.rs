//! Quotas, with many jobs at a time and every kind of end.

use bytesize::ByteSize;

use super::*;

/// The number of jobs that arrive at the same time; each has 20 points.
const CROWD: usize = 100;

fn cad() -> Tenant {
    "cad".parse().unwrap()
}

fn queued_of(tenant: Tenant) -> Record {
    let mut record = queued();
    record.outline.tenant = tenant;
    record
}

/// Inserts many jobs of a tenant at the same time; returns those that are stored.
async fn create_many(store: &Store, quota: Quota) -> Vec<Uuid> {
    let records: Vec<Record> = (0..CROWD).map(|_| queued_of(cad())).collect();
    let insert = |record: &Record| store.insert(record.clone(), Arc::new(problem()), None, quota);
    let insertions = futures_util::future::join_all(records.iter().map(insert)).await;
    let ids = records.iter().map(|record| record.outline.id);
    let kept = ids
        .zip(insertions)
        .filter(|(_, it)| matches!(it, Ok(Insertion::New)));
    kept.map(|(id, _)| id).collect()
}

pub(super) async fn no_more_jobs_are_kept_than_a_quota_allows(store: &Store) {
    // Jobs of others do not count.
    for _ in 0..3 {
        insert(store).await;
    }
    let jobs = |jobs| Quota {
        jobs: Some(jobs),
        ..NONE
    };
    let points = |points| Quota {
        points: Some(points),
        ..NONE
    };
    let mut kept = create_many(store, jobs(7)).await;
    assert_eq!(kept.len(), 7);
    kept.extend(create_many(store, points(9 * 20 + 19)).await);
    assert_eq!(kept.len(), 9);
    assert!(create_many(store, jobs(8)).await.is_empty());
    kept.sort();
    let mut found = ids(store).await.split_off(3);
    found.sort();
    assert_eq!(found, kept);
    // A refused job leaves its key free; a known one is not a new job.
    let quota = jobs(9);
    let keyed = async |record: &Record, quota| {
        let key = Some(key("key"));
        let inserted = store.insert(record.clone(), Arc::new(problem()), key, quota);
        inserted.await.unwrap()
    };
    let record = queued_of(cad());
    let refused = keyed(&record, quota).await;
    let Insertion::Refused(exceeded) = refused else {
        panic!("{refused:?}");
    };
    let text = "tenant cad may have 9 unfinished jobs and would have 10";
    assert_eq!(exceeded.to_string(), text);
    assert_eq!(keyed(&record, jobs(10)).await, Insertion::New);
    let known = keyed(&queued_of(cad()), quota).await;
    assert!(matches!(known, Insertion::Known(entry) if entry.id == record.outline.id));
}

#[tokio::test]
async fn replicas_share_a_quota() {
    let schema = replicas::Schema::new().await;
    let stores = [schema.open().await, schema.open().await].map(Store::Shared);
    let quota = Quota {
        jobs: Some(11),
        ..NONE
    };
    let (here, there) = tokio::join!(
        create_many(&stores[0], quota),
        create_many(&stores[1], quota)
    );
    assert_eq!(here.len() + there.len(), 11);
}

pub(super) async fn what_jobs_take_is_given_back(store: &Store) {
    let one = |quota| async move {
        let record = queued_of(cad());
        let inserted = store.insert(record.clone(), Arc::new(problem()), None, quota);
        match inserted.await.unwrap() {
            Insertion::New => Ok(record.outline.id),
            it => Err(it),
        }
    };
    let jobs = Quota {
        jobs: Some(1),
        points: Some(20),
        ..NONE
    };
    let first = one(jobs).await.unwrap();
    assert!(one(jobs).await.is_err());
    store.start(first, Status::running(), false).await.unwrap();
    assert!(one(jobs).await.is_err());
    let result = Some(control_points().into());
    store.finish(first, converged(0), result).await.unwrap();
    let second = one(jobs).await.unwrap();
    // Bytes of the input of both, and of the result of one.
    let bytes = |bytes| Quota {
        bytes: Some(ByteSize(bytes)),
        ..NONE
    };
    let has = async || {
        let Err(Insertion::Refused(exceeded)) = one(bytes(0)).await else {
            panic!("it is beyond a quota of nothing");
        };
        let text = exceeded.to_string();
        text.rsplit(' ').next().unwrap().parse::<u64>().unwrap()
    };
    let three_inputs_and_a_result = has().await;
    assert!(store.remove(second).await.unwrap());
    let two_inputs_and_a_result = has().await;
    let input = three_inputs_and_a_result - two_inputs_and_a_result;
    assert!(store.remove(first).await.unwrap());
    assert_eq!(has().await, input);
    let result = two_inputs_and_a_result - 2 * input;
    // Twenty points of two coordinates of eight bytes.
    assert!((320..1000).contains(&result), "{result}");
    let kept = create_many(store, bytes(5 * input + input / 2)).await;
    assert_eq!(kept.len(), 5);
}
