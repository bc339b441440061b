// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "jobs/job.hpp"

namespace surfaced::api {

/// The job as proto/schema/job.json describes it.
nlohmann::ordered_json job_json(const Job& job);

/// Strong validator of what job_json says.
std::string job_etag(const Job& job);

/// Path of a job, /v1/jobs/ID.
std::string job_path(std::string_view id);
/// Path of one of its outputs.
std::string output_path(std::string_view id, std::string_view output);

}  // namespace surfaced::api
