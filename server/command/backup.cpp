// SPDX-License-Identifier: GPL-3.0-or-later
#include "backup/backup.hpp"

#include <iostream>
#include <memory>

#include "command/command.hpp"
#include "command/problem.hpp"

namespace surfaced {
namespace {

struct BackupOptions {
  std::filesystem::path data;
  std::filesystem::path target;
  bool verify = false;
};

int tell(const BackupOptions& options, const char* done, const Result<BackupContents>& backup) {
  if (!backup) return report_problem(backup.error());
  std::cout << done << " " << backup->jobs << " jobs, " << backup->clouds << " clouds and " << backup->uploads
            << " unfinished uploads: " << backup->files << " files of " << backup->bytes << " bytes in "
            << options.target.string() << std::endl;
  return 0;
}

int run_backup(const BackupOptions& options) {
  if (options.verify) return tell(options, "verified", verify_backup(options.target));
  if (options.data.empty()) {
    return report_problem(with_fault({ErrorCode::invalid_usage, "--data is not set: the folder of the service to copy"},
                                     {"--data", std::nullopt, "the folder that surfaced serve --data was given"}));
  }
  return tell(options, "copied and verified", back_up(options.data, options.target));
}

}  // namespace

void add_backup(CLI::App& app, Run& run) {
  auto options = std::make_shared<BackupOptions>();
  CLI::App* command = app.add_subcommand("backup", "Copy the data folder of a service, which may be running");
  command->add_option("TARGET", options->target, "New folder; a service can be started on it")->required();
  command->add_option("--data", options->data, "Folder of the service")->envname("SURFACED_DATA");
  command->add_flag("--verify", options->verify, "Read the backup in TARGET and compare it with its records");
  command->callback([options, &run] { run = [options] { return run_backup(*options); }; });
}

}  // namespace surfaced
