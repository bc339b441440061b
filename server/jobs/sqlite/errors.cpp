// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/errors.hpp"

#include <sqlite3.h>

namespace surfaced::sqlite {

Error store_error(const SqliteError& error) {
  switch (error.code() & 0xFF) {
    case SQLITE_FULL:
      return {ErrorCode::storage_full, error.what()};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::not_ready, error.what()};
    default:
      return {ErrorCode::internal_error, error.what()};
  }
}

}  // namespace surfaced::sqlite
