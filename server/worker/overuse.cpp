// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/overuse.hpp"

#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <string>
#include <system_error>

#include "worker/attempt_bounds.hpp"

namespace surfaced {
namespace {

struct Folder {
  std::uint64_t files = 0;
  /// On the disk: a file with holes takes less than its size.
  std::uint64_t bytes = 0;
};

Folder look_into(const std::filesystem::path& directory) {
  constexpr std::uint64_t kBlock = 512;
  Folder folder;
  std::error_code error;
  std::filesystem::directory_iterator entries(directory, error);
  const std::filesystem::directory_iterator end;
  // Files come and go meanwhile: what is gone is not counted.
  for (; !error && entries != end && folder.files <= kMostFiles; entries.increment(error)) {
    struct stat status {};
    ++folder.files;
    if (::lstat(entries->path().c_str(), &status) == 0)
      folder.bytes += kBlock * static_cast<std::uint64_t>(status.st_blocks);
  }
  return folder;
}

std::string more_than(std::string_view what, std::uint64_t limit, std::string_view unit) {
  return std::string(what) + " more than the limit of " + std::to_string(limit) + std::string(unit);
}

/// @param written  what the attempt may have taken of the disk, at most
std::optional<Overuse> overuse_of_disk(std::uint64_t written, const AttemptSpec& spec) {
  // Less is nothing worth speaking of on a disk that others fill.
  constexpr std::uint64_t kLittle = std::uint64_t{1} << 20;
  struct statvfs disk {};
  if (written <= kLittle || ::statvfs(spec.directory.c_str(), &disk) != 0) return std::nullopt;
  const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  if (free >= spec.limits.minimum_free) return std::nullopt;
  return Overuse{Outcome::lost,
                 Error{ErrorCode::storage_full, std::to_string(free) + " bytes are free under --data, and " +
                                                    std::to_string(spec.limits.minimum_free) + " are to stay free"}};
}

std::optional<Overuse> overuse_of_folder(std::uint64_t written, const AttemptSpec& spec) {
  const Folder folder = look_into(spec.directory);
  if (folder.files > kMostFiles) {
    return Overuse{Outcome::crashed, Error{ErrorCode::crashed, more_than("the work made", kMostFiles, " files")}};
  }
  // Blocks are counted whole.
  constexpr std::uint64_t kRounding = kMostFiles * 4096;
  if (folder.bytes > spec.limits.file_bytes && folder.bytes - spec.limits.file_bytes > kRounding) {
    return Overuse{
        Outcome::method_failed,
        Error{ErrorCode::method_failed, more_than("the outputs together would be", spec.limits.file_bytes, " bytes")}};
  }
  return overuse_of_disk(std::max(folder.bytes, written), spec);
}

}  // namespace

std::optional<Overuse> overuse_of(ChildProcess& child, const AttemptSpec& spec) {
  const ChildProcess::Use use = child.use();
  if (use.memory_bytes > spec.limits.memory_bytes) {
    return Overuse{Outcome::out_of_memory,
                   Error{ErrorCode::out_of_memory, "the work took more memory than the limit of " +
                                                       std::to_string(spec.limits.memory_bytes) + " bytes"}};
  }
  if (use.threads > most_threads(spec.limits)) {
    return Overuse{Outcome::crashed,
                   Error{ErrorCode::crashed, more_than("the work started", most_threads(spec.limits), " threads")}};
  }
  if (use.written_bytes > most_written(spec.limits)) {
    return Overuse{Outcome::method_failed,
                   Error{ErrorCode::method_failed, more_than("the work wrote", most_written(spec.limits), " bytes")}};
  }
  return overuse_of_folder(use.written_bytes, spec);
}

}  // namespace surfaced
