// OGC API - Processes, Part 1: Core (OGC 18-062r2) as JSON. The methods are its processes, and the jobs are the jobs
// of /v1/jobs, seen through another door.
#pragma once

#include <nlohmann/json.hpp>

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
/// The results of a successful job, by reference.
Json results(const Job& job);

/// What an execute request asks for.
struct Execution {
  /// As POST /v1/jobs takes it: method, cloud_id (may be absent), parameters, outputs.
  Json submission;
  /// The cloud itself; empty if cloud_id names one.
  std::string cloud;
  /// The outputs as such rather than a document that refers to them.
  bool raw = true;
  /// Empty for the mesh.
  bool report_alone = false;
};
/// @return  invalid_request, conflicting_input, unknown_output, not_acceptable.
Result<Execution> read_execution(const Json& body, const MethodInfo& method);

/// The problem with the exception type of the standard, where it has one.
http::Response problem(const Error& error, const http::Request& request);

}  // namespace surfaced::api::ogc
