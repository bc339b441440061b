// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "http/message.hpp"
#include "jobs/job_store.hpp"

namespace surfaced::api {

/// Which jobs a request lists, and which page of them.
struct Page {
  JobFilter filter;
  std::size_t limit = 0;
  std::optional<std::int64_t> cursor;
};

/// Reads status, method, labels, limit and cursor from the query; of the caller's own jobs, unless he sees all.
/// @return  unknown_parameter, invalid_parameter.
Result<Page> read_page(const http::Request& request);

/// The same with the names of OGC API - Processes: type, processID, status, datetime, minDuration, maxDuration, limit;
/// and labels and cursor.
Result<Page> read_ogc_page(const http::Request& request);

/// The address of the next page: this one's with another cursor.
std::string next_page(const http::Request& request, std::int64_t cursor);

}  // namespace surfaced::api
