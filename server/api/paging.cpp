// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/paging.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>

#include "api/submission.hpp"
#include "base/text.hpp"
#include "http/problem.hpp"
#include "http/request_head.hpp"

namespace surfaced::api {
namespace {

using http::Request;

constexpr double kLongestPage = 200;
constexpr std::size_t kUsualPage = 50;
/// What the standard has clients ask for; they get no more than kLongestPage.
constexpr double kLongestOgcPage = 10'000;
constexpr double kLongestDuration = 1e9;

Status refuse_others(const Request& request, std::span<const std::string_view> names) {
  const std::string listed = joined(names);
  for (const auto& [name, value] : request.query) {
    if (std::ranges::find(names, name) != names.end()) continue;
    return with_fault({ErrorCode::unknown_parameter, "'" + name + "' is not taken by this path; allowed are " + listed},
                      {name, value, "one of " + listed});
  }
  return Done{};
}

Status read_statuses(const Request& request, JobFilter& filter) {
  const auto text = single(request.query, "status");
  if (!text) return text.error();
  for (const std::string& name : split_list(*text)) {
    const auto status = job_status_named(name);
    if (!status) {
      return http::wrong_value(ErrorCode::invalid_parameter, "status", name,
                               "one or more of accepted, running, successful, failed, dismissed");
    }
    if (std::ranges::find(filter.statuses, *status) == filter.statuses.end()) filter.statuses.push_back(*status);
  }
  return Done{};
}

/// What both lists take, and the methods under their name.
Result<JobFilter> read_filter(const Request& request, std::string_view methods_name) {
  JobFilter filter;
  filter.owner = request.caller.owner();
  if (Status read = read_statuses(request, filter); !read.ok()) return read.error();
  const auto methods = single(request.query, methods_name);
  if (!methods) return methods.error();
  filter.methods = split_list(*methods);
  const auto labels = single(request.query, "labels");
  if (!labels) return labels.error();
  auto checked = read_labels(*labels);
  if (!checked) return std::move(checked).error();
  filter.labels = std::move(*checked);
  return filter;
}

/// A time, or two with a slash between them of which one may be open: `..`.
Status read_datetime(const Request& request, JobFilter& filter) {
  const auto text = single(request.query, "datetime");
  if (!text || text->empty()) return text ? Status(Done{}) : Status(text.error());
  const std::size_t slash = text->find('/');
  const std::string from = text->substr(0, slash);
  const std::string to = slash == text->npos ? from : text->substr(slash + 1);
  const auto open = [&](const std::string& end) { return slash != text->npos && (end.empty() || end == ".."); };
  filter.created_from = parse_rfc3339(from);
  filter.created_to = parse_rfc3339(to);
  if ((filter.created_from || open(from)) && (filter.created_to || open(to)) && (!open(from) || !open(to)))
    return Done{};
  return http::wrong_value(ErrorCode::invalid_parameter, "datetime", *text,
                           "a time of RFC 3339, or two with / between them, one of which may be ..");
}

Result<std::optional<double>> read_duration(const Request& request, std::string_view name) {
  const auto text = single(request.query, name);
  if (!text) return text.error();
  if (text->empty()) return std::optional<double>();
  const auto seconds = number_within(name, *text, 0, kLongestDuration);
  return seconds ? Result<std::optional<double>>(std::optional(*seconds)) : seconds.error();
}

/// A cursor is opaque to clients: the number of the last job of the page before, in hexadecimal.
Result<std::optional<std::int64_t>> read_cursor(const Request& request) {
  const auto text = single(request.query, "cursor");
  if (!text) return text.error();
  if (text->empty()) return std::optional<std::int64_t>();
  std::int64_t number = 0;
  const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), number, 16);
  if (failed == std::errc() && end == text->data() + text->size() && number > 0) return std::optional(number);
  return http::wrong_value(ErrorCode::invalid_parameter, "cursor", *text, "what a Link header has given");
}

Result<Page> with_page(const Request& request, JobFilter filter, double longest) {
  const auto cursor = read_cursor(request);
  if (!cursor) return cursor.error();
  const auto limit = single(request.query, "limit");
  if (!limit) return limit.error();
  Page page{std::move(filter), kUsualPage, *cursor};
  if (limit->empty()) return page;
  const auto given = number_within("limit", *limit, 1, longest);
  if (!given) return given.error();
  page.limit = static_cast<std::size_t>(std::min(*given, kLongestPage));
  return page;
}

}  // namespace

Result<Page> read_page(const Request& request) {
  constexpr auto kNames = std::to_array<std::string_view>({"status", "method", "labels", "limit", "cursor"});
  if (Status known = refuse_others(request, kNames); !known.ok()) return known.error();
  auto filter = read_filter(request, "method");
  if (!filter) return std::move(filter).error();
  return with_page(request, std::move(*filter), kLongestPage);
}

Result<Page> read_ogc_page(const Request& request) {
  constexpr auto kNames = std::to_array<std::string_view>(
      {"type", "processID", "status", "datetime", "minDuration", "maxDuration", "labels", "limit", "cursor"});
  if (Status known = refuse_others(request, kNames); !known.ok()) return known.error();
  const auto type = single(request.query, "type");
  if (!type) return type.error();
  if (!type->empty() && *type != "process") {
    return http::wrong_value(ErrorCode::invalid_parameter, "type", *type, "process");
  }
  auto filter = read_filter(request, "processID");
  if (!filter) return std::move(filter).error();
  if (Status read = read_datetime(request, *filter); !read.ok()) return read.error();
  const auto shortest = read_duration(request, "minDuration");
  if (!shortest) return shortest.error();
  const auto longest = read_duration(request, "maxDuration");
  if (!longest) return longest.error();
  filter->shortest = *shortest;
  filter->longest = *longest;
  return with_page(request, std::move(*filter), kLongestOgcPage);
}

std::string next_page(const Request& request, std::int64_t cursor) {
  std::string query;
  for (const auto& [name, value] : request.query) {
    if (name != "cursor") query += http::percent_encode(name) + "=" + http::percent_encode(value) + "&";
  }
  std::array<char, 20> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), cursor, 16).ptr;
  return request.path + "?" + query + "cursor=" + std::string(digits.data(), end);
}

}  // namespace surfaced::api
