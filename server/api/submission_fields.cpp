// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/submission_fields.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>

#include "api/outputs.hpp"
#include "base/text.hpp"
#include "http/problem.hpp"

namespace surfaced::api {
namespace {

using Json = nlohmann::ordered_json;

/// Names that are reserved and not handed to the method.
constexpr auto kReserved =
    std::to_array<std::string_view>({"method", "output", "outputs", "wait", "ttl_seconds", "labels", "webhook"});
constexpr auto kForReconstruct = std::to_array<std::string_view>({"method", "output"});
constexpr auto kForJobs = std::to_array<std::string_view>({"method", "outputs", "ttl_seconds", "labels", "webhook"});
constexpr auto kMembers = std::to_array<std::string_view>(
    {"method", "cloud_id", "parameters", "outputs", "webhook", "ttl_seconds", "labels"});
/// Entries of a list in JSON before they are looked at: some may be there twice.
constexpr std::size_t kMostTexts = 256;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool is_among(const auto& names, std::string_view name) { return std::ranges::find(names, name) != names.end(); }

std::string written(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

Error wrong_type(std::string_view field, const Json& value, std::string_view allowed) {
  return http::wrong_value(ErrorCode::invalid_request, field, written(value), allowed);
}

}  // namespace

// A reserved name that this path does not take is not ignored in silence.
Status QueryFields::check_names() const {
  for (const auto& [name, value] : query_) {
    const bool taken = endpoint_ == Endpoint::jobs ? is_among(kForJobs, name) : is_among(kForReconstruct, name);
    if (is_among(kReserved, name) && !taken) {
      return with_fault({ErrorCode::unknown_parameter, "'" + name + "' is not taken by this path"},
                        {name, value,
                         (endpoint_ == Endpoint::jobs ? joined(kForJobs) : joined(kForReconstruct)) +
                             ", and the parameters of the method"});
    }
    if (name == "cloud_id") {
      return with_fault({ErrorCode::conflicting_input,
                         "cloud_id '" + value + "' stands in the query of a request whose body is the cloud"},
                        {name, value, "a body of JSON or a form that names it, without a cloud"});
    }
  }
  return Done{};
}

Result<std::string> QueryFields::text(std::string_view name) const { return single(query_, name); }

Result<std::optional<SubmissionFields::Number>> QueryFields::number(std::string_view name) const {
  auto text = single(query_, name);
  if (!text) return std::move(text).error();
  if (text->empty()) return std::optional<Number>();
  double value = 0;
  const char* const last = text->data() + text->size();
  const auto [end, failed] = std::from_chars(text->data(), last, value, std::chars_format::fixed);
  const bool whole = failed == std::errc() && end == last;
  return std::optional(Number{whole ? value : kNone, std::move(*text)});
}

Result<std::vector<std::string>> QueryFields::output() const {
  const auto format = single(query_, "output");
  if (!format) return format.error();
  if (format->empty()) return std::vector<std::string>();
  auto mesh = mesh_named(*format);
  if (!mesh) return std::move(mesh).error();
  return std::vector{std::move(*mesh)};
}

Result<std::vector<std::string>> QueryFields::list(std::string_view name) const {
  if (name == "outputs" && endpoint_ == Endpoint::reconstruct) return output();
  const auto text = single(query_, name);
  if (!text) return text.error();
  return name == "labels" ? split_labels(*text) : split_list(*text);
}

Result<Json> QueryFields::parameters(const MethodInfo& method) const {
  http::Query parameters;
  std::ranges::copy_if(query_, std::back_inserter(parameters),
                       [](const auto& pair) { return !is_among(kReserved, pair.first); });
  return parameters_from_text(method, parameters);
}

const Json* JsonFields::find(std::string_view name) const {
  const auto found = body_.find(std::string(name));
  return found == body_.end() || found->is_null() ? nullptr : &*found;
}

Status JsonFields::check_names() const {
  if (!body_.is_object()) return wrong_type("body", body_, "a JSON object");
  for (const auto& [field, value] : body_.items()) {
    if (is_among(kMembers, field)) continue;
    return with_fault({ErrorCode::invalid_request,
                       "the body has a field '" + field.substr(0, 200) + "'; allowed are " + joined(kMembers)},
                      {field.substr(0, 200), written(value).substr(0, 200), "one of " + joined(kMembers)});
  }
  return Done{};
}

Result<std::string> JsonFields::text(std::string_view name) const {
  const Json* const found = find(name);
  if (found == nullptr) return std::string();
  if (!found->is_string()) return wrong_type(name, *found, "a string");
  return found->get<std::string>();
}

Result<std::optional<SubmissionFields::Number>> JsonFields::number(std::string_view name) const {
  const Json* const found = find(name);
  if (found == nullptr) return std::optional<Number>();
  return std::optional(Number{found->is_number() ? found->get<double>() : kNone, written(*found)});
}

Result<std::vector<std::string>> JsonFields::list(std::string_view name) const {
  std::vector<std::string> texts;
  const Json* const found = find(name);
  if (found == nullptr) return texts;
  if (!found->is_array()) return wrong_type(name, *found, "an array of strings");
  if (found->size() > kMostTexts) {
    return with_fault(
        {ErrorCode::invalid_parameter, std::string(name) + " has " + std::to_string(found->size()) +
                                           " entries; allowed are " + std::to_string(kMostTexts)},
        {std::string(name), std::to_string(found->size()) + " entries", "up to " + std::to_string(kMostTexts)});
  }
  for (const Json& each : *found) {
    if (!each.is_string()) return wrong_type(name, *found, "an array of strings");
    texts.push_back(each.get<std::string>());
  }
  return texts;
}

Result<Json> JsonFields::parameters(const MethodInfo& method) const {
  const Json* const found = find("parameters");
  if (found == nullptr) return check_parameters(method, Json::object());
  if (!found->is_object()) return wrong_type("parameters", *found, "an object");
  return check_parameters(method, *found);
}

}  // namespace surfaced::api
