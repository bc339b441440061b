// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "jobs/job_store.hpp"

namespace surfaced {

/// Copies the job store as it is at one moment into a new file, while servers use it.
/// @return  what the copy refers to in the artifact store
Result<Artifacts> copy_job_store(const std::filesystem::path& from, const std::filesystem::path& to);

/// Takes jobs out of a copy: those whose files were removed while it was made.
Status forget_jobs(const std::filesystem::path& copy, const std::vector<std::string>& ids);

}  // namespace surfaced
