// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "base/base.hpp"

namespace surfaced {

/// How many processors there are; the thread pool asks.
inline constexpr const char* kProcessors = "/sys/devices/system/cpu";

/// From now on this process opens no file but the cloud (to read) and what lies in the directory (to read,
/// write, create and remove), reaches no TCP port, no abstract socket and, by whatever way, no other process by a
/// signal: as far as the kernel's version of Landlock goes. Files that are open stay so. Needs PR_SET_NO_NEW_PRIVS.
/// @return  "landlock N" with the kernel's version of it and whether it holds signals, or "no landlock" if the kernel
///          has none: then the permissions of the server's user are all that stands before other files
Result<std::string> restrict_files(const std::filesystem::path& cloud, const std::filesystem::path& directory);

}  // namespace surfaced
