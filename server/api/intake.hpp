// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "api/job_service.hpp"
#include "api/submission.hpp"
#include "http/message.hpp"

namespace surfaced::api {

/// A request to submit a job, taken apart: what it asks for, and the cloud that it brought, if it brought one.
struct Intake {
  Submission submission;
  /// None if the submission names a stored cloud.
  std::unique_ptr<Upload> cloud;
};

/// Reads a submission in any of the forms it may have: the raw bytes of a cloud with everything else in the query;
/// multipart/form-data with a file `cloud` and a field for every name of the query (or `cloud_id` in place of the
/// file); with Endpoint::jobs also JSON. What stands in the query is checked before a byte of the body is read.
/// @return  conflicting_input, unsupported_content_encoding, length_required, empty_input, payload_too_large, what
///          read_submission, JobService::begin_upload and reading the body say.
Result<Intake> take_in(http::Request& request, Endpoint endpoint, const SubmissionRules& rules, JobService& service);

/// Stores the raw body; unsupported_content_encoding, length_required, empty_input, and what reading says.
Result<std::unique_ptr<Upload>> receive_raw(http::Request& request, JobService& service);

/// Reads a body of JSON, of bounded size and depth; invalid_request says where it goes wrong.
Result<nlohmann::ordered_json> receive_json(http::Request& request, std::size_t most_bytes);

/// Content-Type without its parameters, in lower case.
std::string content_type_of(const http::Request& request);

}  // namespace surfaced::api
