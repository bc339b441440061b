// SPDX-License-Identifier: GPL-3.0-or-later
#include "platform/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "base/sha256.hpp"

namespace surfaced {

std::string error_text(int error_number) { return std::generic_category().message(error_number); }

Error system_error(std::string_view action, int error_number) {
  const bool full = error_number == ENOSPC || error_number == EDQUOT;
  return {full ? ErrorCode::storage_full : ErrorCode::internal_error,
          "cannot " + std::string(action) + ": " + error_text(error_number)};
}

Status sync_directory(const std::filesystem::path& directory) {
  const UniqueFd fd(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!fd || ::fsync(fd.get()) != 0) return system_error("make a directory durable", errno);
  return Done{};
}

Status make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  if (!directory.parent_path().empty()) std::filesystem::create_directories(directory.parent_path(), error);
  if (error || (::mkdir(directory.c_str(), 0700) != 0 && errno != EEXIST)) {
    return system_error("create the directory " + directory.string(), error ? error.value() : errno);
  }
  return sync_directory(directory.parent_path().empty() ? "." : directory.parent_path());
}

Result<std::vector<std::filesystem::path>> entries_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> entries;
  std::error_code error;
  // Not a range: the steps of that throw.
  for (std::filesystem::directory_iterator each(folder, error); !error && each != end(each); each.increment(error)) {
    entries.push_back(each->path());
  }
  if (error) return system_error("list " + folder.filename().string(), error.value());
  return entries;
}

Result<UniqueFd> open_regular(const std::filesystem::path& path) {
  UniqueFd fd(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!fd || ::fstat(fd.get(), &status) != 0) {
    return system_error("open " + path.filename().string(), errno);
  }
  if (!S_ISREG(status.st_mode)) {
    return Error{ErrorCode::internal_error, path.filename().string() + " is not a regular file"};
  }
  return fd;
}

Status write_all(int fd, std::span<const std::byte> bytes, std::string_view action) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return system_error(action, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return Done{};
}

Status write_file_durably(const std::filesystem::path& path, std::string_view content) {
  std::filesystem::path temporary = path;
  temporary += ".new";
  const std::string action = "write " + path.filename().string();
  const UniqueFd fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!fd) return system_error(action, errno);
  Status written = write_all(fd.get(), as_bytes(content), action);
  if (written && (::fsync(fd.get()) != 0 || ::rename(temporary.c_str(), path.c_str()) != 0)) {
    written = system_error(action, errno);
  }
  if (!written) {
    ::unlink(temporary.c_str());
    return written;
  }
  return sync_directory(path.parent_path());
}

Result<std::uint64_t> file_size(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return system_error("ask for a file's size", errno);
  return static_cast<std::uint64_t>(status.st_size);
}

Result<std::string> digest_of(const UniqueFd& file) {
  auto digest = sha256_of_file(file.get());
  if (!digest) return system_error("read a file", errno);
  return std::move(*digest);
}

}  // namespace surfaced
