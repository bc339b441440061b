// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/file_access.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "platform/files.hpp"

namespace surfaced {
namespace {

// Debian 12 has the headers of Linux 6.1, which end at version 2.
#ifndef LANDLOCK_ACCESS_FS_TRUNCATE
constexpr std::uint64_t LANDLOCK_ACCESS_FS_TRUNCATE = std::uint64_t{1} << 14;
#endif
#ifndef LANDLOCK_ACCESS_FS_IOCTL_DEV
constexpr std::uint64_t LANDLOCK_ACCESS_FS_IOCTL_DEV = std::uint64_t{1} << 15;
#endif

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kWork = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR |
                                LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_TRUNCATE;
/// How many processors there are; the thread pool asks.
constexpr const char* kProcessors = "/sys/devices/system/cpu";

/// Everything that this version of Landlock can forbid; the rules below give back what is needed.
std::uint64_t everything(long version) {
  std::uint64_t access = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
  if (version >= 2) access |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) access |= LANDLOCK_ACCESS_FS_TRUNCATE;
  if (version >= 5) access |= LANDLOCK_ACCESS_FS_IOCTL_DEV;
  return access;
}

Status allow(int rules, const std::filesystem::path& path, std::uint64_t access) {
  const UniqueFd place(::open(path.c_str(), O_PATH | O_CLOEXEC));
  if (!place) return system_error("open what the attempt works on", errno);
  landlock_path_beneath_attr rule{};
  rule.allowed_access = access;
  rule.parent_fd = place.get();
  if (::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0) {
    return system_error("restrict the files", errno);
  }
  return Done{};
}

}  // namespace

Result<std::string> restrict_files(const std::filesystem::path& cloud, const std::filesystem::path& directory) {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return std::string("no landlock");
  landlock_ruleset_attr handled{};
  handled.handled_access_fs = everything(version);
  const UniqueFd rules(static_cast<int>(
      ::syscall(SYS_landlock_create_ruleset, &handled, sizeof handled.handled_access_fs, std::uint32_t{0})));
  if (!rules) return system_error("restrict the files", errno);
  if (Status set = allow(rules.get(), cloud, kRead); !set.ok()) return set.error();
  if (Status set = allow(rules.get(), directory, kWork & everything(version)); !set.ok()) return set.error();
  if (::access(kProcessors, R_OK) == 0) {
    if (Status set = allow(rules.get(), kProcessors, kRead | LANDLOCK_ACCESS_FS_READ_DIR); !set.ok()) {
      return set.error();
    }
  }
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) return system_error("restrict the files", errno);
  return "landlock " + std::to_string(version);
}

}  // namespace surfaced
