// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace surfaced::sqlite {

class Database;

/// `PRAGMA user_version`.
std::int64_t version_of(Database& database);

/// The version that this program makes.
std::int64_t newest_version();

/// Brings the file from whatever version it has (`PRAGMA user_version`) to the current one, in one
/// transaction. Throws SqliteError, also for a file that a newer surfaced has written.
void migrate(Database& database);

}  // namespace surfaced::sqlite
