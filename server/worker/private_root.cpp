// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/private_root.hpp"

#include <fcntl.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <system_error>

#include "base/unique_fd.hpp"

namespace surfaced {
namespace {

namespace fs = std::filesystem;

/// Where the new root is put together: a directory that there always is, since the server starts its children by it.
constexpr const char* kAssembly = "/proc";

/// Flags of the mount below that a mount above may not take away.
unsigned long flags_of(const fs::path& path) {
  struct statvfs status {};
  if (::statvfs(path.c_str(), &status) != 0) return 0;
  unsigned long flags = 0;
  if ((status.f_flag & ST_RDONLY) != 0) flags |= MS_RDONLY;
  if ((status.f_flag & ST_NOATIME) != 0) flags |= MS_NOATIME;
  if ((status.f_flag & ST_NODIRATIME) != 0) flags |= MS_NODIRATIME;
  if ((status.f_flag & ST_RELATIME) != 0) flags |= MS_RELATIME;
  return flags;
}

/// The place's own name in the new root, empty yet.
bool make_place(const fs::path& target, bool is_directory) {
  std::error_code error;
  fs::create_directories(is_directory ? target : target.parent_path(), error);
  if (error) return false;
  if (is_directory) return true;
  const UniqueFd file(::open(target.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  return static_cast<bool>(file);
}

bool same_file(const struct stat& one, const fs::path& path) {
  struct stat other {};
  return ::stat(path.c_str(), &other) == 0 && one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

bool show(const VisiblePlace& place) {
  struct stat status {};
  if (::stat(place.path.c_str(), &status) != 0) return true;
  const fs::path target = kAssembly / place.path.relative_path();
  if (!make_place(target, S_ISDIR(status.st_mode))) return false;
  if (::mount(place.path.c_str(), target.c_str(), nullptr, MS_BIND | MS_REC, nullptr) != 0) return false;
  const unsigned long flags =
      MS_NOSUID | MS_NODEV | MS_NOEXEC | (place.writable ? 0UL : static_cast<unsigned long>(MS_RDONLY));
  if (::mount(nullptr, target.c_str(), nullptr, MS_BIND | MS_REMOUNT | flags | flags_of(target), nullptr) != 0) {
    return false;
  }
  return same_file(status, target) && (!place.writable || ::access(target.c_str(), W_OK | X_OK) == 0);
}

bool assemble(std::span<const VisiblePlace> places) {
  constexpr unsigned long kFlags = MS_NOSUID | MS_NODEV | MS_NOEXEC;
  if (::mount("none", kAssembly, "tmpfs", kFlags, "size=1m,nr_inodes=256,mode=755") != 0) return false;
  for (const VisiblePlace& place : places) {
    if (!show(place)) return false;
  }
  return ::mount(nullptr, kAssembly, nullptr, MS_BIND | MS_REMOUNT | MS_RDONLY | kFlags, nullptr) == 0;
}

bool enter() {
  // The old root is put on top of the new one, and taken off.
  return ::chdir(kAssembly) == 0 && ::syscall(SYS_pivot_root, ".", ".") == 0 && ::umount2(".", MNT_DETACH) == 0 &&
         ::chdir("/") == 0;
}

}  // namespace

bool hide_all_but(std::span<const VisiblePlace> places) {
  for (const VisiblePlace& place : places) {
    if (!place.path.is_absolute()) return false;
  }
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return false;
  if (assemble(places) && enter()) return true;
  ::umount2(kAssembly, MNT_DETACH);
  return false;
}

}  // namespace surfaced
