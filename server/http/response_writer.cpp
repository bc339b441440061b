// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/response_writer.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "platform/clock.hpp"

namespace surfaced::http {
namespace {

struct Reason {
  int status;
  std::string_view words;
};

constexpr auto kReasons = std::to_array<Reason>({{200, "OK"},
                                                 {201, "Created"},
                                                 {202, "Accepted"},
                                                 {204, "No Content"},
                                                 {206, "Partial Content"},
                                                 {303, "See Other"},
                                                 {304, "Not Modified"},
                                                 {400, "Bad Request"},
                                                 {401, "Unauthorized"},
                                                 {403, "Forbidden"},
                                                 {404, "Not Found"},
                                                 {405, "Method Not Allowed"},
                                                 {406, "Not Acceptable"},
                                                 {408, "Request Timeout"},
                                                 {409, "Conflict"},
                                                 {410, "Gone"},
                                                 {411, "Length Required"},
                                                 {412, "Precondition Failed"},
                                                 {413, "Payload Too Large"},
                                                 {414, "URI Too Long"},
                                                 {415, "Unsupported Media Type"},
                                                 {416, "Range Not Satisfiable"},
                                                 {422, "Unprocessable Entity"},
                                                 {429, "Too Many Requests"},
                                                 {431, "Request Header Fields Too Large"},
                                                 {460, "Checksum Mismatch"},
                                                 {503, "Service Unavailable"},
                                                 {507, "Insufficient Storage"}});

using Field = std::pair<std::string_view, std::string>;

/// The length of the body that the client gets, or would get if it did not ask for the head alone; none where there is
/// no body or its end is that of the connection.
std::optional<std::uint64_t> length_of(const Response& response) {
  if (response.streaming || response.status == 204 || response.status == 304) return std::nullopt;
  if (const auto* const stream = std::get_if<BodyStream>(&response.body)) return stream->length;
  return std::get<std::string>(response.body).size();
}

/// What a client said may stand in a value; nothing it says begins a line of its own.
bool is_one_line(std::string_view text) { return text.find_first_of("\r\n") == text.npos; }

std::vector<Field> fields_of(const Response& response, const Request& request, bool close) {
  std::vector<Field> fields;
  for (const auto& [name, value] : response.headers) {
    if (is_one_line(name) && is_one_line(value)) fields.emplace_back(name, value);
  }
  fields.emplace_back("Date", to_http_date(now()));
  fields.emplace_back("X-Request-Id", request.request_id);
  fields.emplace_back("X-Content-Type-Options", "nosniff");
  if (!response.content_type.empty()) fields.emplace_back("Content-Type", response.content_type);
  if (const auto length = length_of(response)) fields.emplace_back("Content-Length", std::to_string(*length));
  if (request.method == "HEAD" && !response.headers.find("Accept-Ranges"))
    fields.emplace_back("Accept-Ranges", "bytes");
  if (close || response.streaming) fields.emplace_back("Connection", "close");
  std::ranges::stable_sort(fields, comes_before, &Field::first);
  return fields;
}

}  // namespace

std::string_view reason_of(int status) {
  const auto* const found = std::ranges::find(kReasons, status, &Reason::status);
  return found == kReasons.end() ? "Internal Server Error" : found->words;
}

std::string write_response(const Response& response, const Request& request, bool close) {
  std::string bytes = "HTTP/1.1 " + std::to_string(response.status) + " ";
  bytes.append(reason_of(response.status)).append("\r\n");
  for (const auto& [name, value] : fields_of(response, request, close)) {
    bytes.append(name).append(": ").append(value).append("\r\n");
  }
  bytes += "\r\n";
  const auto* const text = std::get_if<std::string>(&response.body);
  if (text != nullptr && request.method != "HEAD") bytes += *text;
  return bytes;
}

}  // namespace surfaced::http
