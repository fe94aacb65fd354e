-- Secrets that all replicas share, such as the key of their tickets.
CREATE TABLE secrets (
    name text PRIMARY KEY,
    bytes bytea NOT NULL
);
