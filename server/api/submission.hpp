// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// What a server grants to those who submit.
struct SubmissionRules {
  /// Time to live of a job that asks for none.
  std::chrono::seconds ttl{};
  bool webhooks = false;
};

/// What a request asks for.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct Submission {
  std::string method;
  /// All parameters, with defaults.
  nlohmann::ordered_json parameters;
  /// The meshes first, then cloud.ply if it is wanted, report.json and log.txt.
  std::vector<std::string> outputs;
  std::chrono::seconds ttl{};
  /// Sorted, each once.
  std::vector<std::string> labels{};
  std::string webhook{};
  /// The stored cloud to work on; empty if the request brings its own.
  std::string cloud_id{};
  /// As in NewJob.
  std::string presentation{};
};

/// Which query names a path takes besides parameters of the method.
enum class Endpoint : std::uint8_t { reconstruct, jobs };

/// Reads the query of a submission, before a byte of its body is read. Reserved names are `method output outputs wait
/// ttl_seconds labels webhook up quantization`; every other name is a parameter of the method, as are `up` and
/// `quantization`.
/// @return  unknown_method, unknown_parameter, invalid_parameter, unknown_output.
Result<Submission> read_submission(const http::Query& query, Endpoint endpoint, const SubmissionRules& rules);

/// Reads `{method, cloud_id, parameters, outputs, webhook, ttl_seconds, labels}`; every field but cloud_id may be
/// absent.
/// @return  invalid_request for a field that there is not or of a wrong type, and the errors of the other.
Result<Submission> read_submission(const nlohmann::ordered_json& body, const SubmissionRules& rules);

/// The value of a query name that may be given once; empty if it is not given.
Result<std::string> single(const http::Query& query, std::string_view name);

/// A number in decimal notation within the bounds, or invalid_parameter that names them.
Result<double> number_within(std::string_view name, std::string_view text, double least, double most);

/// Reads `a,b`, or refuses a label that breaks the rules with invalid_parameter. Sorted, each once.
Result<std::vector<std::string>> read_labels(std::string_view list);

/// Cuts a list at its commas; empty entries are left out.
std::vector<std::string> split_list(std::string_view list);
/// The same, sorted, each once. Those far beyond the limit are not looked at: a list may have a mebibyte of them.
std::vector<std::string> split_labels(std::string_view list);

}  // namespace surfaced::api
