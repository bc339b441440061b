// SPDX-License-Identifier: GPL-3.0-or-later
// The records of uploads, in the file of the job store. Each function runs inside a transaction of the caller and
// throws SqliteError.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/sqlite/database.hpp"
#include "uploads/upload_store.hpp"

namespace surfaced::sqlite {

/// @param client  whose number of open uploads it counts to; empty for nobody's
void insert_upload(Database& database, const PartialUpload& upload, std::string_view client);

std::optional<PartialUpload> select_upload(Database& database, std::string_view id);

/// Writes what changes: offset, cloud, gone, until when.
void update_upload(Database& database, const PartialUpload& upload);

/// Uploads that are neither clouds nor gone, of all or of one client; counts no further than to `most`.
std::size_t count_open_uploads(Database& database, std::optional<std::string_view> client, std::size_t most);

std::vector<PartialUpload> select_open_uploads(Database& database);

/// Ids of open uploads whose time is over.
std::vector<std::string> select_expired_uploads(Database& database, SystemTime time);

/// Forgets those whose time was over then.
void purge_uploads(Database& database, SystemTime time);

}  // namespace surfaced::sqlite
