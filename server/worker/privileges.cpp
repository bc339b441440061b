// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/privileges.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>

#include "platform/files.hpp"

namespace surfaced {
namespace {

using Sets = std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3>;

Status set_capabilities(std::uint32_t permitted, std::uint32_t effective) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  Sets sets{};
  sets[0].permitted = permitted;
  sets[0].effective = effective;
  if (::syscall(SYS_capset, &header, sets.data()) != 0) return system_error("give up capabilities", errno);
  return Done{};
}

std::uint32_t permitted_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  Sets sets{};
  return ::syscall(SYS_capget, &header, sets.data()) == 0 ? sets[0].permitted : 0;
}

/// What an exec could bring back; nothing execs here, and the calls fail where the process has no power to begin with.
void empty_the_other_sets() {
  ::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  for (unsigned long each = 0; ::prctl(PR_CAPBSET_READ, each, 0, 0, 0) >= 0; ++each) {
    ::prctl(PR_CAPBSET_DROP, each, 0, 0, 0);
  }
}

bool reaches(const std::filesystem::path& cloud, const std::filesystem::path& directory) {
  return ::faccessat(AT_FDCWD, cloud.c_str(), R_OK, AT_EACCESS) == 0 &&
         ::faccessat(AT_FDCWD, directory.c_str(), R_OK | W_OK | X_OK, AT_EACCESS) == 0;
}

}  // namespace

Result<std::string> drop_capabilities(const std::filesystem::path& cloud, const std::filesystem::path& directory) {
  constexpr std::uint32_t kFiles = 1U << CAP_DAC_OVERRIDE;
  const std::uint32_t files = permitted_capabilities() & kFiles;
  empty_the_other_sets();
  if (Status set = set_capabilities(files, 0); !set.ok()) return set.error();
  const bool needed = files != 0 && !reaches(cloud, directory);
  const std::uint32_t left = needed ? files : 0;
  if (Status set = set_capabilities(left, left); !set.ok()) return set.error();
  return std::string(needed ? "no capability but CAP_DAC_OVERRIDE" : "no capabilities");
}

}  // namespace surfaced
