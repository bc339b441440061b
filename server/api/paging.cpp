#include "api/paging.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "api/submission.hpp"
#include "http/request_head.hpp"

namespace surfaced::api {
namespace {

using http::Request;

constexpr double kLongestPage = 200;
constexpr std::size_t kUsualPage = 50;

Result<JobFilter> read_filter(const Request& request, std::initializer_list<std::string_view> others) {
  JobFilter filter{request.caller.owner(), {}, {}, {}};
  constexpr auto kNames = std::to_array<std::string_view>({"status", "method", "labels", "limit", "cursor"});
  for (const auto& [name, value] : request.query) {
    const bool known =
        std::ranges::find(kNames, name) != kNames.end() || std::ranges::find(others, name) != others.end();
    if (known) continue;
    return Error{ErrorCode::unknown_parameter,
                 "'" + name + "' is not taken by this path; allowed are status, method, labels, limit, cursor"};
  }
  const auto status = single(request.query, "status");
  if (!status) return status.error();
  if (!status->empty()) {
    filter.status = job_status_named(*status);
    if (!filter.status) {
      return Error{ErrorCode::invalid_parameter,
                   "'status' is '" + *status + "'; allowed are accepted, running, successful, failed, dismissed"};
    }
  }
  auto method = single(request.query, "method");
  if (!method) return std::move(method).error();
  filter.method = std::move(*method);
  const auto labels = single(request.query, "labels");
  if (!labels) return labels.error();
  auto checked = read_labels(*labels);
  if (!checked) return std::move(checked).error();
  filter.labels = std::move(*checked);
  return filter;
}

/// A cursor is opaque to clients: the number of the last job of the page before, in hexadecimal.
Result<std::optional<std::int64_t>> read_cursor(const Request& request) {
  const auto text = single(request.query, "cursor");
  if (!text) return text.error();
  if (text->empty()) return std::optional<std::int64_t>();
  std::int64_t number = 0;
  const auto [end, failed] = std::from_chars(text->data(), text->data() + text->size(), number, 16);
  if (failed == std::errc() && end == text->data() + text->size() && number > 0) return std::optional(number);
  return Error{ErrorCode::invalid_parameter, "'cursor' is '" + *text + "'; allowed is what a Link header has given"};
}

}  // namespace

Result<Page> read_page(const Request& request, std::initializer_list<std::string_view> others) {
  auto filter = read_filter(request, others);
  if (!filter) return std::move(filter).error();
  const auto cursor = read_cursor(request);
  if (!cursor) return cursor.error();
  const auto limit = single(request.query, "limit");
  if (!limit) return limit.error();
  Page page{std::move(*filter), kUsualPage, *cursor};
  if (limit->empty()) return page;
  const auto given = number_within("limit", *limit, 1, kLongestPage);
  if (!given) return given.error();
  page.limit = static_cast<std::size_t>(*given);
  return page;
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
