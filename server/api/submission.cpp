// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/submission.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "api/outputs.hpp"
#include "http/problem.hpp"
#include "platform/lists.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {
namespace {

/// Names that are reserved and not handed to the method.
constexpr auto kReserved =
    std::to_array<std::string_view>({"method", "output", "outputs", "wait", "ttl_seconds", "labels", "webhook"});
constexpr auto kForReconstruct = std::to_array<std::string_view>({"method", "output"});
constexpr auto kForJobs = std::to_array<std::string_view>({"method", "outputs", "ttl_seconds", "labels", "webhook"});
constexpr auto kFields = std::to_array<std::string_view>(
    {"method", "cloud_id", "parameters", "outputs", "webhook", "ttl_seconds", "labels"});

/// A number over HTTP; units are for settings, which people type.
constexpr const char* kTtlAllowed = "a number of seconds from 60 to 2592000 (a day is 86400)";
constexpr double kShortestTtl = 60;
constexpr double kLongestTtl = 30 * 24 * 3600;
constexpr std::size_t kMostLabels = 16;
/// Entries of a list before they are looked at: some may be there twice.
constexpr std::size_t kMostTexts = 256;
constexpr std::size_t kLongestLabel = 64;
constexpr std::size_t kLongestWebhook = 2048;

constexpr std::string_view kAllowedLabels = "up to 16 of 1 to 64 letters, digits and the signs ._:/=@-";

bool is_among(const auto& names, std::string_view name) { return std::ranges::find(names, name) != names.end(); }

std::string listed(const auto& names) {
  std::string text;
  for (const std::string_view name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

/// A reserved name that this path does not take is not ignored in silence.
Status refuse_reserved(const http::Query& query, Door door) {
  for (const auto& [name, value] : query) {
    const bool taken = door == Door::jobs ? is_among(kForJobs, name) : is_among(kForReconstruct, name);
    if (is_among(kReserved, name) && !taken) {
      return with_fault(
          {ErrorCode::unknown_parameter, "'" + name + "' is not taken by this path"},
          {name, value,
           (door == Door::jobs ? listed(kForJobs) : listed(kForReconstruct)) + ", and the parameters of the method"});
    }
    if (name == "cloud_id") {
      return with_fault({ErrorCode::conflicting_input,
                         "cloud_id '" + value + "' stands in the query of a request whose body is the cloud"},
                        {name, value, "a body of JSON or a form that names it, without a cloud"});
    }
  }
  return Done{};
}

http::Query method_parameters(const http::Query& query) {
  http::Query parameters;
  std::ranges::copy_if(query, std::back_inserter(parameters),
                       [](const auto& pair) { return !is_among(kReserved, pair.first); });
  return parameters;
}

Result<std::vector<std::string>> checked_labels(std::vector<std::string> labels) {
  std::ranges::sort(labels);
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  if (labels.size() > kMostLabels) {
    const std::string more = "more than " + std::to_string(kMostLabels);
    return with_fault({ErrorCode::invalid_parameter, "labels has " + more + " entries"},
                      {"labels", more + " labels", std::string(kAllowedLabels)});
  }
  constexpr std::string_view kSigns = "._:/=@-";
  for (const std::string& label : labels) {
    const bool clean = std::ranges::all_of(label, [&](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             kSigns.find(c) != kSigns.npos;
    });
    if (label.empty() || label.size() > kLongestLabel || !clean) {
      return http::wrong_value(ErrorCode::invalid_parameter, "labels", label, kAllowedLabels);
    }
  }
  return labels;
}

Result<std::string> checked_webhook(std::string url, const SubmissionRules& rules) {
  if (url.empty()) return url;
  if (!rules.webhooks) {
    return http::wrong_value(ErrorCode::invalid_parameter, "webhook", url,
                             "none: this server sends no webhooks (--webhook-secret)");
  }
  const bool clean = std::ranges::all_of(url, [](char c) { return c > ' ' && c < '\x7f'; });
  if (!url.starts_with("https://") || url.size() > kLongestWebhook || !clean) {
    return http::wrong_value(ErrorCode::invalid_parameter, "webhook", url,
                             "an https:// URL of up to " + std::to_string(kLongestWebhook) + " printable characters");
  }
  return url;
}

Status read_query_extras(const http::Query& query, const SubmissionRules& rules, Submission& submission) {
  const auto ttl = single(query, "ttl_seconds");
  if (!ttl) return ttl.error();
  if (!ttl->empty()) {
    const auto seconds = number_within("ttl_seconds", *ttl, kShortestTtl, kLongestTtl);
    if (!seconds) return http::wrong_value(ErrorCode::invalid_parameter, "ttl_seconds", *ttl, kTtlAllowed);
    submission.ttl = std::chrono::seconds(static_cast<std::int64_t>(*seconds));
  }
  const auto labels = single(query, "labels");
  if (!labels) return labels.error();
  auto checked = read_labels(*labels);
  if (!checked) return std::move(checked).error();
  submission.labels = std::move(*checked);
  auto webhook = single(query, "webhook");
  if (!webhook) return std::move(webhook).error();
  auto url = checked_webhook(std::move(*webhook), rules);
  if (!url) return std::move(url).error();
  submission.webhook = std::move(*url);
  return Done{};
}

Result<std::vector<std::string>> wanted_outputs(const http::Query& query, Door door, const MethodInfo& method) {
  const auto text = single(query, door == Door::reconstruct ? "output" : "outputs");
  if (!text) return text.error();
  if (door == Door::jobs || text->empty()) return outputs_for(split_list(*text), method);
  auto mesh = mesh_named(*text);
  if (!mesh) return std::move(mesh).error();
  return outputs_for(std::array{std::move(*mesh)}, method);
}

using Json = nlohmann::ordered_json;

Error wrong_type(std::string_view field, const Json& value, std::string_view allowed) {
  return http::wrong_value(ErrorCode::invalid_request, field,
                           value.dump(-1, ' ', false, Json::error_handler_t::replace), allowed);
}

Result<std::string> text_field(const Json& body, const char* field) {
  const auto found = body.find(field);
  if (found == body.end() || found->is_null()) return std::string();
  if (!found->is_string()) return wrong_type(field, *found, "a string");
  return found->get<std::string>();
}

Result<std::vector<std::string>> texts_field(const Json& body, const char* field) {
  std::vector<std::string> texts;
  const auto found = body.find(field);
  if (found == body.end() || found->is_null()) return texts;
  if (!found->is_array()) return wrong_type(field, *found, "an array of strings");
  if (found->size() > kMostTexts) {
    return with_fault({ErrorCode::invalid_parameter, std::string(field) + " has " + std::to_string(found->size()) +
                                                         " entries; allowed are " + std::to_string(kMostTexts)},
                      {field, std::to_string(found->size()) + " entries", "up to " + std::to_string(kMostTexts)});
  }
  for (const Json& each : *found) {
    if (!each.is_string()) return wrong_type(field, *found, "an array of strings");
    texts.push_back(each.get<std::string>());
  }
  return texts;
}

Result<std::chrono::seconds> ttl_field(const Json& body, std::chrono::seconds otherwise) {
  const auto found = body.find("ttl_seconds");
  if (found == body.end() || found->is_null()) return otherwise;
  const double seconds = found->is_number() ? found->get<double>() : -1;
  if (seconds >= kShortestTtl && seconds <= kLongestTtl)
    return std::chrono::seconds(static_cast<std::int64_t>(seconds));
  Error error = wrong_type("ttl_seconds", *found, kTtlAllowed);
  error.code = ErrorCode::invalid_parameter;
  return error;
}

Status check_fields(const Json& body) {
  if (!body.is_object()) return wrong_type("body", body, "a JSON object");
  for (const auto& [field, value] : body.items()) {
    if (is_among(kFields, field)) continue;
    return with_fault({ErrorCode::invalid_request,
                       "the body has a field '" + field.substr(0, 200) + "'; allowed are " + listed(kFields)},
                      {field.substr(0, 200), value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 200),
                       "one of " + listed(kFields)});
  }
  return Done{};
}

Result<Json> parameters_field(const Json& body, const MethodInfo& method) {
  const auto found = body.find("parameters");
  if (found == body.end() || found->is_null()) return check_parameters(method, Json::object());
  if (!found->is_object()) return wrong_type("parameters", *found, "an object");
  return check_parameters(method, *found);
}

}  // namespace

std::vector<std::string> split_list(std::string_view list) {
  std::vector<std::string> entries;
  while (!list.empty()) {
    const std::string_view entry = take_entry(list);
    if (!entry.empty()) entries.emplace_back(entry);
  }
  return entries;
}

Result<std::vector<std::string>> read_labels(std::string_view list) {
  // Those beyond the limit are not looked at: a list may have a mebibyte of them.
  std::set<std::string, std::less<>> labels;
  while (!list.empty() && labels.size() <= kMostLabels) {
    const std::string_view label = take_entry(list);
    if (!label.empty() && !labels.contains(label)) labels.emplace(label);
  }
  return checked_labels({labels.begin(), labels.end()});
}

Result<std::string> single(const http::Query& query, std::string_view name) {
  std::string value;
  std::size_t count = 0;
  for (const auto& [key, text] : query) {
    if (key == name && ++count == 1) value = text;
  }
  if (count > 1) {
    return with_fault({ErrorCode::invalid_parameter,
                       "'" + std::string(name) + "' is given " + std::to_string(count) + " times; once is allowed"},
                      {std::string(name), value, "one value"});
  }
  return value;
}

Result<double> number_within(std::string_view name, std::string_view text, double least, double most) {
  double value = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (failed == std::errc() && end == text.data() + text.size() && value >= least && value <= most) return value;
  const auto whole = [](double limit) { return std::to_string(std::llround(limit)); };
  return http::wrong_value(ErrorCode::invalid_parameter, name, text,
                           "a number from " + whole(least) + " to " + whole(most));
}

Result<Submission> read_submission(const http::Query& query, Door door, const SubmissionRules& rules) {
  if (Status taken = refuse_reserved(query, door); !taken.ok()) return taken.error();
  const auto id = single(query, "method");
  if (!id) return id.error();
  const auto method = find_method(id->empty() ? methods().front().id : *id);
  if (!method) return method.error();
  auto parameters = parameters_from_text(**method, method_parameters(query));
  if (!parameters) return std::move(parameters).error();
  auto outputs = wanted_outputs(query, door, **method);
  if (!outputs) return std::move(outputs).error();
  Submission submission{(*method)->id, std::move(*parameters), std::move(*outputs), rules.ttl};
  if (Status extras = read_query_extras(query, rules, submission); !extras.ok()) return extras.error();
  return submission;
}

Result<Submission> read_submission(const Json& body, const SubmissionRules& rules) {
  if (Status known = check_fields(body); !known.ok()) return known.error();
  const auto id = text_field(body, "method");
  if (!id) return id.error();
  const auto method = find_method(id->empty() ? methods().front().id : *id);
  if (!method) return method.error();
  auto parameters = parameters_field(body, **method);
  if (!parameters) return std::move(parameters).error();
  const auto names = texts_field(body, "outputs");
  if (!names) return names.error();
  auto outputs = outputs_for(*names, **method);
  if (!outputs) return std::move(outputs).error();
  const auto ttl = ttl_field(body, rules.ttl);
  if (!ttl) return ttl.error();
  auto texts = texts_field(body, "labels");
  if (!texts) return std::move(texts).error();
  auto labels = checked_labels(std::move(*texts));
  if (!labels) return std::move(labels).error();
  auto url = text_field(body, "webhook");
  if (!url) return std::move(url).error();
  auto webhook = checked_webhook(std::move(*url), rules);
  if (!webhook) return std::move(webhook).error();
  auto cloud = text_field(body, "cloud_id");
  if (!cloud) return std::move(cloud).error();
  return Submission{(*method)->id,      std::move(*parameters), std::move(*outputs), *ttl,
                    std::move(*labels), std::move(*webhook),    std::move(*cloud),   {}};
}

}  // namespace surfaced::api
