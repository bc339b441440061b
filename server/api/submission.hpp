#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// What a request asks for, checked before a byte of its body is read.
struct Submission {
  std::string method;
  /// All parameters, with defaults.
  nlohmann::ordered_json parameters;
  /// The mesh first, then cloud.ply if it is wanted, report.json and log.txt.
  std::vector<std::string> outputs;
  std::chrono::seconds ttl{};
};

/// Which query names a path takes besides parameters of the method.
enum class Door : std::uint8_t { reconstruct, jobs };

/// Reads the query of a submission. Reserved names are `method output outputs wait ttl_seconds labels
/// webhook up quantization`; every other name is a parameter of the method, as are `up` and `quantization`.
/// @return  unknown_method, unknown_parameter, invalid_parameter, unknown_output.
Result<Submission> read_submission(const http::Query& query, Door door, std::chrono::seconds default_ttl);

/// Media type of an output by its name.
std::string_view media_type_of(std::string_view output);

/// The value of a query name that may be given once; empty if it is not given.
Result<std::string> single(const http::Query& query, std::string_view name);

/// A number in decimal notation within the bounds, or invalid_parameter that names them.
Result<double> number_within(std::string_view name, std::string_view text, double least, double most);

}  // namespace surfaced::api
