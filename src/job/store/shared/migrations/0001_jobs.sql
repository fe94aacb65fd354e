-- A job without its points. What SQL works with has columns of its own.
CREATE TABLE jobs (
    id uuid PRIMARY KEY,
    -- To whom it belongs.
    tenant text NOT NULL,
    outline bytea NOT NULL,
    state text NOT NULL,
    status bytea NOT NULL,
    -- The replica that has accepted it and then that runs it, until when it is believed to, and how often the
    -- job was claimed.
    owner uuid,
    lease_until timestamptz,
    epoch bigint NOT NULL,
    crashes integer NOT NULL DEFAULT 0,
    on_probation boolean NOT NULL DEFAULT false,
    -- A client of another replica has asked for its end.
    cancel boolean NOT NULL DEFAULT false,
    -- Another replica waits for its end: it has accepted the job, or has readers of it.
    followed boolean NOT NULL DEFAULT false,
    finished timestamptz,
    points bigint NOT NULL,
    input_bytes bigint NOT NULL,
    result_bytes bigint NOT NULL DEFAULT 0
-- Room for a new version of a row beside the old one: a lease is renewed without touching an index.
) WITH (fillfactor = 70);

CREATE INDEX jobs_of_tenant ON jobs (tenant, id);
CREATE INDEX jobs_queued ON jobs (id) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (owner) WHERE state = 'running';
CREATE INDEX jobs_ended ON jobs (finished, id) WHERE finished IS NOT NULL;

-- Problems as they were asked for, in pieces.
CREATE TABLE inputs (
    id uuid NOT NULL REFERENCES jobs ON DELETE CASCADE,
    piece integer NOT NULL,
    bytes bytea NOT NULL,
    PRIMARY KEY (id, piece)
);

-- The last levels of jobs that have ended, in pieces.
CREATE TABLE results (
    id uuid NOT NULL REFERENCES jobs ON DELETE CASCADE,
    piece integer NOT NULL,
    bytes bytea NOT NULL,
    PRIMARY KEY (id, piece)
);

-- Coordinates do not become smaller by compression.
ALTER TABLE inputs ALTER COLUMN bytes SET STORAGE EXTERNAL;
ALTER TABLE results ALTER COLUMN bytes SET STORAGE EXTERNAL;

-- Which job was made for an idempotency key.
CREATE TABLE keys (
    name text PRIMARY KEY,
    id uuid NOT NULL REFERENCES jobs ON DELETE CASCADE,
    entry bytea NOT NULL,
    created timestamptz NOT NULL
);

CREATE INDEX keys_of_job ON keys (id);
CREATE INDEX keys_by_age ON keys (created);
