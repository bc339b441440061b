// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/database.hpp"

#include <sqlite3.h>

#include <cctype>

namespace surfaced::sqlite {
void Database::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
void Database::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Database::Database(const std::filesystem::path& file, std::chrono::milliseconds patience) {
  sqlite3* handle = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  const int code = sqlite3_open_v2(file.c_str(), &handle, flags, nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail(code, "open");
  sqlite3_busy_timeout(handle_.get(), static_cast<int>(patience.count()));
  run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON; PRAGMA trusted_schema=OFF");
  // SQLite does not fail where it cannot do as it is told, but does something else.
  expect("PRAGMA journal_mode", "wal");
  expect("PRAGMA synchronous", "2");
}

Database Database::unchanging(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) != 0 || c == '/' || c == '.' || c == '-' || c == '_';
    if (plain) uri += c;
    if (!plain) uri.append({'%', kDigits[byte >> 4], kDigits[byte & 15]});
  }
  Database database;
  sqlite3* handle = nullptr;
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  const int code = sqlite3_open_v2((uri + "?immutable=1").c_str(), &handle, flags, nullptr);
  database.handle_.reset(handle);
  if (code != SQLITE_OK) database.fail(code, "open");
  return database;
}

void Database::expect(const char* pragma, std::string_view value) {
  Query query(*this, pragma);
  const std::string is = query.step() ? query.text(0) : std::string();
  if (is == value) return;
  throw SqliteError(0, "the job store cannot be made durable: " + std::string(pragma) + " is '" + is + "', not '" +
                           std::string(value) + "'; put it on a local disk");
}

void Database::fail(int code, std::string_view doing) const {
  const std::string reason = handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code);
  throw SqliteError(code, "cannot " + std::string(doing) + " the job store: " + reason);
}

void Database::run(const char* sql) {
  const int code = sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code, "change");
}

std::int64_t Database::changes() const { return sqlite3_changes64(handle_.get()); }

sqlite3_stmt* Database::prepared(const char* sql) {
  auto& kept = statements_[sql];
  if (!kept) {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v3(handle_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    kept.reset(statement);
    if (code != SQLITE_OK) fail(code, "ask");
  }
  return kept.get();
}

Query::Query(Database& database, const char* sql) : database_(database), statement_(database.prepared(sql)) {}

Query::~Query() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

void Query::check_bound(int code) {
  if (code != SQLITE_OK) database_.fail(code, "ask");
}

Query& Query::bind(std::string_view text) {
  check_bound(sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Query& Query::bind(std::int64_t number) {
  check_bound(sqlite3_bind_int64(statement_, ++bound_, number));
  return *this;
}

Query& Query::bind(double number) {
  check_bound(sqlite3_bind_double(statement_, ++bound_, number));
  return *this;
}

Query& Query::bind(const std::optional<Error>& error) {
  if (error) return bind(name_of(error->code)).bind(std::string_view(error->detail));
  check_bound(sqlite3_bind_null(statement_, ++bound_));
  check_bound(sqlite3_bind_null(statement_, ++bound_));
  return *this;
}

bool Query::step() {
  const int code = sqlite3_step(statement_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail(code, "use");
  return code == SQLITE_ROW;
}

void Query::run() {
  while (step()) {
  }
}

std::string Query::text(int column) const {
  const auto* bytes = sqlite3_column_text(statement_, column);
  const auto length = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  return bytes == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(bytes), length);
}

std::int64_t Query::number(int column) const { return sqlite3_column_int64(statement_, column); }

double Query::real(int column) const { return sqlite3_column_double(statement_, column); }

bool Query::null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

Transaction::Transaction(Database& database, Kind kind) : database_(database) {
  database_.run(kind == Kind::write ? "BEGIN IMMEDIATE" : "BEGIN DEFERRED");
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    database_.run("ROLLBACK");
  } catch (const SqliteError&) {
    // SQLite has rolled back by itself after the error that brought us here.
  }
}

void Transaction::commit() {
  database_.run("COMMIT");
  open_ = false;
}

}  // namespace surfaced::sqlite
