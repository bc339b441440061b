// SPDX-License-Identifier: GPL-3.0-or-later
// What owners hold, as the triggers of the schema count it: one row an owner, so a look costs the same however much he
// has. Each function runs inside a transaction of the caller and throws SqliteError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "jobs/job_store.hpp"
#include "jobs/sqlite/database.hpp"

namespace surfaced::sqlite {

Holding select_holding(Database& database, std::string_view owner);

/// What is about to be added to what an owner holds.
struct Demand {
  std::uint64_t jobs = 0;
  std::uint64_t bytes = 0;
};

/// quota_exceeded if the owner may not have that much more. Inside the write transaction that adds it nothing can come
/// between this look and the addition.
Status admit(Database& database, std::string_view owner, const Allowance& allowance, const Demand& demand);

/// Owners whose row is not what a count from the beginning gives; 0 unless there is a defect.
std::size_t count_wrong_holdings(Database& database);

/// Counts everything from the beginning.
void recount_holdings(Database& database);

}  // namespace surfaced::sqlite
