// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "base/base.hpp"

namespace surfaced {

/// Takes all capabilities from this process for good: a server that runs as root hands on none of its powers. Where
/// root reads the cloud or writes the directory only by its power over everybody's files, that one is kept.
/// To be called while the process has one thread.
/// @return  what is left, for the log
Result<std::string> drop_capabilities(const std::filesystem::path& cloud, const std::filesystem::path& directory);

}  // namespace surfaced
