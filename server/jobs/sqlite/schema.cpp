// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/schema.hpp"

#include <array>
#include <string>

#include "jobs/sqlite/database.hpp"

namespace surfaced::sqlite {
namespace {

// Entry n takes a file from version n to n + 1. An entry that was released is never changed.
constexpr auto kMigrations = std::to_array<const char*>({
    R"sql(
CREATE TABLE jobs (
  seq          INTEGER PRIMARY KEY AUTOINCREMENT,
  id           TEXT NOT NULL UNIQUE,
  method       TEXT NOT NULL,
  parameters   TEXT NOT NULL,
  status       TEXT NOT NULL CHECK (status IN ('accepted', 'running', 'successful', 'failed', 'dismissed')),
  attempt      INTEGER NOT NULL DEFAULT 0,
  failures     INTEGER NOT NULL DEFAULT 0,
  losses       INTEGER NOT NULL DEFAULT 0,
  input_key    TEXT NOT NULL,
  input_bytes  INTEGER NOT NULL,
  input_sha256 TEXT NOT NULL,
  wanted       TEXT NOT NULL,
  request_id   TEXT NOT NULL,
  ttl_seconds  INTEGER NOT NULL,
  created_at   TEXT NOT NULL,
  started_at   TEXT,
  finished_at  TEXT,
  expires_at   TEXT,
  removed_at   TEXT,
  error_code   TEXT,
  error_detail TEXT
) STRICT;
CREATE INDEX jobs_active ON jobs (status, seq) WHERE status IN ('accepted', 'running');
CREATE INDEX jobs_expiry ON jobs (expires_at) WHERE expires_at IS NOT NULL;
CREATE TABLE outputs (
  job     TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  name    TEXT NOT NULL,
  attempt INTEGER NOT NULL,
  bytes   INTEGER NOT NULL,
  sha256  TEXT NOT NULL,
  PRIMARY KEY (job, name)
) STRICT, WITHOUT ROWID;
)sql",
    R"sql(
CREATE TABLE attempts (
  job               TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  number            INTEGER NOT NULL,
  started_at        TEXT NOT NULL,
  ended_at          TEXT,
  outcome           TEXT,
  seconds           REAL NOT NULL DEFAULT 0,
  cpu_seconds       REAL NOT NULL DEFAULT 0,
  peak_memory_bytes INTEGER NOT NULL DEFAULT 0,
  error_code        TEXT,
  error_detail      TEXT,
  PRIMARY KEY (job, number)
) STRICT, WITHOUT ROWID;
INSERT INTO attempts (job, number, started_at, ended_at)
  SELECT id, attempt, coalesce(started_at, created_at), finished_at FROM jobs
  WHERE attempt > 0 AND (status = 'running' OR finished_at IS NOT NULL);
UPDATE attempts SET outcome = (SELECT CASE status WHEN 'successful' THEN 'done' WHEN 'dismissed' THEN 'cancelled'
  ELSE CASE WHEN error_code IN ('method_failed', 'out_of_memory', 'timed_out', 'crashed', 'lost') THEN error_code
  ELSE 'input_invalid' END END FROM jobs WHERE id = attempts.job) WHERE ended_at IS NOT NULL;
ALTER TABLE jobs ADD COLUMN heartbeat INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN parked INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN traceparent TEXT NOT NULL DEFAULT '';
CREATE TABLE store (id TEXT NOT NULL) STRICT;
INSERT INTO store (id) VALUES (lower(hex(randomblob(16))));
)sql",
    R"sql(
ALTER TABLE jobs ADD COLUMN owner TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN labels TEXT NOT NULL DEFAULT '[]';
ALTER TABLE jobs ADD COLUMN webhook TEXT NOT NULL DEFAULT '';
CREATE INDEX jobs_input ON jobs (input_key) WHERE removed_at IS NULL;
CREATE TABLE idempotency (
  owner       TEXT NOT NULL,
  key         TEXT NOT NULL,
  fingerprint TEXT NOT NULL,
  job         TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  PRIMARY KEY (owner, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX idempotency_job ON idempotency (job);
CREATE TABLE clouds (
  id           TEXT PRIMARY KEY,
  bytes        INTEGER NOT NULL,
  status       TEXT NOT NULL CHECK (status IN ('inspecting', 'ready', 'refused')),
  created_at   TEXT NOT NULL,
  facts        TEXT,
  error_code   TEXT,
  error_detail TEXT
) STRICT, WITHOUT ROWID;
CREATE TABLE cloud_holders (
  cloud TEXT NOT NULL REFERENCES clouds (id) ON DELETE CASCADE,
  owner TEXT NOT NULL,
  PRIMARY KEY (cloud, owner)
) STRICT, WITHOUT ROWID;
CREATE TABLE deliveries (
  seq         INTEGER PRIMARY KEY AUTOINCREMENT,
  id          TEXT NOT NULL UNIQUE,
  job         TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  url         TEXT NOT NULL,
  status      TEXT NOT NULL DEFAULT 'pending' CHECK (status IN ('pending', 'delivered', 'given_up')),
  attempts    INTEGER NOT NULL DEFAULT 0,
  created_at  TEXT NOT NULL,
  next_at     TEXT NOT NULL,
  tried_at    TEXT,
  http_status INTEGER,
  detail      TEXT
) STRICT;
CREATE INDEX deliveries_due ON deliveries (next_at) WHERE status = 'pending';
CREATE INDEX deliveries_job ON deliveries (job);
CREATE TRIGGER jobs_ended AFTER UPDATE OF status ON jobs
  WHEN NEW.webhook <> '' AND OLD.status IN ('accepted', 'running')
    AND NEW.status IN ('successful', 'failed', 'dismissed')
BEGIN
  INSERT INTO deliveries (id, job, url, created_at, next_at)
    VALUES (lower(hex(randomblob(16))), NEW.id, NEW.webhook, NEW.finished_at, NEW.finished_at);
END;
)sql",
    R"sql(
ALTER TABLE jobs ADD COLUMN presentation TEXT NOT NULL DEFAULT '';
)sql",
    R"sql(
ALTER TABLE clouds ADD COLUMN used_at TEXT NOT NULL DEFAULT '';
UPDATE clouds SET used_at = strftime('%Y-%m-%dT%H:%M:%fZ', 'now');
)sql",
    // For pages of jobs, and for what a key holds.
    R"sql(
CREATE INDEX jobs_owner ON jobs (owner, seq, status, removed_at) WHERE removed_at IS NULL;
CREATE INDEX jobs_status ON jobs (status, seq) WHERE removed_at IS NULL;
CREATE INDEX jobs_method ON jobs (method, status, seq) WHERE removed_at IS NULL;
)sql",
    // Uploads that may go on, and what each owner holds: counted by the transaction that changes it, whoever makes it.
    // `held` counts from the beginning. A job's outputs and a cloud's holders go before their parent does, as the
    // triggers of what a foreign key removes would look for an owner that is gone.
    R"sql(
