// SPDX-License-Identifier: GPL-3.0-or-later
// SQLite with ownership: a connection, its prepared statements, and transactions that roll back when
// they are not committed. Inside this folder failures are thrown as SqliteError; the store turns them
// into values at its wall.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/base.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace surfaced::sqlite {

/// What SQLite said, with its result code.
class SqliteError : public std::runtime_error {
 public:
  SqliteError(int code, const std::string& message) : std::runtime_error(message), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

/// One connection; not to be used by two threads at once.
class Database {
 public:
  /// Opens or creates the file: WAL, every commit synced to the disk, foreign keys on; throws if the file cannot
  /// be had so (a file system without shared memory).
  /// @param patience  for the lock, which another process (a backup) may hold
  Database(const std::filesystem::path& file, std::chrono::milliseconds patience);

  /// Opens a file that nobody changes while it is open, for reading; nothing is written, not even beside it.
  static Database unchanging(const std::filesystem::path& file);

  /// Runs statements that return nothing.
  void run(const char* sql);
  /// Rows that the last statement changed.
  std::int64_t changes() const;

 private:
  friend class Query;
  Database() = default;
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  [[noreturn]] void fail(int code, std::string_view doing) const;
  /// Throws unless the pragma has this value.
  void expect(const char* pragma, std::string_view value);
  sqlite3_stmt* prepared(const char* sql);

  std::unique_ptr<sqlite3, Close> handle_;
  // By the address of the SQL, which lives as long as the program.
  std::map<const char*, std::unique_ptr<sqlite3_stmt, Finalize>> statements_;
};

/// One use of a prepared statement, which is kept for the next use of the same text.
class Query {
 public:
  Query(Database& database, const char* sql);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  /// Binds the next parameter. The text must live until the last step.
  Query& bind(std::string_view text);
  Query& bind(std::int64_t number);
  Query& bind(double number);
  /// Two parameters, code and detail, or two NULLs.
  Query& bind(const std::optional<Error>& error);

  /// Goes to the next row; false when there is none.
  bool step();
  /// Runs to the end.
  void run();

  std::string text(int column) const;
  std::int64_t number(int column) const;
  double real(int column) const;
  bool null(int column) const;

 private:
  Database& database_;
  sqlite3_stmt* statement_;
  void check_bound(int code);
  int bound_ = 0;
};

/// Holds the write lock from its beginning; rolls back unless committed.
class Transaction {
 public:
  enum class Kind : std::uint8_t { read, write };
  Transaction(Database& database, Kind kind);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace surfaced::sqlite
