// SPDX-License-Identifier: GPL-3.0-or-later
#include "jobs/sqlite/holding_rows.hpp"

#include <string>

namespace surfaced::sqlite {

Holding select_holding(Database& database, std::string_view owner) {
  Query query(database, "SELECT active_jobs, bytes FROM holdings WHERE owner = ?");
  query.bind(owner);
  if (!query.step()) return {};
  return {static_cast<std::uint64_t>(query.number(0)), static_cast<std::uint64_t>(query.number(1))};
}

Status admit(Database& database, std::string_view owner, const Allowance& allowance, const Demand& demand) {
  if (allowance.active_jobs == 0 && allowance.bytes == 0) return Done{};
  return allowance.check(select_holding(database, owner), demand.jobs, demand.bytes);
}

std::size_t count_wrong_holdings(Database& database) {
  // Who holds nothing may have a row or none.
  Query query(database,
              "WITH counted AS (SELECT owner, active_jobs, bytes FROM holdings WHERE active_jobs <> 0 OR bytes <> 0), "
              "whole AS (SELECT owner, active_jobs, bytes FROM held WHERE active_jobs <> 0 OR bytes <> 0) "
              "SELECT count(DISTINCT owner) FROM (SELECT * FROM (SELECT * FROM counted EXCEPT SELECT * FROM whole) "
              "UNION ALL SELECT * FROM (SELECT * FROM whole EXCEPT SELECT * FROM counted))");
  query.step();
  return static_cast<std::size_t>(query.number(0));
}

void recount_holdings(Database& database) {
  database.run("DELETE FROM holdings; INSERT INTO holdings SELECT owner, active_jobs, bytes FROM held");
}

}  // namespace surfaced::sqlite