CREATE TABLE uploads (
  id         TEXT PRIMARY KEY,
  owner      TEXT NOT NULL,
  client     TEXT NOT NULL,
  length     INTEGER NOT NULL,
  offset     INTEGER NOT NULL DEFAULT 0,
  metadata   TEXT NOT NULL,
  created_at TEXT NOT NULL,
  expires_at TEXT NOT NULL,
  cloud      TEXT NOT NULL DEFAULT '',
  gone       INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
CREATE INDEX uploads_open ON uploads (client) WHERE cloud = '' AND gone = 0;
CREATE INDEX uploads_expiry ON uploads (expires_at);
CREATE TABLE holdings (
  owner       TEXT PRIMARY KEY,
  active_jobs INTEGER NOT NULL,
  bytes       INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE VIEW held (owner, active_jobs, bytes) AS
  SELECT owner, sum(active), sum(bytes) FROM (
    SELECT owner, status IN ('accepted', 'running') AS active,
      iif(removed_at IS NULL AND input_key <> input_sha256, input_bytes, 0) AS bytes FROM jobs
    UNION ALL SELECT j.owner, 0, o.bytes FROM outputs o JOIN jobs j ON j.id = o.job
    UNION ALL SELECT h.owner, 0, c.bytes FROM cloud_holders h JOIN clouds c ON c.id = h.cloud
    UNION ALL SELECT owner, 0, length FROM uploads WHERE cloud = '' AND gone = 0)
  GROUP BY owner;
INSERT INTO holdings SELECT owner, active_jobs, bytes FROM held;
CREATE TRIGGER hold_job AFTER INSERT ON jobs BEGIN
  INSERT INTO holdings VALUES (NEW.owner, NEW.status IN ('accepted', 'running'),
    iif(NEW.removed_at IS NULL AND NEW.input_key <> NEW.input_sha256, NEW.input_bytes, 0))
  ON CONFLICT (owner) DO UPDATE SET active_jobs = active_jobs + excluded.active_jobs, bytes = bytes + excluded.bytes;
END;
CREATE TRIGGER hold_changed_job AFTER UPDATE OF status, removed_at ON jobs BEGIN
  UPDATE holdings SET
    active_jobs = active_jobs + (NEW.status IN ('accepted', 'running')) - (OLD.status IN ('accepted', 'running')),
    bytes = bytes + iif(NEW.removed_at IS NULL AND NEW.input_key <> NEW.input_sha256, NEW.input_bytes, 0)
      - iif(OLD.removed_at IS NULL AND OLD.input_key <> OLD.input_sha256, OLD.input_bytes, 0)
  WHERE owner = NEW.owner;
END;
CREATE TRIGGER release_job BEFORE DELETE ON jobs BEGIN
  DELETE FROM outputs WHERE job = OLD.id;
  UPDATE holdings SET active_jobs = active_jobs - (OLD.status IN ('accepted', 'running')),
    bytes = bytes - iif(OLD.removed_at IS NULL AND OLD.input_key <> OLD.input_sha256, OLD.input_bytes, 0)
  WHERE owner = OLD.owner;
END;
CREATE TRIGGER hold_output AFTER INSERT ON outputs BEGIN
  UPDATE holdings SET bytes = bytes + NEW.bytes WHERE owner = (SELECT owner FROM jobs WHERE id = NEW.job);
END;
CREATE TRIGGER hold_changed_output AFTER UPDATE OF bytes ON outputs BEGIN
  UPDATE holdings SET bytes = bytes + NEW.bytes - OLD.bytes WHERE owner = (SELECT owner FROM jobs WHERE id = NEW.job);
END;
CREATE TRIGGER release_output AFTER DELETE ON outputs BEGIN
  UPDATE holdings SET bytes = bytes - OLD.bytes WHERE owner = (SELECT owner FROM jobs WHERE id = OLD.job);
END;
CREATE TRIGGER hold_cloud AFTER INSERT ON cloud_holders BEGIN
  INSERT INTO holdings SELECT NEW.owner, 0, bytes FROM clouds WHERE id = NEW.cloud
  ON CONFLICT (owner) DO UPDATE SET bytes = bytes + excluded.bytes;
END;
CREATE TRIGGER release_cloud AFTER DELETE ON cloud_holders BEGIN
  UPDATE holdings SET bytes = bytes - (SELECT bytes FROM clouds WHERE id = OLD.cloud) WHERE owner = OLD.owner;
END;
CREATE TRIGGER release_holders BEFORE DELETE ON clouds BEGIN
  DELETE FROM cloud_holders WHERE cloud = OLD.id;
END;
CREATE TRIGGER hold_upload AFTER INSERT ON uploads WHEN NEW.cloud = '' AND NEW.gone = 0 BEGIN
  INSERT INTO holdings VALUES (NEW.owner, 0, NEW.length)
  ON CONFLICT (owner) DO UPDATE SET bytes = bytes + excluded.bytes;
END;
CREATE TRIGGER hold_changed_upload AFTER UPDATE OF cloud, gone ON uploads BEGIN
  UPDATE holdings SET bytes = bytes + NEW.length * (NEW.cloud = '' AND NEW.gone = 0)
    - OLD.length * (OLD.cloud = '' AND OLD.gone = 0) WHERE owner = NEW.owner;
END;
CREATE TRIGGER release_upload AFTER DELETE ON uploads WHEN OLD.cloud = '' AND OLD.gone = 0 BEGIN
  UPDATE holdings SET bytes = bytes - OLD.length WHERE owner = OLD.owner;
END;
)sql",
    // Who a delivery goes to, host and port of its URL (`https://` has 8 characters), so that each receiver's next one
    // is found without a look at all that others wait for.
    R"sql(
ALTER TABLE deliveries ADD COLUMN receiver TEXT GENERATED ALWAYS AS (lower(replace(
  substr(url, 9, min(instr(substr(url, 9) || '/', '/'), instr(substr(url, 9) || '?', '?'),
    instr(substr(url, 9) || '#', '#')) - 1) || '/', ':443/', '/'))) VIRTUAL;
DROP INDEX deliveries_due;
CREATE INDEX deliveries_receiver ON deliveries (receiver, next_at) WHERE status = 'pending';
)sql",
});

}  // namespace

std::int64_t version_of(Database& database) {
  Query query(database, "PRAGMA user_version");
  return query.step() ? query.number(0) : 0;
}

std::int64_t newest_version() { return static_cast<std::int64_t>(kMigrations.size()); }

void migrate(Database& database) {
  Transaction transaction(database, Transaction::Kind::write);
  std::int64_t version = version_of(database);
  const std::int64_t newest = newest_version();
  if (version < 0 || version > newest) {
    throw SqliteError(0, "the job store has version " + std::to_string(version) +
                             ", this surfaced knows versions up to " + std::to_string(newest) +
                             "; use the surfaced that wrote it, or a newer one");
  }
  for (; version < newest; ++version) database.run(kMigrations.at(static_cast<std::size_t>(version)));
  database.run(("PRAGMA user_version = " + std::to_string(newest)).c_str());
  transaction.commit();
}

}  // namespace surfaced::sqlite
