// SPDX-License-Identifier: GPL-3.0-or-later
// OGC API - Processes, Part 1: Core (OGC 18-062r2) as JSON. The methods are its processes, and the jobs are the jobs
// of /v1/jobs, seen through another endpoint.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/base.hpp"
#include "http/message.hpp"
#include "jobs/job.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced::api::ogc {

using Json = nlohmann::ordered_json;

Json conformance();
Json process_summary(const MethodInfo& method);
Json process_description(const MethodInfo& method);
Json status_info(const Job& job);

/// How an execute request wants to see its results (OGC 18-062r2, table 11).
struct Presentation {
  struct Wanted {
    /// mesh or report.
    std::string output;
    /// A link instead of the bytes.
    bool by_reference = false;
  };
  /// The outputs as such, rather than a document that holds them or refers to them.
  bool raw = false;
  std::vector<Wanted> outputs{{"mesh", true}, {"report", true}};
};
std::string text_of(const Presentation& presentation);
/// What the job's request wanted; links to mesh and report if it came through another endpoint.
Presentation presentation_of(const Job& job);
/// Name of the job's output that the process calls mesh or report.
std::string output_name(const Job& job, std::string_view output);

/// What an execute request asks for.
struct Execution {
  /// As POST /v1/jobs takes it: method, cloud_id (may be absent), parameters, outputs.
  Json submission;
  /// The cloud itself; empty if cloud_id names one.
  std::string cloud;
  Presentation presentation;
};
/// @return  invalid_request, conflicting_input, unknown_output, not_acceptable.
Result<Execution> read_execution(const Json& body, const MethodInfo& method);

/// The problem with the exception type of the standard, where it has one.
http::Response problem(const Error& error, const http::Request& request);

}  // namespace surfaced::api::ogc
