// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/file_access.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "platform/files.hpp"

namespace surfaced {
namespace {

// Debian 12 has the headers of Linux 6.1, which end at version 2: what came later stands here by its own names.
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;
constexpr std::uint64_t kIoctlOnDevices = std::uint64_t{1} << 15;
constexpr std::uint64_t kBindTcp = std::uint64_t{1} << 0;
constexpr std::uint64_t kConnectTcp = std::uint64_t{1} << 1;
constexpr std::uint64_t kAbstractSockets = std::uint64_t{1} << 0;
constexpr std::uint64_t kSignals = std::uint64_t{1} << 1;

/// landlock_ruleset_attr as of version 6. Earlier kernels take the beginning of it.
struct Ruleset {
  std::uint64_t files = 0;
  std::uint64_t network = 0;
  /// What does not reach beyond processes that are restricted by these rules.
  std::uint64_t scoped = 0;
};

constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kWork = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR |
                                LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                LANDLOCK_ACCESS_FS_REMOVE_FILE | kTruncate;

/// Everything that this version of Landlock can forbid; the rules below give back what is needed.
Ruleset everything(long version) {
  Ruleset rules;
  rules.files = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
  if (version >= 2) rules.files |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) rules.files |= kTruncate;
  if (version >= 4) rules.network = kBindTcp | kConnectTcp;
  if (version >= 5) rules.files |= kIoctlOnDevices;
  if (version >= 6) rules.scoped = kAbstractSockets | kSignals;
  return rules;
}

/// How much of it a kernel with this version knows.
std::size_t size_of_ruleset(long version) {
  if (version >= 6) return sizeof(Ruleset);
  return version >= 4 ? offsetof(Ruleset, scoped) : offsetof(Ruleset, network);
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
  const Ruleset handled = everything(version);
  const UniqueFd rules(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, size_of_ruleset(version), std::uint32_t{0})));
  if (!rules) return system_error("restrict the files", errno);
  if (Status set = allow(rules.get(), cloud, kRead); !set.ok()) return set.error();
  if (Status set = allow(rules.get(), directory, kWork & handled.files); !set.ok()) return set.error();
  if (::access(kProcessors, R_OK) == 0) {
    if (Status set = allow(rules.get(), kProcessors, kRead | LANDLOCK_ACCESS_FS_READ_DIR); !set.ok()) {
      return set.error();
    }
  }
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) return system_error("restrict the files", errno);
  return "landlock " + std::to_string(version) + (handled.scoped != 0 ? " with signals" : " without signals");
}

}  // namespace surfaced
