// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace surfaced::sqlite {

class Database;

/// Brings the file from whatever version it has (`PRAGMA user_version`) to the current one, in one
/// transaction. Throws SqliteError, also for a file that a newer surfaced has written.
void migrate(Database& database);

}  // namespace surfaced::sqlite
