// SPDX-License-Identifier: GPL-3.0-or-later
#include "http/problem.hpp"

#include <string>
#include <vector>

#include "base/nearest.hpp"
#include "proto/embedded.hpp"

namespace surfaced::http {
namespace {

struct Row {
  std::string title;
  std::string hint;
  int status = 500;
};

struct Table {
  std::string type_base;
  std::vector<Row> rows;
};

/// The rows stand in the order of ErrorCode, which is made from the same file.
const Table& table() {
  static const Table kTable = [] {
    const Json json = Json::parse(proto::errors_json());
    Table made{json.at("type_base").get<std::string>(), {}};
    for (const Json& error : json.at("errors")) {
      made.rows.push_back(
          {error.at("title").get<std::string>(), error.at("hint").get<std::string>(), error.at("status").get<int>()});
    }
    return made;
  }();
  return kTable;
}

const Row& row_of(ErrorCode code) { return table().rows.at(static_cast<std::size_t>(code)); }

/// Seconds after which trying again makes sense.
constexpr std::string_view kRetryAfter = "5";

bool asks_to_come_back(int status) { return status == 503 || status == 429 || status == 507; }

}  // namespace

Error wrong_value(ErrorCode code, std::string_view field, std::string_view value, std::string_view allowed) {
  constexpr std::size_t kLongestEcho = 200;
  const std::string name(field);
  const std::string text(value.substr(0, kLongestEcho));
  return with_fault({code, "'" + name + "' is '" + text + "'; allowed is " + std::string(allowed)},
                    {name, text, std::string(allowed)});
}

Error missing_value(ErrorCode code, std::string_view field, std::string_view needed) {
  return with_fault({code, "'" + std::string(field) + "' is missing; needed is " + std::string(needed)},
                    {std::string(field), std::nullopt, std::string(needed)});
}

int status_of(ErrorCode code) { return row_of(code).status; }

Json problem_json(const Error& error, std::string_view instance, std::string_view request_id) {
  const Row& row = row_of(error.code);
  const std::string meant = did_you_mean(error);
  Json problem{{"type", table().type_base + std::string(name_of(error.code))},
               {"title", row.title},
               {"status", row.status},
               {"detail", error.detail},
               {"code", name_of(error.code)},
               {"hint", meant.empty() ? row.hint : meant + " " + row.hint}};
  if (error.fault) {
    problem["field"] = error.fault->field;
    problem["value"] = error.fault->value ? Json(*error.fault->value) : Json();
    problem["allowed"] = error.fault->allowed;
  }
  if (!instance.empty()) problem["instance"] = instance;
  problem["request_id"] = request_id;
  return problem;
}

Response problem_response(const Error& error, const Request& request) {
  Response response = json_response(status_of(error.code), problem_json(error, request.path, request.request_id));
  response.content_type = "application/problem+json";
  if (asks_to_come_back(response.status)) response.headers.add("Retry-After", std::string(kRetryAfter));
  return response;
}

std::string closing_answer(const Error& error, std::string_view request_id) {
  const Row& row = row_of(error.code);
  const std::string body = text_of(problem_json(error, {}, request_id));
  std::string answer = "HTTP/1.1 " + std::to_string(row.status) + " " + row.title +
                       "\r\nContent-Type: application/problem+json\r\nContent-Length: " + std::to_string(body.size()) +
                       "\r\nConnection: close\r\n";
  if (asks_to_come_back(row.status)) answer.append("Retry-After: ").append(kRetryAfter).append("\r\n");
  return answer.append("X-Request-Id: ").append(request_id).append("\r\n\r\n") + body;
}

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Response json_response(int status, const Json& json) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.headers.add("Cache-Control", "no-store");
  response.body = text_of(json);
  return response;
}

}  // namespace surfaced::http
