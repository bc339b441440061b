// SPDX-License-Identifier: GPL-3.0-or-later
// Artifacts as files under one directory:
//
//   DIR/uploads/RANDOM          a cloud on its way in
//   DIR/inputs/KEY              a cloud that a job refers to
//   DIR/attempts/JOB-N/         what the child of attempt N writes
//   DIR/outputs/JOB-N/          what attempt N left, once it was published
//   DIR/store                   identity of the job store that they belong to
//
// What a crash (kill -9, power) at any moment leaves, and what becomes of it:
//
//   while an upload is written              uploads/RANDOM          no job refers to it: swept
//   after fsync, before or after the rename uploads/ or inputs/KEY  no job refers to it: swept
//   after the job was committed             inputs/KEY, complete    kept: file and name were synced before
//   while the child writes                  attempts/JOB-N/         job is `running`: recovered to
//                                                                   `accepted`; the directory is swept
//   after publish, before the commit        outputs/JOB-N/          as before: no row refers to attempt N
//   after the commit                        outputs/JOB-N/, complete kept: files, their directory and its
//                                                                   name were synced before the commit
//   after a removal was committed           inputs/, outputs/       no row refers to them: swept
//
// Attempts of one job never share a directory, so an attempt whose claim is void cannot touch the
// outputs of another.
#pragma once

#include <filesystem>
#include <memory>

#include "artifacts/artifact_store.hpp"
#include "base/unique_fd.hpp"

namespace surfaced {

/// Opens or creates the store under this directory.
/// @param minimum_free  bytes of the disk that are to stay free; check_space speaks of it.
Result<std::unique_ptr<ArtifactStore>> open_file_artifact_store(const std::filesystem::path& directory,
                                                                std::uint64_t minimum_free);

/// Holds the data directory for this process until it is destroyed or the process ends, however it ends.
class DataLock {
 public:
  /// Creates the directory if it is missing. invalid_usage if another server holds it,
  /// output_not_writable if it cannot be used.
  static Result<DataLock> acquire(const std::filesystem::path& directory);

 private:
  explicit DataLock(UniqueFd fd) : fd_(std::move(fd)) {}
  UniqueFd fd_;
};

}  // namespace surfaced
