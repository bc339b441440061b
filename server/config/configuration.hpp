// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/base.hpp"
#include "config/setting_table.hpp"
#include "config/settings.hpp"

namespace surfaced {

/// Where settings come from. A flag wins over the environment, that over the file, that over the default.
struct Sources {
  /// Names of settings and their values as they stand on the command line.
  std::map<std::string, std::string, std::less<>> flags{};
  /// The variable of this name, if there is one.
  std::function<std::optional<std::string>(const std::string& name)> environment{};
  /// A JSON object, name of the setting to text or number; comments are taken. Empty for none.
  std::filesystem::path file{};
};

/// Every setting, where it came from, and all that is wrong.
struct Configuration {
  struct Entry {
    const Setting* setting = nullptr;
    /// "default", "file", "--flag", "SURFACED_NAME" or "SURFACED_NAME_FILE".
    std::string source;
  };
  Settings settings;
  std::vector<Entry> entries;
  /// Each invalid_usage, naming the setting, its value and what is allowed.
  std::vector<Error> problems;
  /// Adds one that has no single setting to blame, or whose fault is told.
  void refuse(std::string detail, std::shared_ptr<const Fault> fault = {}) {
    problems.push_back({ErrorCode::invalid_usage, std::move(detail), std::move(fault)});
  }
  /// What works, but hardly as it was meant.
  std::vector<std::string> warnings;
};

/// Reads all sources. SURFACED_NAME_FILE gives the path of a file whose content is the value, for secrets and for
/// orchestrators that mount files.
Configuration read_configuration(const Sources& sources);

/// The details of all of them in one line.
std::string details_of(std::span<const Error> problems);

/// Adds what this machine makes of the settings: the data folder, memory, open files, space.
void check_machine(Configuration& configuration);

}  // namespace surfaced
