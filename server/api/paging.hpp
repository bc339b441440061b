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
/// @param others  names that the path takes besides
/// @return  unknown_parameter, invalid_parameter.
Result<Page> read_page(const http::Request& request, std::initializer_list<std::string_view> others = {});

/// The address of the next page: this one's with another cursor.
std::string next_page(const http::Request& request, std::int64_t cursor);

}  // namespace surfaced::api
