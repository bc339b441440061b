// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "base/base.hpp"

namespace surfaced {

/// From now on this process opens no file but the cloud (to read) and what lies in the directory (to read,
/// write, create and remove). Files that are open stay so. Needs PR_SET_NO_NEW_PRIVS.
/// @return  "landlock N" with the kernel's version of it, or "no landlock" if the kernel has none: then the
///          permissions of the server's user are all that stands before other files
Result<std::string> restrict_files(const std::filesystem::path& cloud, const std::filesystem::path& directory);

}  // namespace surfaced
