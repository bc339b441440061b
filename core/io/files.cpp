// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <system_error>

#include "base/unique_fd.hpp"
#include "io/io.hpp"

namespace surfaced {
namespace {

Error not_writable(const std::filesystem::path& path, const std::string& why) {
  return {ErrorCode::output_not_writable, path.string() + ": " + why};
}

Error not_writable(const std::filesystem::path& path, int error) {
  return not_writable(path, std::generic_category().message(error));
}

Status write_all(const UniqueFd& file, std::span<const std::byte> bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return not_writable(path, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return Done{};
}

/// A file of a name nobody has, beside the target so that the rename stays within one file system.
struct Temporary {
  std::filesystem::path path;
  UniqueFd file;
};

Result<Temporary> create_temporary(const std::filesystem::path& target) {
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const std::string name = ".surfaced-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    std::filesystem::path path = target.parent_path() / name;
    const int number = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (number >= 0) return Temporary{std::move(path), UniqueFd(number)};
    if (errno != EEXIST) return not_writable(target, errno);
  }
  return not_writable(target, "1000 temporary names beside it are taken");
}

/// Makes a rename durable, where that can be asked for: a folder that may be written and not read cannot be opened for
/// it (EACCES), and some file systems sync no folders (EINVAL). Any other failure is one of the disk, and is told
/// although the file is there.
Status sync_folder(const std::filesystem::path& target) {
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  const UniqueFd opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened ? ::fsync(opened.get()) == 0 || errno == EINVAL : errno == EACCES) return Done{};
  return not_writable(target,
                      "the file is there, but may be gone after a power cut, for its folder cannot be synced: " +
                          std::generic_category().message(errno));
}

Status write_in_place(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file) return not_writable(path, errno);
  return write_all(file, bytes, path);
}

}  // namespace

Status write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::error_code ignored;
  const std::filesystem::file_status there = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(there)) return not_writable(path, EISDIR);
  // A device or a pipe must not be replaced by a file.
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) return write_in_place(path, bytes);
  // A link stays a link: what it points to is replaced.
  std::filesystem::path target =
      std::filesystem::is_symlink(path, ignored) ? std::filesystem::canonical(path, ignored) : path;
  if (target.empty()) return not_writable(path, "a link to nothing");
  Result<Temporary> temporary = create_temporary(target);
  if (!temporary) return std::move(temporary).error();
  Status status = write_all(temporary->file, bytes, path);
  if (status && ::fsync(temporary->file.get()) != 0) status = not_writable(path, errno);
  if (status && ::rename(temporary->path.c_str(), target.c_str()) != 0) status = not_writable(path, errno);
  if (status) return sync_folder(target);
  ::unlink(temporary->path.c_str());
  return status;
}

}  // namespace surfaced
