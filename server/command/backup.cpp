// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>

#include "command/command.hpp"
#include "command/problem.hpp"
#include "jobs/sqlite_backup.hpp"
#include "platform/files.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path data;
  fs::path target;
};

/// Copies a file, or a folder of files, that never changes once it has its name; false if it is gone.
Result<bool> copy_artifact(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (!fs::exists(from, error)) return false;
  fs::copy(from, to, fs::copy_options::recursive, error);
  // Removed while it was copied: then its job was removed, too.
  if (error && !fs::exists(from)) return false;
  if (error) return Error{ErrorCode::output_not_writable, "cannot copy to " + to.string() + ": " + error.message()};
  return true;
}

Status sync_all(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const UniqueFd fd(::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC));
    if (!fd || ::fsync(fd.get()) != 0) return system_error("make the backup durable", errno);
  }
  return sync_directory(folder);
}

/// The job store first, then the files that it refers to: whatever is acknowledged in the copy has its files there.
Status back_up(const Options& options) {
  if (fs::exists(options.target) && !fs::is_empty(options.target)) {
    return with_fault({ErrorCode::invalid_usage, "'" + options.target.string() + "' is not empty"},
                      {"TARGET", options.target.string(), "a folder that is empty or not there yet"});
  }
  for (const fs::path& each : {options.target, options.target / "inputs", options.target / "outputs"}) {
    if (Status made = make_directory(each); !made.ok()) return made;
  }
  const auto artifacts = copy_job_store(options.data / "jobs.sqlite", options.target / "jobs.sqlite");
  if (!artifacts) return artifacts.error();
  std::set<std::string> gone;
  for (const std::string& key : artifacts->inputs) {
    const auto copied = copy_artifact(options.data / "inputs" / key, options.target / "inputs" / key);
    if (!copied) return copied.error();
    if (!*copied) gone.insert(key);
  }
  for (const Claim& claim : artifacts->outputs) {
    const std::string name = claim.job + "-" + std::to_string(claim.attempt);
    const auto copied = copy_artifact(options.data / "outputs" / name, options.target / "outputs" / name);
    if (!copied) return copied.error();
  }
  const std::vector<std::string> ids(gone.begin(), gone.end());
  if (Status forgotten = forget_jobs(options.target / "jobs.sqlite", ids); !forgotten.ok()) return forgotten;
  const auto identity = copy_artifact(options.data / "store", options.target / "store");
  if (!identity) return identity.error();
  if (Status synced = sync_all(options.target); !synced.ok()) return synced;
  std::cout << "copied " << artifacts->inputs.size() - gone.size() << " jobs to " << options.target.string() << "\n";
  return Done{};
}

}  // namespace

void add_backup(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("backup", "Copy the data folder of a service, which may be running");
  command->add_option("TARGET", options->target, "New folder; a service can be started on it")->required();
  command->add_option("--data", options->data, "Folder of the service")->required()->envname("SURFACED_DATA");
  command->callback([options, &run] {
    run = [options] {
      const Status done = back_up(*options);
      return done ? 0 : report_problem(done.error());
    };
  });
}

}  // namespace surfaced
