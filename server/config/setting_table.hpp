// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/base.hpp"
#include "config/settings.hpp"
#include "config/units.hpp"

namespace surfaced {

/// One line of the table: what can be set, in what unit, within what bounds, and what it is for.
struct Setting {
  /// As a flag without its dashes, and as a key of the file; SURFACED_NAME_IN_CAPITALS in the environment.
  std::string_view name;
  SettingUnit unit = SettingUnit::count;
  /// For texts: the words that are allowed, separated by |; empty for any.
  std::string_view choices;
  std::uint64_t least = 0;
  std::uint64_t most = 0;
  std::string_view text;
  std::variant<std::string Settings::*, std::filesystem::path Settings::*, std::uint64_t Settings::*> place;
};

std::span<const Setting> setting_table();

/// SURFACED_JOB_MEMORY for job-memory.
std::string environment_name(const Setting& setting);

/// "1000", "256 MiB", "30 s", "1 d": as the documentation writes it, and as `assign` reads it.
std::string shown(const Setting& setting, const Settings& settings);

/// What is allowed, in words.
std::string allowed(const Setting& setting);

/// Puts the value into its place; sizes and durations take units (config/units.hpp).
/// @return  invalid_usage that names the setting, the value, what is allowed, and a word that was meant
Status assign(const Setting& setting, std::string_view value, Settings& settings);

}  // namespace surfaced
