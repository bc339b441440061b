// SPDX-License-Identifier: GPL-3.0-or-later
// What the store looks up and notes around jobs: pages of them, submissions that come again, outputs that are made
// later. Each function runs inside a transaction of the caller and throws SqliteError.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "jobs/job_store.hpp"
#include "jobs/sqlite/database.hpp"

namespace surfaced::sqlite {

JobPage select_page(Database& database, const JobFilter& filter, std::size_t limit, std::optional<std::int64_t> before);

std::optional<std::string> select_owner(Database& database, std::string_view id);

/// Notes that the cloud is used at this time; false if there is no such cloud.
bool use_cloud(Database& database, std::string_view id, SystemTime time);

void insert_idempotency(Database& database, const NewJob& job);
std::optional<Replay> select_replay(Database& database, std::string_view owner, std::string_view key);

/// False if the job's outputs are not those of the source any more.
bool insert_output(Database& database, const Claim& source, const Output& output);

}  // namespace surfaced::sqlite
