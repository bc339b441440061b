// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/submission.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "api/outputs.hpp"
#include "api/submission_fields.hpp"
#include "http/problem.hpp"
#include "platform/lists.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api {
namespace {

/// A number over HTTP; units are for settings, which people type.
constexpr const char* kTtlAllowed = "a number of seconds from 60 to 2592000 (a day is 86400)";
constexpr double kShortestTtl = 60;
constexpr double kLongestTtl = 30 * 24 * 3600;
constexpr std::size_t kMostLabels = 16;
constexpr std::size_t kLongestLabel = 64;
constexpr std::size_t kLongestWebhook = 2048;

constexpr std::string_view kAllowedLabels = "up to 16 of 1 to 64 letters, digits and the signs ._:/=@-";

Result<std::chrono::seconds> read_ttl(const SubmissionFields& fields, std::chrono::seconds otherwise) {
  const auto given = fields.number("ttl_seconds");
  if (!given) return given.error();
  if (!*given) return otherwise;
  const auto& [seconds, text] = **given;
  if (seconds >= kShortestTtl && seconds <= kLongestTtl) {
    return std::chrono::seconds(static_cast<std::int64_t>(seconds));
  }
  return http::wrong_value(ErrorCode::invalid_parameter, "ttl_seconds", text, kTtlAllowed);
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

Result<std::vector<std::string>> read_labels(const SubmissionFields& fields) {
  auto labels = fields.list("labels");
  if (!labels) return labels;
  return checked_labels(std::move(*labels));
}

Result<std::string> read_webhook(const SubmissionFields& fields, const SubmissionRules& rules) {
  auto url = fields.text("webhook");
  if (!url || url->empty()) return url;
  if (!rules.webhooks) {
    return http::wrong_value(ErrorCode::invalid_parameter, "webhook", *url,
                             "none: this server sends no webhooks (--webhook-secret)");
  }
  const bool clean = std::ranges::all_of(*url, [](char c) { return c > ' ' && c < '\x7f'; });
  if (!url->starts_with("https://") || url->size() > kLongestWebhook || !clean) {
    return http::wrong_value(ErrorCode::invalid_parameter, "webhook", *url,
                             "an https:// URL of up to " + std::to_string(kLongestWebhook) + " printable characters");
  }
  return url;
}

Result<Submission> read(const SubmissionFields& fields, const SubmissionRules& rules) {
  if (Status known = fields.check_names(); !known.ok()) return known.error();
  const auto id = fields.text("method");
  if (!id) return id.error();
  const auto method = find_method(id->empty() ? methods().front().id : *id);
  if (!method) return method.error();
  auto parameters = fields.parameters(**method);
  if (!parameters) return std::move(parameters).error();
  const auto names = fields.list("outputs");
  if (!names) return names.error();
  auto outputs = outputs_for(*names, **method);
  if (!outputs) return std::move(outputs).error();
  const auto ttl = read_ttl(fields, rules.ttl);
  if (!ttl) return ttl.error();
  auto labels = read_labels(fields);
  if (!labels) return std::move(labels).error();
  auto webhook = read_webhook(fields, rules);
  if (!webhook) return std::move(webhook).error();
  auto cloud = fields.text("cloud_id");
  if (!cloud) return std::move(cloud).error();
  return Submission{(*method)->id,      std::move(*parameters), std::move(*outputs), *ttl,
                    std::move(*labels), std::move(*webhook),    std::move(*cloud),   {}};
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

std::vector<std::string> split_labels(std::string_view list) {
  std::set<std::string, std::less<>> labels;
  while (!list.empty() && labels.size() <= kMostLabels) {
    const std::string_view label = take_entry(list);
    if (!label.empty() && !labels.contains(label)) labels.emplace(label);
  }
  return {labels.begin(), labels.end()};
}

Result<std::vector<std::string>> read_labels(std::string_view list) { return checked_labels(split_labels(list)); }

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

Result<Submission> read_submission(const http::Query& query, Endpoint endpoint, const SubmissionRules& rules) {
  return read(QueryFields(query, endpoint), rules);
}

Result<Submission> read_submission(const nlohmann::ordered_json& body, const SubmissionRules& rules) {
  return read(JsonFields(body), rules);
}

}  // namespace surfaced::api
